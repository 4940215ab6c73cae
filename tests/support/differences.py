"""Central differences of the oracle: the witness of the derivatives.

Each parameter is moved by 1e-28 of its scale to either side, at 90 digits: the error of a
difference is 1e-50 of the derivative where that of the motion is not larger than 1e20.
"""

import numpy as np
from mpmath import mp, mpf, workdps

from attitude import propagate
from tests.support.oracle import Oracle

# Of the largest entry of a column (docs/sensitivities.md).
PROMISE = 4e-15

_STEP = mpf(10) ** -28
# Beside the doubles that are given, a relative change at which the derivatives are taken again.
_SHIFT = mpf(10) ** -20
_LAST_BIT = 2.0**-52


def _product(p, q):
    return [
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    ]


def sensitivity(moments, wxyz, omega, times, impulses=()):
    """Derivatives (T, 3, 9) of the attitude, inertial axes, and of the angular velocity."""
    attitude, rates = exact_sensitivity(moments, wxyz, omega, times, impulses)
    return attitude.astype(float), rates.astype(float)


def exact_sensitivity(moments, wxyz, omega, times, impulses=()):
    """As `sensitivity`, in arrays of mpf; moments, angular velocity and times may be mpf.

    At the time of each of the `impulses`, (seconds, (3,) N m s over the body axes), the momentum
    changes; they are in order, and the times are those of one span.
    """
    attitude = np.full((len(times), 3, 9), mpf(0))
    rates = attitude.copy()
    with workdps(90):
        moments, omega = [mpf(x) for x in moments], [mpf(x) for x in omega]
        length = mp.sqrt(sum(mpf(x) ** 2 for x in wxyz))
        wxyz = [mpf(x) / length for x in wxyz]
        for j in range(9):
            scale = (mpf(1), max(map(abs, omega)) or mpf(1), max(moments))[j // 3]
            step = _STEP * scale
            sides = []
            for sign in (1, -1):
                q, w, i = list(wxyz), list(omega), list(moments)
                if j < 3:
                    turn = [mpf(1), mpf(0), mpf(0), mpf(0)]
                    turn[1 + j] = sign * step / 2
                    q = _product(turn, q)
                elif j < 6:
                    w[j - 3] += sign * step
                else:
                    i[j - 6] += sign * step
                sides.append(_motions(i, q, w, impulses))
            for k, t in enumerate(times):
                (a, u), (b, v) = (_state(side, t) for side in sides)
                turn = _product(a, [b[0], -b[1], -b[2], -b[3]])
                sign = 1 if turn[0] > 0 else -1
                attitude[k, :, j] = [sign * x / step for x in turn[1:]]
                rates[k, :, j] = [(x - y) / (2 * step) for x, y in zip(u, v, strict=True)]
    return attitude, rates


def _motions(moments, wxyz, omega, impulses):
    """Pairs of the first second and the motion from then on."""
    motions = [(mpf(0), Oracle(moments, wxyz, omega, digits=70))]
    for at, momentum in impulses:
        q, w = _state(motions, mpf(at))
        w = [x + mpf(h) / i for x, h, i in zip(w, momentum, moments, strict=True)]
        motions.append((mpf(at), Oracle(moments, q, w, digits=70)))
    return motions


def _state(motions, t):
    start, motion = max((pair for pair in motions if pair[0] <= t or not pair[0]), key=_first)
    return motion.at(mpf(t) - start)


def _first(pair):
    return pair[0]


def tensor_sensitivity(tensor, omega, times):
    """The attitude's derivatives of a body by its tensor, attitude (1, 0, 0, 0) at the epoch."""
    with workdps(90):
        values, vectors = mp.eigsy(mp.matrix(tensor.tolist()))
        if mp.det(vectors) < 0:
            vectors = -vectors
        rates = [sum(vectors[i, k] * mpf(omega[i]) for i in range(3)) for k in range(3)]
        exact = exact_sensitivity(list(values), (1, 0, 0, 0), rates, times)[0]
        turn = np.array(vectors.tolist()).astype(object)
        # attitudes of the principal axes begin with 1: their inertial axes are turned
        exact = np.einsum("ij,tjk->tik", turn, exact)
        exact[:, :, :3] = np.einsum("tij,kj->tik", exact[:, :, :3], turn)
        exact[:, :, 3:6] = np.einsum("tij,kj->tik", exact[:, :, 3:6], turn)
    return exact.astype(float)


def conditioning(moments, wxyz, omega, times, impulses=()):
    """By how much the last bits of the inputs can change each column, over its largest entry.

    Returns
    -------
    (T, 9) arrays of the attitude and of the angular velocity, 2^-52 kappa with the condition number
    kappa, the sum of |x d column / dx| over the inputs x: moments, angular velocity, time.
    """
    with workdps(90):
        given = [[mpf(x) for x in each] for each in (moments, omega, times)]
        middle = exact_sensitivity(given[0], wxyz, given[1], given[2], impulses)
        most = [np.zeros((len(times), 9)) for _ in middle]
        places = [(0, k) for k in range(3)] + [(1, k) for k in range(3) if omega[k] != 0.0]
        for part, k in [*places, (2, None)]:
            moved = [list(each) for each in given]
            for place in range(len(times)) if k is None else (k,):
                moved[part][place] *= 1 + _SHIFT
            found = exact_sensitivity(moved[0], wxyz, moved[1], moved[2], impulses)
            for one, other, total in zip(found, middle, most, strict=True):
                change = np.abs((one - other) / _SHIFT).max(axis=1)
                size = np.abs(other).max(axis=1)
                size[size == 0] = mpf(1)
                total += (change / size).astype(float) * _LAST_BIT
    return most


def excess(moments, wxyz, omega, times):
    """The largest error of a column of `propagate` over 4e-15 or, if larger, `conditioning`."""
    given = moments, wxyz, omega, times
    found = propagate(*given, angular_velocity=True, sensitivity=True)[2:]
    ratios = [relative(*pair) for pair in zip(found, sensitivity(*given), strict=True)]
    most = max(error.max() for error in ratios)
    if most <= PROMISE:
        return most / PROMISE
    allowed = [np.maximum(PROMISE, bits) for bits in conditioning(*given)]
    return max((error / limit).max() for error, limit in zip(ratios, allowed, strict=True))


def relative(computed, exact):
    """The error (T, P) of each column (T, 3, P) over its largest entry."""
    size = np.abs(exact).max(axis=1)
    size[size < 1e-50] = 1.0  # zero in exact arithmetic
    return np.abs(computed - exact).max(axis=1) / size
