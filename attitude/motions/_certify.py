"""`certify`: proved distances of attitudes from the exact free rotation of a body and spin."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude.epochs import _inputs
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FloatArray, Reals
    from attitude.motions._body import Body
    from attitude.motions._spin import Spin
    from attitude.proof._certificate import Certificate
    from attitude.proof._chain import Chain, Joint


def certify(
    body: Body,
    spin: Spin,
    seconds: Epochs,
    wxyz: Reals,
    *,
    low: ArrayLike | None = None,
    angular_velocity: Reals | None = None,
) -> Certificate:
    """Proved distances of attitudes that anyone computed from the exact free rotation.

    Parameters
    ----------
    body, spin : Body, Spin
        Their doubles are exact: the moments, or the tensor if it is full; the attitude over ICRF
        (`Spin.wxyz_icrf_as_pairs`) and the angular velocity.
    seconds : (T,) array_like
        TDB seconds since the epoch of the spin, or epochs as `Motion.at` takes them.
    wxyz : (T, 4) array_like
        Attitudes, body to ICRF, scalar first, of any length; of either sign.
    low : (T,) array_like, optional
        A second double of the seconds.
    angular_velocity : (T, 3) array_like, optional
        rad/s over the body axes, to be certified too.

    Returns
    -------
    Certificate
        `error` is not less than the rotation angle between each attitude and the exact one.

    Raises
    ------
    AttitudeError
        For wrong shapes, numbers that are not finite, a spin about an axis without inertia,
        attitudes that 65,536 bits do not decide, and without python-flint (extra ``proof``).

    Notes
    -----
    Arb balls around the solution of van Zon & Schofield (2006), docs/proof.md.

    >>> import pytest
    >>> flint = pytest.importorskip("flint", reason="python-flint is not installed")
    >>> from attitude import Body, Spin
    >>> spin = Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0.5))
    >>> certificate = certify(Body(moments=(1, 2, 3)), spin, [0.0], [(1, 0, 1e-9, 0)])
    >>> f"{certificate.error[0]:.3e}"
    '2.000e-09'
    """
    from attitude.motions._spin import refuse_others

    refuse_others(body, spin, "certify takes a Body and a Spin first")
    _check_inertia(body, spin)
    hi, lo = _inputs.seconds_since(spin.epoch, seconds, low, name="seconds")
    wxyz = validation.real(wxyz, "wxyz", shape=(*hi.shape, 4))
    rates = None
    if angular_velocity is not None:
        rates = validation.real(
            angular_velocity, "angular_velocity", shape=(*hi.shape, 3), unit="rad/s"
        )
    return chain_of(body, spin).certificate(hi, lo, wxyz, rates)


def _check_inertia(body: Body, spin: Spin) -> None:
    """Refuse a spin about a principal axis without inertia."""
    rates = spin.angular_velocity
    if body.has_given_axes and np.any((body.moments == 0.0) & (rates != 0.0)):
        raise AttitudeError(
            f"the angular velocity is {rates.tolist()} rad/s and the moments are "
            f"{body.moments.tolist()}; the spin about an axis without inertia is undefined. Give 0 "
            "for that component, or a moment above zero."
        )


def chain_of(body: Body, spin: Spin, joints: Sequence[Joint] = (), record: Any = None) -> Chain:
    """The exact motion from the doubles of a body and a spin.

    Where equal moments leave the order of two axes open, or a rate of zero the sense of one, they
    are those of a record of the motion that tumbles (records.CONSTANTS).
    """
    from attitude.proof._chain import Chain

    order, axes = None, None if body.has_given_axes else body.principal_axes
    if record is not None:
        order = record["order"].tolist()
        if axes is not None:
            first, second, reverse1, reverse3 = record["jacobi"].tolist()
            senses = np.ones(3)
            senses[first], senses[3 - first - second] = 1 - 2 * reverse1, 1 - 2 * reverse3
            axes = axes * senses
    return Chain(
        inertia_of(body), spin.wxyz_icrf_as_pairs, spin.angular_velocity, joints, order, axes
    )


def inertia_of(body: Body) -> FloatArray:
    """The moments (3,) of a body if its axes are principal, else its tensor (3, 3)."""
    if body.moments.min() == 0.0 and not body.has_given_axes:
        raise AttitudeError(
            "a moment of inertia of the tensor is zero within rounding; such a body is certified "
            "over its principal axes only: give moments."
        )
    return body.moments if body.has_given_axes else body.tensor
