"""The free rotation through measured angular velocities, by least squares."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.fitting import first_guess, losses, minimum
from attitude.fitting.attitudes import FEWEST, FEWEST_ROBUST, first_stage
from attitude.fitting.model import Model
from attitude.fitting.observations import Observations, Rates, epochs_of, weights
from attitude.fitting.result import Fit, result

if TYPE_CHECKING:
    from attitude.annotations import Epoch, Epochs, Real, Reals
    from attitude.body import Body
    from attitude.free_rotation.free_rotation import FreeRotation

_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


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
    body : Body, optional
        Of known inertia; by default the ratios of the inertia are fitted too.
    epoch : Epoch, optional
        From which plain numbers t count; with epochs t it is not needed.
    axes : str
        Without a body: "principal" if the body axes are the principal axes, "free" if the
        principal axes are fitted too.
    sigma : float or (N,) array, optional
        Standard errors of the angular velocities, rad/s; by default they are equal.
    loss, f_scale, start
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
    how = losses.known(loss, f_scale, sigma)
    first_epoch, seconds = epochs_of(t, epoch)
    count = len(seconds)
    omega = validation.real(angular_velocity, "angular_velocity", shape=(count, 3), unit="rad/s")
    fewest = 3 if body is None else 1
    if count < fewest:
        raise AttitudeError(
            f"there {'is' if count == 1 else 'are'} {count} angular "
            f"velocit{'y' if count == 1 else 'ies'}; give three or more (one with body=)."
        )
    rates = Rates(omega, weights(sigma, count, "sigma", "rad/s"))
    observed = Observations(first_epoch, seconds, (rates,))
    speed = float(np.mean(np.linalg.norm(omega, axis=1)))
    first = first_stage(seconds, speed, FEWEST_ROBUST if how.robust else FEWEST)
    if start is not None:
        point = first_guess.point_of(model, observed, start)
    else:
        shape = np.zeros(0)
        if body is None:
            tensor = first_guess.inertia_of_rates(seconds, omega, axes, robust=how.robust)
            shape = model.shape_of(tensor)
        attitudes = np.broadcast_to(_IDENTITY, (count, 4))
        problem = minimum.Problem(model, observed.at(slice(first)), how)
        point = first_guess.best_state(problem, shape, (seconds, attitudes, omega))
    # The attitude has no influence: that of the first record is the identity.
    point = replace(point, wxyz=_IDENTITY)
    return result(model, observed, minimum.found(model, observed, how, point, first))
