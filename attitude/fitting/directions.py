"""The free rotation through measured directions (stars, the Sun), by least squares."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import frames, validation
from attitude.errors import AttitudeError
from attitude.fitting import first_guess, losses, minimum, sightings
from attitude.fitting.attitudes import FEWEST_ROBUST, first_stage, guess
from attitude.fitting.model import Model
from attitude.fitting.observations import Directions, Observations, epochs_of, weights
from attitude.fitting.result import Fit, result

if TYPE_CHECKING:
    from attitude.annotations import Epoch, Epochs, FloatArray, Real, Reals
    from attitude.body import Body
    from attitude.fitting.losses import Loss
    from attitude.fitting.model import Point
    from attitude.free_rotation.free_rotation import FreeRotation

# Directions of the first stage, at least.
_FEWEST = 12


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
    body : Body, optional
        Of known inertia; by default the ratios of the inertia are fitted too.
    epoch : Epoch, optional
        From which plain numbers t count; with epochs t it is not needed.
    frame : str
        "icrf", "eme2000" or "ecliptic" (of J2000).
    axes : str
        Without a body: "principal" if the body axes are the principal axes, "free" if the
        principal axes are fitted too.
    sigma : float or (N,) array, optional
        Standard errors of the directions about each axis across them, rad; by default equal.
    loss, f_scale, start
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
    how = losses.known(loss, f_scale, sigma)
    first_epoch, seconds = epochs_of(t, epoch, repeated=True)
    count = len(seconds)
    measured = _unit(body_directions, "body_directions", count)
    known = _unit(inertial_directions, "inertial_directions", count)
    directions = Directions(
        measured,
        known @ frames.matrix_to_icrf(frames.known(frame)).T,
        weights(sigma, count, "sigma", "rad"),
    )
    if 2 * count < model.count:
        raise AttitudeError(
            f"there {'is' if count == 1 else 'are'} {count} "
            f"direction{'' if count == 1 else 's'} for {model.count} parameters; give "
            f"{(model.count + 1) // 2} or more."
        )
    observed = Observations(first_epoch, seconds, (directions,))
    fewest = FEWEST_ROBUST if how.robust else _FEWEST
    if start is not None:
        point = first_guess.point_of(model, observed, start)
    else:
        point = _guess(model, observed, directions, how, fewest)
    first = first_stage(seconds, float(np.linalg.norm(point.omega)), fewest)
    return result(model, observed, minimum.found(model, observed, how, point, first))


def _guess(
    model: Model, observed: Observations, directions: Directions, loss: Loss, fewest: int
) -> Point:
    """The first guess, from attitudes or from spans."""
    times, wxyz = sightings.attitudes(observed.t, directions)
    epochs = len(np.unique(observed.t))
    if 2 * len(times) >= epochs and len(times) >= (3 if model.body is None else 2):
        middle, omega = first_guess.velocities(wxyz, times)
        given = 0.5 * (times[1:] + times[:-1]), middle, omega
        speed = float(np.median(np.linalg.norm(omega, axis=1)))
        first = first_stage(observed.t, speed, fewest)
        return guess(minimum.Problem(model, observed.at(slice(first)), loss), given)
    times, wxyz, omega = sightings.spans(observed, loss)
    shapes = [np.zeros(model.count - 6)]
    if model.body is None:
        # A span in which the direction is near the axis of rotation may give a wrong one.
        tensor = first_guess.inertia_of_rates(times, omega, model.axes, robust=True)
        shapes.append(model.shape_of(tensor))
    first = first_stage(observed.t, float(np.median(np.linalg.norm(omega, axis=1))), fewest)
    problem = minimum.Problem(model, observed.at(minimum.thinned(first)), loss)
    chosen = slice(None, first_guess.CANDIDATES)
    states = times[chosen], wxyz[chosen], omega[chosen]
    points = [
        point for shape in shapes for point in first_guess.states_at_first(model, shape, states)
    ]
    found = (problem.minimum(point, last=False) for point in points)
    return min(found, key=lambda each: each.cost).point


def _unit(value: Reals, name: str, count: int) -> FloatArray:
    """Unit vectors (count, 3) along a value (count, 3) or (3,)."""
    given = validation.real(value, name)
    if given.shape not in ((count, 3), (3,)):
        raise AttitudeError(f"{name} has shape {given.shape}; give ({count}, 3), one a record.")
    size = np.max(np.abs(given), axis=-1, keepdims=True)
    if np.any(size == 0.0):
        raise AttitudeError(f"{name} holds a vector of length zero, which has no direction.")
    scaled = given / size
    unit = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
    return np.broadcast_to(unit, (count, 3))
