"""The free rotation through measured attitudes, by least squares."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.attitude_table.table import AttitudeTable
from attitude.errors import AttitudeError
from attitude.fitting import first_guess, losses, minimum
from attitude.fitting.model import Model
from attitude.fitting.observations import Attitudes, Measured, Observations, Rates, weights
from attitude.fitting.result import Fit, result
from attitude.history import AttitudeHistory

if TYPE_CHECKING:
    from attitude.annotations import FloatArray, Real, Reals
    from attitude.body import Body
    from attitude.fitting.minimum import Problem
    from attitude.fitting.model import Point
    from attitude.free_rotation.free_rotation import FreeRotation

# Records of the first stage, at least; more where some of them are outliers.
FEWEST, FEWEST_ROBUST = 6, 30


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
        Standard errors of the attitudes, rad; by default they are equal.
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
        A motion near the truth, in place of the first guess from the records.

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
    Moments follow from the wobble alone: a steady rotation fits any body, and the one returned is
    close to a sphere.  Derivatives are in closed form (`attitude.propagate`, `sensitivity=True`).

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.1, 1.5, 0.1))
    >>> motion = FreeRotation(Body(moments=(10, 20, 26)), spin)
    >>> found = fit(AttitudeTable.from_history(motion.at(np.arange(0.0, 60.0, 0.5))))
    >>> found.rms < 1e-9, (found.motion.body.moments / found.motion.body.moments[0]).round(6)
    (True, array([1. , 2. , 2.6]))
    """
    observed = _observed(table, sigma, rate_sigma)
    model = Model(body, axes)
    how = losses.known(loss, f_scale, sigma)
    if len(observed) < (3 if model.count > 6 else 2):
        raise AttitudeError(_too_few(len(observed)))
    given = velocities(observed)
    speed = float(np.mean(np.linalg.norm(given[2], axis=1)))
    first = first_stage(observed.t, speed, FEWEST_ROBUST if how.robust else FEWEST)
    if start is not None:
        point = first_guess.point_of(model, observed, start)
    else:
        point = guess(minimum.Problem(model, observed.at(slice(first)), how), given)
    return result(model, observed, minimum.found(model, observed, how, point, first))


def guess(problem: Problem, given: tuple[FloatArray, FloatArray, FloatArray]) -> Point:
    """The first guess from attitudes.

    Parameters
    ----------
    problem : Problem
        Of the records of the first stage.
    given : arrays (K,), (K, 4), (K, 3)
        Seconds, attitudes and the angular velocities there.
    """
    model, shape = problem.model, np.zeros(0)
    if model.body is None:
        robust = problem.loss.robust
        tensor = first_guess.inertia_of_attitudes(*given[1:], model.axes, robust=robust)
        shape = model.shape_of(tensor)
    return first_guess.best_state(problem, shape, given)


def first_stage(t: FloatArray, speed: float, fewest: int) -> int:
    """The number of records of the first stage: about one turn."""
    return max(fewest, int(np.searchsorted(t, 2.0 * np.pi / max(speed, 1e-300))))


def velocities(observed: Observations) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Seconds (K,), attitudes (K, 4) and angular velocities (K, 3) there, given or differences."""
    attitudes, *others = observed.kinds
    assert isinstance(attitudes, Attitudes)
    if others and isinstance(others[0], Rates):
        return observed.t, attitudes.wxyz, others[0].omega
    middle, omega = first_guess.velocities(attitudes.wxyz, observed.t)
    return 0.5 * (observed.t[1:] + observed.t[:-1]), middle, omega


def _too_few(count: int) -> str:
    """The sentence about a table that is too short."""
    plural = "" if count == 1 else "s"
    return f"the table has {count} record{plural}; give three or more (two with body=)."


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
    low = np.zeros(count) if history.low is None else np.asarray(history.low)
    seconds = np.asarray(history.seconds)
    attitudes = Attitudes(np.asarray(history.wxyz), weights(sigma, count, "sigma", "rad"))
    kinds: tuple[Measured, ...] = (attitudes,)
    given = table.angular_velocity
    if given is not None:
        rates = Rates(np.asarray(given), attitudes.weight)
        if rate_sigma is None:
            with np.errstate(divide="ignore"):
                usual = float(np.mean(1.0 / attitudes.weight)) * rates.scale()
            rate_sigma = usual if np.any(rates.omega) else np.inf
        kinds = (attitudes, Rates(rates.omega, weights(rate_sigma, count, "rate_sigma", "rad/s")))
    epoch = history.epoch.after(seconds[0], low[0])
    return Observations(epoch, (seconds - seconds[0]) + (low - low[0]), kinds)
