"""Checks of the solution, pairs, quaternions and elliptic functions that need no compilation.

They run in two seconds, those of derivatives (`battery_derivatives`) in twenty:
`benchmarks/mutation.py` runs them for each of its changes of the source, and
`tests/solver/test_battery.py` with the other tests.  A check is a function of `Truths`, which are
computed before by balls (`attitude.proof`) and mpmath, and are plain numbers.
"""

import itertools
import math
from fractions import Fraction
from random import Random
from types import SimpleNamespace

import numpy as np
from mpmath import mp, mpf

from tests.support import battery_axes, battery_derivatives, battery_periods, states
from tests.support.oracle import carlson_rj

U = 2.0**-53
EPS = 2.0**-52
IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])

# ---- States: name, moments or tensor, attitude, rates


_ROOT3 = math.sqrt(3.0)
_TURN = np.array([[1.0, -2.0, 2.0], [2.0, -1.0, -2.0], [2.0, 2.0, 1.0]])
_HAND = [
    ("short axis", (10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    ("short axis", (26.0, 10.0, 20.0), (-1.0, 0.5, -15.0)),
    ("short axis", (20.0, 10.0, 26.0), (1.0, -0.5, -5.0)),
    ("long axis", (10.0, 20.0, 26.0), (15.0, 1.0, 1.0)),
    ("long axis", (26.0, 20.0, 10.0), (1.0, -1.0, -15.0)),
    ("long axis", (20.0, 26.0, 10.0), (-2.0, 1.0, 7.0)),
    ("near separatrix", (1.0, 2.0, 3.0), (_ROOT3 * (1 + 1e-9), 0.3, 1.0)),
    ("near separatrix", (3.0, 1.0, 2.0), (-1.0, _ROOT3 * (1 - 1e-9), -0.3)),
    ("next to the separatrix", (2.0, 5.0, 6.0), (1.0, 0.3, math.nextafter(1.0, 2.0))),
    ("next to the separatrix", (2.0, 5.0, 6.0), (1.0, -0.3, math.nextafter(1.0, 0.0))),
    # T = 2 K'/K just above and below 1, where the form changes, in both modes
    ("largest nome", (10.0, 20.0, 26.0), (1.22979, 0.3, 1.0)),
    ("largest nome", (10.0, 20.0, 26.0), (1.22955, 0.3, 1.0)),
    ("largest nome", (10.0, 20.0, 26.0), (1.26848, 0.3, 1.0)),
    ("largest nome", (20.0, 26.0, 10.0), (0.2, 0.78848, 1.0)),
    ("separatrix", (2.0, 5.0, 6.0), (1.0, 0.3, 1.0)),
    ("separatrix", (5.0, 2.0, 6.0), (0.0, -1.0, 1.0)),
    ("separatrix", (27.0, 2.0, 26.0), (-4.0, 3.0, 1.5)),
    ("symmetric", (2.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
    ("symmetric", (1.0, 3.0, 3.0), (1.0, -2.0, 3.0)),
    ("symmetric", (3.0, 1.0, 3.0), (-0.1, 2.0, 0.2)),
    ("near symmetric", (2.0, 2.0 + 1e-10, 3.0), (1.0, 2.0, 3.0)),
    ("near symmetric", (1.0, 3.0, 3.0 - 1e-13), (1.0, -2.0, 3.0)),
    ("equatorial", (2.0, 2.0, 3.0), (1.0, 2.0, 0.0)),
    ("flip", (1.0, 2.0, 3.0), (1e-9, 1.0, 3e-10)),
    ("flip", (3.0, 1.0, 2.0), (1e-12, -3e-10, -1.0)),
    ("wobble", (1.0, 2.0, 3.0), (1e-12, 0.0, 1.0)),
    ("sphere", (2.0, 2.0, 2.0), (1.0, 2.0, -3.0)),
    ("principal axis", (10.0, 20.0, 26.0), (0.0, 0.0, 1.0)),
    ("principal axis", (10.0, 20.0, 26.0), (-0.7, 0.0, 0.0)),
    ("middle axis", (10.0, 20.0, 26.0), (0.0, -1.0, 0.0)),
    ("rest", (1.0, 2.0, 3.0), (0.0, 0.0, 0.0)),
    ("rod", (0.0, 2.0, 2.0), (0.0, 1.0, -1.0)),
    ("needle", (1e-10, 1.0, 1.0), (1.0, 0.1, 0.2)),
    ("needle", (1.0, 1e-6, 1.0 + 3e-7), (0.3, 1e5, 0.2)),
    ("flat", (1.0, 2.0, 3.0), (0.2, 0.3, 0.4)),
    ("small units", (1e-45, 2e-45, 2.5e-45), (1e6, 2e6, 1e5)),
    ("large units", (1e30, 2e30, 2.5e30), (1e-12, 2e-12, 1e-13)),
    ("tensor", ((2.0, 0.1, 0.2), (0.1, 2.5, 0.5), (0.2, 0.5, 2.9)), (0.3, -0.2, 0.6)),
    ("tensor", ((2.0, 0.1, 0.2), (0.1, 2.5, 0.5), (0.2, 0.5, 2.9)), (-0.9, 0.1, 0.1)),
    ("symmetric tensor", ((2.0, 0.0, 0.0), (0.0, 2.5, 0.5), (0.0, 0.5, 2.5)), (0.3, 0.2, -0.7)),
    ("axis of a tensor", ((3.0, 1.0, 0.0), (1.0, 3.0, 0.0), (0.0, 0.0, 3.0)), (1.0, 1.0, 0.0)),
    (
        "separatrix of a tensor",
        tuple(map(tuple, (_TURN @ np.diag([4.0, 5.0, 9.0]) @ _TURN.T).tolist())),
        tuple((_TURN @ (3.0, 1.0, 1.0)).tolist()),
    ),
]
# Turns of the angular velocity at the epoch.
_TURNS = (0.0, 0.3, -7.7, 1.1e3, -1.3e6, 1.7e9, 1.9e12)


def _sampled():
    """Two of each family, with the order of fields of a case."""
    for state in states.sample(2, 38, states.FAMILIES):
        yield state.family, state.moments, state.wxyz0, state.omega0


def cases():
    """(name, inertia, wxyz, rates) of every state."""
    random = Random(38)
    found = []
    for name, inertia, rates in _HAND:
        wxyz = tuple(random.uniform(-2.0, 2.0) for _ in range(4))
        found.append((name, inertia, wxyz, rates))
    return found + list(_sampled())


def motion_of(case):
    """The free rotation of a state."""
    from attitude import Body, FreeRotation, Spin

    _, inertia, wxyz, rates = case
    full = isinstance(inertia[0], tuple)
    body = Body(tensor=inertia) if full else Body(moments=inertia)
    return FreeRotation(body, Spin("2026-01-01", wxyz, rates))


def epochs_of(case):
    """Seconds of a state, and second doubles."""
    speed = math.hypot(*case[3])
    t = np.array(_TURNS) * (2.0 * math.pi / speed if speed else 1.0)
    return t, 0.3 * np.spacing(t)


# ---- What is exact


def truths(*, has_derivatives=True):
    """All that the checks compare with, as plain numbers."""
    from attitude import AttitudeError

    kept = SimpleNamespace(states=[], coefficients=_coefficients())
    for case in cases():
        try:
            kept.states.append((case, _exact_of(case)))
        except AttitudeError as err:
            assert "rates below" in str(err) or "too small" in str(err), err
    kept.rounded = [(case, t, _attitudes_of(case, t)) for case, t in _rounded()]
    _of_series(kept)
    _of_integrals(kept)
    battery_axes.truths_of_axes(kept)
    battery_periods.truths_of_periods(kept)
    if has_derivatives:
        battery_derivatives.truths_of_derivatives(kept)
    return kept


def _rounded():
    """A state of each form with many epochs, at which the second doubles of phases are large."""
    random = Random(12)
    named = {case[0]: case for case in reversed(cases())}
    for name in ("sphere", "short axis", "largest nome", "near separatrix", "separatrix", "flat"):
        case = named[name]
        unit = 2.0 * math.pi / math.hypot(*case[3])
        yield case, np.array([unit * 10.0 ** random.uniform(2.0, 9.0) for _ in range(60)])


def _attitudes_of(case, t):
    """Exact attitudes (T, 4, 2)."""
    from attitude.motions._free_rotation import chain_of
    from attitude.proof._certificate import precision
    from attitude.proof._exact import rational

    motion = motion_of(case)
    with precision(512):
        solution = chain_of(motion.body, motion.spin).solution()
        rows = [[_doubles(x) for x in solution.at(rational(float(x)))] for x in t]
    return np.array(rows)


def _doubles(x, places=2):
    """A ball or mpmath number as a sum of doubles."""
    parts = []
    for _ in range(places):
        part = float(x.mid()) if hasattr(x, "mid") else float(x)
        parts.append(part)
        x = x - part
    return parts


def _exact_of(case):
    """Exact attitudes (T, 4, 2) and rates (T, 3), and constants of the motion, of a state."""
    from attitude.motions._free_rotation import chain_of
    from attitude.proof._certificate import precision
    from attitude.proof._exact import flint, rational

    motion = motion_of(case)
    record = motion._constants[0]
    chain = chain_of(motion.body, motion.spin, record=record if record["form"] else None)
    for bits in (256, 512, 1024, 4096):
        with precision(bits):
            solution = chain.solution()
            wxyz, rates = [], []
            for hi, lo in zip(*epochs_of(case), strict=True):
                q = solution.at(rational(float(hi), float(lo)))
                wxyz.append(q)
                rates.append([float(x.mid()) for x in solution.rates(q)])
            if max(float(x.rad()) for q in wxyz for x in q) > 1e-40:
                continue
            wxyz = np.array([[_doubles(x) for x in q] for q in wxyz])
            found = {"wxyz": wxyz, "rates": np.array(rates), "form": solution.form}
            pi = flint().arb.pi()
            found["side"] = solution.decided.side
            if solution.form == "theta":
                found["nutation"] = _doubles(solution.rate / 2)
                found["quarter"] = _doubles(solution.quarter)
                found["stretch"] = float(solution.tau.imag.mid())
                found["fraction"] = float((4 * solution.shift.imag / solution.tau.imag).mid())
            if solution.form != "uniform":
                found["precession"] = _doubles(solution.precession / (2 * pi))
            return found
    raise AssertionError(case)


def _coefficients():
    """Names of `series` and the numbers that benchmarks/make_coefficients.py remakes."""
    from benchmarks import make_coefficients

    with mp.workdps(60):
        return [
            (table.file, tuple(table.owners), [mpf(x) for x in table.remake()])
            for table in make_coefficients.tables()
            if table.file in ("_solver/series.py", "_solver/twofloat.py")
        ]


def _of_series(kept):
    """Sine and cosine of phases, and powers of two."""
    random = Random(1)
    kept.sines, kept.powers = [], []
    phases = [k / 8.0 for k in range(-20, 21)]
    phases += [random.uniform(-0.5, 0.5) for _ in range(60)] + [1e-9, -1e-9, 0.125 - 1e-17]
    with mp.workdps(50):
        for s in phases:
            for lo in (0.0, 2.0**-53, -0.7 * 2.0**-53):
                x = 2 * mp.pi * (mpf(s) + mpf(lo))
                kept.sines.append((s, lo, _doubles(mp.sin(x)), _doubles(mp.cos(x))))
        arguments = [0.0, 0.5, 0.25, 1.0, 1.5, 2.5, 31.4, 900.3, 1000.0, 1000.5, 5e5]
        for a in arguments + [random.uniform(0.0, 60.0) for _ in range(40)]:
            kept.powers.append((a, _doubles(mpf(2) ** -min(mpf(a), 1000))))


_COMPLEMENTS = ("1e-30", "1e-18", "1e-9", "1e-3", "0.03", "0.3", "0.7", "0.999", "1")
_TANGENTS = ("0", "1e-30", "1e-15", "1e-3", "0.4", "1", "2.5", "1e3", "1e15", "inf")


def _pair(x):
    hi = float(x)
    return hi, float(x - mpf(hi))


def _of_integrals(kept):
    """Elliptic integrals and functions."""
    kept.complete, kept.phases, kept.quarters, kept.integrals, kept.degenerate = [], [], [], [], []
    with mp.workdps(60):
        for text in _COMPLEMENTS:
            kc = _pair(mp.sqrt(mpf(text)))
            mc = (mpf(kc[0]) + mpf(kc[1])) ** 2
            quarter = mp.elliprf(0, mc, 1)
            for p in map(mpf, ("1", "1.3", "7", "1e8", "1e28")):
                for a in (0.0, 1.0):
                    value = a * quarter + (1 - a * p) * carlson_rj(mpf(0), mc, p) / 3
                    kept.complete.append(
                        (kc, _pair(p), (a, 0.0), _doubles(value / quarter), _doubles(quarter))
                    )
            b = math.sqrt(float(text))
            other = mp.elliprf(0, mpf(b) ** 2, 1)
            for tangent in _TANGENTS:
                cosine = mpf(0) if tangent == "inf" else mpf("0.37") / max(1, mpf(tangent))
                sine = mpf(3) if tangent == "inf" else cosine * mpf(tangent)
                c, s = (sum(map(mpf, _pair(x))) for x in (cosine, sine))
                value = s * mp.elliprf(c**2, c**2 + mc * s**2, c**2 + s**2) / (4 * quarter)
                kept.phases.append((kc, _pair(cosine), _pair(sine), _doubles(value)))
                c, s = mpf(float(cosine)), mpf(float(sine))
                value = s * mp.elliprf(c**2, c**2 + mpf(b) ** 2 * s**2, c**2 + s**2) / other
                kept.quarters.append((b, float(c), float(s), float(other), float(value)))
            complement = mpf(float(text))
            m = 1 - complement
            second = mp.elliprd(0, complement, 1) / 3
            first = float(mp.elliprf(0, complement, 1))
            kept.integrals.append((float(m), float(complement), first, float(second)))
        random = Random(4)
        for _ in range(40):
            x, y, z = (10.0 ** random.uniform(-6.0, 1.0) for _ in range(3))
            kept.degenerate.append((x, y, z, float(mp.elliprd(x, y, z))))
        for _ in range(8):  # nearly equal: no step of duplication
            x, y, z = (1.0 + random.uniform(-0.0015, 0.0015) for _ in range(3))
            kept.degenerate.append((x, y, z, float(mp.elliprd(x, y, z))))
        for x, y, z in ((0.0, 1.0, 1.0), (1.0, 0.0, 2.0), (1.0, 1.0, 1.0), (0.3, 1.0, 1e-8)):
            kept.degenerate.append((x, y, z, float(mp.elliprd(x, y, z))))
    _of_jacobi(kept)


_M = (0.0, 1e-12, 0.1, 0.5, 0.9, 0.999, 1 - 1e-9)


def _of_jacobi(kept):
    """Values of the public functions of `attitude.jacobi`: name, arguments, keywords, value."""
    found = kept.jacobi = []

    def add(name, arguments, value, scale=None, **keywords):
        size = abs(value) if scale is None else scale
        found.append((name, arguments, keywords, complex(value), float(size)))

    with mp.workdps(40):
        for m in _M:
            k = mp.ellipk(mpf(m))
            add("K", (m,), k)
            add("E", (m,), mp.ellipe(mpf(m)))
            for n in (-1e3, -0.5, -1e-6, 0.0):
                add("Pi", (n, m), mp.ellippi(mpf(n), mpf(m)))
            if m > 0.0:
                add("nome", (m,), mp.qfrom(m=mpf(m)), 20 * mp.qfrom(m=mpf(m)))
            if m == 1 - 1e-9:
                continue
            for phi in (-9.0, -math.pi / 2, -0.3, 0.0, 1e-9, 0.7, 1.57, 3.0, 8.1):
                add("F", (phi, m), mp.ellipf(mpf(phi), mpf(m)), max(k, abs(mp.ellipf(phi, m))))
                add("E_incomplete", (phi, m), mp.ellipe(mpf(phi), mpf(m)), 1 + abs(phi))
            for u in (-7.3, -0.4, 0.0, 0.8, 1.7, 5.9):
                for name in ("sn", "cn", "dn"):
                    add(name, (u, m), mp.ellipfun(name, mpf(u), m=mpf(m)), 10.0)
                sn, cn = (mp.ellipfun(x, mpf(u), m=mpf(m)) for x in ("sn", "cn"))
                turns = mp.nint(mpf(u) / (2 * k))
                value = mp.pi * turns + mp.asin(sn * (-1) ** int(turns))
                assert abs(mp.cos(value) - cn) < 1e-20
                add("am", (u, m), value, 10.0)
        add("K", (1.0,), mp.ellipk(1 - mpf(1e-25)), mc=1e-25)
        add("E", (1.0,), mpf(1))
        for j in (1, 2, 3, 4):
            for z in (-4.0, 0.0, 0.7, 2.1, 0.3 + 0.8j, -1.0 - 2.2j):
                for q in (0.0, 1e-8, 0.04, 0.3, 0.95):
                    growth = float(mp.re(mp.jtheta(3, mpf(0) + 1j * abs(mp.im(z)), mpf(q))))
                    for derivative in (False, True):
                        value = mp.jtheta(j, mp.mpmathify(z), mpf(q), int(derivative))
                        size = (
                            growth
                            * (1.0 + 3.0 * (q > 0.9))
                            * (1.0 + derivative * (2.0 + 90.0 * (q > 0.9)))
                        )
                        add("theta", (j, z, q), value, size, derivative=derivative)


# ---- Pairs of doubles


def _value(pair):
    return Fraction(float(pair[0])) + Fraction(float(pair[1]))


def _random_pairs(count, seed, spread=40):
    random = Random(seed)
    pairs = []
    for _ in range(count):
        hi = (
            random.choice((-1.0, 1.0))
            * random.uniform(1.0, 2.0)
            * 2.0 ** random.randint(-spread, spread)
        )
        pairs.append((hi, random.uniform(-0.499, 0.499) * math.ulp(hi)))
    return pairs


def _near(computed, exact, bound):
    """A pair, normalised, within bound u^2 of an exact fraction."""
    assert abs(computed[1]) <= 0.5 * math.ulp(computed[0])
    assert abs(_value(computed) - exact) <= bound * Fraction(U) ** 2 * abs(exact), (computed, exact)


def check_pairs(truths):
    """Functions of `twofloat` against fractions, with the bounds that are proved for them."""
    from attitude._solver import twofloat as two

    first, second = _random_pairs(60, 1), _random_pairs(60, 2)
    # neighbours, whose difference cancels
    first += [(1.5, 0.4 * EPS), (1.5, 0.4 * EPS), (3.0, -EPS / 3), (-1.0, EPS / 5)]
    second += [(-1.5, 0.3 * EPS), (1.5 + EPS, 0.0), (-3.0, EPS / 7), (1.0, EPS / 9)]
    for a, b in zip(first, second, strict=True):
        x, y = _value(a), _value(b)
        _near(two.add(a, b), x + y, Fraction(301, 100))
        _near(two.sub(a, b), x - y, Fraction(301, 100))
        _near(two.mul(a, b), x * y, 6)
        _near(two.div(a, b), x / y, 15)
        _near(two.scale(a, b[0]), x * Fraction(b[0]), 4)
        _near(two.square(a), x * x, 6)
        s, e = two.two_sum(a[0], b[0])
        assert s == a[0] + b[0] and _value((s, e)) == Fraction(a[0]) + Fraction(b[0])
        p, e = two.two_prod(a[0], b[0])
        assert p == a[0] * b[0] and _value((p, e)) == Fraction(a[0]) * Fraction(b[0])
        large, small = (a, b) if abs(a[0]) >= abs(b[0]) else (b, a)
        s, e = two.quick_two_sum(large[0], small[0])
        assert s == a[0] + b[0] and _value((s, e)) == Fraction(a[0]) + Fraction(b[0])
        root = two.sqrt(two.absolute(a))
        assert abs(root[1]) <= 0.5 * math.ulp(root[0])
        assert abs(_value(root) ** 2 - abs(x)) <= 8 * Fraction(U) ** 2 * abs(x)
        assert two.neg(a) == (-a[0], -a[1]) and _value(two.absolute(a)) == abs(x)
        for one, other in ((a, b), (a, a), (a, (a[0], a[1] + 0.1 * math.ulp(a[0]))), (b, a)):
            assert two.less(one, other) == (_value(one) < _value(other))
            assert two.same(one, other) == (_value(one) == _value(other))
    for zero in ((0.0, 0.0), (-0.0, 0.0), (-1e-300, 0.0)):
        assert two.sqrt(zero) == (0.0, 0.0)
    assert math.copysign(1.0, two.absolute((0.0, 0.0))[0]) == 1.0
    assert two.ZERO == (0.0, 0.0) and two.ONE == (1.0, 0.0)
    row = [1.0, 2.0, 3.0]
    two.put(row, (4.0, 5.0))
    assert row == [4.0, 5.0, 3.0] and two.pair(row) == (4.0, 5.0)


def check_expansions(truths):
    """Exact sums of doubles and of products."""
    from attitude._solver import twofloat as two

    random = Random(6)
    for count in (1, 3, 9):
        terms = [pair[0] for pair in _random_pairs(count, count)]
        terms += [-x for x in terms[:-1]] + [math.ldexp(terms[0], -100)]
        random.shuffle(terms)
        row, n = [0.0] * (2 * len(terms)), 0
        for x in terms:
            n = two.added(row, n, x)
        exact = sum(map(Fraction, terms), Fraction(0))
        assert sum(map(Fraction, row[:n]), Fraction(0)) == exact
        assert all(abs(x) < abs(y) for x, y in itertools.pairwise(row[:n]))
        assert all(x != 0.0 for x in row[:n])
        assert abs(_value(two.rounded(row, n)) - exact) <= 8 * Fraction(U) ** 2 * abs(exact)
    assert two.added([0.0, 0.0], 0, 0.0) == 0
    assert two.rounded([1.0], 0) == (0.0, 0.0)
    row, n, exact = [0.0] * 64, 0, Fraction(0)
    for k in range(5):
        factors = [pair[0] for pair in _random_pairs(4, 10 + k, 8)]
        n = two.product_added(row, n, *factors)
        exact += math.prod(map(Fraction, factors))
    assert sum(map(Fraction, row[:n]), Fraction(0)) == exact


def check_pairs_of_arrays(truths):
    """Functions of `attitude._support.pairs`, of floats and of arrays."""
    from attitude._support import pairs

    first, second = _random_pairs(40, 1), _random_pairs(40, 2)
    first += [(1.5, 0.4 * EPS), (3.0, -EPS / 3)]
    second += [(-1.5, 0.3 * EPS), (-3.0, EPS / 7)]
    columns = [np.array(x) for x in (*zip(*first, strict=True), *zip(*second, strict=True))]
    a, b = (columns[0], columns[1]), (columns[2], columns[3])
    positive = tuple(np.sign(a[0]) * x for x in a)
    found = {
        "sum": pairs.two_sum(a[0], b[0]),
        "add": pairs.add(a, *b),
        "add one": pairs.add(a, b[0]),
        "product": pairs.product(a[0], b[0]),
        "times": pairs.times(a, b),
        "root": pairs.root(positive),
        "quotient": pairs.quotient(a, b),
    }
    for k, (p, q) in enumerate(zip(first, second, strict=True)):
        x, y = _value(p), _value(q)
        at = {name: (float(hi[k]), float(lo[k])) for name, (hi, lo) in found.items()}
        assert at["sum"][0] == p[0] + q[0] and _value(at["sum"]) == Fraction(p[0]) + Fraction(q[0])
        assert at["product"][0] == p[0] * q[0]
        assert _value(at["product"]) == Fraction(p[0]) * Fraction(q[0])
        size = max(abs(x), abs(y))
        assert abs(_value(at["add"]) - (x + y)) <= 8 * Fraction(U) ** 2 * size
        assert abs(_value(at["add one"]) - (x + Fraction(q[0]))) <= 8 * Fraction(U) ** 2 * size
        assert abs(at["add"][1]) <= 0.5 * math.ulp(at["add"][0])
        _near(at["times"], x * y, 16)
        _near(at["quotient"], x / y, 16)
        assert abs(_value(at["root"]) ** 2 - abs(x)) <= 16 * Fraction(U) ** 2 * abs(x)
        assert abs(at["root"][1]) <= 0.5 * math.ulp(at["root"][0])
        assert pairs.times(p, q) == at["times"] and pairs.quotient(p, q) == at["quotient"]


def check_epochs(truths):
    """`Seconds`, with and without second doubles."""
    from attitude._support import pairs

    hi, lo = np.array([1.0, 2.0, 3.0]), np.array([1e-3, -1e-17, 0.0])
    plain, both = pairs.Seconds(hi), pairs.Seconds(hi, lo)
    assert plain.lo is None
    assert plain.low.tolist() == [0.0] * 3 and both.low is lo
    assert plain.rounded is hi and both.rounded.tolist() == [1.001, 2.0, 3.0]
    some = slice(1, None)
    assert plain.taken(some).hi.tolist() == [2.0, 3.0] and plain.taken(some).lo is None
    assert [part.tolist() for part in both.taken(some)] == [[2.0, 3.0], [-1e-17, 0.0]]
    assert plain.mapped(np.sign).hi.tolist() == [1.0] * 3 and plain.mapped(np.sign).lo is None
    assert [part.tolist() for part in both.mapped(np.sign)] == [[1.0] * 3, [1.0, -1.0, 0.0]]
    assert [part.tolist() for part in plain.flat] == [hi.tolist(), [0.0] * 3]
    assert [part.tolist() for part in both.flat] == [hi.tolist(), lo.tolist()]
    assert [part.tolist() for part in plain.compact] == [hi.tolist(), [0.0]]
    assert [part.tolist() for part in both.compact] == [hi.tolist(), lo.tolist()]
    alone = pairs.rows(*plain)
    assert alone[0].shape == (1, 3) and alone[1] is None
    second = pairs.rows(*both)[1]
    assert second.tolist() == [lo.tolist()] and not second.flags.writeable
    assert [part.tolist() for part in plain.plus(1.0)] == [[2.0, 3.0, 4.0], [0.0] * 3]
    for high, rest, x, y in zip(*both.plus(-2.0, 1e-20), hi, lo, strict=True):
        exact = Fraction(x) + Fraction(y) - 2 + Fraction(1e-20)
        assert abs(_value((high, rest)) - exact) <= 4 * U * (abs(y) + 4.0 * U)
        assert abs(rest) <= 0.5 * math.ulp(high)


# ---- Series


def check_coefficients(truths):
    """Coefficients against those that benchmarks/make_coefficients.py computes."""
    from attitude._solver import series, twofloat

    modules = {"_solver/series.py": series, "_solver/twofloat.py": twofloat}
    for file, owners, numbers in truths.coefficients:
        stored = []
        for owner in owners:
            value = getattr(modules[file], owner)
            stored += list(value) if isinstance(value, tuple) else [value]
        if not owners[0].startswith(("_SIN_", "_COS_", "_EXP_")) or "_SIN_1" in owners:
            with mp.workdps(60):
                assert abs(sum(map(mpf, stored)) - sum(numbers)) <= 1e-31, owners
            continue
        half = 0.5 if owners[0].startswith("_EXP") else 0.125
        off = [x - float(y) for x, y in zip(stored, numbers, strict=True)]
        powers = [int(owner.rpartition("_")[2]) for owner in owners]
        for x in np.linspace(-half, half, 81).tolist():
            difference = sum(d * x**n for d, n in zip(off, powers, strict=True))
            assert abs(difference) <= 1e-19, (owners, x)


def check_sines(truths):
    """Sine, cosine and powers of two: within a rounding of the exact ones."""
    from attitude._solver import series

    for s, lo, sine, cosine in truths.sines:
        x, y = series.sincos(s, lo)
        assert abs((x - sine[0]) - sine[1]) <= 1.3e-16, (s, lo)
        assert abs((y - cosine[0]) - cosine[1]) <= 1.3e-16, (s, lo)
        if abs(sine[0]) < 0.1:
            assert abs((x - sine[0]) - sine[1]) <= 1.8e-16 * abs(sine[0]) + 1e-31, (s, lo)
    for a, exact in truths.powers:
        assert abs((series.exp2_of_minus(a) - exact[0]) - exact[1]) <= 1.4e-16 * exact[0], a
    assert math.isnan(series.exp2_of_minus(math.nan))
    for x, n, wanted in ((1.5, 0.0, 1.5), (1.5, 1.0, -1.5), (-2.0, -3.0, 2.0), (3.0, -2.0, 3.0)):
        assert series.negated_if_odd(x, n) == wanted
    for x, y, wanted in ((1.5, 2.0, 1.5), (1.5, -2.0, -1.5), (-1.5, -0.1, 1.5)):
        assert series._with_sign_of(x, y) == wanted
    c, x = (3.0, 5.0, 7.0, 11.0, 13.0), 0.5
    assert series.quadratic(c, x) == 7.25 and series.cubic(c, x) == 8.625
    assert series.quartic(c, x) == 9.4375
    assert series.turned((1.0, 2.0, 3.0, 4.0), 0.5, 2.0) == (1.0, 4.5, 4.0, 9.5)


def check_phases(truths):
    """Phases against fractions, up to 1e15 turns; and how many turns were removed."""
    from attitude._solver import series

    random = Random(3)
    for k in range(400):
        rate = random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-6, 3)
        turns = random.choice((-1.0, 1.0)) * 10.0 ** random.uniform(-3, 16.6 if k % 4 == 0 else 15)
        t = turns / rate
        numbers = [rate, random.uniform(-0.5, 0.5) * math.ulp(rate)]
        start = random.uniform(-0.5, 0.5)
        numbers += [start, random.uniform(-0.5, 0.5) * math.ulp(start)]
        numbers += [t, random.uniform(-0.5, 0.5) * math.ulp(t)]
        s, lo, parity = series.phase(*numbers, 1.0)
        a, b, c, d, e, f = map(Fraction, numbers)
        exact = (a + b) * (e + f) + c + d
        off = exact - Fraction(s) - Fraction(lo)
        whole = round(off)
        assert abs(lo) <= 1.01 * 2.0 ** (-53 if abs(turns) < 1e15 else -49) and abs(s) <= 0.5
        assert abs(parity) <= 4.0
        assert abs(off - whole) <= 7.0 * U * U * abs(turns) + 4.0 * U * U, numbers
        assert parity == int(parity) and (int(parity) - whole) % 2 == 0, numbers
        if k < 40:
            numbers[4], numbers[5] = 3.0 / rate, 0.0
            s, lo, parity = series.phase(*numbers, 0.0)
            exact = (a + b) * Fraction(numbers[4]) + c + d
            assert parity == 0.0
            assert abs(Fraction(s) + Fraction(lo) - exact) <= 20.0 * U * U


# ---- Elliptic integrals


def _apart(pair, exact):
    """The difference of a pair from one, without loss."""
    return abs((pair[0] - exact[0]) + (pair[1] - exact[1]))


def check_integrals(truths):
    """Complete and incomplete integrals, in pairs and in doubles."""
    from attitude._solver import elliptic

    one, zero = (1.0, 0.0), (0.0, 0.0)
    for kc, p, a, ratio, quarter in truths.complete:
        found, complete, turns = elliptic.complete_and_phase(kc, p, a, one, zero)
        assert _apart(found, ratio) <= 2e-30 * ratio[0], (kc, p, a)
        assert _apart(complete, quarter) <= 2e-30 * quarter[0], (kc, p, a)
        assert turns == (0.0, 0.0)
    for kc, cosine, sine, exact in truths.phases:
        _, _, turns = elliptic.complete_and_phase(kc, one, one, cosine, sine)
        assert _apart(turns, exact) <= min(1.2e-17, 3e-16 * exact[0]), (kc, cosine, sine)
    for b, cosine, sine, quarter, fraction in truths.quarters:
        found = elliptic.quarter_and_fraction(b, cosine, sine)
        assert abs(found[0] - quarter) <= 5e-16 * quarter
        assert abs(found[1] - fraction) <= 8e-16 * fraction, (b, cosine, sine)
    for m, mc, first, second in truths.integrals:
        found = elliptic.integrals(m, mc)
        assert abs(found[0] - first) <= 5e-16 * first, m
        assert abs(found[1] - second) <= 1e-15 * second, m
    for x, y, z, exact in truths.degenerate:
        assert abs(elliptic.third_kind_degenerate(x, y, z) - exact) <= 6e-16 * exact, (x, y, z)
    # dF/dm = s^3 R_D(c^2, 1, 1 - m s^2) / 6
    with mp.workdps(30):
        for m, phi in ((0.3, 0.7), (0.9, 1.2)):
            exact = mp.diff(lambda x, phi=phi: mp.ellipf(phi, x), m)
            s = math.sin(phi)
            found = elliptic.by_parameter(math.cos(phi), s, 1.0 - m * s * s)
            assert abs(found - exact) <= 1e-15 * exact


# ---- The solution


def _turn(computed, exact):
    """The rotation angle between a unit quaternion and an exact one (4, 2)."""
    d = (computed - exact[..., 0]) - exact[..., 1]
    q = exact[..., 0]
    return 2.0 * np.linalg.norm(d - np.sum(d * q, axis=-1, keepdims=True) * q, axis=-1)


# Above the largest error of these states, rad.
_MOST = 1.2e-15
# Of rates, relative to the largest.
_MOST_RATE = 8e-16


def check_attitudes(truths):
    """Attitudes, their sign, and rates against balls."""
    for case, exact in truths.states:
        motion = motion_of(case)
        history = motion.at(*epochs_of(case))
        assert np.all(np.abs(history.wxyz - exact["wxyz"][..., 0]) < 1e-14), case
        turned = _turn(history.wxyz, exact["wxyz"])
        assert np.all(turned <= _MOST), (case, turned)
        size = np.abs(exact["rates"]).max(axis=1, keepdims=True)
        off = np.abs(history.angular_velocity - exact["rates"])
        assert np.all(off <= _MOST_RATE * size), (case, off / size)
        assert np.all(np.abs(np.sum(history.wxyz**2, axis=1) - 1.0) < 2e-15)


def check_roundings(truths):
    """The root mean square of the errors of many epochs, rad, to a fifteenth."""
    most = (1.95e-16, 2.86e-16, 2.99e-16, 3.78e-16, 2.2e-16, 2.58e-16)
    for (case, t, exact), limit in zip(truths.rounded, most, strict=True):
        wxyz = motion_of(case).at(t, 0.0 * t).wxyz
        assert math.sqrt(np.mean(_turn(wxyz, exact) ** 2)) <= limit, case


def check_bounds(truths):
    """Constants of the motions: what they add to the bound of all attitudes."""
    from attitude.proof._error_bound import LOOPS

    for case, _ in truths.states:
        motion = motion_of(case)
        record = motion._constants[0]
        bound = motion.error_bound()
        fastest = max(abs(record["precession"][0]), abs(record["nutation"][0]))
        loop = LOOPS[int(record["form"])]
        assert loop <= bound.constant <= loop + 1.5e-15, (case, bound)
        assert bound.rate <= 3.2e-30 * fastest + 1e-320, (case, bound, fastest)


def check_records(truths):
    """Numbers that regimes and methods of a motion read, and the mode."""
    from attitude._solver import codes

    for case, exact in truths.states:
        record = motion_of(case)._constants[0]
        name, form = case[0], exact["form"]
        speed = math.hypot(*case[3])
        wanted = {
            "symmetric": {codes.SYMMETRIC},
            "separatrix": {codes.SEPARATRIX},
            "uniform": {codes.AT_REST, codes.SPHERICAL, codes.PRINCIPAL_AXIS},
            "theta": {codes.LONG_AXIS if exact["side"] == -1 else codes.SHORT_AXIS},
        }[form]
        assert record["mode"] in wanted, case
        if form == "uniform":
            wanted = codes.SPHERICAL if name.startswith("sphere") else codes.PRINCIPAL_AXIS
            assert record["mode"] == (wanted if speed else codes.AT_REST), case
            assert record["circulates"] in (-1, 0, 1, 2)
            turns = float(record["phi_rate"] + record["psi_rate"])
            assert (
                record["mode"] == codes.AT_REST
                or record["circulates"] >= 0
                or (record["psi_rate"] == 0.0)
            )
            assert abs(turns - speed / (2 * math.pi)) <= 4 * U * abs(turns) or name == "rod"
            continue
        if form == "separatrix":
            wanted = 2.0 * exact["precession"][0]
            assert abs(record["phi_rate"] - wanted) <= 2 * U * wanted
            assert record["psi_rate"] == 0.0 and record["quarter"][0] == math.inf
            continue
        # half of the turns of phi + psi is the precession
        both = float(record["phi_rate"]) + float(record["psi_rate"])
        size = abs(float(record["phi_rate"])) + abs(float(record["psi_rate"]))
        assert abs(both - 2.0 * exact["precession"][0]) <= 4 * U * size, case
        if form == "theta":
            times = 2.0 if record["form"] == codes.HYPERBOLIC else 1.0
            assert (exact["stretch"] < 1.0) == (times == 2.0), case
            assert abs(record["psi_rate"] - exact["nutation"][0]) <= U * size * 2, case
            assert _apart(record["quarter"], exact["quarter"]) <= 2e-30 * exact["quarter"][0]
            assert abs(record["stretch"] / exact["stretch"] - 1.0) <= 1e-15, case
            assert abs(record["fraction"] / exact["fraction"] - 1.0) <= 2e-15, case


def check_axial_rates(truths):
    """Rates of a vanishing wobble about axis k: psi = s turns, s^2 = (Ik - Ii)(Ik - Ij) / Ii Ij."""
    for moments in ((10.0, 20.0, 26.0), (1e-9, 1.0, 1.0 + 1e-10), (3.0, 3.0, 2.0), (2.0, 3.0, 5.0)):
        for k in range(3):
            rates = [0.0, 0.0, 0.0]
            rates[k] = -0.7
            case = "axis", moments, (1.0, 0.0, 0.0, 0.0), tuple(rates)
            record = motion_of(case)._constants[0]
            i, j = (Fraction(moments[n]) for n in range(3) if n != k)
            m = Fraction(moments[k])
            square = (m - i) * (m - j) / (i * j)
            turns = mpf(0.7) / (2 * mp.pi)
            if square <= 0:
                assert record["circulates"] == -1 and record["psi_rate"] == 0.0
                assert abs(record["phi_rate"] / turns - 1) < 4e-16
                continue
            with mp.workdps(40):
                s = mp.sqrt(mpf(square.numerator) / square.denominator)
                psi = turns * s * (1 if m < i else -1)
                assert record["circulates"] == k
                assert abs(record["psi_rate"] / psi - 1) < 8e-16, (moments, k)
                assert abs(record["phi_rate"] / (turns - psi) - 1) < 2e-15, (moments, k)


def _refused(sentence, call, *arguments, **keywords):
    """A call is refused in a sentence that has these words."""
    from attitude import AttitudeError

    try:
        call(*arguments, **keywords)
    except AttitudeError as err:
        assert sentence in str(err), (sentence, err)
        return
    raise AssertionError(f"not refused: {sentence}")


_NEXT = math.nextafter


def check_limits(truths):
    """What is refused, to the last double."""
    from attitude import propagate

    good = (1.0, 0.0, 0.0, 0.0)

    def fails(sentence, moments, rates, wxyz=good, t=(0.0,)):
        _refused(sentence, propagate, moments, wxyz, rates, list(t))

    def passes(moments, rates, wxyz=good, t=(0.0,)):
        found = propagate(moments, wxyz, rates, list(t))
        assert np.all(np.isfinite(found))

    any_rate = (0.1, 0.2, 0.3)
    moment, ratio, triangle = "moment", "1e45", "exceeds the sum"
    for bad in (-1.0, -1e-300):
        for k in range(3):
            moments = [2.0, 2.0, 2.0]
            moments[k] = bad
            fails(moment, moments, any_rate)
    fails(moment, (0.0, 0.0, 0.0), any_rate)
    for k in range(4):
        wxyz = [0.0] * 4
        wxyz[k] = -1e-200
        passes((1.0, 2.0, 2.5), any_rate, wxyz)
    fails("not all zero", (1.0, 2.0, 2.5), any_rate, (0.0, -0.0, 0.0, 0.0))
    # the largest may exceed the sum of the others by 1e-14 of it
    ulp = math.ulp(3.0)
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        for last, sound in ((3.0, True), (3.0 + 68 * ulp, True), (3.0 + 70 * ulp, False)):
            moments = [(1.0, 2.0, last)[k] for k in order]
            (passes(moments, any_rate) if sound else fails(triangle, moments, any_rate))
    passes((1.0 / 1e45, 1.0, 1.0), (0.0, 0.2, 0.3))
    fails(ratio, (_NEXT(1.0 / 1e45, 0.0), 1.0, 1.0), (0.0, 0.2, 0.3))
    for k in range(3):
        moments, rates = [2.0] * 3, [0.1, 0.2, 0.3]
        moments[k] = 0.0
        fails("about", moments, rates)
        rates[k] = 0.0
        passes(moments, rates)
        moments[k - 1] = _NEXT(2.0, 3.0)
        fails("moment", moments, rates)
    # rates below 2^-400 of the largest count as zero, and beside the middle axis they are refused
    # where none of 2^-300 is beside them
    lost, kept = _NEXT(2.0**-400, 0.0), 2.0**-400  # the largest, 0.5, is not scaled
    for moments in ((1.0, 2.0, 3.0), (3.0, 2.0, 1.0)):
        for other, sound in ((2.0**-300, True), (_NEXT(2.0**-300, 0.0), False), (0.0, False)):
            for rates in ((lost, 0.5, other), (other, 0.5, lost), (-lost, -0.5, -other)):
                (passes if sound else lambda *x: fails("rate", *x))(moments, rates)
        passes(moments, (kept, 0.5, 0.0))
    passes((1.0, 2.0, 3.0), (0.5, lost, 0.0))
    passes((2.0, 2.0, 3.0), (lost, 0.5, 0.0))
    passes((1.0, 2.0, 2.0), (0.5, 0.0, lost))
    one = propagate((1.0, 2.0, 3.0), good, (0.5, lost, 0.0), [1e3])
    two = propagate((1.0, 2.0, 3.0), good, (0.5, 0.0, 0.0), [1e3])
    assert np.array_equal(one, two)
    _limits_of_time(passes, fails)


def _limits_of_time(passes, fails):
    """Two doubles of time resolve 5e16 turns of the fastest phase."""
    from attitude._solver import evaluation

    for case in cases()[:34]:
        record = motion_of(case)._constants
        fastest = max(abs(record["precession"][0, 0]), abs(record["nutation"][0, 0]))
        if fastest == 0.0:
            continue
        farthest = 5e16 / fastest
        out = np.full((1, 4, 1), np.nan)
        for sign in (1.0, -1.0):
            for low in (None, np.array([[0.0]])):
                t = np.array([[sign * farthest]])
                assert evaluation.evaluate_all(record, t, low, out, None, 0, 1) == -1, case
                t = np.array([[sign * _NEXT(farthest, math.inf)]])
                assert evaluation.evaluate_all(record, t, low, out, None, 0, 1) == 0, case
            t, low = np.array([[sign * farthest]]), np.array([[sign * np.spacing(farthest)]])
            assert evaluation.evaluate_all(record, t, low, out, None, 0, 1) == 0, case
    record = motion_of(("slow", (1.0, 2.0, 3.0), (1, 0, 0, 0), (0.0, 0.0, 1e-300)))._constants
    t = np.array([[1.7976931348623157e308]])
    assert evaluation.evaluate_all(record, t, None, np.empty((1, 4, 1)), None, 0, 1) == -1


def _pairs_of(moments, rates):
    """Moments and rates (B, 3) as pairs (B, 3, 2)."""
    pairs = np.zeros((2, len(moments), 3, 2))
    pairs[0, ..., 0], pairs[1, ..., 0] = moments, rates
    return pairs


def check_counts(truths):
    """What the stages of the solution return, what is not physical, and which loop fills what."""
    from attitude._solver import codes, constants, evaluation, kernel
    from attitude._solver.records import CONSTANTS

    states_of = [
        ((1.0, 2.0, 3.0), (0.1, 0.2, 0.9), False),  # trigonometric
        ((2.0, 5.0, 6.0), (1.0, 0.3, 1.0 + 1e-9), True),  # hyperbolic; D2 cancels
        ((2.0, 2.0, 2.0), (1.0, 2.0, 3.0), False),
        ((1.0, 2.0, 4.0), (1.0, 2.0, 3.0), False),  # no triangle
        ((1.0, 2.0, 3.0), (0.0, 0.0, 1.0), False),
        ((1.0, 2.0, 3.0), (0.3, 0.2, 0.1), False),
        ((1.0, 2.0, 3.0), (1e-125, 1.0, 0.0), False),  # a rate is lost
        ((2.0, 5.0, 6.0), (1.0, 0.7, 1.0 - 1e-9), True),
    ]
    moments, rates, cancels = (np.array([row[k] for row in states_of]) for k in range(3))
    pairs = _pairs_of(moments, rates)
    wxyz = np.tile(IDENTITY, (len(moments), 1))
    records = np.zeros(len(moments), CONSTANTS)
    counts = constants.classify_all(pairs[0], wxyz, pairs[1], records)
    assert tuple(map(int, counts)) == (2, 2, 2)
    faults = [codes.FINE] * 8
    faults[3], faults[6] = codes.NO_TRIANGLE, codes.LOST_RATE
    assert records["fault"].tolist() == faults
    assert (records["cancelled"] == 1).tolist() == cancels.tolist()
    assert records["moments"][3].tolist() == np.zeros((3, 2)).tolist()
    constants.refine_all(records)
    assert int(constants.solve_all(records)) == 2
    hyperbolic = codes.HYPERBOLIC
    assert (records["form"] == hyperbolic).tolist() == [k in (1, 7) for k in range(8)]
    # numbers that are not finite
    for place in range(3):
        for value, part in ((math.inf, 0), (math.nan, 0), (-math.inf, 0)):
            for which in range(2):
                changed = _pairs_of(moments[:2], rates[:2])
                changed[which, 1, place, part] = value
                assert evaluation.faults_of(changed[0], wxyz[:2], changed[1]).tolist() == [1]
        for value in (math.inf, math.nan, -math.inf):
            changed = wxyz[:2].copy()
            changed[1, place] = value
            given = _pairs_of(moments[:2], rates[:2])
            assert evaluation.faults_of(given[0], changed, given[1]).tolist() == [1]
    # each loop fills the rows of its own form, and says that all is well
    fine = [0, 1, 2, 4, 5, 7]
    records = states.constants_of(pairs[0][fine], wxyz[fine], pairs[1][fine], IDENTITY)
    t = np.array([[0.5, 1.5, 2.5, 3.5]])
    for loop, form in (
        (kernel.uniform, codes.UNIFORM),
        (kernel.trigonometric, codes.TRIGONOMETRIC),
        (kernel.hyperbolic, codes.HYPERBOLIC),
    ):
        out, speeds = np.full((6, 4, 4), np.nan), np.full((6, 3, 4), np.nan)
        assert loop(records, t, None, out, speeds, 0, 4, 0) == -1
        filled = ~np.isnan(out).any(axis=(1, 2))
        assert filled.tolist() == (records["form"] == form).tolist()
        assert (~np.isnan(speeds)).all(axis=(1, 2)).tolist() == filled.tolist()
        # epochs beyond all doubles are refused, also of the slowest motions
        assert loop(records, np.full((1, 1), np.inf), None, out, None, 0, 1, 0) >= 0
    slow = motion_of(("slow", (1.0, 2.0, 3.0), (1, 0, 0, 0), (0.0, 0.0, 1e-300)))._constants
    assert kernel.uniform(slow, np.full((1, 1), np.inf), None, out, None, 0, 1, 0) == 0


def check_two(truths):
    """Two bodies with axes, second doubles and epochs of their own are what each is alone."""
    from attitude._solver import evaluation

    turns = _some_quaternions(4)
    low = 1e-16 * _some_quaternions(6)[4:]
    t = np.array([[0.5, 1.5], [2.5, -40.5]])
    for moments, rates in (
        ([(1.0, 2.0, 3.0), (2.0, 3.0, 4.0)], [(0.1, 0.2, 0.9), (0.2, 0.1, 0.9)]),
        ([(2.0, 5.0, 6.0), (2.0, 5.0, 6.0)], [(1.0, 0.3, 1.0 + 1e-9), (1.0, 0.7, 1.0 - 1e-9)]),
        ([(1.0, 2.0, 3.0), (2.0, 2.0, 2.0)], [(0.0, 0.0, 0.4), (0.2, 0.1, 0.9)]),
    ):
        pairs = _pairs_of(np.array(moments), np.array(rates))

        def records_of(rows, pairs=pairs):
            return states.constants_of(
                pairs[0][rows], turns[:2][rows], pairs[1][rows], turns[2:][rows], wxyz_low=low[rows]
            )

        out, alone = np.empty((2, 4, 2)), np.empty((1, 4, 2))
        evaluation.evaluate(records_of(slice(0, 2)), t, None, out, None)
        for k in range(2):
            evaluation.evaluate(records_of(slice(k, k + 1)), t[k : k + 1], None, alone, None)
            assert np.array_equal(out[k], alone[0])


def check_many(truths):
    """Many bodies and epochs at once are what each is alone; some epochs of a row; NaN."""
    from attitude import propagate
    from attitude._solver import evaluation

    chosen = [case for case in cases() if not isinstance(case[1][0], tuple)][::3]
    moments, wxyz, rates = (np.array([case[k] for case in chosen]) for k in (1, 2, 3))
    t = np.array([0.0, 1.5, -1e4, math.nan, 77.0])
    together = propagate(moments, wxyz, rates, t, angular_velocity=True)
    rows = np.stack([t * (1 + k % 3) for k in range(len(chosen))])
    other = propagate(moments, wxyz, rates, rows, angular_velocity=True)
    for k in range(len(chosen)):
        alone = propagate(moments[k], wxyz[k], rates[k], t, angular_velocity=True)
        apart = propagate(moments[k], wxyz[k], rates[k], rows[k], angular_velocity=True)
        for some, many in ((alone, together), (apart, other)):
            for x, y in zip(some, many, strict=True):
                assert np.array_equal(x, y[k], equal_nan=True), chosen[k]
        for found in alone:
            assert np.all(np.isnan(found[3])) and np.all(np.isfinite(np.delete(found, 3, 0)))
    for case in chosen:
        record = motion_of(case)._constants
        times = np.arange(7.0)[None]
        lows = 1e-17 * np.arange(7.0)[None]
        whole, part = np.zeros((1, 4, 7)), np.full((1, 4, 7), np.nan)
        speeds, some = np.zeros((1, 3, 7)), np.full((1, 3, 7), np.nan)
        evaluation.evaluate_all(record, times, lows, whole, speeds, 0, 7)
        evaluation.evaluate_all(record, times, lows, part, some, 2, 5)
        for x, y in ((whole, part), (speeds, some)):
            inside = ~np.isnan(y[0, 0])
            assert inside.sum() == 3
            first = int(np.flatnonzero(inside)[0])
            assert np.array_equal(y[..., inside], x[..., 2:5]), (case, first)


# ---- Quaternions


def _exact_product(p, q):
    (a, b, c, d), (e, f, g, h) = p, q
    return [
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    ]


def _exact_matrix(q):
    """The rotation matrix of a quaternion of fractions of any length."""
    size = sum(x * x for x in q)
    back = [q[0], -q[1], -q[2], -q[3]]
    columns = []
    for k in range(3):
        v = [Fraction(int(n == k + 1)) for n in range(4)]
        columns.append([x / size for x in _exact_product(_exact_product(q, v), back)[1:]])
    return [[columns[k][i] for k in range(3)] for i in range(3)]


def _some_quaternions(count=12):
    random = Random(9)
    rows = [[random.uniform(-1.0, 1.0) for _ in range(4)] for _ in range(count)]
    return np.array([[x / math.hypot(*row) for x in row] for row in rows])


def check_quaternions(truths):
    """Products, rotations and matrices against fractions."""
    from attitude._solver import kernel
    from attitude.frames import quaternion

    rows = _some_quaternions()
    whole = np.array([[1, 2, 3, 5], [7, -11, 13, 17], [-2, 3, 19, -23]], float)
    for p in whole:
        for q in whole:
            wanted = _exact_product(p, q)
            assert quaternion.multiply(p, q).tolist() == wanted
            assert list(kernel.product(p.tolist(), q.tolist())) == wanted
    assert quaternion.conjugate(whole[0]).tolist() == [1, -2, -3, -5]
    assert kernel.plus((1.0, 2.0, 3.0, 4.0), (5.0, 7.0, 11.0, 13.0)) == (6.0, 9.0, 14.0, 17.0)
    for q in rows:
        exact = _exact_matrix([Fraction(x) for x in q.tolist()])
        matrix = np.array([[float(x) for x in row] for row in exact])
        assert np.max(np.abs(quaternion.matrix(q) - matrix)) < 5e-16
        v = np.array([0.3, -0.7, 0.2])
        assert np.max(np.abs(quaternion.rotate(q, v) - matrix @ v)) < 5e-16
        turned = kernel.turned_by(tuple(q.tolist()), tuple(v.tolist()))
        assert np.max(np.abs(np.array(turned) - matrix @ v)) < 5e-16
        assert np.max(np.abs(quaternion.from_matrix(matrix) * np.sign(q[0]) - q)) < 5e-16
        for size in (1.0, 3.0, 1e-200, 1e200):
            found = np.array(kernel.unit(tuple((size * q).tolist())))
            assert np.max(np.abs(found - q)) < 4e-16
    zeros = [0.0, -0.0, 0.0, 0.0]
    assert not kernel.any_of(zeros)
    for k in range(4):
        assert kernel.any_of([1e-300 if n == k else x for n, x in enumerate(zeros)])
    _check_permutations(kernel)
    v = np.array([0.3, -0.7, 0.2])
    many = np.tile(rows, (1400, 1))[:16500]
    turned = quaternion.rotate(many, v)
    assert np.array_equal(turned[:12], quaternion.rotate(rows, v))
    assert np.array_equal(turned, np.tile(turned[:12], (1400, 1))[:16500])
    vectors = np.tile(np.eye(3), (3000, 1))
    turned = quaternion.rotate(rows[0], vectors)
    assert np.array_equal(turned, np.tile(quaternion.rotate(rows[0], np.eye(3)), (3000, 1)))
    assert quaternion.rotate(rows[:5, None], rows[:7, 1:]).shape == (5, 7, 3)


def _check_permutations(kernel):
    """Internal to principal axes: 24 rotation matrices, each with its quaternion."""
    from attitude.frames import quaternion

    seen = set()
    for first in range(3):
        for second in range(3):
            for minus1 in range(2):
                for minus3 in range(2):
                    matrix = kernel._MATRICES[first, second, minus1, minus3]
                    if first == second:
                        assert not matrix.any()
                        continue
                    wanted = np.zeros(3)
                    wanted[first] = 1 - 2 * minus1
                    assert matrix[:, 0].tolist() == wanted.tolist()
                    assert abs(matrix[second, 1]) == 1.0
                    assert matrix[3 - first - second, 2] == 1 - 2 * minus3
                    assert np.linalg.det(matrix) == 1.0
                    q = kernel._QUATERNIONS[first, second, minus1, minus3]
                    assert np.max(np.abs(quaternion.matrix(q) - matrix)) < 1e-15
                    seen.add(tuple(matrix.ravel().tolist()))
    assert len(seen) == 24


def check_units(truths):
    """Quaternions of length one, in doubles and in pairs."""
    from attitude.frames import quaternion

    rows = _some_quaternions()
    for power in (0, 1, -3, 300, -300, 1000, -1000):
        found = quaternion.unit(np.ldexp(rows, power))
        assert np.max(np.abs(found - rows)) < 4e-16
    # of length 1 to 16 units in the last place: bit for bit
    off = np.array([1.0 + 15.9 * EPS, 0.0, 0.0, 0.0])
    assert quaternion.unit(off)[0] == off[0]
    assert quaternion.unit([1.0 + 16 * EPS, 0.0, 0.0, 0.0])[0] == 1.0 + 16 * EPS
    assert quaternion.unit([1.0 - 16 * EPS, 0.0, 0.0, 0.0])[0] == 1.0 - 16 * EPS
    assert quaternion.unit([1.0 + 17 * EPS, 0.0, 0.0, 0.0])[0] == 1.0
    assert quaternion.unit([2.0, 0.0, 0.0, 0.0], tolerance=1.0)[0] == 1.0
    _refused("off 1 by", quaternion.unit, [2.1, 0.0, 0.0, 0.0], tolerance=1.0)
    _refused("off 1 by", quaternion.unit, [0.5, 0.0, 0.0, 0.0], tolerance=0.4)
    for bad in ((0.0, 0.0, -0.0, 0.0), (1.0, math.nan, 0.0, 0.0), (math.inf, 0.0, 0.0, 0.0)):
        for function in (quaternion.unit, quaternion.unit_in_pairs):
            try:
                function(bad)
            except Exception as err:
                assert "no attitude" in str(err) or "finite" in str(err), err
            else:
                raise AssertionError(bad)
    _refused(
        "no attitude", quaternion.unit, [[1.0, 0.0, 0.0, 0.0], [0.0] * 4, [math.nan] * 4][:2] * 2
    )
    # the largest double but no infinity, the smallest but not zero
    assert quaternion.unit([1.7e308, 0.0, 0.0, 0.0])[0] == 1.0
    assert quaternion.unit([0.0, 5e-324, 0.0, 0.0])[1] == 1.0
    given = [*rows.tolist(), [3.0, -1.0, 2.0, 0.5], [1e-180, 2e-180, -1e-181, 0.0]]
    given += [[1e200, 1e200, -2e200, 1e199], [1.0 + 3 * EPS, 0.0, 0.0, 0.0]]
    given += [[1.0 + 5 * EPS, 0.0, 0.0, 0.0], [1.0 - 4 * EPS, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0]]
    given += [[1.0 + 4 * EPS, math.sqrt(EPS), 0.0, 0.0]]  # of a square of 1 + 9 eps
    given += [[1.0 + 4 * EPS, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [1.99, 0.0, 0.0, 0.0]]
    high, low = quaternion.all_unit_in_pairs(np.array(given))
    for k, row in enumerate(given):
        found = quaternion.unit_in_pairs(row)
        assert np.array_equal(found, np.stack([high[k], low[k]], axis=1)), row
        exact = [Fraction(x) for x in row]
        square = sum(x * x for x in exact)
        if abs(sum(x * x for x in row) - 1.0) <= 8 * EPS:
            assert found[:, 0].tolist() == row and not found[:, 1].any()
            continue
        with mp.workdps(50):
            length = mp.sqrt(mpf(square.numerator) / square.denominator)
            for x, pair in zip(row, found.tolist(), strict=True):
                off = mpf(pair[0]) + mpf(pair[1]) - mpf(x) / length
                assert abs(off) < 3e-32, (row, pair)
    high, low = quaternion.all_unit_in_pairs(rows)
    assert high is rows and low is None
    many = np.tile(np.array(given), (1000, 1))
    high, low = quaternion.all_unit_in_pairs(many)
    for k in (*range(24), *range(8180, 8230), *range(len(many) - 24, len(many))):
        found = np.stack([high[k], low[k]], axis=1)
        assert np.array_equal(found, quaternion.unit_in_pairs(many[k])), k
    high, low = quaternion.all_unit_in_pairs(np.array([[0.0] * 4, [1.0, 0.0, 0.0, 0.0]]))
    assert np.all(np.isnan(high[0])) and high[1, 0] == 1.0


def check_forms_of_attitudes(truths):
    """Euler angles and matrices."""
    from attitude.frames import quaternion

    def about(axis, angle):
        c, s = math.cos(angle), math.sin(angle)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        matrix = np.eye(3)
        matrix[i, i] = matrix[j, j] = c
        matrix[i, j], matrix[j, i] = -s, s
        return matrix

    angles = (0.3, -1.1, 2.3)
    for sequence, axes in (
        ("ZXZ", (2, 0, 2)),
        ("313", (2, 0, 2)),
        ("XYZ", (0, 1, 2)),
        (321, (2, 1, 0)),
    ):
        wanted = about(axes[0], 0.3) @ about(axes[1], -1.1) @ about(axes[2], 2.3)
        found = quaternion.matrix(quaternion.from_euler(sequence, angles))
        assert np.max(np.abs(found - wanted)) < 1e-15, sequence
    wanted = about(2, 2.3) @ about(0, -1.1) @ about(2, 0.3)
    found = quaternion.matrix(quaternion.from_euler("zxz", angles))
    assert np.max(np.abs(found - wanted)) < 1e-15
    found = quaternion.matrix(quaternion.from_euler("y", [[0.4], [0.5]]))
    assert np.max(np.abs(found[0] - about(1, 0.4))) < 1e-15 and found.shape == (2, 3, 3)
    found = quaternion.matrix(quaternion.from_euler("XZ", (0.4, 0.5)))
    assert np.max(np.abs(found - about(0, 0.4) @ about(2, 0.5))) < 1e-15
    found = quaternion.from_euler("YZX", np.zeros((2, 5, 3)) + angles)
    assert found.shape == (2, 5, 4) and np.max(np.abs(found - found[0, 0])) == 0.0
    for bad in ("Xy", "AB", "xB", "A"):
        _refused("give three axes", quaternion.from_euler, bad, angles[: len(bad)])
    for bad in ("XXZ", "XZZ", "XyZ", "XYZX", "ABC", True, 1.5, "", "aZ"):
        _refused("give three axes", quaternion.from_euler, bad, angles)
    matrix = about(0, 0.4) @ about(1, 0.3)
    _refused("not a rotation", quaternion.from_matrix, matrix * (1.0 + 6e-7))
    quaternion.from_matrix(matrix * (1.0 + 4e-7))
    _refused("reflection", quaternion.from_matrix, -matrix)
    _refused("reflection", quaternion.refuse_other_matrices, np.diag([1.0, 1.0, -1.0]), "matrix")
    quaternion.refuse_other_matrices(np.eye(3), "matrix")
    assert quaternion.from_matrix(np.stack([matrix, np.eye(3)])).shape == (2, 4)
    assert quaternion.from_matrix(np.diag([1.0, -1.0, -1.0])).tolist() == [0.0, 1.0, 0.0, 0.0]


# ---- The public elliptic functions


def check_jacobi(truths):
    """Every function of `attitude.jacobi` against mpmath."""
    from attitude import jacobi

    for name, arguments, keywords, value, size in truths.jacobi:
        found = complex(getattr(jacobi, name)(*arguments, **keywords))
        assert abs(found - value) <= 2e-15 * size, (name, arguments, keywords, found, value)
    assert jacobi.K(1.0) == math.inf and jacobi.E(1.0) == 1.0 and jacobi.nome(0.0) == 0.0
    assert jacobi.nome(1.0) == 1.0 and jacobi.Pi(-0.5, 1.0) == math.inf
    assert jacobi.K([[0.0, 0.5], [1.0, 0.1]]).shape == (2, 2)
    assert jacobi.Pi(np.array([[-1.0], [0.0]]), (0.1, 0.2, 0.3)).shape == (2, 3)
    assert jacobi.F([0.1, 0.2], 0.3).shape == (2,)
    assert jacobi.am([0.1, 0.2], 0.3).shape == (2,)
    phi = np.array([0.2, 5.0])
    assert np.allclose(jacobi.F(-phi, 0.4), -jacobi.F(phi, 0.4), rtol=1e-15)
    outside = "outside of 0 to 1"
    for bad in (-0.1, 1.0000001, math.nan):
        try:
            jacobi.K(bad)
        except Exception as err:
            assert outside in str(err) or "m" in str(err)
        else:
            raise AssertionError(bad)
        if bad == bad:
            _refused(outside, jacobi.K, bad)
            _refused(outside, jacobi.K, 0.5, mc=bad)
    _refused("m + mc is not 1", jacobi.K, 0.5, mc=0.5 + 2e-12)
    jacobi.K(0.5, mc=0.5 + 5e-13)
    _refused("not above 0", jacobi.Pi, 1e-300, 0.5)
    for function in (jacobi.F, jacobi.E_incomplete, jacobi.am, jacobi.sn):
        _refused("give m < 1", function, 0.5, 1.0)
        _refused("give m < 1", function, [0.5, 0.5], [1.0, 0.5])
    for j in (0, 5, "1"):
        _refused("give 1, 2, 3 or 4", jacobi.theta, j, 0.0, 0.1)
    for q in (-0.1, 0.9999):
        _refused("q is outside", jacobi.theta, 3, 0.0, q)
    jacobi.theta(3, 0.0, _NEXT(0.9999, 0.0))
    assert jacobi.theta(1, [0.1, 0.2, 0.3], [[0.1], [0.2]]).shape == (2, 3)


_TENSOR = ((2.0, 0.1, 0.2), (0.1, 2.5, 0.5), (0.2, 0.5, 2.9))


def check_steps(truths):
    """The formulas of the paper against the motion."""
    from attitude import jacobi

    for moments in ((10.0, 20.0, 26.0), (26.0, 10.0, 20.0), (3.0, 2.0, 1.5), _TENSOR):
        for rates in ((1.0, 15.0, 1.0), (3.0, 0.2, -1.0), (-0.3, -0.2, 2.0), (-2.0, 0.3, -0.2)):
            case = "steps", moments, (0.5, 0.1, -0.7, 0.5), rates
            motion = motion_of(case)
            found = jacobi.steps(motion)
            t = np.linspace(-3.0, 20.0, 12)
            history = motion.at(t)
            assert np.max(np.abs(found.matrix(t) - history.matrix)) < 3e-12, case
            omega = found.angular_velocity(t) @ found.axes
            assert np.max(np.abs(omega - history.angular_velocity)) < 2e-12, case
            assert abs(4.0 * found.quarter / abs(found.speed) / motion.period_psi - 1.0) < 1e-12
            assert abs(np.linalg.det(found.axes) - 1.0) < 1e-15
            one, two, three = found.moments
            assert (one - two) * (two - three) > 0.0
            full = isinstance(moments[0], tuple)
            momentum = np.linalg.norm(
                np.dot(moments, rates) if full else np.multiply(moments, rates)
            )
            assert abs(found.momentum / momentum - 1.0) < 2e-15
            other = float(jacobi.K(1.0 - found.m))
            assert abs(found.other_quarter / other - 1.0) < 1e-13
            assert abs(found.q - float(jacobi.nome(found.m))) < 1e-15
    for moments, rates in (
        ((1.0, 2.0, 3.0), (0.0, 0.0, 1.0)),
        ((1.0, 2.0, 3.0), (0.0, 1.0, 0.0)),
        ((2.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
        ((2.0, 5.0, 6.0), (1.0, 0.25, 1.0)),
        ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0)),
    ):
        case = "steps", moments, (1.0, 0.0, 0.0, 0.0), rates
        _refused("divide by zero", jacobi.steps, motion_of(case))


CHECKS = {
    name.removeprefix("check_"): value
    for module in (globals(), *map(vars, (battery_axes, battery_periods, battery_derivatives)))
    for name, value in list(module.items())
    if name.startswith("check_")
}
# Those that see changes of derivatives only, the slow ones last.
OF_DERIVATIVES = (
    *("products", "growth", "thin_needles", "derivatives", "covariances"),
    *("many_derivatives", "streams"),
)
