"""Many freely rotating bodies, each evaluated at epochs of its own or at shared ones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from attitude.ensemble.arcs import ArcsEnsemble
from attitude.ensemble.described import Described
from attitude.ensemble.lit import Lit
from attitude.ensemble.reduced import Reduced
from attitude.ensemble.sources import Sourced
from attitude.ensemble.torqued import TorquedEnsemble

if TYPE_CHECKING:
    from attitude.annotations import Real
    from attitude.splitting.schemes import Scheme


class Ensemble(Sourced, Lit, Reduced, Described):
    """The free rotations of N bodies, as arrays.

    Parameters
    ----------
    body : Body, or N of them
        Or moments=, or tensors=.
    wxyz : (4,) or (N, 4) array_like
        Quaternions from body axes to `frame`, scalar first; of any length.
    angular_velocity : (3,) or (N, 3) array_like
        rad/s over the body axes, or a Quantity.
    epoch : one epoch, or N
        As for `Spin`: ISO text in UTC, astropy or skyfield Time, datetime, datetime64.
    frame : str
        As for `Spin`.
    names : N of str, optional
        Names of the members, which differ from each other.
    moments : (3,) or (N, 3) array_like
        Principal moments about the body axes, kg m2.
    tensors : (3, 3) or (N, 3, 3) array_like
        Inertia tensors in body axes, kg m2; their doubles are taken as exact, as by `Body`.
    relative : bool
        True if the unit of moments or tensors is unknown.
    on_error : "raise" or "nan"
        "nan" keeps members with a state that no body has: their attitudes, periods and brightness
        are NaN, their mode is -1; and epochs beyond the reach of a member give NaN.

    Attributes
    ----------
    wxyz : (N, 4) array
        As given.
    angular_velocity : (N, 3) array
        rad/s over the body axes.
    names : (N,) array of str, or None
    frame, on_error : str

    Raises
    ------
    AttitudeError
        For members that are not physical, the first of which is named; arrays of different
        lengths; names given twice.

    Notes
    -----
    Attitudes have the bits of `FreeRotation.at`, whatever the ensemble, the order of rows and the
    number of threads.  Constants of a member are computed anew in each call, in 1.1 us, and are
    not kept.  benchmarks/ensembles.py measures the cost.

    >>> tops = Ensemble(
    ...     moments=[(10, 20, 26), (1, 2, 2.5)], wxyz=(1, 0, 0, 0),
    ...     angular_velocity=[(1, 15, 1), (0.2, 0.1, 0)], epoch="2026-01-01",
    ... )
    >>> tops.at([0.0, 30.0, 60.0]).wxyz.shape
    (2, 3, 4)
    >>> tops.at([60.0, 5.0, 6.0], member=[0, 1, 1]).wxyz[0].round(6)
    array([ 0.006059,  0.14546 , -0.019617,  0.989151])
    >>> tops[0].mode.name, tops.period_psi.round(6)
    ('SHORT_AXIS', array([ 2.347113, 55.168519]))
    """

    def arcs(self, changes: Any) -> ArcsEnsemble:
        """The same states with impulses or changes of inertia: an `ArcsEnsemble`."""
        return ArcsEnsemble(self, changes)

    def torqued(
        self, torques: Any, step: Real, scheme: str | Scheme = "kick-rotate-kick"
    ) -> TorquedEnsemble:
        """The same states under torques, with one scheme and one step: a `TorquedEnsemble`."""
        return TorquedEnsemble(self, torques, step, scheme)
