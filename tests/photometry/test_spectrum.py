"""Lines of tumblers' light curves, on light curves of the exact motion."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, catalog, light_curve, photometry
from attitude.errors import AttitudeWarning
from attitude.shape import Ellipsoid

HOUR = 3600.0


def tumbler(mode, omega=None, moments=(2.0, 3.1, 3.6)):
    omega = omega or {"SAM": (0.3, 0.25, 1.0), "LAM": (1.0, 0.2, 0.35)}[mode]
    spin = Spin(epoch="2026-01-01", wxyz=(0.6, -0.3, 0.5, 0.2), angular_velocity=omega)
    return FreeRotation(Body(moments=moments), spin)


def curve(motion, t):
    """Brightness of an ellipsoid under a Sun and an observer that stand still."""
    history = motion.at(t)
    sun = history.inertial_to_body(np.array([0.6, 0.0, 0.8]))
    observer = history.inertial_to_body(np.array([0.0, 0.28, 0.96]))
    return light_curve.brightness(Ellipsoid((1.5, 1.0, 0.8)), "lommel-seeliger", sun, observer)


def epochs(motion, count, periods=37.0):
    rng = np.random.default_rng(3)
    return np.sort(rng.uniform(0, periods * motion.period_psi, count))


@pytest.mark.parametrize("mode", ["SAM", "LAM"])
def test_the_series_converges_to_the_exact_light_curve(mode):
    motion = tumbler(mode)
    assert motion.mode.name == {"SAM": "SHORT_AXIS", "LAM": "LONG_AXIS"}[mode]
    t = epochs(motion, 1200)
    y = curve(motion, t)
    psi, phi = motion.period_psi, motion.period_phi
    fits = [photometry.fit_series(t, y, psi, phi, order=n) for n in (2, 4, 8)]
    rms = [each.rms / np.std(y) for each in fits]
    # Coefficients of an analytic function fall geometrically; wrong lines leave order 1.
    assert rms[1] < 0.3 * rms[0] and rms[2] < 2e-3, rms
    wrong = photometry.fit_series(t, y, psi, phi * 1.037, order=8)
    assert wrong.rms / np.std(y) > 0.3
    found = fits[-1]
    later = t[-1] + epochs(motion, 200)
    assert np.std(found(later) - curve(motion, later)) < 4e-3 * np.std(y)


@pytest.mark.parametrize("mode", ["SAM", "LAM"])
def test_both_conventions_have_the_same_lines(mode):
    motion = tumbler(mode)
    long, short = (photometry.lines(motion, 8, convention=c) for c in "LS")
    inner = [line.frequency for line in photometry.lines(motion, 4, convention="L")]
    every = np.array([line.frequency for line in short])
    # 1/P_phi differs by 1/P_psi, so (i, j) becomes (i, j -+ i).
    assert max(np.min(np.abs(every - f)) for f in inner) < 1e-14
    assert len(long) == len(short) == 2 * 8 * 9


def test_apophis_shows_30_56_hours():
    # Pravec et al., Icarus 233, 48 (2014): P_phi 27.38 h, P_psi 263 h, short-axis mode; the
    # strongest line is the second harmonic of 1/27.38 h - 1/263 h = 1/30.56 h.
    body, spin = catalog.load("99942 Apophis (2014)", phi0=0.0, psi0=0.0, epoch="2012-12-23")
    motion = FreeRotation(body, spin)
    assert motion.period_psi / HOUR == pytest.approx(263.0, abs=0.5)
    assert motion.period_phi / HOUR == pytest.approx(27.38, abs=0.01)
    assert motion.mode.name == "SHORT_AXIS"
    rng = np.random.default_rng(8)
    t = np.sort(rng.uniform(0, 100 * 24 * HOUR, 2000))
    history = motion.at(t)
    across = np.cross(motion.momentum, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    observer = history.inertial_to_body(across)
    y = -2.5 * np.log10(
        light_curve.brightness(Ellipsoid((1.6, 1.1, 1.0)), "lommel-seeliger", observer, observer)
    )
    line, amplitude = photometry.fit_series(
        t, y, motion.period_psi, motion.period_phi, order=4
    ).strongest(1)[0]
    assert (line.i, abs(line.j)) == (2, 2)
    assert 2 * line.period / HOUR == pytest.approx(30.56, abs=0.01)
    assert amplitude > 0.05


def test_a_refined_fold_finds_the_periods_of_the_motion():
    # P_psi / P_phi is 4.3: near a whole number lines would coincide, and either period be free.
    motion = tumbler("SAM", (0.35, 0.2, 1.0), (2.0, 2.6, 3.1))
    t = epochs(motion, 500, periods=8.0)
    rng = np.random.default_rng(4)
    y = curve(motion, t)
    noisy = y + 0.01 * np.std(y) * rng.normal(size=len(y))
    psi, phi = motion.period_psi, motion.period_phi
    near = [1.0 / (1.0 / psi + 0.1 / np.ptp(t)), 1.0 / (1.0 / phi - 0.1 / np.ptp(t))]
    found = photometry.fold(t, near, noisy, order=4, refine=True)
    # In parts of the resolution of the span: what is left out of the series draws them so far.
    span = np.ptp(t)
    assert abs(1 / found.periods[1] - 1 / phi) * span < 2e-3
    assert abs(1 / found.periods[0] - 1 / psi) * span < 2e-3


def test_relative_curves_have_their_own_constants():
    t = np.linspace(0, 500, 300)
    which = (t > 250).astype(int)
    y = np.cos(2 * np.pi * t / 13.0) + np.where(which, 7.0, -2.0)
    found = photometry.fit_series(t, y, 70.0, 13.0, order=1, curve=which, errors=np.full(300, 0.1))
    np.testing.assert_allclose(found.offsets, [-2.0, 7.0], atol=1e-12)
    np.testing.assert_allclose(found(t, which), y, atol=1e-12)
    for wrong in (2, -1, 0.5, which[:3]):
        with pytest.raises(AttitudeError, match="whole numbers from 0 to 1"):
            found(t, wrong)
    line, amplitude = found.strongest(1)[0]
    assert (line.i, line.j) == (1, 0) and amplitude == pytest.approx(1.0, abs=1e-12)
    assert np.max(np.abs(found.residuals)) < 1e-12


def test_lines_that_coincide_leave_a_smaller_rank():
    t = np.linspace(0, 500, 300)
    with pytest.warns(AttitudeWarning, match=r"the values determine \d+ of the 25 parameters"):
        found = photometry.fit_series(t, np.cos(2 * np.pi * t / 10.0), 20.0, 10.0, order=2)
    assert found.rank < found.parameters
    np.testing.assert_allclose(found.residuals, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"t": [0.0, 1.0]}, "shape"),
        ({"order": 0}, "order is 0"),
        ({"order": 9}, "unknowns"),
        ({"P_psi": -1.0}, "P_psi"),
        ({"errors": np.zeros(50)}, "errors"),
        ({"curve": np.full(50, 1)}, "every number"),
        ({"values": np.full(50, np.nan)}, "finite"),
    ],
)
def test_bad_input_is_a_sentence(change, said):
    given = {"t": np.arange(50.0), "values": np.arange(50.0), "P_psi": 9.0, "P_phi": 4.0}
    with pytest.raises(AttitudeError, match=said):
        photometry.fit_series(**{**given, **change})
