"""Checks of periods, ranges and times of motions for `battery`: against mpmath.

The formulas are those of the literature (van Zon & Schofield 2006; Samarasinha & A'Hearn 1991) with
Legendre's integrals, where the package has sums of terms of one sign and Carlson's.
"""

import math
from random import Random

import numpy as np
from mpmath import mp, mpf

_ROOT3 = math.sqrt(3.0)
# Moments and rates of bodies that tumble, in any order of the axes.
_STATES = (
    ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    ((26.0, 10.0, 20.0), (-1.0, 0.5, -15.0)),
    ((10.0, 20.0, 26.0), (9.0, -2.0, 1.0)),
    ((20.0, 26.0, 10.0), (-2.0, 1.0, 7.0)),
    ((3.0836, 3.235, 1.0), (0.1451, 0.33529, -0.98709)),
    ((1.0, 2.0, 3.0), (_ROOT3 * (1 + 1e-9), 0.3, 1.0)),
    ((3.0, 1.0, 2.0), (-1.0, _ROOT3 * (1 - 1e-9), -0.3)),
    ((2.0, 5.0, 6.0), (1.0, 0.3, math.nextafter(1.0, 2.0))),
    ((2.0, 5.0, 6.0), (1.0, -0.3, math.nextafter(1.0, 0.0))),
    ((1.0, 2.0, 2.5), (1e-6, 1e-6, 1.0)),
    ((1.0, 2.0, 2.5), (1.0, 3e-6, 2e-6)),
    # m just above and below 1e-10
    ((1.0, 2.0, 2.5), (7.0e-6, 1e-7, 1.0)),
    ((1.0, 2.0, 2.5), (7.6e-6, 1e-7, 1.0)),
    ((1.0, 2.0, 2.5), (1e-9, 2e-9, 1.0)),
    ((1e-6, 1.0, 1.0 + 3e-7), (1e5, 0.3, 0.2)),
    ((0.02, 1.0, 1.01), (0.3, 0.5, -0.2)),
    ((1e-45, 2e-45, 2.5e-45), (1e6, 2e6, 1e5)),
    ((1e30, 2e30, 2.5e30), (1e-12, 2e-12, 1e-13)),
    # the largest moment has another exponent than the others, at any place
    ((1.3, 1.7, 2.5), (0.3, -0.4, 0.5)),
    ((1.3, 2.5, 1.7), (0.3, -0.4, 0.5)),
    ((2.5, 1.3, 1.7), (0.3, -0.4, 0.5)),
    ((2.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
    ((1.0, 3.0, 3.0), (1.0, -2.0, 3.0)),
    ((3.0, 1.0, 3.0), (-0.1, 2.0, 0.2)),
    ((1.0, 1.0 + 1e-9, 1.0 + 3e-9), (0.3, -0.4, 0.5)),
)
# Names of numbers, and of ranges, of a regime.
_NUMBERS = (
    *("energy_ratio", "dynamic_inertia", "m", "one_minus_m", "libration", "spin_rate"),
    *("spin_rate_along", "flip_time", "dwell_time", "P_psi", "P_phi_L", "P_phi_S"),
    "mean_spin_rate",
)
_RANGES = (
    *("nutation_L", "nutation_S", "precession_rate_L", "precession_rate_S"),
    "spin_rate_range",
)


def truths_of_periods(kept):
    """Exact numbers and ranges of states, and cycles of bodies."""
    with mp.workdps(50):
        kept.regimes = [(state, _regime_of(*state)) for state in _STATES]
        kept.cycles = list(_cycles())


def _regime_of(moments, omega):
    """Numbers and ranges of a state by the formulas of Legendre's integrals."""
    order = sorted(range(3), key=lambda k: moments[k])
    a, b, c = (mpf(moments[k]) for k in order)
    rates = [mpf(omega[k]) for k in order]
    energy2 = sum(i * w * w for i, w in zip((a, b, c), rates, strict=True))
    square = sum((i * w) ** 2 for i, w in zip((a, b, c), rates, strict=True))
    momentum, inertia = mp.sqrt(square), square / energy2
    long_axis = inertia < b
    # the axis about which the momentum circulates, and the other extreme one
    third, first = (a, c) if long_axis else (c, a)
    less = (square - energy2 * first) / (third - first)  # I3 w3^2 I3 / I3 ... at sn = 0
    speed = mp.sqrt(abs((third - b) * (square - energy2 * first) / (a * b * c)))
    m = (b - first) * (energy2 * third - square) / ((third - b) * (square - energy2 * first))
    quarter = mp.ellipk(m)
    # squares of the amplitudes of the rates: w1 cn, w2 sn, w3 dn
    w3 = less / third
    w1 = (energy2 * third - square) / (first * (third - first))
    w2 = (energy2 * third - square) / (b * (third - b))
    ends = [(w1, mpf(0), w3), (mpf(0), w2, w3 * (1 - m))]
    rates_of = {}
    for name, axis, k in (("own", third, 2), ("other", first, 0)):
        # d phi/dt = L (2E - I w^2) / (L^2 - I^2 w^2), whose squares are linear in sn^2
        top = [energy2 - axis * end[k] for end in ends]
        low = [square - axis**2 * end[k] for end in ends]
        rise, fall = top[1] - top[0], low[1] - low[0]
        ratio = fall / low[0]
        mean = mp.ellippi(-ratio, m) / quarter  # of 1/(1 + ratio sn^2)
        if ratio == 0:
            total = (top[0] + rise * _mean_square(m, quarter)) / low[0]
        else:
            total = rise / fall + (top[0] - rise / ratio) / low[0] * mean
        values = [momentum * x / y for x, y in zip(top, low, strict=True)]
        tilts = [mp.acos(min(axis * mp.sqrt(end[k]) / momentum, mpf(1))) for end in ends]
        rates_of[name] = momentum * total, values, tilts
    own, other = rates_of["own"], rates_of["other"]
    tilt = other[2][0]
    named = ("L", "S") if long_axis else ("S", "L")
    found = {
        "energy_ratio": energy2 * c / square,
        "dynamic_inertia": inertia,
        "m": m,
        "one_minus_m": 1 - m,
        "libration": own[2][1],
        "spin_rate": mp.sqrt(sum(w * w for w in rates)),
        "spin_rate_along": energy2 / momentum,
        "flip_time": mp.pi / speed,
        "dwell_time": (2 * quarter - mp.pi) / speed,
        "P_psi": 4 * quarter / speed,
        f"P_phi_{named[0]}": 2 * mp.pi / own[0],
        f"P_phi_{named[1]}": 2 * mp.pi / other[0],
        f"nutation_{named[0]}": sorted(own[2]),
        f"nutation_{named[1]}": [tilt, mp.pi - tilt],
        f"precession_rate_{named[0]}": sorted(own[1]),
        f"precession_rate_{named[1]}": sorted(other[1]),
        "spin_rate_range": sorted(mp.sqrt(sum(end)) for end in ends),
    }
    found["mean_spin_rate"] = _mean_speed(sum(ends[0]), sum(ends[1]), m, quarter)
    numbers = {
        k: [float(x) for x in v] if isinstance(v, list) else float(v) for k, v in found.items()
    }
    return {**numbers, "circulates": -1 if long_axis else 1, "symmetric": a == b or b == c}


def _mean_square(m, quarter):
    """The mean of sn^2."""
    return (quarter - mp.ellipe(m)) / (m * quarter) if m else mpf(1) / 2


def _mean_speed(at_sine, at_cosine, m, quarter):
    """The mean of sqrt(p cn^2 + q sn^2)."""
    ends = [mpf(0), mp.pi / 4]
    ends += [mp.pi / 2 - mpf(10) ** -k for k in range(1, 10)] + [mp.pi / 2]

    def value(phi):
        # by the distance from a right angle, where m is near 1
        s, c = mp.sin(phi), mp.cos(phi)
        return mp.sqrt(at_sine * c * c + at_cosine * s * s) / mp.sqrt(c * c + (1 - m) * s * s)

    with mp.workdps(25):
        return mp.quad(value, ends) / quarter


def _cycles():
    """Moments, long axis, y, 1 - y, the turns of phi of the long axis, and P_psi for L = 1."""
    random = Random(2)
    bodies = [(1.0, 2.0, 2.5), (0.3, 1.0, 1.01), (1e-3, 1.0, 1.0005), (1.0, 1.001, 1.003)]
    bodies += [(1.0, 1.0, 1.5), (1.0, 2.0, 2.0)]
    for moments in bodies:
        for long_axis in (True, False):
            a, b, c = map(mpf, moments)
            if (b == a) if long_axis else (c == b):
                continue
            places = [
                (0.5, 0.5),
                (1.0, 0.0),
                (2.0**-10, 1 - 2.0**-10),
                (1e-100, 1.0),
                (1e-290, 1.0),
            ]
            places += [(1 - 2.0**-17, 2.0**-17), (1 - 2.0**-43, 2.0**-43), (1.0, 1e-40)]
            places += [(y, 1 - y) for y in (random.uniform(0.0, 1.0) for _ in range(3))]
            for y, rest in places:
                yield (moments, long_axis, y, rest, *_cycle(a, b, c, long_axis, mpf(y), mpf(rest)))


def _cycle(a, b, c, long_axis, y, one_minus_y):
    """Turns of phi of the long axis in a period of psi, and that period, for L = 1."""
    first, third = (c, a) if long_axis else (a, c)
    with mp.workdps(350 if y < mpf(10) ** -30 or one_minus_y < mpf(10) ** -30 else 60):
        inertia = b + y * (third - b) if y <= 0.5 else third - one_minus_y * (third - b)
        energy2 = 1 / inertia
        speed = mp.sqrt(abs((third - b) * (1 - energy2 * first) / (a * b * c)))
        m = (b - first) * (energy2 * third - 1) / ((third - b) * (1 - energy2 * first))
        quarter = mp.ellipk(m)
        # the long axis: 2E - A w^2 and 1 - A^2 w^2 at sn = 0 and at cn = 0
        if long_axis:
            w = (1 - energy2 * c) / (a - c) / a
            squares = w, w * (1 - m)
        else:
            squares = (energy2 * c - 1) / (a * (c - a)), mpf(0)
        top = [energy2 - a * x for x in squares]
        low = [1 - a * a * x for x in squares]
        rise, fall = top[1] - top[0], low[1] - low[0]
        if low[0] == 0:  # about the long axis: the limit of a small wobble
            s = mp.sqrt((b - a) * (c - a) / (b * c))
            mean = (1 - s) / a
        else:
            ratio = fall / low[0]
            if ratio == 0:
                mean = (top[0] + rise * _mean_square(m, quarter)) / low[0]
            else:
                mean = (
                    rise / fall + (top[0] - rise / ratio) / low[0] * mp.ellippi(-ratio, m) / quarter
                )
        period = 4 * quarter / speed
        return float(mean * period / (2 * mp.pi)), float(period)


# Above the largest relative error of these states.
_MOST = 1.2e-15
# Of the mean speed, a sum of 400 terms.
_MOST_MEAN = 2e-15


def check_periods(truths):
    """Numbers and ranges of motions that tumble, one by one and together."""
    from attitude._solver.regime import Mode, regimes

    together = regimes([state[0] for state, _ in truths.regimes], [s[1] for s, _ in truths.regimes])
    for k, (state, exact) in enumerate(truths.regimes):
        found = regimes(*state)
        assert found.circulates == exact["circulates"], state
        mode = Mode.LONG_AXIS if exact["circulates"] < 0 else Mode.SHORT_AXIS
        mode = Mode.SYMMETRIC if exact["symmetric"] else mode
        assert found.mode is mode and together.mode[k] == mode
        for name in _NUMBERS:
            value, wanted = getattr(found, name), exact[name]
            most = _MOST_MEAN if name == "mean_spin_rate" else _MOST
            off = abs(value - wanted)
            assert isinstance(value, float) and off <= most * abs(wanted), (name, state, off)
            assert getattr(together, name)[k] == value
        for name in _RANGES:
            value = getattr(found, name)
            assert value.shape == (2,) and np.array_equal(getattr(together, name)[k], value)
            off = np.abs(value - exact[name])
            assert np.all(off <= _MOST * np.abs(exact[name])), (name, state, value, exact[name])


# Uniform rotations: moments, rates, mode, the axis of which the ends circulate, and what differs
# from a rotation at this rate about any axis: 1/P_psi over the turns, and the range of d phi/dt.
_ABOUT = (
    ((1.0, 2.0, 2.5), (0.0, 0.0, 2.0)),
    ((2.5, 1.0, 2.0), (-2.0, 0.0, 0.0)),
    ((1.0, 2.0, 2.5), (3.0, 0.0, 0.0)),
    ((2.0, 2.5, 1.0), (0.0, 0.0, -3.0)),
    ((1e-9, 1.0, 1.0), (1.0, 0.0, 0.0)),
    ((2.0, 2.0, 3.0), (0.0, 0.0, 1.0)),
)


def check_uniform_regimes(truths):
    """The limits of a wobble that vanishes."""
    from attitude._solver.regime import Mode, regimes

    with mp.workdps(40):
        for moments, omega in _ABOUT:
            _check_axial(moments, omega, regimes(moments, omega), Mode)
        _check_other_uniform(regimes, Mode)


def _check_axial(moments, omega, periods, Mode):
    """A rotation about the long or the short axis."""
    a, b, c = (mpf(x) for x in sorted(moments))
    axis = next(k for k in range(3) if omega[k])
    moment, speed = mpf(moments[axis]), abs(mpf(omega[axis]))
    one, two = (mpf(moments[k]) for k in range(3) if k != axis)
    turns, is_long = speed / (2 * mp.pi), moment == a
    psi = turns * mp.sqrt((moment - one) * (moment - two) / (one * two))
    assert periods.mode is Mode.PRINCIPAL_AXIS and periods.circulates == (-1 if is_long else 1)
    wanted = {
        "P_psi": 1 / psi,
        "P_phi_L": 1 / ((turns - psi) if is_long else turns),
        "P_phi_S": 1 / (turns if is_long else turns + psi),
        "flip_time": 1 / (2 * psi),
        "energy_ratio": c / moment,
        "dynamic_inertia": moment,
        "spin_rate": speed,
        "spin_rate_along": speed,
        "mean_spin_rate": speed,
        "one_minus_m": mpf(1),
    }
    for name, value in wanted.items():
        assert abs(getattr(periods, name) - value) <= 1e-15 * abs(value), (name, moments, omega)
    assert periods.m == periods.libration == periods.dwell_time == 0.0
    assert periods.spin_rate_range.tolist() == [float(speed)] * 2
    # the axis of rotation is that of the momentum, the other extreme axis lies across
    ends = ("L", "S") if is_long else ("S", "L")
    assert periods.nutation(ends[0]).tolist() == [0.0, 0.0]
    assert periods.nutation(ends[1]).tolist() == [0.5 * math.pi] * 2
    momentum = moment * speed
    rates = [momentum / x for x in ((c, b) if is_long else (b, a))]
    assert np.max(np.abs(periods.precession_rate(ends[0]) / [float(x) for x in rates] - 1)) < 1e-15
    assert periods.precession_rate(ends[1]).tolist() == [float(speed)] * 2


def _check_other_uniform(regimes, Mode):
    """Spheres, rest, the equator of a symmetric body, the middle axis, the separatrix."""
    still = regimes((1.0, 2.0, 2.5), (0.0, 0.0, 0.0))
    assert still.mode is Mode.AT_REST and still.circulates == still.m == still.spin_rate == 0
    assert still.one_minus_m == 1.0 and still.mean_spin_rate == still.spin_rate_along == 0.0
    assert still.P_psi == still.P_phi_L == still.P_phi_S == still.flip_time == math.inf
    assert still.libration == still.dwell_time == 0.0 and math.isnan(still.energy_ratio)
    assert np.isnan(still.nutation_L).all() and np.isnan(still.nutation_S).all()
    assert not still.precession_rate_L.any() and not still.precession_rate_S.any()
    assert not still.spin_rate_range.any()
    for moments, omega, mode in (
        ((2.0, 2.0, 2.0), (1.0, 2.0, -2.0), Mode.SPHERICAL),
        ((2.0, 2.0, 3.0), (0.0, 3.0, 0.0), Mode.PRINCIPAL_AXIS),
        ((2.0, 2.0, 3.0), (3.0, 0.0, 0.0), Mode.PRINCIPAL_AXIS),
        ((1.0, 3.0, 3.0), (0.0, 0.0, -3.0), Mode.PRINCIPAL_AXIS),
    ):
        found = regimes(moments, omega)
        assert found.mode is mode and found.circulates == 0, (moments, omega)
        assert found.P_psi == found.flip_time == math.inf and found.m == 0.0
        assert found.one_minus_m == 1.0 and found.libration == found.dwell_time == 0.0
        assert abs(found.P_phi_L * 3.0 / (2.0 * math.pi) - 1.0) < 4e-16
        assert found.P_phi_S == found.P_phi_L and found.spin_rate_range.tolist() == [3.0, 3.0]
        assert found.precession_rate_L.tolist() == found.precession_rate_S.tolist() == [3.0, 3.0]
        # equal moments in the order given: the first is long, the last short
        order = sorted(range(3), key=lambda k: moments[k])
        momentum = np.multiply(moments, omega) / np.linalg.norm(np.multiply(moments, omega))
        for name, k in (("L", order[0]), ("S", order[2])):
            wanted = math.acos(abs(momentum[k]))
            assert np.max(np.abs(found.nutation(name) - wanted)) < 4e-16, (moments, omega, name)
    for moments, rates in (
        ((10.0, 20.0, 26.0), (0.0, -3.0, 0.0)),
        ((26.0, 10.0, 20.0), (0, 0, 3.0)),
        ((10.0, 20.0, 26.0), (0.0, 0.1, 0.0)),
    ):
        middle, speed = regimes(moments, rates), max(map(abs, rates))
        assert middle.mode is Mode.PRINCIPAL_AXIS and middle.circulates == 0
        assert middle.m == 1.0 and middle.one_minus_m == 0.0 and middle.libration == 0.5 * math.pi
        growth = speed * math.sqrt(10.0 * 6.0 / 260.0)
        assert abs(middle.flip_time * growth / math.pi - 1.0) < 8e-16
        assert middle.dwell_time == middle.P_psi == math.inf and middle.mean_spin_rate == speed
        assert middle.nutation_L.tolist() == middle.nutation_S.tolist() == [0.5 * math.pi] * 2
    on = regimes((2.0, 5.0, 6.0), (1.0, 0.7, 1.0))  # 2 (5 - 2) = 6 (6 - 5)
    assert (
        on.mode is Mode.SEPARATRIX and on.circulates == 0 and on.P_psi == on.dwell_time == math.inf
    )
    assert on.m == 1.0 and on.one_minus_m == 0.0 and on.libration == 0.5 * math.pi
    square, energy2 = mpf(4 + 36) + mpf(3.5) ** 2, mpf(8) + 5 * mpf(0.7) ** 2
    steady = mp.sqrt(square) / 5
    for name in ("P_phi_L", "P_phi_S"):
        assert abs(getattr(on, name) * steady / (2 * mp.pi) - 1) < 1e-15
    assert abs(on.mean_spin_rate / steady - 1) < 1e-15  # about the middle axis nearly always
    tilt = mp.acos(6 * mp.sqrt((energy2 * 2 - square) / (6 * (2 - 6))) / mp.sqrt(square))
    assert np.max(np.abs(on.nutation_S - [float(tilt), 0.5 * math.pi])) < 4e-16
    assert np.max(np.abs(on.nutation_L - [float(mp.pi / 2 - tilt), 0.5 * math.pi])) < 4e-16
    momentum = mp.sqrt(square)
    own, other = [momentum / 5, momentum / 2], [momentum / 6, momentum / 5]
    assert np.max(np.abs(on.precession_rate_S - [float(x) for x in own])) < 4e-15
    assert np.max(np.abs(on.precession_rate_L - [float(x) for x in other])) < 4e-15


def check_long_dwells(truths):
    """Beside the middle axis the mean speed less that about it falls with the period."""
    from attitude._solver.regime import regimes

    found = []
    for small in (1e-30, 1e-60, 1e-85):
        row = regimes((1.0, 2.0, 2.5), (small, 1.0, 1e-5 * small))
        found.append((row.mean_spin_rate - 1.0) * row.P_psi)
        assert row.mode.name == "LONG_AXIS" and 1.0 < row.mean_spin_rate < row.spin_rate_range[1]
    # each of two flips adds the same; the difference from 1 has 13 digits
    assert abs(found[1] / found[0] - 1.0) < 1e-11 and abs(found[2] / found[0] - 1.0) < 1e-11


def check_cycles(truths):
    """Turns in a period of psi at a dynamic inertia, and the dynamic inertia of these turns."""
    from attitude._compilation import decorators
    from attitude._solver import regime_loops

    rows = [np.array(column) for column in zip(*truths.cycles, strict=True)]
    moments, long_axis, y, rest, turns, periods = rows
    out = np.empty((len(turns), 2))
    regime_loops.cycles_all(moments, long_axis, y, rest, out)
    assert np.max(np.abs(out[:, 0] / turns - 1.0)) < 2e-15
    assert np.max(np.abs(out[:, 1] / periods - 1.0)) < 1e-15
    calls, most = [], 0
    counted = regime_loops.cycle

    def cycle(*arguments):
        calls.append(arguments)
        return counted(*arguments)

    regime_loops.cycle = cycle
    # in Python with this function among its names: compiled code does not count
    positions = decorators._for_python(regime_loops.positions_all.py_func)
    try:
        for k in range(len(turns)):
            found = np.empty((1, 3))
            calls.clear()
            one = slice(k, k + 1)
            positions(moments[one], long_axis[one], out[one, 0], found)
            most += len(calls)
            _check_place(truths.cycles[k], out[k, 0], found[0].tolist(), regime_loops)
    finally:
        regime_loops.cycle = counted
    # the method of Chandrupatla takes 9.7 in the mean
    assert most <= 10.3 * len(turns), most / len(turns)
    _check_places(regime_loops)


def _check_place(case, ratio, answer, regime_loops):
    """The place of a ratio is as near as the ratio resolves it."""
    moments, long_axis, y, rest, _, period = case
    place, left, psi = answer
    again = np.empty((1, 2))
    regime_loops.cycles_all(
        np.array([moments]), np.array([long_axis]), np.array([place]), np.array([left]), again
    )
    # z = ln y to one unit in its last place, from which y follows
    least = 4e-15 if y > 1e-90 else 1.2 * math.ulp(math.log(y))
    assert abs(again[0, 0] / ratio - 1.0) <= least, case
    assert abs(psi / again[0, 1] - 1.0) <= least, case
    assert abs(place + left - 1.0) <= 4e-16, case
    if y < 1e-90:
        # the ratio grows with ln y: one unit in the last place is 700 of y
        assert abs(math.log(place / y)) < 1e-12 * abs(math.log(y)), case
        assert left == 1.0 and abs(psi / period - 1.0) < 1e-12
    if y == 1.0 and rest < 1e-30:
        assert place == 1.0 and left < 1e-13


def _check_places(regime_loops):
    """Ratios at the limit, below and beyond it, and bodies without motions of the mode."""
    moments = np.array([(1.0, 2.0, 2.5)])
    nan = [math.nan] * 3
    for is_long in (True, False):
        long_axis, limit, out = np.array([is_long]), np.empty((1, 2)), np.empty((1, 3))
        regime_loops.cycles_all(moments, long_axis, np.array([1.0]), np.array([0.0]), limit)
        farthest, period = limit[0].tolist()

        def place(ratio, moments=moments, long_axis=long_axis, out=out):
            regime_loops.positions_all(moments, long_axis, np.array([ratio]), out)
            return out[0].tolist()

        for ratio in (farthest, farthest * (1.0 - 0.9e-14), farthest * (1.0 - 1e-14)):
            assert place(ratio) == [1.0, 0.0, period], ratio
        assert np.array_equal(place(farthest * (1 - 1.1e-14)), nan, equal_nan=True)
        found = place(math.nextafter(farthest, math.inf))
        assert found[1] > 0.0 or found[0] == 1.0
        for bad in (0.0, -1.0, math.inf, math.nan, 1e6):
            assert np.array_equal(place(bad), nan, equal_nan=True), bad
        # the largest ratio is that at a distance of exp(-690) from the separatrix
        given = np.array([math.exp(-690.0)]), np.array([1.0])
        regime_loops.cycles_all(moments, long_axis, *given, limit)
        assert place(limit[0, 0] * (1.0 - 5e-4))[0] > 0.0
        assert np.array_equal(place(limit[0, 0] * (1.0 + 5e-4)), nan, equal_nan=True)
        # no motion in long-axis mode of a body with A = B, none in the other with B = C
        for body, has in (((1.0, 1.0, 1.5), not is_long), ((1.0, 2.0, 2.0), is_long)):
            found = place(100.0, np.array([body]))
            assert math.isnan(found[0]) != has, (body, is_long)
        for body in ((0.0, 1.0, 1.0), (0.0, 0.9, 1.0)):
            assert np.array_equal(place(2.0, np.array([body])), nan, equal_nan=True)


def check_blocks_of_regimes(truths):
    """States in blocks, their shapes, and what is refused, by its number."""
    from attitude import AttitudeError
    from attitude._solver import regime, states

    moments = np.tile((1.0, 2.0, 2.5), (8, 1))
    omega = np.array([(0.1, 0.2, 0.3 + 0.01 * k) for k in range(8)])
    size, states.BLOCK = states.BLOCK, 3
    try:
        found = regime.regimes(moments, omega)
        _check_refused(regime, moments, omega)
        # where they are not refused, they have no numbers
        changed = omega.copy()
        changed[4, 1] = math.nan
        source = states.States.of_principal_axes(moments, changed)
        rows, rates = regime.summary(states.Evaluation(source, raises=False), 8)
        assert np.flatnonzero(rows["mode"] == -1).tolist() == [4]
        assert np.flatnonzero(np.isnan(rates).all(axis=0)).tolist() == [4]
        assert np.isnan(rows["psi_rate"][4]) and not np.isnan(rows["psi_rate"][:4]).any()
    finally:
        states.BLOCK = size
    for k in range(8):
        alone = regime.regimes(moments[k], omega[k])
        assert found.P_psi[k] == alone.P_psi and found.mode[k] == alone.mode == found[k].mode
        assert found[k].P_phi("L") == alone.P_phi_L and found[k].P_phi("s") == alone.P_phi_S
        assert np.array_equal(found[k].nutation("l"), alone.nutation_L)
        assert np.array_equal(found[k].nutation("S"), alone.nutation_S)
        assert np.array_equal(found[k].precession_rate("L"), alone.precession_rate_L)
        assert np.array_equal(found[k].precession_rate("S"), alone.precession_rate_S)
    assert found.shape == (8,) and len(found) == 8
    grid = regime.regimes(moments[:6].reshape(2, 3, 3), (0.1, 0.2, 0.3))
    assert grid.shape == grid.P_psi.shape == grid.mean_spin_rate.shape == (2, 3)
    assert grid.nutation_L.shape == (2, 3, 2) and repr(grid) == "<Regime of 6 states>"
    assert "LONG_AXIS" in repr(found[0]) or "SHORT_AXIS" in repr(found[0])
    # L^2 - 2 E B of doubles that cancel, with its exact sign
    for moments_of, rates, mode in (
        ((2.0, 5.0, 6.0), (1.0, 0.3, 1.0), regime.Mode.SEPARATRIX),
        ((2.0, 5.0, 6.0), (1.0, 0.3, math.nextafter(1.0, 2.0)), regime.Mode.SHORT_AXIS),
        ((2.0, 5.0, 6.0), (1.0, 0.3, math.nextafter(1.0, 0.0)), regime.Mode.LONG_AXIS),
        ((2.0, 5.0, 6.0), (0.0, 0.0, 0.0), regime.Mode.AT_REST),
    ):
        assert regime.regimes(moments_of, rates).mode is mode
    for bad in ("X", 1, None):
        try:
            regime.known_convention(bad)
        except AttitudeError as err:
            assert "convention is" in str(err)
        else:
            raise AssertionError(bad)
    try:
        found.m = 1.0
    except AttributeError:
        pass
    else:
        raise AssertionError("an attribute was set")
    assert [mode.phrase[:7] for mode in regime.Mode] == [
        "at rest",
        "uniform",
        "uniform",
        "on the ",
        "regular",
        "long-ax",
        "short-a",
    ]


def _check_refused(regime, moments, omega):
    """States that are not physical are named by their number."""
    from attitude import AttitudeError

    for bad in (2, 5, 7):
        changed = omega.copy()
        changed[bad, 1] = math.nan
        try:
            regime.regimes(moments, changed)
        except AttitudeError as err:
            assert f"State {bad} of 8" in str(err), err
        else:
            raise AssertionError(bad)
    for count, words in ((1, "the angular velocity is"), (2, "State 0 of 2: the angular")):
        try:
            regime.regimes(moments[:count], np.full((count, 3), math.nan))
        except AttitudeError as err:
            assert str(err).startswith(words), err
        else:
            raise AssertionError(count)
    for arguments, words in (
        ((np.ones((2, 3)), np.ones((4, 3))), "do not broadcast"),
        (((1.0, 2.0), (1.0, 0.0, 0.0)), "shape"),
    ):
        try:
            regime.regimes(*arguments)
        except AttitudeError as err:
            assert words in str(err), err
        else:
            raise AssertionError(arguments)
