"""Brightness of ensembles: that of `light_curve` for the attitudes of each member."""

import numpy as np
import pytest
from astropy import units

from attitude import AttitudeError, Ensemble, light_curve
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude.shape import Ellipsoid, _solids
from tests.support import states

EPOCH = "2026-01-01"
# m2/sr, relative: a few roundings of vectors of length one, amplified where little is lit
LIMIT = 1e-12


@pytest.fixture(scope="module")
def ensemble():
    given = states.sample(1, seed=4)[:10]
    return Ensemble(
        moments=[s.moments for s in given],
        wxyz=[s.wxyz0 for s in given],
        angular_velocity=[s.omega0 for s in given],
        epoch=EPOCH,
    )


def _rows(count=2000, seed=2):
    """Members in any order, epochs, and vectors that are at most 120 deg apart."""
    rng = np.random.default_rng(seed)
    sun, observer = rng.normal(size=(2, count, 3))
    observer += 1.2 * sun
    scale = rng.uniform(1e11, 5e11, (2, count, 1))
    return (
        rng.integers(0, 10, count),
        rng.uniform(0, 100, count),
        sun * scale[0],
        observer * scale[1],
    )


def _axes():
    return np.random.default_rng(1).uniform(50.0, 200.0, (10, 3))


def _expected(history, shapes, law, sun, observer):
    out = np.empty(history.shape)
    for k in range(10):
        some = history.member == k
        shape = shapes[k if len(shapes) > 1 else 0]
        one = [v[some] / np.linalg.norm(v[some], axis=-1)[:, None] for v in (sun, observer)]
        turned = (history[some].inertial_to_body(each) for each in one)
        out[some] = light_curve.brightness(shape, law, *turned)
    return out


@pytest.mark.parametrize("threads", [1, 2])
def test_ellipsoids_of_ragged_rows(ensemble, threads):
    member, t, sun, observer = _rows()
    axes = _axes()
    found = ensemble.brightness(t, member, sun, observer, shape=axes, threads=threads)
    expected = _expected(
        ensemble.at(t, member=member), [Ellipsoid(each) for each in axes], "lommel-seeliger",
        sun, observer,
    )  # fmt: skip
    assert np.max(np.abs(found / expected - 1)) < LIMIT
    # the same bits in another order, from component-major memory and from objects
    order = np.argsort(member, kind="stable")
    turned = [np.ascontiguousarray(v[order].T).T for v in (sun, observer)]
    shapes = [Ellipsoid(each) for each in axes]
    again = ensemble.brightness(t[order], member[order], *turned, shape=shapes, threads=3)
    assert np.array_equal(again, found[order])
    reversed_ = ensemble.brightness(t[::-1], member[::-1], sun[::-1], observer[::-1], shape=axes)
    assert np.array_equal(reversed_[::-1], found)
    out = np.empty(member.size)
    assert ensemble.brightness(t, member, sun, observer, shape=axes, out=out) is out
    assert np.array_equal(out, found)


def test_grids(ensemble):
    t, axes = np.linspace(0.0, 50.0, 30), _axes()
    sun, observer = np.array([1.0, 0, 0]), np.random.default_rng(3).normal(size=(30, 3))
    observer[:, 0] += 2.0
    grid = ensemble.brightness(t, None, sun, observer, shape=axes)
    assert grid.shape == (10, 30)
    member = np.arange(10).repeat(30)
    rows = ensemble.brightness(np.tile(t, 10), member, sun, np.tile(observer, (10, 1)), shape=axes)
    assert np.array_equal(grid.ravel(), rows)
    own = ensemble.brightness(
        np.tile(t, (10, 1)), None, sun, observer, shape=axes, low=np.zeros(())
    )
    assert np.array_equal(own, grid)
    one = ensemble.brightness(t[7], None, sun, observer[7], shape=axes)
    assert np.array_equal(one, grid[:, 7])
    of_one = ensemble.brightness(t, 4, sun, observer, shape=Ellipsoid(axes[4]))
    assert np.array_equal(of_one, grid[4])


@pytest.mark.parametrize("law", ["lambert", "lommel-seeliger-lambert"])
def test_meshes(ensemble, law):
    member, t, sun, observer = _rows(300)
    history = ensemble.at(t, member=member)
    one = [_solids.box((3.0, 2.0, 1.0))]
    each = [_solids.box((3.0, 2.0, 1.0 + k)) for k in range(9)] + [one[0]]
    for shapes in (one, each):
        given = shapes[0] if len(shapes) == 1 else shapes
        found = ensemble.brightness(t, member, sun, observer, shape=given, law=law)
        expected = _expected(history, shapes, law, sun, observer)
        assert np.allclose(found, expected, rtol=LIMIT, atol=1e-13)
    mixed = [*each[:9], Ellipsoid((3, 2, 1))]
    if law == "lambert":
        with pytest.raises(AttitudeError, match="closed form under the law"):
            ensemble.brightness(t, member, sun, observer, shape=mixed, law=law)
    else:
        found = ensemble.brightness(t, member, sun, observer, shape=mixed)
        expected = _expected(history, mixed, "lommel-seeliger", sun, observer)
        assert np.allclose(found, expected, rtol=LIMIT, atol=1e-13)


def test_magnitudes(ensemble):
    member, t, sun, observer = _rows(200)
    given = (t, member, sun, observer)
    bright = ensemble.brightness(*given, shape=_axes())
    reduced = ensemble.reduced_magnitude(*given, shape=_axes())
    assert np.allclose(reduced, light_curve.reduced_magnitude(bright), rtol=0, atol=1e-13)
    redder = ensemble.reduced_magnitude(*given, shape=_axes(), sun_magnitude=-27.0)
    assert np.allclose(redder - reduced, -27.0 + 26.76, rtol=0, atol=1e-12)
    far = [np.linalg.norm(each, axis=-1) for each in (sun, observer)]
    apparent = light_curve.apparent_magnitude(bright, *far)
    assert np.allclose(ensemble.magnitude(*given, shape=_axes()), apparent, rtol=0, atol=1e-12)
    in_au = [each / ASTRONOMICAL_UNIT_M * units.au for each in (sun, observer)]
    found = ensemble.magnitude(t, member, *in_au, shape=_axes())
    assert np.allclose(found, apparent, rtol=0, atol=1e-12)
    assert np.shape(ensemble.magnitude(5.0, 3, sun[0], observer[0], shape=_axes())) == ()


def test_what_is_missing_is_nan():
    arrays = {
        "moments": [(1, 2, 2.5), (1, 1, 5)], "wxyz": (1, 0, 0, 0),
        "angular_velocity": (0.1, 0, 0.2), "epoch": EPOCH,
    }  # fmt: skip
    kept = Ensemble(**arrays, on_error="nan")
    box = _solids.box((1, 2, 3))
    sun = np.array([(1.0, 0, 0), (np.nan, 0, 0), (1, 0, 0)])
    for shape in ((3, 2, 1), box):
        options = {"shape": shape, "law": "lommel-seeliger"}
        found = kept.brightness([0.0, 1.0, np.nan], None, sun, (0, 1, 0.5), **options)
        assert np.isnan(found).tolist() == [[False, True, True], [True] * 3]
        far = kept.brightness([0.0, 1e300], [0, 0], sun[0], (0, 1, 0.5), **options)
        assert np.isnan(far).tolist() == [False, True] and far[0] == found[0, 0]


def test_bad_input(ensemble):
    member, t, sun, observer = _rows(4)
    good = {"shape": (3, 2, 1), "sun": sun, "observer": observer}
    shapes = [Ellipsoid((3, 2, 1))] * 10
    for changes, sentence in (
        ({"shape": [*shapes[:7], None, *shapes[:2]]}, "member 7 of 10: its shape is missing"),
        ({"shape": None}, "shape is missing; give an Ellipsoid"),
        ({"shape": shapes[:3]}, "3 shapes are given for 10 members"),
        ({"shape": np.ones((9, 3))}, r"give semi-axes \(3,\) or \(10, 3\)"),
        ({"shape": np.diag([1.0, 1, 1, -1, 1, 1, 1, 1, 1, 1])[:, :3]}, "member 0 of 10: its semi"),
        ({"shape": [*shapes[:9], "ball"]}, "its shape is 'ball'"),
        ({"sun": None}, "sun is missing"),
        ({"observer": observer[:3]}, "observer has shape"),
        ({"sun": np.zeros(3)}, r"sun of member \d of 10 is \[0.0, 0.0, 0.0\]"),
        ({"observer": (np.inf, 0, 0)}, "observer of member"),
        ({"law": "lambert"}, "closed form"),
        ({"law": "magic"}, "law is 'magic'"),
        ({"out": np.empty(3)}, "give a writable float64 array"),
        ({"threads": -1}, "threads is -1"),
    ):  # fmt: skip
        with pytest.raises(AttitudeError, match=sentence):
            ensemble.brightness(t, member, **{**good, **changes})
    with pytest.raises(AttitudeError, match="member 0 of 10: an epoch lies"):
        ensemble.brightness([1e300], [0], shape=(1, 1, 1), sun=sun[0], observer=sun[0])
    assert ensemble.brightness([], [], shape=(1, 1, 1), sun=sun[0], observer=sun[0]).shape == (0,)
