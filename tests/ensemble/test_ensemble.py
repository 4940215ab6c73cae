"""Ensembles: the bits of FreeRotation for every member, in grids and in ragged rows."""

import pickle

import numpy as np
import pytest
from astropy import units
from astropy.time import Time, TimeDelta

from attitude import AttitudeError, Body, Ensemble, FreeRotation, Mode, Spin, catalog
from tests.support import states

EPOCH = "2026-01-01T00:00:00"


def _states(count=40, seed=3):
    """States of all kinds: both modes, symmetric, uniform, near the separatrix."""
    return states.sample(-(-count // 20), seed=seed)[:count]


def _ensemble(states, **options):
    return Ensemble(
        moments=[s.moments for s in states],
        wxyz=[s.wxyz0 for s in states],
        angular_velocity=[s.omega0 for s in states],
        **{"epoch": EPOCH, **options},
    )


def _motions(states, epochs=None, frame="icrf"):
    epochs = [EPOCH] * len(states) if epochs is None else epochs
    return [
        FreeRotation(Body(moments=s.moments), Spin(e, s.wxyz0, s.omega0, frame))
        for s, e in zip(states, epochs, strict=True)
    ]


def _same(history, k, single):
    """Whether the attitudes and rates of row k are those of a single history, bit for bit."""
    return np.array_equal(history.wxyz[k], single.wxyz, equal_nan=True) and np.array_equal(
        history.angular_velocity[k], single.angular_velocity, equal_nan=True
    )


@pytest.mark.parametrize("frame", ["icrf", "ecliptic"])
def test_grids_have_the_bits_of_single_motions(frame):
    given = _states()
    ensemble, t = _ensemble(given, frame=frame), np.linspace(-50.0, 500.0, 37)
    shared, own = ensemble.at(t), ensemble.at(np.outer(np.arange(1, len(given) + 1), t))
    one, dated = ensemble.at(7.5), ensemble.at(["2026-01-01T00:01:00", "2027-01-01"])
    for k, motion in enumerate(_motions(given, frame=frame)):
        assert _same(shared, k, motion.at(t))
        assert _same(own, k, motion.at((k + 1) * t))
        assert _same(one, k, motion.at(7.5))
        assert _same(dated, k, motion.at(["2026-01-01T00:01:00", "2027-01-01"]))
        assert _same(shared, k, ensemble[k].at(t))


@pytest.mark.parametrize("threads", [1, 3])
def test_ragged_rows_in_any_order(threads):
    given = _states()
    ensemble, rng = _ensemble(given), np.random.default_rng(5)
    member = rng.integers(0, len(given), 3000)
    t = rng.uniform(-1e3, 1e3, member.size)
    found = ensemble.at(t, member=member, threads=threads, angular_velocity=True)
    order = np.argsort(member, kind="stable")
    ordered = ensemble.at(t[order], member=member[order], threads=threads)
    assert np.array_equal(found.wxyz[order], ordered.wxyz)
    assert np.array_equal(found.angular_velocity[order], ordered.angular_velocity)
    for k, motion in enumerate(_motions(given)):
        assert _same(found, member == k, motion.at(t[member == k]))
    few = found[member == 3]
    assert np.array_equal(few.angular_velocity, found.angular_velocity[member == 3])
    assert np.all(few.member == 3)


def test_rows_longer_than_a_piece_of_work():
    """One member's rows span pieces; the last piece is short."""
    given = _states(2)
    ensemble = _ensemble(given)
    member = np.repeat([1, 0], [300_000, 11])
    t = np.linspace(0.0, 1e5, member.size)
    found = ensemble.at(t, member=member, threads=2).wxyz
    motions = _motions(given)
    assert np.array_equal(found[:300_000], motions[1].at(t[:300_000]).wxyz)
    assert np.array_equal(found[300_000:], motions[0].at(t[300_000:]).wxyz)
    long = ensemble.at(np.stack([t, t]), threads=2).wxyz
    assert np.array_equal(long[1, :300_000], found[:300_000])


def test_second_doubles_and_epochs_of_their_own():
    given = _states(20)
    starts = [f"2026-01-{k + 1:02d}T03:00:00.125" for k in range(len(given))]
    ensemble = _ensemble(given, epoch=starts)
    assert ensemble.epoch is None
    assert ensemble.epoch_of(3) == Spin(starts[3], (1, 0, 0, 0), (0, 0, 1)).epoch
    # TDB, of which the difference from TT is not interpolated in long arrays
    days = Time(["2026-02-01T00:00:00", "2026-03-05T07:00:00.3"], scale="tdb")
    member = np.arange(len(given)).repeat(2)
    dated, grid = ensemble.at(days[np.tile([0, 1], len(given))], member=member), ensemble.at(days)
    low = np.full(5, 3e-9)
    plain = ensemble.at(np.arange(5.0), low=low)
    for k, motion in enumerate(_motions(given, starts)):
        assert _same(dated, member == k, motion.at(days))
        assert _same(grid, k, motion.at(days))
        assert _same(plain, k, motion.at(np.arange(5.0), low=low))
    assert np.max(np.abs((dated.time[:2] - days).to_value("s"))) < 1e-10
    durations = ensemble.at([1, 2] * units.min)
    assert np.array_equal(durations.wxyz, ensemble.at([60.0, 120.0]).wxyz)
    with pytest.raises(AttitudeError, match="TimeDelta"):
        ensemble.at(TimeDelta(60.0, format="sec", scale="tai"))


@pytest.mark.parametrize("family", ["tumbling", "near_separatrix", "symmetric", "needle"])
def test_tensors_keep_the_precision_of_single_bodies(family):
    given = states.sample(3, families=[family], seed=8)
    rows = [states.tensor(state) for state in given]
    tensors = np.array([tensor for tensor, _ in rows])
    rates = np.array([omega for _, omega in rows])
    spin = {"wxyz": [s.wxyz0 for s in given], "angular_velocity": rates, "epoch": EPOCH}
    ensemble = Ensemble(tensors=tensors, **spin)
    bodies = Ensemble([Body(tensor=tensor) for tensor in tensors], **spin)
    shared = Ensemble(Body(tensor=tensors[0]), **spin)
    t = np.array([0.0, 1e3, 1e6, 1e9])
    for k, state in enumerate(given):
        motion = FreeRotation(Body(tensor=tensors[k]), Spin(EPOCH, state.wxyz0, rates[k]))
        for each in (ensemble, bodies, pickle.loads(pickle.dumps(ensemble))[k : k + 1]):
            assert _same(each.at(t), 0 if len(each) == 1 else k, motion.at(t))
            assert each.mode[0 if len(each) == 1 else k] == motion.mode
        first = FreeRotation(Body(tensor=tensors[0]), Spin(EPOCH, state.wxyz0, rates[k]))
        assert _same(shared.at(t), k, first.at(t))
        size = np.linalg.norm(motion.momentum)
        assert np.allclose(ensemble.momentum[k], motion.momentum, rtol=0.0, atol=4e-16 * size)
        assert _same(ensemble.at(t), k, ensemble[k].at(t))


def test_arrays_of_descriptions():
    given = _states(60)
    ensemble = _ensemble(given)
    for k, motion in enumerate(_motions(given)):
        assert ensemble.mode[k] == motion.mode
        for name in ("period_psi", "period_phi", "energy"):
            assert getattr(ensemble, name)[k] == getattr(motion, name), name
        assert np.array_equal(ensemble.momentum[k], motion.momentum)
        assert np.array_equal(ensemble.energy_ratio[k], motion.regime.energy_ratio, equal_nan=True)
        for convention in "LS":
            both = ensemble.nutation(convention)[k], motion.regime.nutation(convention)
            assert np.array_equal(*both, equal_nan=True)


def test_parts_and_joined_ensembles():
    given = _states(20)
    names = [f"body {k}" for k in range(len(given))]
    ensemble, t = _ensemble(given, names=names), np.arange(4.0)
    all_of_them = ensemble.at(t).wxyz
    assert isinstance(ensemble[3], FreeRotation) and isinstance(ensemble["body 3"], FreeRotation)
    assert np.array_equal(ensemble["body 3"].at(t).wxyz, all_of_them[3])
    for index, which in (
        (slice(2, 9, 2), range(2, 9, 2)),
        (np.arange(20) % 3 == 0, range(0, 20, 3)),
        ([5, 1, -1], [5, 1, 19]),
        (["body 5", "body 1"], [5, 1]),
        ([], range(0)),
    ):
        part = ensemble[index]
        assert np.array_equal(part.at(t).wxyz, all_of_them[list(which)])
        assert list(part.names) == [names[k] for k in which]
    joined = ensemble[10:] + ensemble[:10]
    assert np.array_equal(joined.at(t).wxyz, np.roll(all_of_them, -10, axis=0))
    tensor = Ensemble(
        tensors=[[2, 0, 0], [0, 2.5, 0.5], [0, 0.5, 2.5]], wxyz=(1, 2, 3, 4),
        angular_velocity=(1, 2, 3), epoch="2027-01-01", names=["rotated"],
    )  # fmt: skip
    mixed = Ensemble.concatenated([ensemble, tensor])
    assert np.array_equal(mixed.at(t, member=np.full(4, 20)).wxyz, tensor[0].at(t).wxyz)
    assert np.array_equal(mixed[:20].at(t).wxyz, all_of_them)
    again = pickle.loads(pickle.dumps(mixed))
    assert np.array_equal(again.at(t).wxyz, mixed.at(t).wxyz)
    assert again.epoch_of(20) == tensor.epoch
    by_name = mixed.at(t[:2], member=["rotated", "body 7"])
    assert np.array_equal(by_name.member, [20, 7])


def test_of_motions():
    given = _states(20)
    motions = _motions(given[:10], frame="ecliptic") + _motions(given[10:], frame="icrf")
    t = np.array([0.0, 1e3, 1e7])
    for part in (motions[:10], motions):
        ensemble = Ensemble.of(part)
        for k, motion in enumerate(part):
            assert _same(ensemble.at(t), k, motion.at(t))
            assert _same(ensemble.at(t), k, ensemble[k].at(t))
        assert np.array_equal([motion.spin.wxyz for motion in ensemble], ensemble.wxyz)
        assert len(list(ensemble[:10].arcs([]))) == 10
    assert Ensemble.of(motions[:2])[1].body is motions[1].body
    toutatis = catalog.entry("toutatis").motion()
    for named in ("toutatis", ["toutatis"], [toutatis]):
        assert _same(Ensemble.of(named).at(t), 0, toutatis.at(t))


def test_members_that_are_not_physical():
    arrays = {
        "moments": np.array([[1.0, 2, 2.5], [1, 1, 5], [3, 4, 5], [1, 2, 2]]),
        "wxyz": np.array([[1.0, 0, 0, 0], [1, 0, 0, 0], [np.nan, 0, 0, 1], [1, 2, 3, 4]]),
        "angular_velocity": np.array([[0.1, 0.2, 0.3]] * 4),
        "epoch": EPOCH,
        "names": ["a", "b", "c", "d"],
    }
    with pytest.raises(AttitudeError, match=r"member 1 of 4 \('b'\): moments .*1 more"):
        Ensemble(**arrays)
    ensemble, t = Ensemble(**arrays, on_error="nan"), np.arange(3.0)
    assert ensemble.is_physical.tolist() == [True, False, False, True]
    assert ensemble.mode.tolist() == [Mode.SHORT_AXIS, -1, -1, Mode.SYMMETRIC]
    wrong = np.isnan(ensemble.period_psi)
    assert wrong.tolist() == [False, True, True, False]
    for history in (ensemble.at(t), ensemble.at(np.tile(t, (4, 1)))):
        assert np.array_equal(np.isnan(history.wxyz).all(axis=(1, 2)), wrong)
        assert np.array_equal(np.isnan(history.angular_velocity).all(axis=(1, 2)), wrong)
        assert np.array_equal(history.wxyz[3], ensemble[3].at(t).wxyz)
    rows = ensemble.at(np.zeros(4), member=[3, 2, 1, 0])
    assert np.isnan(rows.wxyz[:, 0]).tolist() == [False, True, True, False]
    assert np.isnan((ensemble[[1, 3]] + ensemble[:1]).period_phi).tolist() == [True, False, False]
    with pytest.raises(AttitudeError, match="moments are"):
        _ = ensemble["b"]
    for quantity in (ensemble.energy, ensemble.momentum[:, 0]):
        assert np.array_equal(np.isnan(quantity), wrong)
    assert ensemble._repr_html_().count("not physical") == 2
    empty = Ensemble(
        moments=[(1, 2, 2.5), (np.nan,) * 3],
        wxyz=(1, 0, 0, 0),
        angular_velocity=(0.1, 0.2, 0.3),
        epoch=EPOCH,
        on_error="nan",
    )
    bends = empty.at(t).angular_acceleration
    assert np.isfinite(bends[0]).all() and np.isnan(bends[1]).all()
    with pytest.raises(AttitudeError, match="some attitudes are NaN"):
        ensemble.at(t).euler("ZXZ")
    with pytest.raises(AttitudeError, match="Ensemble has no covariance"):
        _ = ensemble.at(t).nonlinearity


def test_epochs_beyond_reach():
    given = _states(3)
    far = np.array([0.0, 1e300, 5.0])
    with pytest.raises(AttitudeError, match="member 0 of 3: an epoch lies 1e\\+300 s"):
        _ensemble(given).at(far)
    with pytest.raises(AttitudeError, match="member 1 of 3: an epoch lies 1e\\+300 s"):
        _ensemble(given).at([0.0, 1e300], member=[2, 1])
    kept = _ensemble(given, on_error="nan")
    grid, low = kept.at(far), kept.at(far, low=np.zeros(3))
    rows = kept.at(np.tile(far, 3), member=np.repeat([0, 1, 2], 3))
    for found in (grid.wxyz, low.wxyz, rows.wxyz.reshape(3, 3, 4)):
        assert np.array_equal(np.isnan(found[:, :, 0]), [[False, True, False]] * 3)
        assert np.array_equal(found[:, 2], kept.at(5.0).wxyz)
    assert np.isnan(rows.angular_velocity[1]).all()


def test_output_arrays():
    given = _states(5)
    ensemble, t = _ensemble(given), np.linspace(0.0, 9.0, 7)
    found = ensemble.at(t, angular_velocity=True)
    for out in (np.empty((5, 7, 4)), np.moveaxis(np.empty((5, 4, 7)), 1, 2)):
        rates = np.empty((5, 7, 3))
        history = ensemble.at(t, out=out, rates_out=rates)
        assert np.array_equal(out, found.wxyz) and np.array_equal(rates, found.angular_velocity)
        assert np.shares_memory(history.wxyz, out)
    member = np.array([3, 3, 1, 4])
    for out in (np.empty((4, 4)), np.empty((4, 4)).T):
        ensemble.at(t[:4], member=member, out=out)
        assert np.array_equal(out, found.wxyz[member, np.arange(4)])
    with pytest.raises(AttitudeError, match="out is an array of shape"):
        ensemble.at(t, out=np.empty((5, 7, 3)))


def test_ensembles_of_none_and_one():
    given = _states(1)
    one = _ensemble(given)
    assert one.at(3.0).wxyz.shape == (1, 4) and one.at([3.0]).wxyz.shape == (1, 1, 4)
    none = one[:0]
    assert len(none) == 0 and none.at([1.0, 2.0]).wxyz.shape == (0, 2, 4)
    assert none.mode.shape == none.period_psi.shape == (0,) and none.momentum.shape == (0, 3)
    assert none.at([], member=[]).wxyz.shape == (0, 4)
    with pytest.raises(AttitudeError, match="member 0 of row 0 is out of range"):
        none.at([1.0], member=[0])
    empty = Ensemble(
        moments=np.zeros((0, 3)), wxyz=np.zeros((0, 4)), angular_velocity=np.zeros((0, 3)),
        epoch=EPOCH,
    )  # fmt: skip
    assert len(empty + one) == 1


GOOD = {"moments": [(1, 2, 2.5)] * 2, "wxyz": [(1, 0, 0, 0)] * 2, "epoch": EPOCH}
RATES = [(0.1, 0, 0.2)] * 2


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"wxyz": [(1, 0, 0, 0)] * 3}, "different numbers of members .moments 2, wxyz 3"),
        ({"wxyz": [(1, 0, 0, 0), (1, 0, 0)]}, "wxyz is ragged"),
        ({"wxyz": [(1, 0, 0)] * 2}, r"wxyz has shape \(2, 3\); give \(4,\) or \(N, 4\)"),
        ({"wxyz": None}, "wxyz is missing"),
        ({"epoch": 5.0}, "length of time"),
        ({"epoch": None}, "epoch is missing"),
        ({"epoch": [EPOCH, None]}, "epoch holds None"),
        ({"epoch": np.array(["2026-01-01", "NaT"], "M8[s]")}, "epoch 1 of 2 is missing"),
        ({"moments": None}, "takes one of body="),
        ({"names": ["a", "a"]}, "two members are called 'a'"),
        ({"names": ["a ", "a"]}, "two members are called 'a'"),
        ({"names": ["a", " "]}, "member 1 has an empty name"),
        ({"names": ["a"] * 3}, "names 3"),
        ({"names": 5}, "names is 5"),
        ({"frame": "j2000"}, "means two things"),
        ({"on_error": "ignore"}, "on_error is 'ignore'"),
        ({"moments": [(-1, 2, 2.5), (1, 2, 2.5)]}, "member 0 of 2: moments are"),
        ({"body": 3, "moments": None}, "3 is not a list"),
        ({"tensors": [np.eye(3), np.triu(np.ones((3, 3)))], "moments": None}, "Tensor 1 of 2"),
    ],
)  # fmt: skip
def test_bad_input_of_the_constructor(changes, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        Ensemble(**{**GOOD, "angular_velocity": RATES, **changes})


def test_bad_input_of_at():
    ensemble = Ensemble(**GOOD, angular_velocity=RATES)
    for t, member, sentence in (
        ([0.0, 1.0], [0, 2], "member 2 of row 1 is out of range: the ensemble has 2"),
        ([0.0, 1.0], [0, -1], "member -1 of row 1"),
        ([0.0, 1.0], [0.0, 1.0], "give whole numbers or names"),
        ([0.0, 1.0], [True, False], "give whole numbers or names"),
        ([0.0, 1.0], ["a", "b"], "no member is called 'a'; the ensemble has no names"),
        ([0.0, 1.0], [[0], [1, 0]], "member is ragged"),
        ([[0.0], [1.0, 2.0]], None, "t is ragged"),
        ([0.0, 1.0, 2.0], [0, 1], "give one member for each epoch"),
        (np.zeros((3, 4)), None, r"t has shape \(3, 4\); give \(T,\)"),
        (["tomorrow"], None, "tomorrow"),
    ):
        with pytest.raises(AttitudeError, match=sentence):
            ensemble.at(t, member=member)
    for index, sentence in ((7, "member 7 is out of range"), (1.5, "chosen by 1.5"),
                            ([True], "the mask has 1 entries"), ([5], "out of range"),
                            ([[1], [0, 1]], "members are chosen by")):  # fmt: skip
        with pytest.raises(AttitudeError, match=sentence):
            _ = ensemble[index]
    with pytest.raises(AttitudeError, match="threads"):
        ensemble.at([0.0], threads=0)
    with pytest.raises(AttributeError, match="does not change"):
        ensemble.wxyz = 1


def test_histories_have_tables_and_frames():
    ensemble = Ensemble(**GOOD, angular_velocity=RATES, names=["a", "b"])
    history = ensemble.at([0.0, 1.0, 2.0])
    table = history.table()
    assert table["name"].tolist() == ["a"] * 3 + ["b"] * 3 and len(table) == 6
    assert history.body_to_inertial([0, 0, 1]).shape == (2, 3, 3)
    single = ensemble[1].at([0.0, 1.0, 2.0])
    assert np.array_equal(history[1].matrix, single.matrix)
    assert np.allclose(
        history.angular_acceleration[1], single.angular_acceleration, rtol=0.0, atol=1e-16
    )
    with pytest.raises(AttitudeError, match="no standard deviations"):
        history.table(sigma=True)
