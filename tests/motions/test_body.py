"""Mass properties: known bodies, equal constructors, and what is refused."""

import copy
import math

import numpy as np
import pytest
from astropy import units as u

from attitude import AttitudeError, Body, shape

TENSOR = [[14.0, -3.0, 1.5], [-3.0, 19.0, 2.0], [1.5, 2.0, 22.0]]


# ---- from points, solids and units -------------------------------------------------------------


def test_point_masses_from_any_origin():
    """Eqs. 2.1 and 2.2 of the paper: about the centre of mass, wherever the origin is."""
    rng = np.random.default_rng(1)
    masses, positions = rng.uniform(1, 5, 12), rng.normal(size=(12, 3))
    centre = masses @ positions / masses.sum()
    tensor = sum(
        m * (r @ r * np.eye(3) - np.outer(r, r))
        for m, r in zip(masses, positions - centre, strict=True)
    )
    body = Body.from_points(masses, positions + np.array([10.0, -20.0, 30.0]))
    assert np.allclose(body.tensor, tensor, rtol=0, atol=1e-12)  # kg m2: 1e-16 of 5 kg (37 m)^2
    assert np.allclose(
        body.center_of_mass, centre + np.array([10.0, -20.0, 30.0]), rtol=0, atol=1e-13
    )
    assert body.mass == pytest.approx(masses.sum(), rel=1e-15)


def test_a_dumbbell_is_a_rod():
    """Two points, and not along an axis: rounding leaves no moment about the line, nor two others.

    The moment about the line is 0 or a rounding error, and never a reason to refuse the body.
    """
    for direction in ((1.0, 2.0, 3.0), (0.3, -0.1, 0.7), (0.0, 0.0, 1.0), (1e-3, 5.0, -2.0)):
        body = Body.from_points([1.5, 2.5], [np.zeros(3), np.array(direction)])
        reduced = 1.5 * 2.5 / 4.0 * np.dot(direction, direction)
        assert abs(np.sort(body.moments)[0]) <= 1e-14 * reduced
        assert np.allclose(np.sort(body.moments)[1:], reduced, rtol=1e-14)


def test_an_ellipsoid():
    """m (b^2 + c^2) / 5 about the axis a."""
    body = Body.from_ellipsoid((3.0, 2.0, 1.0), mass=10.0)
    assert np.allclose(body.moments, [10.0, 20.0, 26.0], rtol=2e-16)
    assert body.mass == 10.0 and not body.relative
    assert Body.from_ellipsoid((3, 2, 1)).relative
    by_text = Body.from_ellipsoid("3000, 2000, 1000 mm")
    assert by_text.relative and by_text.moments == pytest.approx([1.0, 2.0, 2.6], rel=1e-15)


def test_a_shape_with_and_without_a_density():
    """A cube of 2 m off the origin: 8 m3, and m s^2 / 6 about its centre."""
    cube = shape.box((2, 2, 2), center=(1, 2, 3))
    known, unknown = Body.from_shape(cube, density=1000.0), Body.from_shape(cube)
    shell = Body.from_shape(cube, surface_density=20.0)
    assert np.array_equal(shell.tensor, cube.mass_properties(surface_density=20.0).inertia)
    assert shell.mass == pytest.approx(20.0 * cube.areas.sum()) and not shell.relative
    with pytest.raises(AttitudeError, match="give either density"):
        Body.from_shape(cube, density=1000.0, surface_density=20.0)
    with pytest.raises(AttitudeError, match="surface_density is that of a Mesh"):
        Body.from_shape(shape.Ellipsoid((3.0, 2.0, 1.0)), surface_density=20.0)
    assert known.mass == 8000.0 and not known.relative
    assert unknown.mass is None and unknown.relative
    assert np.allclose(known.moments, 16000 / 3, rtol=1e-15)
    assert np.array_equal(known.center_of_mass, [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    "moments",
    [
        (10, 20, 26),
        [10.0, 20.0, 26.0],
        np.array([10, 20, 26], dtype=np.int32),
        np.array([10, 20, 26], dtype=np.float32),
        [10, 20, 26] * u.kg * u.m**2,
        [1e8, 2e8, 2.6e8] * u.g * u.cm**2,
        (10 * u.kg * u.m**2, 2e8 * u.g * u.cm**2, 26 * u.kg * u.m**2),
    ],
)
def test_moments_of_any_kind_and_unit(moments):
    assert np.allclose(Body(moments=moments).moments, (10, 20, 26), rtol=3e-16)


def test_moments_stay_in_their_order():
    body = Body(moments=(26, 10, 20))
    assert np.array_equal(body.moments, [26, 10, 20])
    assert np.array_equal(body.principal_axes, np.eye(3))
    assert np.array_equal(body.tensor, np.diag([26, 10, 20]))


def test_principal_axes_are_right_handed_and_ascending():
    body = Body(tensor=TENSOR)
    axes = body.principal_axes
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-15)
    assert np.allclose(np.array(TENSOR) @ axes, axes * body.moments, rtol=0, atol=1e-14)
    assert np.all(np.diff(body.moments) > 0)


# ---- values do not change ----------------------------------------------------------------------


def test_a_body_is_a_value():
    given = np.array([10.0, 20.0, 26.0])
    body = Body(moments=given)
    given[0] = 99.0
    assert body.moments[0] == 10.0
    for name in ("moments", "tensor", "principal_axes", "center_of_mass"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(body, name)[...] = 0.0
    with pytest.raises(AttributeError):
        body.moments = (1, 2, 3)
    with pytest.raises(ValueError, match="read-only"):
        copy.deepcopy(body).tensor[0, 0] = 0.0


def test_the_tensor_given_is_copied():
    given = np.array(TENSOR)
    body = Body(tensor=given)
    given[0, 0] = 99.0
    assert body.tensor[0, 0] == 14.0


# ---- what is refused ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, r"takes either moments=\(3 numbers\) or tensor=\(3 x 3\)"),
        ({"moments": (1, 2, 2), "tensor": np.eye(3)}, "takes either moments"),
        ({"moments": (-1, 2, 2)}, r"moments are \(-1, 2, 2\).*must not be negative"),
        ({"moments": (0, 0, 0)}, "at most one of them can be zero"),
        ({"moments": (0, 0, 1)}, "exceeds the sum of the other two"),
        ({"moments": (math.nan, 2, 2)}, "moments holds nan; every number in it must be finite"),
        ({"moments": (math.inf, 2, 2)}, "moments holds inf"),
        ({"moments": (1, 2, 3.1)}, r"exceeds the sum of the other two \(here by 0.1\)"),
        ({"moments": (1, 2, 3 * (1 + 1e-13))}, "exceeds the sum of the other two"),
        ({"moments": (1, 2)}, r"moments has shape \(2,\); give \(3\)"),
        ({"moments": np.ones((2, 3))}, r"moments has shape \(2, 3\)"),
        ({"moments": "ten"}, "moments is 'ten'.*like \"5.2 h\""),
        ({"moments": ("1 kg m2", "2 kg m2", "3 kg m")}, "moments is"),
        ({"moments": [10, 20, 26] * u.kg}, "moments is in kg; give it in kg m2"),
        ({"moments": (1 + 1j, 2, 2)}, "give real numbers"),
        (
            {"moments": None, "tensor": [[1, 2], [2, 1]]},
            r"tensor has shape \(2, 2\); give \(3, 3\)",
        ),
        ({"tensor": [[2, 0.1, 0], [0, 2, 0], [0, 0, 2]]}, "differ by 0.1. Give a symmetric"),
        ({"tensor": [[2, 1e-12, 0], [0, 2, 0], [0, 0, 2]]}, "tensor is not symmetric"),
        ({"tensor": [[1, 0, 0], [0, 2, 0.2], [0, 0.2, 3.5]]}, "principal moments of tensor"),
        ({"tensor": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "must not be negative"),
        ({"tensor": [[1, math.nan, 0], [math.nan, 1, 0], [0, 0, 1]]}, "tensor holds nan"),
        ({"tensor": [[1, 0, 0], [0, 1], [0, 0, 1]]}, "tensor is ragged"),
        ({"moments": (1, 2, 2), "mass": 0.0}, "mass is 0.0; it must be greater than zero"),
        ({"moments": (1, 2, 2), "mass": -1}, "mass is -1.0"),
        ({"moments": (1, 2, 2), "mass": (1, 2)}, r"mass has shape \(2,\); give a single number"),
        ({"moments": (1, 2, 2), "center_of_mass": (1, 2)}, r"center_of_mass has shape \(2,\)"),
        ({"moments": [1, 2, 2] * u.kg * u.m**2, "relative": True}, "must be a pure number"),
    ],
)
def test_bad_input_is_a_sentence(options, message):
    with pytest.raises(AttitudeError, match=message):
        Body(**options)


@pytest.mark.parametrize(
    ("masses", "positions", "message"),
    [
        ([1, 2], np.zeros((3, 3)), r"masses have shape \(2,\) and positions \(3, 3\)"),
        ([1, -2], np.eye(3)[:2], r"masses holds -2\.0; every mass must be greater than zero"),
        ([], np.zeros((0, 3)), r"give \(N,\) and \(N, 3\)"),
        ([1, 1], np.full((2, 3), math.nan), "positions holds nan"),
        ([1], np.zeros((1, 3)), "at most one of them can be zero"),
    ],
)
def test_bad_points(masses, positions, message):
    with pytest.raises(AttitudeError, match=message):
        Body.from_points(masses, positions)


@pytest.mark.parametrize(
    ("axes", "mass", "message"),
    [
        ((3, 2, 0), 1.0, r"axes are \[3.0, 2.0, 0.0\]; semi-axes must be greater than zero"),
        ((3, 2), 1.0, r"axes has shape \(2,\)"),
        ((3, 2, 1), -1.0, "mass is -1.0"),
        ((3, 2, math.nan), None, "axes holds nan"),
    ],
)
def test_bad_ellipsoids(axes, mass, message):
    with pytest.raises(AttitudeError, match=message):
        Body.from_ellipsoid(axes, mass=mass)


@pytest.mark.parametrize("density", [0.0, -1.0, math.nan, "1 kg"])
def test_bad_densities(density):
    with pytest.raises(AttitudeError, match="density"):
        Body.from_shape(object(), density=density)


def test_rounding_is_forgiven():
    """Asymmetry of 1e-13 and triangles short by 1e-14 come from the user's own arithmetic."""
    assert Body(moments=(0.1, 0.2, 0.1 + 0.2)).moments[2] == 0.1 + 0.2
    assert Body(moments=(1, 2, 3 * (1 + 1e-15))).moments[0] == 1
    tensor = np.array(TENSOR)
    tensor[0, 1] *= 1 + 1e-15
    assert np.array_equal(Body(tensor=tensor).tensor, Body(tensor=tensor.T).tensor)


@pytest.mark.parametrize("shape", ["cube.obj", None, (1.0, 2.0, 3.0)])
def test_what_is_no_shape_is_a_sentence(shape):
    with pytest.raises(AttitudeError, match=r"give an attitude\.shape Mesh or Ellipsoid"):
        Body.from_shape(shape, density=1000.0)
