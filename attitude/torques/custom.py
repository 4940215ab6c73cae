"""A torque that a user wrote, in plain Python or compiled by numba."""

import ctypes
from dataclasses import dataclass

import numpy as np

from attitude.errors import AttitudeError
from attitude.torques.torque import BY_ATTITUDE, BY_RATE, Torque

_POINTER = ctypes.POINTER(ctypes.c_double)


@dataclass(frozen=True, eq=False)
class CustomTorque(Torque):
    """Any function of time, attitude and angular velocity.

    Parameters
    ----------
    function : function
        ``function(t, wxyz, omega)`` of TDB seconds since the epoch of the spin, the attitude (4,)
        body to ICRF and the angular velocity (3,) in rad/s over the body axes; returns three
        numbers, N m over the body axes.  One compiled by ``numba.njit`` runs at full speed, a
        plain one costs a few microseconds a call.
    depends_on_rate : bool
        Whether it uses omega.  False saves three of four calls, and makes the schemes symplectic
        where the torque has a potential.

    Raises
    ------
    AttitudeError
        If the function does not return three numbers for a first, harmless state.
    """

    function: object
    depends_on_rate: bool = True

    def __post_init__(self):
        if not callable(self.function):
            raise AttitudeError(
                f"function is {self.function!r}; give a function of (t, wxyz, omega)."
            )
        self._set("_error", [])
        self._set("_door", None)
        _three(self.function(0.0, np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)))

    def __reduce__(self):
        return CustomTorque, (self.function, self.depends_on_rate)

    @property
    def kind(self):
        return BY_RATE if self.depends_on_rate else BY_ATTITUDE

    def address(self):
        if self._door is None:
            compiled = hasattr(self.function, "py_func")
            self._set("_door", _compiled(self.function) if compiled else self._plain())
        if hasattr(self._door, "address"):
            return self._door.address
        return ctypes.cast(self._door, ctypes.c_void_p).value

    def explain(self):
        if self._error:
            raise self._error.pop()

    def _plain(self):
        """A C function that calls the Python one; what that raises is kept for `explain`."""
        function, error = self.function, self._error

        @ctypes.CFUNCTYPE(None, ctypes.c_double, *[_POINTER] * 5)
        def torque(t, wxyz, omega, given, parameters, out):
            try:
                # Copies: the function may keep what it is given.
                q, w = np.array(wxyz[0:4]), np.array(omega[0:3])
                out[0], out[1], out[2] = _three(function(t, q, w))
            except BaseException as err:
                error.append(err)
                out[0] = out[1] = out[2] = float("nan")

        return torque


def _compiled(function):
    from numba import carray, cfunc

    from attitude.torques.compiled import SIGNATURE

    @cfunc(SIGNATURE)
    def torque(t, wxyz, omega, given, parameters, out):
        found = function(t, carray(wxyz, (4,)), carray(omega, (3,)))
        out[0], out[1], out[2] = found[0], found[1], found[2]

    return torque


def _three(value):
    array = np.asarray(value)
    if array.shape != (3,) or array.dtype.kind not in "fiu":
        raise AttitudeError(
            f"the torque function returned {value!r}; it must return three numbers, the torque in "
            "N m over the body axes."
        )
    return array.astype(float).tolist()
