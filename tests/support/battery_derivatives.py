"""Checks of derivatives and covariances for `battery`: against differences of the oracle."""

import math

import numpy as np

from tests.support import states
from tests.support.differences import PROMISE, relative, sensitivity

_WXYZ = (1.0, 0.3, 0.2, -0.1)
# Moments and rates of one motion of each kind; of those that tumble, the quick ones first.
_STATES = (
    ((2.0, 2.00000002, 2.00000003), (0.18, 9.0, 0.27)),
    ((1.0, 2.0, 2.6), (1e-8, -1.0, -2e-8)),
    ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    ((4.5, 1.5, 3.75), (-0.3, 2.0, 0.4)),
    ((1.0, 2.0, 2.7), (0.0, 0.0, 1.0)),
    ((1.0, 2.0, 2.7), (0.7, 0.0, 0.0)),
    ((2.0, 2.0, 2.0), (0.3, 0.5, 1.0)),
    ((1.0, 2.0, 2.7), (0.0, 0.0, 0.0)),
    ((1.0, 1.005, 1e-2), (0.0, 0.0, 1.0)),
    ((1.0, 2.0, 2.7), (0.0, 1.0, 0.0)),
    ((2.0, 3.0, 3.0), (1.3, 0.4, 0.9)),
    ((1.0, 2.0, 2.7), (1e-10, 2e-10, 1.0)),
    ((1e-5, 1.0, 1.000004), (0.3, 0.5, -0.9)),
    # symmetric bodies about an equatorial axis that is not principal, and about their own
    ((2.0, 2.0, 3.0), (0.6, -0.8, 0.0)),
    ((2.0, 2.0, 3.0), (0.0, 0.0, -1.0)),
    # the largest nomes of both forms, and of ellipticities; needles that precess less slowly
    ((0.347, 1.336, 1.597), (-0.19, -1.25, 0.25)),
    ((0.045, 1.0, 1.0226), (-0.1, 0.728, 0.053)),
    ((10.0, 20.0, 26.0), (1.22979, 0.3, 1.0)),
    ((20.0, 26.0, 10.0), (0.2, 0.78848, 1.0)),
    ((0.04, 1.0, 1.03), (5.0, 0.3, -0.2)),
    ((1.0, 1.03, 0.04), (0.03, -0.02, -5.0)),
    # on the separatrix exactly, before and after the passage of the middle axis
    ((2.0, 5.0, 6.0), (1.0, 0.3, 1.0)),
    ((6.0, 5.0, 2.0), (1.0, -3.0, -1.0)),
)
# Motions that approach the middle axis or turn about it, whose derivatives grow by e.
_GROWING = {(1.0, 2.0, 2.7): (0.0, 1.0, 0.0), (2.0, 5.0, 6.0): (1.0, 0.3, 1.0),
            (6.0, 5.0, 2.0): (1.0, -3.0, -1.0)}  # fmt: skip
# Revolutions after the epoch; of those that grow, few.
_REVOLUTIONS = (-0.02, 0.0, 0.1, 0.4, -0.3, 1.3, -3.7, 1e6 + 0.7)


def _epochs_of(moments, omega):
    speed = max(map(abs, omega)) or 1.0
    count = 5 if _GROWING.get(moments) == omega else len(_REVOLUTIONS)
    return np.array(_REVOLUTIONS[:count]) * (2.0 * np.pi / speed)


def truths_of_derivatives(kept):
    """States, epochs, and exact derivatives (T, 3, 9) of attitudes and angular velocities."""
    kept.derivatives = []
    for moments, omega in _STATES:
        times = _epochs_of(moments, omega)
        kept.derivatives.append((moments, omega, times, sensitivity(moments, _WXYZ, omega, times)))


def check_derivatives(truths):
    """Derivatives by attitude, angular velocity and moments, in every form."""
    from attitude import propagate
    from attitude._solver import derivatives

    nodes, weights = np.polynomial.legendre.leggauss(len(derivatives._NODES))
    assert np.allclose(derivatives._NODES, 0.5 + 0.5 * nodes, rtol=0.0, atol=1e-15)
    assert np.allclose(derivatives._WEIGHTS, 0.5 * weights, rtol=0.0, atol=1e-15)
    for moments, omega, times, (attitude, rates) in truths.derivatives:
        given = moments, _WXYZ, omega, times
        found = propagate(*given, angular_velocity=True, sensitivity=True)
        for one, other in ((found[2], attitude), (found[3], rates)):
            off = relative(one, other)
            assert np.all(off <= PROMISE), (moments, omega, off)


def check_thin_needles(_truths):
    """A needle whose spin and wobble agree to the last bit has the derivatives of a thicker one."""
    from attitude import propagate

    times = 2.0 * np.pi * np.array(_REVOLUTIONS[:6])
    found = [
        propagate((1.0, 1.0, thin), _WXYZ, (0.0, 0.0, 1.0), times, sensitivity=True)[1]
        for thin in (1e-40, 1e-20)
    ]
    assert np.all(relative(*found) <= 4e-16)


def check_growth(_truths):
    """Derivatives about the middle axis grow by e^280 within reach, and are refused beyond."""
    from attitude import AttitudeError
    from attitude._solver import sensitivities

    moments, rates = np.zeros((1, 3, 2)), np.zeros((1, 3, 2))
    moments[0, :, 0], rates[0, :, 0] = (1.0, 2.0, 2.7), (0.0, 1.0, 0.0)
    wxyz, axes = np.array([_WXYZ]), np.array([[1.0, 0.0, 0.0, 0.0]])
    constants = states.constants_of(moments, wxyz, rates, axes)
    tangents = sensitivities.tangents_of(moments, wxyz, axes, constants)
    rate = math.sqrt((2.0 - 1.0) * (2.7 - 2.0) / (1.0 * 2.7))
    reach = sensitivities.reaches(tangents)
    assert abs(reach[0] * rate / 280.0 - 1.0) <= 1e-14
    found = np.full((1, 3, 9, 1), np.nan)
    sensitivities.evaluate(constants, tangents, 0.999 * reach[:, None], None, found)
    assert np.isfinite(found).all()
    try:
        sensitivities.evaluate(constants, tangents, 1.001 * reach[:, None], None, found)
    except AttitudeError as err:
        assert f"within {reach[0]:.3g} s" in str(err), err
    else:
        raise AssertionError("an epoch beyond reach")


def check_products(_truths):
    """A coefficient of a product of series: of machine code, and of Python."""
    from attitude._solver import short_times

    terms = short_times.TERMS
    a, b = np.random.default_rng(35).normal(size=(2, 3 * terms))
    for n in range(terms):
        both = zip(a[terms : terms + n + 1], b[2 * terms + n : 2 * terms - 1 : -1], strict=True)
        exact = math.fsum(x * y for x, y in both)
        for product in (short_times._product, short_times._product.py_func):
            assert abs(product(a, b, 1, 2, n) - exact) <= 1e-14


def _factor():
    """W of a covariance W W^T of the nine parameters."""
    random = np.random.default_rng(7)
    return 1e-15 * (np.eye(9) + 0.3 * random.standard_normal((9, 9)))


def check_covariances(truths):
    """Covariances of attitude and angular velocity: sums of products of exact columns."""
    from attitude import Body, FreeRotation, Spin

    factor = _factor()
    for k in (2, 10, 6, 8):
        moments, omega, times, (attitude, rates) = truths.derivatives[k]
        both = np.concatenate([attitude, rates], axis=1) @ factor
        exact = both @ np.swapaxes(both, 1, 2)
        size = np.sqrt(np.diagonal(exact, axis1=1, axis2=2))
        size = np.repeat([size[:, :3].max(axis=1), size[:, 3:].max(axis=1)], 3, axis=0).T
        spin = Spin("2026-01-01", _WXYZ, omega, covariance=factor @ factor.T)
        motion = FreeRotation(Body(moments=moments, relative=True), spin)
        for count, with_rates in ((7, True), (7, False), (3, False)):
            found = motion.covariance_at(times[-count:], rates=with_rates)
            n = 6 if with_rates else 3
            off = np.abs(found - exact[-count:, :n, :n])
            off /= size[-count:, :n, None] * size[-count:, None, :n]
            assert off.max() <= 8e-15, (moments, omega, with_rates, off.max(axis=(1, 2)))
            assert np.array_equal(found, np.swapaxes(found, 1, 2))


def _stream_from(size):
    """Store arrays of so many numbers past the caches; functions in Python keep their globals."""
    from attitude._solver import columns

    columns.STREAMED = size
    for function in (columns.epochs_again, columns.has_whole_lines):
        function._python = None


def check_streams(_truths):
    """Derivatives and covariances of many epochs, stored past the caches, are those of few."""
    from attitude import Body, FreeRotation, Spin, propagate
    from attitude._solver import columns

    limit = columns.STREAMED
    moments, omega = _STATES[2]
    factor = _factor()
    spin = Spin("2026-01-01", _WXYZ, omega, covariance=factor @ factor.T)
    motion = FreeRotation(Body(moments=moments, relative=True), spin)

    def results(times):
        every = propagate(moments, _WXYZ, omega, times, angular_velocity=True, sensitivity=True)
        if count == 1011:
            return every
        return (*every, motion.covariance_at(times), motion.covariance_at(times, rates=True))

    # rows of 1008 epochs begin at lines of the caches, those of 1011 do not; the first epochs are
    # near the state or not
    for count, begin in ((1008, 5e3), (1011, 0.0), (1011, 5e3)):
        times = begin + 0.0037 * np.arange(count)
        _stream_from(1)
        try:
            many = results(times)
        finally:
            _stream_from(limit)
        for first in (0, 236, 482, 992):
            some = slice(first, first + 16)
            for one, other in zip(results(times[some]), many, strict=True):
                assert np.array_equal(one, other[some]), first


def check_many_derivatives(truths):
    """Derivatives and covariances of several motions are those of each alone."""
    from attitude._solver import sensitivities

    chosen = [_STATES[k] for k in (0, 2, 4, 6)]
    count = len(chosen)
    pairs = np.zeros((2, count, 3, 2))
    pairs[0, ..., 0], pairs[1, ..., 0] = zip(*chosen, strict=True)
    turns = np.array([_WXYZ, (0.5, -0.1, 0.3, 0.2)])
    wxyz, principal = turns[np.arange(count) % 2], turns[np.arange(1, count + 1) % 2].copy()
    principal /= np.linalg.norm(principal, axis=1, keepdims=True)
    given = states.constants_of(pairs[0], wxyz, pairs[1], principal)
    tangents = sensitivities.tangents_of(pairs[0], wxyz, principal, given)
    for first, end in ((0, 1), (2, 3), (3, 4), (0, 2), (2, 4)):  # set up alone, and in twos
        some = slice(first, end)
        alone = sensitivities.tangents_of(pairs[0][some], wxyz[some], principal[some], given[some])
        assert alone.tobytes() == tangents[some].tobytes()
    _check_rods(pairs[0], wxyz, principal, given)
    factors = np.stack([_factor() * (k + 1.0) for k in range(count)])
    of = sensitivities.factored(given, tangents, factors)
    t = np.array([0.1, 1.7, -40.0])[:, None] * (1.0 + np.arange(count) % 3)
    t = np.ascontiguousarray(t.T)
    low = 1e-17 * t

    def results(rows, times, lows):
        found = [np.full((len(given[rows]), 3, 9, 3), np.nan) for _ in range(2)]
        sensitivities.evaluate(given[rows], tangents[rows], times, lows, *found)
        factors_of = sensitivities.Factored(of.factors[rows], of.tangents[rows])
        for size in (6, 3):
            found.append(np.full((len(given[rows]), size, size, 3), np.nan))
            sensitivities.covariances(
                given[rows], tangents[rows], factors_of, times, lows, found[-1]
            )
        return found

    together = results(slice(0, count), t, low)
    for k in (0, 1, 3):
        alone = results(slice(k, k + 1), t[k : k + 1], low[k : k + 1])
        for one, many in zip(alone, together, strict=True):
            assert np.array_equal(one[0], many[k]), chosen[k]
    _check_runs(given, tangents, together, t)
    _check_far(given, tangents, of)


def _check_far(constants, tangents, of):
    """Covariances of attitudes far from the epoch fill all of out, eight at a time and the rest."""
    from attitude._solver import columns, sensitivities

    t = np.ascontiguousarray(np.tile(1e3 + 0.7 * np.arange(24), (len(constants), 1)))
    found = []
    for first, size in ((0, columns.STREAMED), (0, 1), (24 - 9, columns.STREAMED)):
        limit = columns.STREAMED
        _stream_from(size)
        try:
            shape = len(constants), 3, 3, 24 - first
            memory = np.full(math.prod(shape) + 8, np.nan)
            line = -(memory.ctypes.data // 8) % 8  # where a line of the caches begins
            out = memory[line : line + math.prod(shape)].reshape(shape)
            later = np.ascontiguousarray(t[:, first:])  # as the package passes epochs
            sensitivities.covariances(constants, tangents, of, later, None, out)
        finally:
            _stream_from(limit)
        found.append(out)
    assert np.isfinite(found[0]).all()
    assert np.array_equal(found[0], np.swapaxes(found[0], 1, 2))
    assert np.array_equal(found[0], found[1])
    assert np.array_equal(found[0][..., 15:], found[2])


def _check_rods(moments, wxyz, principal, constants):
    """A moment of zero is refused, and that of the first body which has one is named."""
    from attitude import AttitudeError
    from attitude._solver import sensitivities

    moments = moments.copy()
    moments[1, 1], moments[3] = 0.0, 0.0
    try:
        sensitivities.tangents_of(moments, wxyz, principal, constants)
    except AttitudeError as err:
        assert f"moments are {moments[1, :, 0].tolist()}" in str(err), err
    else:
        raise AssertionError("a moment of zero")


def _check_runs(constants, tangents, together, t):
    """Epochs of several motions in one row, and epochs beyond all doubles."""
    from attitude import AttitudeError
    from attitude._solver import sensitivities

    count, size = len(constants), t.shape[1]
    found = [np.full((1, 3, 9, count * size), np.nan) for _ in range(2)]
    times = t.reshape(1, -1).copy()
    edges = size * np.arange(count + 1)
    sensitivities.evaluate(constants, tangents, times, 1e-17 * times, *found, edges=edges)
    for one, many in zip(found, together, strict=False):
        rows = one[0].reshape(3, 9, count, size).transpose(2, 0, 1, 3)
        assert np.array_equal(rows, many)
    # a NaN is one among others; an epoch beyond the reach of its motion is refused
    times[0, 1] = np.nan
    again = [np.full((1, 3, 9, count * size), np.nan) for _ in range(2)]
    sensitivities.evaluate(constants, tangents, times, None, *again, edges=edges)
    for one in again:
        assert np.isnan(one[..., 1]).all() and np.isfinite(np.delete(one, 1, axis=-1)).all()
    for k in (0, 1, 2, 3):
        times = t.reshape(1, -1).copy()
        times[0, k * size] = 1e300
        try:
            sensitivities.evaluate(constants, tangents, times, None, *again, edges=edges)
        except AttitudeError as err:
            assert "1e+300" in str(err) or "epoch" in str(err), err
        else:
            raise AssertionError(k)
