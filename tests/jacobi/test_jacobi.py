"""Elliptic integrals, elliptic functions and theta functions against mpmath and scipy."""

import mpmath
import numpy as np
import pytest
from scipy import special

from attitude import Body, FreeRotation, Spin, catalog, jacobi
from attitude._solver.elliptic import integrals
from attitude.errors import AttitudeError

M = np.array([0.0, 1e-12, 0.1, 0.5, 0.9, 0.999, 1 - 1e-9])
EPS = np.finfo(float).eps


def exact(function, *arguments):
    with mpmath.workdps(40):
        return np.array([float(function(*map(mpmath.mpf, map(float, each))))
                         for each in np.broadcast(*arguments)])  # fmt: skip


def test_complete_integrals():
    assert np.allclose(jacobi.K(M), exact(mpmath.ellipk, M), rtol=4 * EPS, atol=0)
    assert np.allclose(jacobi.E(M), exact(mpmath.ellipe, M), rtol=8 * EPS, atol=0)
    assert jacobi.K(1.0) == np.inf and jacobi.E(1.0) == 1.0
    n = np.array([-1e3, -2.0, -0.5, -1e-6, 0.0])[:, None]
    found = jacobi.Pi(n, M)
    assert found.shape == (5, 7)
    expected = exact(mpmath.ellippi, n, M).reshape(5, 7)
    assert np.allclose(found, expected, rtol=8 * EPS, atol=0)


@pytest.mark.parametrize("mc", [1e-3, 1e-10, 1e-25, 1e-50, 1e-80, 1e-200, 1e-307])
def test_the_complement_keeps_digits(mc):
    """K, E and nome of 1 - mc: m itself is 1.0 in doubles.  4e-16 is the stated accuracy."""
    with mpmath.workdps(400):
        m, other = 1 - mpmath.mpf(mc), mpmath.mpf(mc)
        first, second = mpmath.ellipk(m), mpmath.ellipe(m)
        nome = mpmath.exp(-mpmath.pi * mpmath.ellipk(other) / first)
    assert jacobi.K(1.0 - mc, mc=mc) == pytest.approx(float(first), rel=4e-16)
    assert jacobi.E(1.0 - mc, mc=mc) == pytest.approx(float(second), rel=4e-16)
    assert jacobi.nome(1.0 - mc, mc=mc) == pytest.approx(float(nome), rel=4 * EPS)
    k, d = integrals(1.0 - mc, mc)
    assert k == pytest.approx(float(first), rel=4 * EPS)
    assert d == pytest.approx(float((first - second) / m), rel=4 * EPS)


def test_incomplete_integrals_and_amplitude():
    phi = np.linspace(-9.0, 9.0, 37)[:, None]
    m = M[1:6]
    f, e = jacobi.F(phi, m), jacobi.E_incomplete(phi, m)
    expected = exact(mpmath.ellipf, phi, m).reshape(f.shape)
    assert np.allclose(f, expected, rtol=0, atol=1e-14 * np.abs(expected).max())
    expected = exact(mpmath.ellipe, phi, m).reshape(f.shape)
    assert np.allclose(e, expected, rtol=0, atol=1e-14 * np.abs(expected).max())
    assert jacobi.F("90 deg", 0.5) == jacobi.F(0.5 * np.pi, 0.5)
    # am is its inverse; near m = 1 an error of u grows by 1 / dn.
    assert np.allclose(jacobi.am(f, m), np.broadcast_to(phi, f.shape), rtol=0, atol=2e-12)


def test_jacobi_functions():
    u = np.linspace(-20.0, 20.0, 101)[:, None]
    m = M[:6]
    mine = jacobi.sn(u, m), jacobi.cn(u, m), jacobi.dn(u, m)
    theirs = special.ellipj(u, m)[:3]
    for found, expected, name in zip(mine, theirs, ("sn", "cn", "dn"), strict=True):
        assert np.allclose(found, expected, rtol=0, atol=3e-13), name
        true = exact(lambda a, b, name=name: mpmath.ellipfun(name, a, m=b), u[:9], m)
        assert np.allclose(found[:9].ravel(), true, rtol=0, atol=2e-14)
    assert np.allclose(mine[0] ** 2 + mine[1] ** 2, 1.0, rtol=0, atol=4 * EPS)


@pytest.mark.parametrize("mc", [1e-6, 1e-12, 1e-16, 1e-30])
def test_jacobi_functions_near_m_of_one(mc):
    u = np.linspace(0.1, 0.99, 12) * float(jacobi.K(1.0 - mc, mc=mc))
    for name in ("sn", "cn", "dn"):
        found = getattr(jacobi, name)(u, 1.0 - mc, mc=mc)
        true = exact(lambda a, b, name=name: mpmath.ellipfun(name, a, m=1 - b), u, mc)
        assert np.allclose(found, true, rtol=0, atol=1e-15), name


def test_the_nome():
    expected = exact(lambda m: mpmath.qfrom(m=m), M[1:])
    assert np.allclose(jacobi.nome(M[1:]), expected, rtol=1e-13, atol=0)
    assert jacobi.nome(0.0) == 0.0


@pytest.mark.parametrize("j", [1, 2, 3, 4])
def test_theta_functions(j):
    z = np.linspace(-4.0, 4.0, 17)[:, None]
    q = np.array([0.0, 1e-8, 0.04, 0.3, 0.7, 0.95])
    for k in (0, 1):
        found = jacobi.theta(j, z, q, derivative=bool(k))
        expected = exact(lambda a, b, k=k: mpmath.jtheta(j, a, b, k), z, q).reshape(found.shape)
        assert np.allclose(found, expected, rtol=0, atol=1e-13 * max(1.0, np.abs(expected).max()))
    z = np.array([0.3 + 0.8j, -1.0 + 0.2j])
    with mpmath.workdps(30):
        expected = [complex(mpmath.jtheta(j, complex(each), 0.2)) for each in z]
    assert np.allclose(jacobi.theta(j, z, 0.2), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("moments", [(10, 20, 26), (3, 2, 1.5)])
@pytest.mark.parametrize("rate", [(1, 15, 1), (3, 0.2, -1)])
def test_the_steps_of_the_paper_are_the_motion(moments, rate):
    spin = Spin(epoch="2026-01-01", wxyz=(0.5, 0.1, -0.7, 0.5), angular_velocity=rate)
    motion = FreeRotation(Body(moments=moments), spin)
    found = jacobi.steps(motion)
    assert found in [jacobi.steps(motion), found] and hash(found)
    times = np.linspace(-3.0, 20.0, 50)
    history = motion.at(times)
    assert np.allclose(found.matrix(times), history.matrix, rtol=0, atol=2e-11)
    omega = found.angular_velocity(times) @ found.axes
    assert np.allclose(omega, history.angular_velocity, rtol=0, atol=1e-11)
    period = 4.0 * found.quarter / abs(found.speed)
    assert period == pytest.approx(motion.period_psi, rel=1e-11)


def test_toutatis():
    motion = catalog.entry("toutatis").motion()
    times = np.linspace(0.0, 30 * 86400.0, 40)
    found = jacobi.steps(motion).matrix(times)
    assert np.allclose(found, motion.at(times).matrix, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: jacobi.K(1.5), "outside of 0 to 1"),
        (lambda: jacobi.K(np.nan), "m"),
        (lambda: jacobi.K(0.5, mc=0.4), "m \\+ mc is not 1"),
        (lambda: jacobi.Pi(0.3, 0.5), "not above 0"),
        (lambda: jacobi.am(1.0, 1.0), "give m < 1"),
        (lambda: jacobi.am([1.0, 2.0], [0.1, 0.2, 0.3]), r"u \(2,\), m \(3,\)"),
        (lambda: jacobi.theta(3, [1.0, 2.0], [0.1, 0.2, 0.3]), "do not broadcast"),
        (lambda: jacobi.theta(5, 0.0, 0.1), "give 1, 2, 3 or 4"),
        (lambda: jacobi.theta(3, 0.0, 1.0), "q is outside"),
    ],
)
def test_bad_arguments(call, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        call()


def test_motions_that_the_paper_excludes():
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1))
    with pytest.raises(AttitudeError, match="divide by zero"):
        jacobi.steps(FreeRotation(Body(moments=(1, 2, 3)), spin))
