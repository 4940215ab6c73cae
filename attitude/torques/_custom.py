"""A torque by a function of the user, in plain Python or compiled by numba."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._compilation.callbacks import Callback, callback_of, is_compiled
from attitude._compilation.pointers import C_FUNCTION
from attitude.errors import AttitudeError
from attitude.torques._torque import BY_ATTITUDE, BY_RATE, Torque

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray

    TorqueFunction: TypeAlias = Callable[[float, FloatArray, FloatArray], ArrayLike]


@dataclass(frozen=True, eq=False)
class CustomTorque(Torque):
    """Any function of time, attitude and angular velocity.

    Parameters
    ----------
    function : function
        ``function(t, wxyz, omega)`` of TDB seconds since the epoch of the spin, the attitude (4,)
        body to ICRF and the angular velocity (3,) in rad/s over the body axes; returns three
        numbers, N m over the body axes.  One compiled by ``numba.njit`` runs at full speed, a
        plain one costs a few microseconds a call.  Its exceptions propagate to the caller of the
        motion, with their traceback.
    depends_on_rate : bool
        Whether the function uses omega.  False saves three of four calls, and makes the schemes
        symplectic where the torque has a potential.
    slope : function, optional
        ``slope(t, wxyz, y)``, three numbers, for the scheme "force-gradient": the derivatives of
        N . y by turns about the body axes, y being a vector that is constant over these axes.
        Allowed only with depends_on_rate=False.

    Raises
    ------
    AttitudeError
        If a function does not return three numbers for t = 0, no rotation and zero omega or y,
        and for a slope where the torque depends on the rate.

    Examples
    --------
    A magnetic dipole m in the field b over the body axes: N = m x b, so that N . y = b . (y x m),
    and a turn d changes b by b x d.

    >>> from attitude import quaternion
    >>> m, field = np.array([0.0, 0.0, 2.0]), np.array([0.0, 3e-5, 0.0])
    >>> def over_body(wxyz):
    ...     return quaternion.rotate(quaternion.conjugate(wxyz), field)
    >>> dipole = CustomTorque(
    ...     lambda t, wxyz, omega: np.cross(m, over_body(wxyz)),
    ...     depends_on_rate=False,
    ...     slope=lambda t, wxyz, y: np.cross(np.cross(y, m), over_body(wxyz)),
    ... )
    """

    function: TorqueFunction
    depends_on_rate: bool = True
    slope: TorqueFunction | None = None
    _callbacks: dict[str, Any] = field(init=False, repr=False)
    is_users = True

    def __post_init__(self) -> None:
        self._set("kind", BY_RATE if self.depends_on_rate else BY_ATTITUDE)
        self._set("_callbacks", {})
        self._check("function", "omega")
        if self.slope is None:
            return
        self._check("slope", "y")
        if self.depends_on_rate:
            raise AttitudeError(
                "slope is given for a torque that depends on the angular velocity, but the scheme "
                '"force-gradient" takes no such torque; set depends_on_rate=False, or leave out '
                "slope."
            )

    def __reduce__(self) -> tuple[Any, ...]:
        return CustomTorque, (self.function, self.depends_on_rate, self.slope)

    def address(self) -> int:
        """Address of a C function that calls `function`."""
        return self._address("function")

    def slope_address(self) -> int:
        """Address of a C function that calls `slope`; 0 without one."""
        return 0 if self.slope is None else self._address("slope")

    def _check(self, name, third):
        """Raise an AttitudeError unless a function returns three numbers for a test state."""
        function = getattr(self, name)
        if not callable(function):
            raise AttitudeError(f"{name} is {function!r}; give a function of (t, wxyz, {third}).")
        _three(function(0.0, np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)), name)

    def _address(self, name):
        """The address of a C function, which this object keeps alive."""
        if name not in self._callbacks:
            function = getattr(self, name)
            made = callback_of(function) if is_compiled(function) else self._plain(function, name)
            self._callbacks[name] = made
        made = self._callbacks[name]
        if isinstance(made, Callback):
            return made.address
        return ctypes.cast(made, ctypes.c_void_p).value

    def _plain(self, function, name):
        """A C function that calls the Python one."""

        @C_FUNCTION
        def torque(t, wxyz, omega, given, parameters, out):
            # Copies: the function may store its arguments.
            q, w = np.array(wxyz[0:4]), np.array(omega[0:3])
            out[0], out[1], out[2] = _three(function(t, q, w), name)

        return torque


def _three(value, name):
    """A result of a user's function as three floats."""
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # ragged, or each number with its unit
        array = np.empty(0)
    if array.shape != (3,) or array.dtype.kind not in "fiu" or hasattr(value, "unit"):
        raise AttitudeError(
            f"the {name} of a CustomTorque returned {value!r}; it must return three plain numbers, "
            "over the body axes: a torque in N m."
        )
    return array.astype(float).tolist()
