"""Rotation about one axis over several apparitions: linear fits of many rates, and the search."""

import itertools
import math

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, inversion
from attitude.frames import matrix_to_icrf, quaternion
from attitude.inversion import _apparitions, _moving, _pole_map, _problem, _shapes
from attitude.inversion._ellipsoid import SearchState
from attitude.torques import ConstantTorque
from benchmarks import inversion_apparitions


@pytest.fixture(scope="module")
def known():
    """A curve of 25 years of relative nights and a survey, its period (h) and its pole."""
    return inversion_apparitions.rotator(100)


@pytest.fixture(scope="module")
def problem(known):
    curve = known[0]
    return _problem.problem(curve, 12.0 / 86400.0, 0.07, curve.zero_points)[0]


def test_sums_of_cells_are_those_of_the_points(problem):
    """Gains of rates against least squares with all linear terms projected out."""
    combs = _apparitions.Combs(problem)
    assert combs.total == pytest.approx(problem.chi_squared(np.zeros(len(problem))), rel=1e-7)
    columns = _apparitions.harmonics_about(problem, _pole_map.sphere(100)[37])
    rates = 20000.0 + np.array([0.0, 0.4, 3.0])
    [(_, gain, _)] = combs.gains([columns], rates)
    exact = [next(combs.gains([columns], rates[k : k + 1])) for k in range(3)]
    y = problem.y * problem.root
    turning = columns.turns > 0
    for k, rate in enumerate(rates):
        z = columns.values * np.exp(-2j * np.pi * rate * problem.t * columns.turns[:, None])
        rows = np.concatenate([z.real, z.imag[turning]]) * problem.root
        left = rows - (rows @ problem.u.T) @ problem.u
        widths = np.concatenate([columns.widths, columns.widths[turning]])
        x = np.linalg.solve(left @ rows.T + np.diag(widths**-2.0), left @ y)
        # of several rates, a cell has the phase within it of the middle one: in a night of 7 h 1.5
        # turns of 9000 d are 2e-4 rad, fourfold in the last harmonic
        assert gain[0, k] == pytest.approx(x @ (left @ y), rel=1e-3)
        assert exact[k][1][0, 0] == pytest.approx(x @ (left @ y), rel=1e-6)
        assert exact[k][2][0, 0] == pytest.approx(x, abs=1e-6)


def test_a_curve_falls_into_its_apparitions(problem, known):
    found = _apparitions.apparitions(problem)
    assert sum(np.count_nonzero(each) for each in found) == len(problem)
    order = np.argsort([problem.t[each].min() for each in found])
    ends = [(problem.t[found[k]].min(), problem.t[found[k]].max()) for k in order]
    gaps = [(b[0] - a[1]) * problem.span / 86400.0 for a, b in itertools.pairwise(ends)]
    assert min(gaps) > 60.0


def test_period_and_pole_of_25_years(known):
    """The number of turns, among those of 2 % of the period, and the pole to 10 degrees."""
    curve, period, pole = known
    found = inversion.spin_states(curve, period=f"{period * 1.003} h", budget=900)
    right, own, _ = inversion_apparitions.judged(found, curve, period, pole)
    assert found.verdict == "solved" and found[0].mode == "PA"
    assert right and own < 10.0
    assert abs(found[0].P_phi / 3600.0 - period) < 4.0 * found[0].periods_sigma[1] / 3600.0
    assert found[0].rms < 0.035


def test_refine_keeps_a_rotation_about_one_axis(known):
    """Of one apparition, from the truth with a wrong shape: rates across the axis stay zero."""
    curve, period, pole = known
    whole = _problem.problem(curve, 12.0 / 86400.0, 0.07, curve.zero_points)[0]
    part = curve[max(_apparitions.apparitions(whole), key=np.count_nonzero)]
    wxyz = _turned_to(matrix_to_icrf("ecliptic") @ pole)
    rates = [0.0, 0.0, 2.0 * math.pi / (3600.0 * period)]
    start = FreeRotation(
        Body(moments=[0.6, 0.9, 1.0], relative=True), Spin(part.epoch, wxyz, rates)
    )
    problem = _problem.problem(part, 12.0 / 86400.0, 0.07, part.zero_points)[0]
    point = _moving.moving_point(start, part.epoch, (-1e8, 1e8), None, ConstantTorque((0, 0, 0)))
    fit = _moving.moving_fit(part.epoch, problem, point, None, _shapes.Tie())
    assert fit.fixed[:11].tolist() == [k in (3, 4, 6, 7, 8, 9) for k in range(11)]
    free = _moving.moving_point(start, part.epoch, (-1e8, 1e8), None, None)
    fit = _moving.moving_fit(part.epoch, problem, free, None, _shapes.Tie())
    found = fit.minimum(problem, _moving.MovingState(free, np.zeros(_shapes.SIZE)), 3)
    assert found.cost < math.inf and fit.is_axial
    assert np.all(found.state.point.spin.angular_velocity[:2] == 0.0)
    assert found.state.point.axis == 2


def _turned_to(pole):
    """The attitude whose z axis is a direction (3,)."""
    first = np.cross(pole, np.eye(3)[np.argmin(np.abs(pole))])
    first = first / np.linalg.norm(first)
    return quaternion.from_matrix(np.stack([first, np.cross(pole, first), pole], axis=-1))


def test_two_rotations_are_compared_across_gaps(problem):
    """By the angle between the bodies as the scene sees them, not by turns in the gaps."""
    state = np.zeros(16)
    state[0], state[5:14] = 1e4, np.eye(3).ravel()
    other = state.copy()
    other[0] += 0.1
    assert _pole_map.has_turn(problem, state, other)
    other[0] += 0.3
    assert not _pole_map.has_turn(problem, state, other)
    tilted, angle = state.copy(), math.radians(20.0)
    c, s = math.cos(angle), math.sin(angle)
    tilted[5:14] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]).ravel()
    assert _pole_map.has_turn(problem, state, tilted)
    assert SearchState.of(tilted).pole[2] == pytest.approx(c)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "max_frequency is missing"),
        ({"period": ("3 h", "2 h")}, "give the shorter one first"),
        ({"period": ("2 h", "3 h", "4 h")}, "period has 3 entries"),
        ({"period": "3 h", "modes": ("LAM",)}, "rotation about one axis"),
        ({"period": "3 h", "max_frequency": "1 /d"}, "no period from"),
        ({"max_frequency": "3 /d", "modes": ("PA", "LAM")}, 'leave "PA" out'),
        ({"max_frequency": "12 /d"}, 'modes=("PA",)'),
    ],
)
def test_arguments_that_no_search_has(known, given, words):
    with pytest.raises(AttitudeError) as caught:
        inversion.spin_states(known[0], **given)
    assert words in str(caught.value)
