"""One sampler of nasty inputs, used by every test and benchmark.

Each family is a function of a random.Random and returns (moments, wxyz0, omega0): principal moments
in kg m2 (in any order, triangle inequality kept), body -> inertial quaternion scalar first, body
rates in rad/s. The same functions serve fixed seeds (`sample`) and hypothesis (`strategy`), which
supplies its own Random, so that a failing example shrinks.
"""

import math
from random import Random
from typing import NamedTuple

FAMILIES = {}


class State(NamedTuple):
    """One input: family name, moments (3,), wxyz0 (4,), omega0 (3,), all Python floats."""

    family: str
    moments: tuple
    wxyz0: tuple
    omega0: tuple


def family(build):
    FAMILIES[build.__name__] = build
    return build


def draw(name, random):
    """One State of the named family."""
    moments, omega0 = FAMILIES[name](random)
    return State(name, tuple(map(float, moments)), _attitude(random), tuple(map(float, omega0)))


def sample(per_family=10, seed=2006, families=None):
    """A list of States: per_family of each family (all by default), the same for the same seed.

    A family has its own stream, so that adding one leaves the others as they were.
    """
    states = []
    for name in families or FAMILIES:
        random = Random(f"{seed} {name}")
        states += [draw(name, random) for _ in range(per_family)]
    return states


def strategy(families=None):
    """Hypothesis strategy for States of the named families (all by default)."""
    from hypothesis import strategies

    names = strategies.sampled_from(list(families or FAMILIES))
    return strategies.builds(draw, names, strategies.randoms(use_true_random=False))


def revolution(state):
    """Seconds in one revolution, 2 pi / |omega0|; 1 at rest."""
    rate = math.hypot(*state.omega0)
    return 2 * math.pi / rate if rate else 1.0


def epochs(state, revolutions=(10, 1e3, 1e6, 1e9), seed=2006):
    """Seconds, both signs of each horizon, an epoch drawn from the last tenth of it."""
    random, unit = Random(f"{seed} {state}"), revolution(state)
    return [s * unit * n * random.uniform(0.9, 1.0) for n in revolutions for s in (1, -1)]


def tensor(state, seed=2006):
    """The body of a state in axes that are not principal: (symmetric 3x3 rows, omega0).

    The turned tensor is rounded to doubles, so that equal moments come out all but equal.
    """
    turn = _matrix(_attitude(Random(f"{seed} {state}")))
    rows = [[0.0] * 3 for _ in range(3)]
    for i in range(3):
        for j in range(i + 1):
            terms = (turn[i][k] * state.moments[k] * turn[j][k] for k in range(3))
            rows[i][j] = rows[j][i] = math.fsum(terms)
    omega0 = tuple(math.fsum(turn[i][k] * state.omega0[k] for k in range(3)) for i in range(3))
    return tuple(map(tuple, rows)), omega0


# Bodies and rates that tumble ------------------------------------------------------------------


@family
def tumbling(random):
    """Nothing special."""
    return _moments(random), _rates(random)


@family
def wobble(random):
    """Spin about the least or greatest axis, either sense, off it by 1e-1 to 1e-15."""
    moments = _moments(random)
    return moments, _near_axis(random, moments, random.choice((0, 2)), random.randint(1, 15))


@family
def middle_axis_wobble(random):
    """Dzhanibekov: spin about the middle axis with outer rates of 1e-1 to 1e-16."""
    moments = _moments(random)
    return moments, _near_axis(random, moments, 1, random.randint(1, 16))


@family
def near_separatrix(random):
    """Large rates whose terms of D2 cancel to 1e-1 .. 1e-16, on both sides."""
    moments = _moments(random)
    low, mid, high = _sorted_axes(moments)
    omega = _rates(random)
    a, b, c = moments[low], moments[mid], moments[high]
    nearness = random.choice((-1, 1)) * 10.0 ** -random.randint(1, 16)
    balance = math.sqrt(a * (b - a) / (c * (c - b)) * (1 + nearness))
    omega[high] = math.copysign(omega[low] * balance, omega[high])
    return moments, omega


@family
def near_symmetric(random):
    """Two moments equal to 1e-1 .. 1e-15, the pair the lesser or the greater."""
    third = random.choice((random.uniform(0.2, 0.8), random.uniform(1.25, 1.75)))
    return _shuffle(random, [1.0, 1.0 + 10.0 ** -random.randint(1, 15), third]), _rates(random)


@family
def near_symmetric_near_separatrix(random):
    """Two moments all but equal and L near their plane, where m is neither 0 nor 1."""
    moments = near_symmetric(random)[0]
    distance = [abs(moments[i] - 1.0) for i in range(3)]
    axis = distance.index(max(distance))
    omega = _rates(random)
    omega[axis] *= math.sqrt(sorted(distance)[1]) * 10.0 ** -random.choice((0, 0, 1, 3, 8))
    return moments, omega


@family
def near_spherical(random):
    """Three moments equal to 1e-1 .. 1e-15."""
    small = 10.0 ** -random.randint(1, 15)
    return [1.0 + small * random.uniform(-1, 1) for _ in range(3)], _rates(random)


@family
def needle(random):
    """One moment 1e-2 .. 1e-6 of the others, which differ by less than it."""
    return _needle(random, 10.0 ** -random.randint(2, 6)), _rates(random)


@family
def extreme_needle(random):
    """One moment 1e-7 .. 1e-12 of the others."""
    return _needle(random, 10.0 ** -random.randint(7, 12)), _rates(random)


@family
def spinning_needle(random):
    """A needle that spins fast about its length: every component of L counts."""
    thin = 10.0 ** -random.randint(2, 6)
    moments, omega = _needle(random, thin), _rates(random)
    omega[moments.index(min(moments))] /= thin
    return moments, omega


@family
def flat(random):
    """A lamina: the greatest moment is exactly the sum of the others."""
    a, b = random.randint(1, 1024) / 1024, random.randint(1, 1024) / 1024
    return _shuffle(random, [a, b, a + b]), _rates(random)


@family
def units(random):
    """Moments of 1e-7 to 1e30 kg m2, rates of 1e-12 to 1e6 rad/s."""
    return _scaled(random, _moments(random), _rates(random), (-7, 30), (-12, 6))


@family
def extreme_units(random):
    """Moments of 1e-45 to 1e30 kg m2, any of the states above."""
    build = random.choice((wobble, middle_axis_wobble, near_separatrix, near_symmetric, needle))
    return _scaled(random, *build(random), (-45, 30), (-12, 6))


@family
def unequal_rates(random):
    """Each rate of its own size, 1e-12 to 1."""
    return _moments(random), [w * 10.0 ** -random.randint(0, 12) for w in _rates(random)]


# Exactly degenerate ----------------------------------------------------------------------------


@family
def sphere(random):
    return [random.uniform(0.5, 2)] * 3, _rates(random)


@family
def symmetric(random):
    """Exactly symmetric, oblate or prolate, general rates."""
    return _symmetric(random)[0], _rates(random)


@family
def symmetric_equatorial(random):
    """Exactly symmetric, spun about a direction of its equator."""
    moments, axis = _symmetric(random)
    omega = _rates(random)
    omega[axis] = random.choice((0.0, -0.0))
    return moments, omega


@family
def symmetric_polar(random):
    moments, axis = _symmetric(random)
    return moments, _only(axis, random)


@family
def principal_axis(random):
    """Exactly about the least or greatest axis, either sense."""
    moments = _moments(random)
    return moments, _only(_sorted_axes(moments)[random.choice((0, 2))], random)


@family
def middle_axis(random):
    moments = _moments(random)
    return moments, _only(_sorted_axes(moments)[1], random)


@family
def one_rate_zero(random):
    """Two principal rates, the third exactly zero."""
    omega = _rates(random)
    omega[random.randrange(3)] = random.choice((0.0, -0.0))
    return _moments(random), omega


# a, b, c, w1, w3 with a (b - a) w1^2 = c (c - b) w3^2 in integers, found by search
_SEPARATRIX = (
    (2, 5, 6, 1, 1),
    (2, 26, 27, 3, 4),
    (3, 4, 6, 2, 1),
    (3, 5, 8, 2, 1),
    (4, 5, 9, 3, 1),
    (8, 17, 25, 5, 3),
    (7, 37, 42, 1, 1),
)


@family
def separatrix(random):
    """D2 is exactly zero, in exact arithmetic on the doubles; the rate w2 is any."""
    a, b, c, w1, w3 = random.choice(_SEPARATRIX)
    size, rate = 2.0 ** random.randint(-20, 60), 2.0 ** random.randint(-30, 10)
    w2 = random.choice((0.0, random.uniform(-5, 5)))
    signs = [random.choice((-1, 1)) * rate for _ in range(3)]
    order = random.sample(range(3), 3)
    moments, omega = (size * a, size * b, size * c), (signs[0] * w1, signs[1] * w2, signs[2] * w3)
    return [moments[i] for i in order], [omega[i] for i in order]


@family
def rest(random):
    return _moments(random), [0.0, 0.0, -0.0]


@family
def rod(random):
    """No inertia about its length, about which it is at rest."""
    axis, moment = random.randrange(3), random.uniform(0.5, 2)
    omega = _rates(random)
    omega[axis] = 0.0
    return [0.0 if i == axis else moment for i in range(3)], omega


TUMBLING = tuple(name for name in list(FAMILIES)[: list(FAMILIES).index("sphere")])
DEGENERATE = tuple(name for name in FAMILIES if name not in TUMBLING)


# Ingredients -----------------------------------------------------------------------------------


def _moments(random):
    """Distinct moments of a solid body in any order: sums of pairs of mean squares."""
    x, y, z = random.uniform(0.05, 0.3), random.uniform(0.4, 0.6), random.uniform(0.7, 1.0)
    return _shuffle(random, [y + z, x + z, x + y])


def _rates(random):
    """Three rates of either sign, none near zero."""
    return [random.choice((-1, 1)) * random.uniform(0.1, 1.5) for _ in range(3)]


def _attitude(random):
    """A unit quaternion to within rounding, either sign."""
    wxyz = [random.uniform(-1, 1) for _ in range(4)]
    size = math.hypot(*wxyz)
    return tuple(x / size for x in wxyz) if size > 1e-3 else (1.0, 0.0, 0.0, 0.0)


def _matrix(wxyz):
    w, x, y, z = wxyz
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def _shuffle(random, values):
    return random.sample(values, len(values))


def _sorted_axes(moments):
    return sorted(range(3), key=lambda i: moments[i])


def _near_axis(random, moments, rank, digits):
    """Spin about the axis of the given rank of inertia, the other rates 10^-digits of it."""
    main = _sorted_axes(moments)[rank]
    return [w * (1.0 if i == main else 10.0**-digits) for i, w in enumerate(_rates(random))]


def _only(axis, random):
    return [w if i == axis else random.choice((0.0, -0.0)) for i, w in enumerate(_rates(random))]


def _needle(random, thin):
    return _shuffle(random, [thin, 1.0, 1.0 + thin * random.uniform(-0.9, 0.9)])


def _symmetric(random):
    """Moments with an exactly equal pair, and the axis of symmetry."""
    third = random.choice((random.uniform(0.01, 0.9), random.uniform(1.1, 1.9)))
    axis, equal = random.randrange(3), random.uniform(0.5, 2)
    return [third * equal if i == axis else equal for i in range(3)], axis


def _scaled(random, moments, omega, moment_powers, rate_powers):
    size, rate = 10.0 ** random.randint(*moment_powers), 10.0 ** random.randint(*rate_powers)
    return [i * size for i in moments], [w * rate for w in omega]


def constants_of(moments, wxyz, omega, principal, wxyz_low=None):
    """Constants (B,) of motions.

    Shapes: moments, omega (B, 3, 2), pairs; wxyz, wxyz_low (B, 4); principal (1 or B, 4).
    """
    from attitude._solver.states import Evaluation, States

    states = States(moments, principal, omega, None, wxyz, wxyz_low)
    return Evaluation(states).prepared(range(len(moments)), rates=True).constants
