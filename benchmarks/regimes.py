"""How accurate are periods and published spin states, and what do a million states cost?

    python benchmarks/regimes.py

It measures periods against 50 digits and against the motion integrated step by step, round trips of
published sets, the numbers that papers print, and the time of a million states.
"""

import math
import sys
import time
from pathlib import Path
from random import Random

import mpmath
import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from attitude import Body, FreeRotation, Spin, catalog
from attitude._compilation.choice import compiling
from attitude._solver.regime import regimes
from attitude.motions import _conventions
from attitude.motions._published import longest_P_phi, total_spin
from tests.support.oracle import Oracle
from tests.support.states import TUMBLING, sample
from tests.support.taylor import measured


def main():
    against_50_digits()
    near_the_separatrix()
    against_the_motion()
    there_and_back()
    printed()
    a_million()


def exact(moments, omega):
    """P_psi and P_phi of the long and of the short axis, in 50 digits."""
    oracle = Oracle(moments, (1, 0, 0, 0), omega, digits=50)
    oracle.at(0.0)
    c = oracle._motion
    with mpmath.mp.workdps(60):
        psi = abs(c.rate) / (4 * c.quarter)
        phi = (c.steady + c.coupling * c.rate * c.complete / c.quarter) / (2 * mpmath.pi)
        if oracle.mode == "SAM":
            return 1 / psi, 1 / (phi - psi), 1 / phi
        return 1 / psi, 1 / phi, 1 / (phi + psi)


def error(moments, omega):
    """The largest relative error of the three periods."""
    found = regimes(moments, omega)
    ours = (found.P_psi, found.P_phi_L, found.P_phi_S)
    with mpmath.mp.workdps(60):
        pairs = zip(ours, exact(moments, omega), strict=True)
        return max(abs(float(mpmath.mpf(value) / true - 1)) for value, true in pairs)


def against_50_digits():
    states = sample(15, families=TUMBLING)
    worst = max(error(state.moments, state.omega0) for state in states)
    print(f"periods of {len(states)} tumbling states against 50 digits: {worst:.1e} relative")


def near_the_separatrix():
    worst, count = 0.0, 0
    moments, random = (10.0, 20.0, 26.0), Random(3)
    balance = math.sqrt(10.0 * 10.0 / (26.0 * 6.0))
    for _ in range(200):
        nearness = random.choice((-1, 1)) * 10.0 ** random.uniform(-12.6, -12.2)
        omega = (1.0, random.uniform(-1, 1), balance * (1.0 + nearness))
        if not 5e-13 < regimes(moments, omega).one_minus_m < 2e-12:
            continue
        worst, count = max(worst, error(moments, omega)), count + 1
    print(f"periods of {count} states at 1 - m = 1e-12 (required: 1e-15): {worst:.1e} relative")


def against_the_motion():
    worst = 0.0
    states = {
        "paper's example": ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
        "long-axis mode": ((10.0, 20.0, 26.0), (9.0, 2.0, 1.0)),
        "Toutatis": ((3.0836, 3.235, 1.0), (0.1451, 0.33529, -0.98709)),
    }
    for moments, omega in states.values():
        period, turned = measured(moments, omega, turns=20)
        found = regimes(moments, omega)
        worst = max(worst, abs(float(period / found.P_psi) - 1.0))
        for P_phi in (found.P_phi_L, found.P_phi_S):
            turns = 20.0 * found.P_psi / P_phi
            worst = max(worst, abs((turns - turned + 0.5) % 1.0 - 0.5) / turns)
    print(f"periods against 20 integrated periods (required: 1e-12): {worst:.1e} relative")


def there_and_back(count=1000):
    random, worst, cost = Random(5), 0.0, 0.0
    for _ in range(count):
        body, given = _random_set(random)
        start = time.perf_counter()
        spin = Spin.from_periods(body, **given, epoch="2026-01-01")
        cost += time.perf_counter() - start
        table = FreeRotation(body, spin).published(given["convention"])
        angles = [
            table.phi0 - given["phi0"],
            table.psi0 - given["psi0"],
            *table.pole - given["pole"],
        ]
        sine = math.sin(table.theta0)  # the error of phi and psi grows as 1/sin(theta)
        angles = [abs((angle + math.pi) % (2 * math.pi) - math.pi) * sine for angle in angles]
        periods = [table.P_psi / given["P_psi"] - 1.0, table.P_phi / given["P_phi"] - 1.0]
        worst = max(worst, *angles, *np.abs(periods))
    print(
        f"{count} published sets -> state -> set, four combinations (required: 1e-12): "
        f"{worst:.1e}; {cost / count * 1e3:.2f} ms each"
    )


def _random_set(random):
    x, y, z = (random.uniform(0.1, 1.0) for _ in range(3))
    moments = random.sample([y + z, x + z, x + y], 3)
    body = Body(moments=moments)
    mode, convention = random.choice(("LAM", "SAM")), random.choice("LS")
    librates = (mode == "LAM") == (convention == "S")
    P_psi = 10.0 ** random.uniform(-3, 8)
    longest = longest_P_phi(body.moments[_conventions.order(body)], mode, convention, P_psi)
    psi0 = random.uniform(0.0, 2.0 * math.pi)
    if librates:
        psi0 = (0.5 * math.pi if mode == "LAM" else 0.0) + random.uniform(-0.05, 0.05)
    return body, {
        "mode": mode,
        "convention": convention,
        "P_psi": P_psi,
        "P_phi": longest * random.uniform(0.4, 0.98),
        "pole": np.array([random.uniform(0, 2 * math.pi), random.uniform(-1.5, 1.5)]),
        "phi0": random.uniform(0, 2 * math.pi),
        "psi0": psi0,
        "theta_branch": random.choice(("acute", "obtuse")),
    }


def printed():
    body, spin = catalog.load("99942 Apophis (2014)", phi0=0.0, psi0=0.0, epoch="2012-12-23")
    apophis = FreeRotation(body, spin).regime
    toutatis = catalog.entry("4179 Toutatis").motion().published("L")
    halley, angle = total_spin(mode="LAM", P_psi="7.1 d", P_phi="3.69 d", theta="66 deg")
    print(f"Apophis 2014: E/E0 {apophis.energy_ratio:.4f} (expected: 1.0236), ", end="")
    print(f"signal {apophis.P_phi_L / 3600.0:.3f} h (expected: 30.562)")
    print(f"Toutatis: P_psi {toutatis.P_psi / 86400.0:.4f} d (expected: 5.3685), ", end="")
    print(f"P_phi {toutatis.P_phi / 86400.0:.4f} d (expected: 7.4117)")
    print(f"Halley: total spin {halley / 86400.0:.4f} d (literature: 2.84), ", end="")
    print(f"{math.degrees(angle):.2f} deg from the momentum")


def a_million(count=1_000_000):
    rng = np.random.default_rng(0)
    x = rng.uniform(0.1, 1.0, (count, 3))
    moments = x + np.roll(x, 1, axis=1)
    omega = rng.normal(size=(count, 3))
    regimes(moments[:1000], omega[:1000])
    costs = []
    for _ in range(3):
        start = time.perf_counter()
        regimes(moments, omega)
        costs.append(time.perf_counter() - start)
    print(f"regimes of 1e6 states, all periods and ranges: {min(costs):.2f} s")


if __name__ == "__main__":
    with compiling():
        main()
