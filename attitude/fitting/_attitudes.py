"""`fit`, `fit_rates`, `fit_directions`: the free rotation through measurements."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from attitude import frames
from attitude._support import validation
from attitude._support.arrays import units
from attitude._support.synonyms import arguments
from attitude.errors import AttitudeError
from attitude.fitting._minimum import (
    Loss,
    Problem,
    fitted,
    known_loss,
    minimum_of_stages,
    misfit_of,
    thinned,
)
from attitude.fitting._model import Model, Point
from attitude.fitting._observations import (
    Attitudes,
    Directions,
    Observations,
    Rates,
    epochs_of,
    epochs_of_history,
    weights,
)
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _propagation
from attitude.motions._body import Body
from attitude.motions._history import AttitudeHistory
from attitude.motions._table import AttitudeTable

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import Epoch, Epochs, FloatArray, IntArray, Real, Reals
    from attitude.fitting._minimum import Fit, Linearised
    from attitude.fitting._observations import Measured
    from attitude.motions._free_rotation import FreeRotation


# ---- First guesses: the inertia from what a free rotation conserves, and the first state
# With attitudes, R I w = L at every record, which is linear in the inertia I and in L.  With
# angular velocities alone, Euler's equations integrated over time, I w + integral of w x I w, do
# not change. Either way the tensor is that for which the vectors vary least; a sphere where none is
# better.

# Records of which a guess is made, at most.
_ENOUGH = 2000
# Weight of a sphere, relative to the squares of the angular velocities.
_SPHERE = 1e-12
# Repetitions of the weighting that removes outliers.
_REWEIGHTED = 15
# Records from whose states one is chosen, at most.
CANDIDATES = 16
# Records to either side of which medians are taken.
_NEIGHBOURS = 2
# Median deviations beyond which a record is an outlier.
_SPIKE = 6.0
# Windows: their records, those of the first stage of one, their number where some records are
# outliers, and those from which a fit begins.
_WINDOW = 12
_FEWEST_OF_WINDOW = 4
_WINDOWS = 8
_BEST_WINDOWS = 4
# Logarithms of the second moments of mass of bodies from which windows begin.
_SHAPES = (-0.8, 0.0, 0.8)
_LINEAR = Loss("linear", 1.0)
# Angle, rad, over which differences of attitudes are taken where records are denser.
_BASE = 0.5
# Angle between records, rad, up to which angular velocities are integrated.
_FARTHEST = 1.0


def velocities(wxyz: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Seconds (K,), attitudes (K, 4) and angular velocities (K, 3) between attitudes (N, 4).

    They are differences of neighbours, or of records so far apart that the turn is `_BASE` or more,
    against the noise.
    """
    count = len(t)
    begin, end = np.arange(count - 1), np.arange(1, count)
    span = float(np.median(np.diff(t)))
    while True:
        chosen = thinned(len(begin), most=_ENOUGH)
        turn = _turns(wxyz[begin[chosen]], wxyz[end[chosen]])
        if np.median(np.linalg.norm(turn, axis=1)) >= _BASE:
            break
        span *= 2.0
        later = np.searchsorted(t, t + (1.0 - 1e-9) * span)
        earlier = np.flatnonzero(later < count)
        earlier = earlier[t[later[earlier]] - t[earlier] <= 1.5 * span]
        if len(earlier) < max(count // 2, 2):
            break
        begin, end = earlier, later[earlier]
    turn = _turns(wxyz[begin], wxyz[end])
    middle = quaternion.multiply(wxyz[begin], forms.from_rotation_vector(0.5 * turn))
    return 0.5 * (t[end] + t[begin]), middle, turn / (t[end] - t[begin])[:, None]


def _turns(begin: FloatArray, end: FloatArray) -> FloatArray:
    """The rotation vectors (K, 3) from attitudes (K, 4) to others, body axes."""
    return forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(begin), end))


def inertia_of_attitudes(
    wxyz: FloatArray, omega: FloatArray, axes: str, *, robust: bool
) -> FloatArray:
    """The tensor (3, 3) of unit trace for which R I w varies least; wxyz, omega (K, 4) rad/s."""
    chosen = thinned(len(omega), most=_ENOUGH)
    wxyz, omega = wxyz[chosen], omega[chosen]
    basis = _basis(axes)
    vectors = quaternion.matrix(wxyz) @ np.tensordot(omega, basis, axes=(1, 2)).transpose(0, 2, 1)
    return _least_varying(vectors, np.zeros(len(omega), np.int64), omega, basis, robust)


def inertia_of_rates(t: FloatArray, omega: FloatArray, axes: str, *, robust: bool) -> FloatArray:
    """The tensor (3, 3) of unit trace for which Euler's equations hold best."""
    t, omega = t[:_ENOUGH], omega[:_ENOUGH]
    if robust:
        # An outlier would remain in all later integrals.
        omega = _without_spikes(omega)
    basis = _basis(axes)
    step = np.diff(t)
    speed = np.linalg.norm(omega, axis=1)
    joined = 0.5 * (speed[1:] + speed[:-1]) * step <= _FARTHEST
    if np.count_nonzero(joined) < 3:
        raise AttitudeError(
            "the angular velocities are too far apart for a first guess of the inertia: fewer than "
            f"3 of their {len(step)} steps are turns of less than {_FARTHEST:g} rad. Give denser "
            "records, the body, or a motion near the truth, start=FreeRotation(...)."
        )
    vectors = np.empty((len(t), 3, len(basis)))
    for k, matrix in enumerate(basis):
        product = np.cross(omega, omega @ matrix)
        area = 0.5 * (product[1:] + product[:-1]) * step[:, None]
        if len(t) > 2:
            # The trapezium rule with slopes at the ends, of fourth order.
            slope = np.gradient(product, t, axis=0)
            area += (slope[:-1] - slope[1:]) * (step**2 / 12.0)[:, None]
        area[~joined] = 0.0
        vectors[:, :, k] = omega @ matrix
        vectors[1:, :, k] += np.cumsum(area, axis=0)
    group = np.concatenate([[0], np.cumsum(~joined)])
    return _least_varying(vectors, group, omega, basis, robust)


def point_of(model: Model, observed: Observations, start: object) -> Point:
    """The point of a motion that the caller gives as the first guess."""
    from attitude.motions._free_rotation import FreeRotation

    start = validation.instance(start, FreeRotation, "start", "a FreeRotation, or leave it out")
    tensor = start.body.tensor / np.trace(start.body.tensor)
    off = np.max(np.abs(tensor - np.diag(np.diag(tensor))))
    if model.body is None and model.axes == "principal" and off > 1e-9:
        raise AttitudeError(
            "start has a body whose principal axes are not along the body axes; give "
            'axes="free", or a start with Body(moments=...).'
        )
    state = start.at(observed.epoch)
    return Point(np.array(state.wxyz), np.array(state.angular_velocity), model.shape_of(tensor))


def states_at_first(
    model: Model, shape: FloatArray, states: tuple[FloatArray, FloatArray, FloatArray]
) -> list[Point]:
    """Points (K) at the first record of states at other epochs; shape (k,), states (K,)."""
    t, wxyz, omega = states
    moments, axes = model.principal(shape)
    to_body = quaternion.from_matrix(axes)
    wxyz, omega = _propagation.propagate(
        moments,
        quaternion.multiply(wxyz, to_body),
        omega @ axes,
        -t[:, None],
        angular_velocity=True,
    )
    first = quaternion.multiply(wxyz[:, 0], quaternion.conjugate(to_body))
    return [Point(q, axes @ w, shape) for q, w in zip(first, omega[:, 0], strict=True)]


def best_state(
    problem: Problem,
    shape: FloatArray,
    states: tuple[FloatArray, FloatArray, FloatArray],
) -> Point:
    """The first of some states, or with a robust loss, as some are outliers, the best one."""
    many = CANDIDATES if problem.loss.robust else 1
    t, wxyz, omega = states
    points = states_at_first(problem.model, shape, (t[:many], wxyz[:many], omega[:many]))
    if many == 1:
        return points[0]
    return min(points, key=lambda point: problem.linearised(point).cost)


def points_of_windows(problem: Problem, turn: int) -> list[Point]:
    """Points at the first record, each the motion through a few records, the best ones first.

    turn: the records of one turn, over which a window extends if it has more of them than a window.
    They begin from bodies of several shapes; where some records are outliers, other windows have
    none.
    """
    model, observed, robust = problem.model, problem.observed, problem.loss.robust
    total = len(observed)
    size = min(_WINDOW, total)
    stride = max(min(turn, total) // size, 1)
    last_begin = total - 1 - stride * (size - 1)
    attempts = thinned(min(max(turn, 2 * size), last_begin + 1), most=_WINDOWS if robust else 1)
    ahead = Problem(model, observed.at(slice(max(turn, FEWEST_ROBUST))), problem.loss.wide)
    trials: list[Linearised] = []
    for begin in attempts:
        window = observed.at(begin + stride * np.arange(size))
        window = replace(window, t=window.t - observed.t[begin])
        for point in _window_points(model, window):
            with suppress(AttitudeError):
                best = minimum_of_stages(model, window, _LINEAR, point, _FEWEST_OF_WINDOW).point
                state = observed.t[begin : begin + 1], best.wxyz[None], best.omega[None]
                trials.append(ahead.linearised(states_at_first(model, best.shape, state)[0]))
        trials.sort(key=lambda trial: trial.cost)
        if trials and misfit_of(ahead.observed, problem.loss, trials[0]) < 1.0:
            break
    return [trial.point for trial in trials[:_BEST_WINDOWS]]


def _window_points(model: Model, window: Observations) -> list[Point]:
    """Points at the first record of a window, of bodies of several shapes."""
    attitudes = window.kinds[0]
    assert isinstance(attitudes, Attitudes)
    t, wxyz, omega = velocities(attitudes.wxyz, window.t)
    state = t[:1], wxyz[:1], omega[:1]
    shapes = [np.zeros(model.count - 6)]
    if model.body is None:
        pairs = permutations(_SHAPES, 2)
        shapes.extend(np.pad(pair, (0, model.count - 8)) for pair in pairs)
    return [states_at_first(model, shape, state)[0] for shape in shapes]


def _without_spikes(omega: FloatArray) -> FloatArray:
    """The rates (K, 3), with the medians of their neighbours in place of outliers."""
    padded = np.pad(omega, ((_NEIGHBOURS, _NEIGHBOURS), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _NEIGHBOURS + 1, axis=0)
    medians = np.median(windows, axis=-1)
    away = np.linalg.norm(omega - medians, axis=1)
    return np.where((away > _SPIKE * np.median(away))[:, None], medians, omega)


def _least_varying(
    vectors: FloatArray,
    group: IntArray,
    omega: FloatArray,
    basis: FloatArray,
    robust: bool,
) -> FloatArray:
    """The tensor of unit trace whose vectors (K, 3, B) vary least within groups (K,) of records."""
    sphere = np.array([np.trace(matrix) / np.sum(matrix**2) for matrix in basis])
    floor = _SPHERE * np.sum(omega**2) * np.eye(len(basis))
    if not np.any(floor):
        return np.eye(3) / 3.0
    weight = np.ones(len(vectors))
    candidate = sphere
    for _ in range(_REWEIGHTED if robust else 1):
        total = np.bincount(group, weight)
        centred = vectors - _sums(vectors, group, weight)[group] / total[group, None, None]
        flat = centred.reshape(-1, len(basis))
        normal = flat.T @ (flat * np.repeat(weight, 3)[:, None])
        candidate = np.linalg.solve(normal + floor, sphere)
        candidate = candidate / np.tensordot(candidate, basis, axes=1).trace()
        size = np.linalg.norm(centred @ candidate, axis=1)
        weight = 1.0 / np.maximum(size, 0.1 * np.median(size) + 1e-300)
        weight /= weight.max()
    return np.tensordot(candidate, basis, axes=1)


def _sums(vectors: FloatArray, group: IntArray, weight: FloatArray) -> FloatArray:
    """Weighted sums (G, 3, B) of the vectors (K, 3, B) of each group."""
    sums = np.zeros((group[-1] + 1, *vectors.shape[1:]))
    np.add.at(sums, group, vectors * weight[:, None, None])
    return sums


def _basis(axes: str) -> FloatArray:
    """A basis (B, 3, 3) of the diagonal matrices, or of the symmetric ones for free axes."""
    matrices = [np.diag(row) for row in np.eye(3)]
    if axes == "free":
        for i, j in ((0, 1), (0, 2), (1, 2)):
            matrix = np.zeros((3, 3))
            matrix[i, j] = matrix[j, i] = 1.0
            matrices.append(matrix)
    return np.array(matrices)


# Records of the first stage, at least.
FEWEST = 6
# The same where some of them are outliers.
FEWEST_ROBUST = 30


@arguments(
    dict.fromkeys(
        ("t", "times", "wxyz", "quaternions", "attitudes"),
        "give an AttitudeTable: fit(AttitudeTable(epoch, t, wxyz))",
    ),
    "fit(table)",
)
def fit(
    table: AttitudeTable | AttitudeHistory,
    body: Body | None = None,
    *,
    axes: str = "principal",
    sigma: Reals | None = None,
    rate_sigma: Reals | None = None,
    loss: str = "linear",
    f_scale: Real | None = None,
    start: FreeRotation | None = None,
) -> Fit:
    """The free rotation with the least squared residuals to the attitudes of a table.

    Parameters
    ----------
    table : AttitudeTable or AttitudeHistory
        Three records or more, with a body two; steps of less than half a turn unless it has
        angular velocities.
    body : Body, optional
        Of known inertia; by default the inertia is fitted too, as ratios.
    axes : str
        Without a body: "principal" if the body axes are the principal axes, "free" if the
        principal axes are fitted too.
    sigma : float or (N,) array, optional
        Standard errors of the attitudes, rad; by default they are equal.  inf leaves records out.
    rate_sigma : float or (N,) array, optional
        Standard errors of given angular velocities, rad/s; by default `sigma` times their mean
        size.  inf leaves them out.
    loss : str
        "linear" (least squares), or "soft_l1", "huber" or "cauchy", with which outliers count
        less; these need `sigma` or `f_scale`.
    f_scale : float, optional
        In standard errors, by default 1: the size from which residuals count as outliers.  The
        residual of a record is one vector.
    start : FreeRotation, optional
        A motion near the truth, in place of the first guess from the records; the loss of all
        records is minimised from it too.

    Returns
    -------
    Fit

    Raises
    ------
    AttitudeError
        For too few records, errors that are not greater than zero, and attitudes from which no
        motion follows.

    Notes
    -----
    Where the residuals are larger than the errors, or without `sigma` alike in neighbouring
    records, other first guesses are tried, and the motion of least loss is kept.  A warning says
    that its residuals too are far larger than the errors (without `sigma`, than 0.2 rad).

    Moments follow from the wobble alone.  Where that of no body lowers chi2 by 20, the body is a
    sphere: the rotation is steady, with infinite variances of the moments in `covariance`.  A
    warning says where turns in a gap of the records are not counted.  Derivatives are in closed
    form (`attitude.propagate`, `sensitivity=True`).

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1))
    >>> motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    >>> found = fit(AttitudeTable.from_history(motion.at(np.arange(0.0, 60.0, 0.5))))
    >>> found.rms < 1e-9, (found.motion.body.moments / found.motion.body.moments[0]).round(6)
    (True, array([1. , 2. , 2.6]))
    """
    observed = _observed(table, sigma, rate_sigma)
    model = Model(body, axes)
    scaled_loss = known_loss(loss, f_scale, sigma)
    if observed.used < (3 if model.count > 6 else 2):
        raise AttitudeError(_too_few(observed.used))
    states = velocities_observed(observed)
    speed = float(np.median(np.linalg.norm(states[2], axis=1)))
    first = first_stage(observed.t, speed, FEWEST_ROBUST if scaled_loss.robust else FEWEST)
    others: Callable[[], Sequence[Point]] = tuple
    if start is not None:
        point = point_of(model, observed, start)
    else:
        point = guess(Problem(model, observed.at(slice(first)), scaled_loss.wide), states)
        turn = first_stage(observed.t, speed, 1)
        others = partial(points_of_windows, Problem(model, observed, scaled_loss), turn)
    return fitted(model, observed, scaled_loss, point, first, others, is_start=start is not None)


def guess(problem: Problem, states: tuple[FloatArray, FloatArray, FloatArray]) -> Point:
    """The first guess from states: seconds (K,), attitudes (K, 4) and angular velocities (K, 3)."""
    model, shape = problem.model, np.zeros(0)
    if model.body is None:
        tensor = inertia_of_attitudes(*states[1:], model.axes, robust=problem.loss.robust)
        shape = model.shape_of(tensor)
    return best_state(problem, shape, states)


def first_stage(t: FloatArray, speed: float, fewest: int) -> int:
    """The number of records of the first stage: about one turn."""
    return max(fewest, int(np.searchsorted(t, 2.0 * np.pi / max(speed, 1e-300))))


def velocities_observed(observed: Observations) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Seconds (K,), attitudes (K, 4) and angular velocities (K, 3) there, given or differences."""
    attitudes, *others = observed.kinds
    assert isinstance(attitudes, Attitudes)
    if others and isinstance(others[0], Rates):
        return observed.t, attitudes.wxyz, others[0].omega
    return velocities(attitudes.wxyz, observed.t)


def _too_few(count: int) -> str:
    """The sentence about a table that is too short."""
    plural = "" if count == 1 else "s"
    return (
        f"the table has {count} record{plural}; give three or more of finite sigma (two with "
        "body=)."
    )


def _observed(
    table: AttitudeTable | AttitudeHistory, sigma: Reals | None, rate_sigma: Reals | None
) -> Observations:
    """The records of a table, with their weights."""
    history = table.history if isinstance(table, AttitudeTable) else table
    if not isinstance(history, AttitudeHistory) or len(history.shape) != 1:
        raise AttitudeError(
            f"table is {validation.shown(table)}; give an AttitudeTable, or an AttitudeHistory "
            "of epochs (N,)."
        )
    count = len(history)
    if not count:
        raise AttitudeError(_too_few(0))
    epoch, seconds = epochs_of_history(history)
    attitudes = Attitudes(weights(sigma, count, "sigma", "rad"), np.asarray(history.wxyz))
    used = attitudes.weight > 0.0
    if not np.any(used):
        raise AttitudeError(_too_few(0))
    kinds: tuple[Measured, ...] = (attitudes,)
    omega = table.angular_velocity
    if omega is not None:
        rates = Rates(attitudes.weight, np.asarray(omega))
        if rate_sigma is None:
            usual = float(np.mean(1.0 / attitudes.weight[used])) * rates.scale()
            rate_sigma = usual if np.any(rates.omega) else np.inf
        kinds = (attitudes, Rates(weights(rate_sigma, count, "rate_sigma", "rad/s"), rates.omega))
    return Observations(epoch, seconds, kinds)


# ---- The free rotation through measured angular velocities, by least squares

_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


@arguments(
    dict.fromkeys(("omega", "rates"), "give angular_velocity="),
    'fit_rates(t, angular_velocity, epoch="2026-01-01")',
)
def fit_rates(
    t: Epochs,
    angular_velocity: Reals,
    body: Body | None = None,
    *,
    epoch: Epoch | None = None,
    axes: str = "principal",
    sigma: Reals | None = None,
    loss: str = "linear",
    f_scale: Real | None = None,
    start: FreeRotation | None = None,
) -> Fit:
    """The free rotation with the least squared residuals to angular velocities, as of gyros.

    Parameters
    ----------
    t : (N,) array_like
        Increasing: epochs of any kind, or TDB seconds since `epoch`.
    angular_velocity : (N, 3) array_like
        rad/s over the body axes, relative to inertial space.
    epoch : Epoch, optional
        From which plain numbers t count; with epochs t it is not needed.
    sigma : float or (N,) array, optional
        Standard errors of the angular velocities, rad/s; by default they are equal.
    body, axes, loss, f_scale, start
        As for `fit`.

    Returns
    -------
    Fit
        With `rate_residuals`, and no `residuals`.

    Raises
    ------
    AttitudeError
        For too few records, epochs that do not increase, errors that are not greater than zero,
        and, without a body or `start`, records too far apart for a first guess.

    Notes
    -----
    Angular velocities leave the attitude undetermined.  The motion begins at the identity: its
    attitudes are relative to that of the first record.  In `covariance` the variances of the
    attitude are infinite.  The covariance of the spin holds, for the first attitude, that of a
    rotation of which nothing is known: (pi^2/3 + 2)/3 = 1.76 rad2 about each axis.  For the errors
    relative to the first attitude, set them to zero: ``spin.with_covariance(...)``.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1))
    >>> t = np.arange(0.0, 60.0, 0.2)
    >>> rates = FreeRotation(Body(moments=(10, 20, 26)), spin).at(t).angular_velocity
    >>> moments = fit_rates(t, rates, epoch="2026-01-01").motion.body.moments
    >>> (moments / moments[0]).round(6)
    array([1. , 2. , 2.6])
    """
    model = Model(body, axes)
    scaled_loss = known_loss(loss, f_scale, sigma)
    first_epoch, seconds = epochs_of(t, epoch)
    count = len(seconds)
    omega = validation.real(angular_velocity, "angular_velocity", shape=(count, 3), unit="rad/s")
    rates = Rates(weights(sigma, count, "sigma", "rad/s"), omega)
    observed = Observations(first_epoch, seconds, (rates,))
    fewest = 1 if body is not None else 3 if start is not None else 4
    if observed.used < fewest:
        raise AttitudeError(
            f"angular velocities with finite sigma are {observed.used}; give four or more (three "
            "with start=, one with body=)."
        )
    speed = float(np.mean(np.linalg.norm(omega, axis=1)))
    first = first_stage(seconds, speed, FEWEST_ROBUST if scaled_loss.robust else FEWEST)
    if start is not None:
        point = point_of(model, observed, start)
    else:
        shape = np.zeros(0)
        if body is None:
            tensor = inertia_of_rates(seconds, omega, axes, robust=scaled_loss.robust)
            shape = model.shape_of(tensor)
        attitudes = np.broadcast_to(_IDENTITY, (count, 4))
        problem = Problem(model, observed.at(slice(first)), scaled_loss.wide)
        point = best_state(problem, shape, (seconds, attitudes, omega))
    # The attitude has no influence: that of the first record is the identity.
    point = replace(point, wxyz=_IDENTITY)
    return fitted(model, observed, scaled_loss, point, first, is_start=start is not None)


# ---- Attitudes and angular velocities from directions, by Davenport's method
# The attitude that fits weighted directions best is the eigenvector of the greatest eigenvalue of a
# 4 x 4 matrix that is linear in the products of their components.  Over a span in which the angular
# velocity counts as constant, the directions are turned to its middle first: all angular velocities
# of a grid are tried, the best ones are improved.

# Gap between the two greatest eigenvalues, of the sum of weights, from which an attitude is
# determined: two directions 3 deg apart.
_DETERMINED = 1e-3
# Directions of the first span.
_FIRST = 10
# Directions of a later span, at least and at most.
_LEAST = 6
_LARGEST = 60
# Angle of a later span, rad.
_SPAN = 1.0
# Angle from one span to the next, rad.
_STRIDE = 0.3
# Number of spans.
_SPANS = 60
# The grid: greatest turn between records, rad.
_FASTEST = 1.5
# Spacing of the grid across half a span, rad.
_SPACING = 0.4
# Nodes of the grid that are improved.
_BEST = 8


def attitudes(t: FloatArray, directions: Directions) -> tuple[FloatArray, FloatArray]:
    """Epochs (K,), of t (N,), with directions that determine an attitude, and these (K, 4)."""
    times, group = np.unique(t, return_inverse=True)
    products = np.einsum("n,ni,nj->nij", directions.weight, directions.known, directions.measured)
    sums = np.zeros((len(times), 3, 3))
    np.add.at(sums, group, products)
    total = np.bincount(group, directions.weight)
    values, vectors = np.linalg.eigh(_davenport(sums))
    determined = values[:, 3] - values[:, 2] > _DETERMINED * total
    return times[determined], vectors[determined, :, 3]


def spans(observed: Observations, loss: Loss) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States of short spans: seconds (K,), attitudes (K, 4), angular velocities (K, 3)."""
    if len(np.unique(observed.t)) < 3:
        raise AttitudeError(
            "the directions are of fewer than three epochs and do not determine attitudes; give "
            "more, or a motion near the truth, start=FreeRotation(...)."
        )
    sphere = Model(Body(moments=(1.0, 1.0, 1.0)), "principal")
    guesses: list[tuple[float, Point]] = []
    begin, size, stride = 0, min(_FIRST, len(observed)), 1
    while begin + size <= len(observed) and len(guesses) < _SPANS:
        records_of_span, middle = _centred(observed, begin, size)
        problem = Problem(sphere, records_of_span, loss)
        if guesses:
            before, point = guesses[-1]
            turn = forms.from_rotation_vector(point.omega * (middle - before))
            wxyz = quaternion.multiply(point.wxyz, turn)
            best = problem.minimum(Point(wxyz, point.omega, point.shape))
        else:
            best = min(
                (problem.minimum(node) for node in _nodes(records_of_span)),
                key=lambda minimum: minimum.cost,
            )
            step = float(observed.t[-1] - observed.t[0]) / (len(observed) - 1)
            angle = max(float(np.linalg.norm(best.point.omega)) * step, 1e-300)
            size = int(np.clip(_SPAN / angle, _LEAST, _LARGEST))
            stride = int(np.clip(_STRIDE / angle, 1, _LARGEST))
            begin = max(begin, (_FIRST - size) // 2)
        guesses.append((middle, best.point))
        begin += stride
    states = zip(*((middle, point.wxyz, point.omega) for middle, point in guesses), strict=True)
    times, wxyz, omega = (np.array(values) for values in states)
    return times, wxyz, omega


def _centred(observed: Observations, begin: int, size: int) -> tuple[Observations, float]:
    """Records begin .. begin + size - 1, their seconds since the middle, and the middle."""
    records_of_span = observed.at(slice(begin, begin + size))
    middle = 0.5 * float(records_of_span.t[0] + records_of_span.t[-1])
    return replace(records_of_span, t=records_of_span.t - middle), middle


def _nodes(records: Observations) -> list[Point]:
    """The nodes of a grid of angular velocities that fit a span best, with their attitudes."""
    directions: Directions = records.kinds[0]  # type: ignore[assignment]
    half = float(np.max(np.abs(records.t)))
    step = 2.0 * half / (len(records) - 1)
    most = int(_FASTEST / step * half / _SPACING)
    line = np.arange(-most, most + 1) * (_SPACING / half)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[np.linalg.norm(grid, axis=1) <= line[-1] * (1.0 + 1e-9)]
    turns = forms.from_rotation_vector(grid[:, None] * records.t[:, None])
    turned = quaternion.rotate(turns, directions.measured)
    weighted = directions.known * directions.weight[:, None]
    values, vectors = np.linalg.eigh(_davenport(np.einsum("ni,gnj->gij", weighted, turned)))
    best = np.argsort(-values[:, 3])[:_BEST]
    return [Point(vectors[k, :, 3], grid[k], np.zeros(0)) for k in best]


def _davenport(sums: FloatArray) -> FloatArray:
    """Davenport's matrices (..., 4, 4) of sums (..., 3, 3) of inertial times body components."""
    matrix = np.empty((*sums.shape[:-2], 4, 4))
    trace = np.trace(sums, axis1=-2, axis2=-1)
    matrix[..., 0, 0] = trace
    for k, (i, j) in enumerate(((2, 1), (0, 2), (1, 0)), start=1):
        matrix[..., 0, k] = matrix[..., k, 0] = sums[..., i, j] - sums[..., j, i]
    matrix[..., 1:, 1:] = sums + np.swapaxes(sums, -1, -2) - trace[..., None, None] * np.eye(3)
    return matrix


# ---- The free rotation through measured directions (stars, the Sun), by least squares

# Directions of the first stage, at least.
_FEWEST = 12


@arguments({}, 'fit_directions(t, body_directions, inertial_directions, epoch="2026-01-01")')
def fit_directions(
    t: Epochs,
    body_directions: Reals,
    inertial_directions: Reals,
    body: Body | None = None,
    *,
    epoch: Epoch | None = None,
    frame: str = "icrf",
    axes: str = "principal",
    sigma: Reals | None = None,
    loss: str = "linear",
    f_scale: Real | None = None,
    start: FreeRotation | None = None,
) -> Fit:
    """The free rotation with the least squared residuals to directions, as of stars or the Sun.

    Parameters
    ----------
    t : (N,) array_like
        Epochs of any kind, or TDB seconds since `epoch`, in the order of time; equal ones for
        several directions at an epoch.
    body_directions : (N, 3) array_like
        Measured vectors over the body axes, of any length.
    inertial_directions : (N, 3) or (3,) array_like
        The same directions over the axes of `frame`; one for all, or one for each.
    epoch : Epoch, optional
        From which plain numbers t count; with epochs t it is not needed.
    frame : str
        "icrf", "eme2000" or "ecliptic" (of J2000).
    sigma : float or (N,) array, optional
        Standard errors of the directions about each axis across them, rad; by default equal.
    body, axes, loss, f_scale, start
        As for `fit`.

    Returns
    -------
    Fit
        `residuals` (N, 3): the least turn, rad over the body axes, from the model to an attitude
        that agrees with the direction.

    Raises
    ------
    AttitudeError
        For fewer numbers (two a direction) than parameters, epochs that are out of order, vectors
        of length zero, and records from which no first guess follows.

    Notes
    -----
    The first guess is made from attitudes where at least half of the epochs have two directions or
    more that are not parallel.  Else it follows from short spans in which the angular velocity
    counts as constant: successive directions may be 1 rad of rotation apart; others need `start`.
    A guess from one direction for all records can fail, most easily where it is near the axis of
    rotation at first: `rms` is then far above the errors of the records; give `start`.

    The turn about one fixed direction, such as the Sun alone in a short span, stays undetermined:
    the three variances of the attitude in `covariance` are then infinite, the angular velocity and
    the inertia are still determined unless the body spins about that direction.

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1))
    >>> history = FreeRotation(Body(moments=(10, 20, 26)), spin).at(np.arange(0.0, 60.0, 0.1))
    >>> stars = np.resize([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8]], (600, 3))
    >>> seen = history.inertial_to_body(stars)
    >>> found = fit_directions(history.seconds, seen, stars, epoch="2026-01-01")
    >>> (found.motion.body.moments / found.motion.body.moments[0]).round(6)
    array([1. , 2. , 2.6])
    """
    model = Model(body, axes)
    scaled_loss = known_loss(loss, f_scale, sigma)
    first_epoch, seconds = epochs_of(t, epoch, repeated=True)
    count = len(seconds)
    measured = _unit(body_directions, "body_directions", count)
    known = _unit(inertial_directions, "inertial_directions", count)
    directions = Directions(
        weights(sigma, count, "sigma", "rad"),
        measured,
        known @ frames.matrix_to_icrf(frames.known(frame)).T,
    )
    observed = Observations(first_epoch, seconds, (directions,))
    used = observed.used
    if 2 * used < model.count:
        raise AttitudeError(
            f"there {'is' if used == 1 else 'are'} {used} direction{'' if used == 1 else 's'} "
            f"with finite sigma for {model.count} parameters; give "
            f"{(model.count + 1) // 2} or more."
        )
    fewest = FEWEST_ROBUST if scaled_loss.robust else _FEWEST
    if start is not None:
        point = point_of(model, observed, start)
    else:
        point = _guess(model, observed, directions, scaled_loss, fewest)
    first = first_stage(seconds, float(np.linalg.norm(point.omega)), fewest)
    return fitted(model, observed, scaled_loss, point, first, is_start=start is not None)


def _guess(
    model: Model, observed: Observations, directions: Directions, loss: Loss, fewest: int
) -> Point:
    """The first guess, from attitudes or from spans."""
    times, wxyz = attitudes(observed.t, directions)
    epochs = len(np.unique(observed.t))
    if 2 * len(times) >= epochs and len(times) >= (3 if model.body is None else 2):
        velocity_samples = velocities(wxyz, times)
        speed = float(np.median(np.linalg.norm(velocity_samples[2], axis=1)))
        first = first_stage(observed.t, speed, fewest)
        return guess(Problem(model, observed.at(slice(first)), loss.wide), velocity_samples)
    times, wxyz, omega = spans(observed, loss)
    shapes = [np.zeros(model.count - 6)]
    if model.body is None:
        # A span in which the direction is near the axis of rotation may give a wrong one.
        tensor = inertia_of_rates(times, omega, model.axes, robust=True)
        shapes.append(model.shape_of(tensor))
    first = first_stage(observed.t, float(np.median(np.linalg.norm(omega, axis=1))), fewest)
    problem = Problem(model, observed.at(thinned(first)), loss)
    chosen = slice(None, CANDIDATES)
    states = times[chosen], wxyz[chosen], omega[chosen]
    points = [point for shape in shapes for point in states_at_first(model, shape, states)]
    minima = (problem.minimum(point, last=False) for point in points)
    return min(minima, key=lambda minimum: minimum.cost).point


def _unit(value: Reals, name: str, count: int) -> FloatArray:
    """Unit vectors (count, 3) along a value (count, 3) or (3,)."""
    vectors = validation.real(value, name)
    if vectors.shape not in ((count, 3), (3,)):
        raise AttitudeError(f"{name} has shape {vectors.shape}; give ({count}, 3), one a record.")
    size = np.max(np.abs(vectors), axis=-1, keepdims=True)
    if np.any(size == 0.0):
        raise AttitudeError(f"{name} holds a vector of length zero, which has no direction.")
    return np.broadcast_to(units(vectors / size), (count, 3))
