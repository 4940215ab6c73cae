"""The oracle is proved by a Taylor integration, by the laws of free motion, and by restarts."""

import math
from operator import mul

import pytest
from hypothesis import given, settings
from mpmath import mp, mpf

from tests.support import states
from tests.support.oracle import (
    Oracle,
    carlson_rj,
    multiply,
    rate_error,
    rotation_error,
    two_floats,
)

PROMISE = 1e-38  # rad and relative rate: the default 40 digits of the oracle, less two

# ---- a second witness: Euler's equations integrated by power series in fixed point -----------

_BITS = 200  # rounding of 2^-200 a step, 1e-58 after a few hundred steps
_ORDER = 44  # steps of 0.2 / |w| leave 1e-47 at worst (needles), the triangle inequality kept


def _one(x):
    return int(mp.nint(mp.ldexp(x, _BITS)))


def integrate(inertia, wxyz, omega, t):
    """wxyz, omega at t, by the Taylor series of w' = J^-1 (J w x w), q' = q w / 2.

    inertia: three moments, or the rows of a tensor. All in integers scaled by 2^200, with |w| = 1
    as the unit of time: the recurrences are sums of products of coefficients, which Python's
    integers do faster than any multiprecision float.
    """
    with mp.workprec(2 * _BITS):
        size = mp.sqrt(mp.fsum(w * w for w in omega))
        norm = mp.sqrt(mp.fsum(x * x for x in wxyz))
        angle = t * size
        steps = int(abs(angle) / 0.2) + 1
        h = angle / steps
        # scaled by the step, so that the coefficients of the series are its terms
        factors = [[[_one(h * x) for x in row] for row in plane] for plane in _euler(inertia)]
        half = _one(h / 2)
        w = [_one(x / size) for x in omega]
        q = [_one(x / norm) for x in wxyz]
        for _ in range(steps):
            w, q = _taylor_step(factors, half, w, q)
        return [mp.ldexp(x, -_BITS) for x in q], [mp.ldexp(x, -_BITS) * size for x in w]


def _euler(inertia):
    """B with w'_i = sum over j <= k of B[i][j][k] w_j w_k; rows of a rod's axis are zero."""
    rows = [[[mpf(0)] * 3 for _ in range(3)] for _ in range(3)]
    if isinstance(inertia[0], float):
        moments = [mpf(x) for x in inertia]
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            if moments[i]:
                rows[i][min(j, k)][max(j, k)] = (moments[j] - moments[k]) / moments[i]
        return rows
    tensor = mp.matrix(inertia)
    inverse = tensor**-1
    for a in range(3):
        for b in range(3):
            x, y, z = tensor[:, a]
            cross = ((0, z, -y), (-z, 0, x), (y, -x, 0))[b]  # (J e_a) x e_b
            for i in range(3):
                value = mp.fsum(inverse[i, j] * cross[j] for j in range(3))
                rows[i][min(a, b)][max(a, b)] += value
    return rows


def _taylor_step(factors, half, w, q):
    ws, qs = [[x] for x in w], [[x] for x in q]
    pairs = [(j, k) for j in range(3) for k in range(j, 3) if any(f[j][k] for f in factors)]
    for n in range(_ORDER):
        backward = [x[::-1] for x in ws]
        products = {jk: sum(map(mul, ws[jk[0]], backward[jk[1]])) >> _BITS for jk in pairs}
        turned = [[sum(map(mul, x, y)) >> _BITS for y in backward] for x in qs]
        for i in range(3):
            total = sum(factors[i][j][k] * products[j, k] for j, k in pairs)
            ws[i].append((total >> _BITS) // (n + 1))
        (w1, w2, w3), (x1, x2, x3), (y1, y2, y3), (z1, z2, z3) = turned
        rates = (-x1 - y2 - z3, w1 + y3 - z2, w2 + z1 - x3, w3 + x2 - y1)
        for series, rate in zip(qs, rates, strict=True):
            series.append((half * rate >> _BITS) // (n + 1))
    return [sum(x) for x in ws], [sum(x) for x in qs]


def _agree(state, exact, tolerance=PROMISE):
    """Attitudes with their signs, and rates, of two results (wxyz, omega) in mpf."""
    assert rotation_error(state[0], exact[0], signed=True) < tolerance
    assert rate_error(state[1], exact[1]) < tolerance


def _oracle(state, **options):
    return Oracle(state.moments, state.wxyz0, state.omega0, **options)


every_family = pytest.mark.parametrize("family", states.FAMILIES)


def test_taylor_series_agrees_with_mpmath_odefun():
    """The integrator of this file, 40 digits, against the one of mpmath, on the paper's example."""
    moments, omega = (10.0, 20.0, 26.0), (1.0, 15.0, 1.0)

    def slope(_, y):
        wxyz, (w1, w2, w3) = y[:4], y[4:]
        turning = [x / 2 for x in multiply(wxyz, (0, w1, w2, w3))]
        i1, i2, i3 = map(mpf, moments)
        euler = [(i2 - i3) / i1 * w2 * w3, (i3 - i1) / i2 * w3 * w1, (i1 - i2) / i3 * w1 * w2]
        return turning + euler

    with mp.workdps(42):
        y = mp.odefun(slope, 0, [mpf(1), 0, 0, 0, *map(mpf, omega)])(mpf(0.125))
    _agree(integrate(moments, (1, 0, 0, 0), omega, 0.125), (y[:4], y[4:]))


# ---- the oracle against it ---------------------------------------------------------------------


@every_family
def test_few_revolutions_agree_with_integration(family):
    """Both signs of t; at 1.4 revolutions wxyz has gone through -wxyz0, and signs are compared."""
    for state, sign in zip(states.sample(2, families=[family]), (1, -1), strict=True):
        t = sign * 1.4 * states.revolution(state)
        expected = state.wxyz0, state.omega0
        if any(state.omega0):
            expected = integrate(state.moments, state.wxyz0, state.omega0, t)
        _agree(_oracle(state).at(t), expected)


@pytest.mark.parametrize("family", ["tumbling", "near_separatrix", "symmetric", "sphere", "needle"])
def test_tensor_agrees_with_integration(family):
    """In axes that are not principal, where symmetric bodies are rounded to all but symmetric."""
    state = states.sample(1, families=[family])[0]
    rows, omega0 = states.tensor(state)
    t = 1.7 * states.revolution(state)
    oracle = Oracle.from_tensor(rows, state.wxyz0, omega0)
    _agree(oracle.at(t), integrate(rows, state.wxyz0, omega0, t))


@pytest.mark.parametrize(
    ("rows", "omega0", "regime", "mode"),
    [
        (((2, 1, 1), (1, 2, 1), (1, 1, 2)), (1, 2, 3), "tumbling", "SAM"),  # moments 1, 1, 4
        (((3, 1, 1), (1, 3, 1), (1, 1, 3)), (1, 1, 1), "constant", None),  # 2, 2, 5: its axis
        (((3, 1, 1), (1, 3, 1), (1, 1, 3)), (1, -1, 0), "constant", None),  # its equator
        (((3, 0, 0), (0, 3, 0), (0, 0, 3)), (1, -1, 0), "constant", None),
        (((3, 0.5, 0), (0.5, 3, 0), (0, 0, 3)), (0, 0, -2), "constant", None),  # the middle axis
        # moments 3, 5, 6, turned by pi/4 about z: D2 = 6 (wc^2 - wa^2) = 12 wx wy
        (((4.5, 1.5, 0), (1.5, 4.5, 0), (0, 0, 5)), (1, 0, 3), "separatrix", None),
        (((4.5, 1.5, 0), (1.5, 4.5, 0), (0, 0, 5)), (1, 2.0**-60, 3), "tumbling", "SAM"),
        (((4.5, 1.5, 0), (1.5, 4.5, 0), (0, 0, 5)), (1, -(2.0**-60), 3), "tumbling", "LAM"),
        (((4.5, 1.5, 0), (1.5, 4.5, 0), (0, 0, 5)), (0, 0, 0), "rest", None),
    ],
)
def test_exactly_degenerate_tensors(rows, omega0, regime, mode):
    rows = [[float(x) for x in row] for row in rows]
    wxyz0 = (0.5, 0.5, -0.5, 0.5)
    oracle = Oracle.from_tensor(rows, wxyz0, omega0)
    assert (oracle.regime, oracle.mode) == (regime, mode)
    if any(omega0):
        _agree(oracle.at(-2.0), integrate(rows, wxyz0, omega0, -2.0))


def test_diagonal_tensor_is_moments():
    for state in states.sample(1):
        a, b, c = state.moments
        rows = ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))
        t = 1e6 * states.revolution(state)
        tensor = Oracle.from_tensor(rows, state.wxyz0, state.omega0)
        assert tensor.regime == _oracle(state).regime
        _agree(tensor.at(t), _oracle(state).at(t))


# ---- long after the start ----------------------------------------------------------------------


@every_family
def test_momentum_and_energy_stay(family):
    """After 1e9 revolutions, momentum in inertial axes and energy are those of the start."""
    (state,) = states.sample(1, seed=1, families=[family])
    oracle, t = _oracle(state), 1e9 * states.revolution(state)
    start = oracle.at(0.0)
    _agree(start, (state.wxyz0, state.omega0))
    for late in (oracle.at(t), oracle.at(-t)):
        with mp.workdps(60):
            size = mp.norm(oracle.momentum(*start)) or 1
            change = mp.matrix(oracle.momentum(*late)) - mp.matrix(oracle.momentum(*start))
            energies = [oracle.energy(omega) for _, omega in (start, late)]
            assert mp.norm(change) < PROMISE * size
            assert abs(energies[1] - energies[0]) <= PROMISE * energies[0]


@every_family
def test_restart_reaches_the_same_state(family):
    """From t1 on as from 0, in high precision; near the exact separatrix errors grow as exp t."""
    (state,) = states.sample(1, seed=2, families=[family])
    unit = states.revolution(state) * (10 if family == "separatrix" else 1e9)
    t1, t2 = 0.7 * unit, -1.1 * unit
    first = _oracle(state, digits=90)
    second = Oracle(state.moments, *first.at(t1), digits=90)
    _agree(second.at(t2, -t1), first.at(t2))


@every_family
def test_digits_suffice(family):
    """Twice the digits change nothing promised, up to 1e12 revolutions."""
    (state,) = states.sample(1, seed=3, families=[family])
    coarse, fine = _oracle(state), _oracle(state, digits=90)
    for t in states.epochs(state, revolutions=(1e3, 1e12)):
        _agree(coarse.at(t), fine.at(t))


@pytest.mark.parametrize(
    "family",
    [
        "tumbling",
        pytest.param("middle_axis_wobble", marks=pytest.mark.slow),
        pytest.param("near_symmetric", marks=pytest.mark.slow),
    ],
)
def test_sign_by_doubling(family):
    """The sign at 1e9 revolutions, carried there from one revolution by 30 doublings.

    If signs over the interval t are right from any state, going on for t from the state at t gives
    the right sign over 2 t; the first interval is the one that integration proved.
    """
    (state,) = states.sample(1, seed=4, families=[family])
    first, t = _oracle(state, digits=90), states.revolution(state)
    for _ in range(30):
        _agree(Oracle(state.moments, *first.at(t), digits=90).at(t), first.at(2 * t))
        t *= 2


# ---- its inputs and measures -------------------------------------------------------------------


def test_epoch_in_two_parts():
    oracle = _oracle(states.sample(1)[0])
    t, low = 1e9, 3e-9
    whole = oracle.at(mp.fadd(t, low, exact=True))
    assert oracle.at(t, low) == oracle.at((t, low)) == whole
    assert oracle.at(t) != whole


@pytest.mark.parametrize("digits", [15, 40, 300])
def test_integrals_of_balls_are_those_of_mpmath(digits):
    """R_J(x, y, 1, p), complete and not, of thin and of flat bodies, next to a separatrix."""
    pytest.importorskip("flint", reason="without python-flint they are mpmath's")
    with mp.workdps(digits):
        for x in ("0", "1e-80", "0.3", "1"):
            for y in ("1e-70", "0.02", "1"):
                for p in ("1e-9", "0.7", "1", "1e30"):
                    x, y, p = mpf(x), mpf(y), mpf(p)
                    found = carlson_rj(x, y, p)
                    with mp.extradps(15):
                        exact = mp.elliprj(x, y, 1, p)
                    assert abs(found / exact - 1) < 2 * mp.eps


def test_errors_are_angles_and_ratios():
    exact = mpf(1), mpf(0), mpf(0), mpf(0)
    tilted = (math.cos(1e-17), math.sin(1e-17), 0.0, 0.0)
    assert rotation_error(tilted, exact) == pytest.approx(2e-17, rel=1e-12)
    assert rotation_error((-3.0, 0.0, 0.0, 0.0), exact) == 0.0
    assert rotation_error((-3.0, 0.0, 0.0, 0.0), exact, signed=True) == pytest.approx(2 * math.pi)
    assert rotation_error((0.0, 0.0, 2.0, 0.0), exact) == pytest.approx(math.pi)
    assert rotation_error((math.nan, 0.0, 0.0, 0.0), exact) == math.inf
    assert rotation_error((0.0, 0.0, 0.0, 0.0), exact) == math.inf
    assert rate_error((1.0, 2.5, -4.0), (mpf(1), mpf(2), mpf(-4))) == 0.125
    assert rate_error((0.0, 0.0, 0.0), (mpf(0),) * 3) == 0.0
    assert rate_error((1e-300, 0.0, 0.0), (mpf(0),) * 3) == math.inf
    assert rate_error((math.nan, 0.0, 0.0), (mpf(1),) * 3) == math.inf


def test_two_floats_keep_32_digits():
    values = _oracle(states.sample(1)[0]).at(1.0)[0]
    for value, high, low in zip(values, *two_floats(values), strict=True):
        with mp.workdps(60):
            assert abs(value - high - low) < 1e-31 * abs(value)


@pytest.mark.parametrize(
    ("moments", "wxyz0", "omega0"),
    [
        ((0.0, 1.0, 1.0), (1.0, 0.0, 0.0, 0.0), (1e-9, 1.0, 0.0)),
        ((-1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 0.0), (1.0, 1.0, 0.0)),
        ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((1.0, 1.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
        ((1.0, 1.0, 1.0), (1.0, 0.0, 0.0, 0.0), (0.0, math.nan, 1.0)),
    ],
)
def test_refuses_what_is_no_rotation(moments, wxyz0, omega0):
    with pytest.raises(ValueError):
        Oracle(moments, wxyz0, omega0)


# ---- the sampler ------------------------------------------------------------------------------


def test_sampler_repeats_itself():
    assert states.sample(2) == states.sample(2)
    assert states.sample(2) != states.sample(2, seed=1)


@every_family
def test_sampled_bodies_are_physical(family):
    """Doubles, the triangle inequality, a unit quaternion, the regime that the name says."""
    regimes = set()
    for state in states.sample(40, families=[family]):
        a, b, c = sorted(state.moments)
        assert all(type(x) is float for x in (*state.moments, *state.wxyz0, *state.omega0))
        assert a + b >= c and math.isclose(math.hypot(*state.wxyz0), 1, rel_tol=1e-15)
        regimes.add(_oracle(state).regime)
    expected = "tumbling"
    if family in states.DEGENERATE and family not in ("symmetric", "one_rate_zero"):
        expected = family if family in ("rest", "separatrix") else "constant"
    assert regimes == {expected}


def test_near_separatrix_has_both_sides():
    oracles = [_oracle(s) for s in states.sample(40, families=["near_separatrix"])]
    assert {oracle.mode for oracle in oracles} == {"LAM", "SAM"}
    assert min(oracle.distance for oracle in oracles) < 1e-15


@settings(max_examples=50, deadline=None)
@given(states.strategy())
def test_strategy_draws_states(state):
    assert state.family in states.FAMILIES
    assert rotation_error(_oracle(state).at(0.0)[0], state.wxyz0, signed=True) < PROMISE
