"""A torque that a user wrote, in plain Python or compiled by numba."""

import ctypes
from dataclasses import dataclass

import numpy as np

from attitude.compilation.callbacks import callback_of, is_compiled
from attitude.compilation.pointers import C_FUNCTION
from attitude.errors import AttitudeError
from attitude.torques.torque import BY_ATTITUDE, BY_RATE, Torque


@dataclass(frozen=True, eq=False)
class CustomTorque(Torque):
    """Any function of time, attitude and angular velocity.

    Parameters
    ----------
    function : function
        ``function(t, wxyz, omega)`` of TDB seconds since the epoch of the spin, the attitude (4,)
        body to ICRF and the angular velocity (3,) in rad/s over the body axes; returns three
        numbers, N m over the body axes.  One compiled by ``numba.njit`` runs at full speed, a
        plain one costs a few microseconds a call.  What a plain one raises is raised; the error of
        a compiled one is printed by numba, and told as a torque that is not finite.
    depends_on_rate : bool
        Whether it uses omega.  False saves three of four calls, and makes the schemes symplectic
        where the torque has a potential.
    slope : function, optional
        ``slope(t, wxyz, y)``, three numbers too, for the scheme "force-gradient": how N . y, the
        torque times a vector y that is held over the body axes, changes with turns about the body
        axes.  Only of torques that do not depend on the rates.

    Raises
    ------
    AttitudeError
        If a function does not return three numbers for a first, harmless state.

    Examples
    --------
    A magnetic dipole m in the field b over the body axes: N = m x b, so that N . y = b . (y x m),
    and a turn changes b by b x d.

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

    function: object
    depends_on_rate: bool = True
    slope: object = None

    def __post_init__(self):
        self._set("_error", [])
        self._set("_doors", {})
        self._check("function", "omega")
        if self.slope is None:
            return
        self._check("slope", "y")
        if self.depends_on_rate:
            raise AttitudeError(
                "slope is given for a torque that depends on the angular velocity; the force "
                "gradient is of torques that do not. Say depends_on_rate=False, or leave it out."
            )

    def __reduce__(self):
        return CustomTorque, (self.function, self.depends_on_rate, self.slope)

    @property
    def kind(self):
        return BY_RATE if self.depends_on_rate else BY_ATTITUDE

    def address(self):
        return self._address("function")

    def slope_address(self):
        return 0 if self.slope is None else self._address("slope")

    def _check(self, name, third):
        function = getattr(self, name)
        if not callable(function):
            raise AttitudeError(f"{name} is {function!r}; give a function of (t, wxyz, {third}).")
        _three(function(0.0, np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)), name)

    def _address(self, name):
        """Of the C function; the object keeps that alive."""
        if name not in self._doors:
            function = getattr(self, name)
            made = callback_of(function) if is_compiled(function) else self._plain(function, name)
            self._doors[name] = made
        door = self._doors[name]
        if hasattr(door, "address"):
            return door.address
        return ctypes.cast(door, ctypes.c_void_p).value

    def explain(self):
        if self._error:
            raise self._error.pop()

    def _plain(self, function, name):
        """A C function that calls the Python one; what that raises is kept for `explain`."""
        error = self._error

        @C_FUNCTION
        def torque(t, wxyz, omega, given, parameters, out):
            try:
                # Copies: the function may keep what it is given.
                q, w = np.array(wxyz[0:4]), np.array(omega[0:3])
                out[0], out[1], out[2] = _three(function(t, q, w), name)
            except BaseException as err:
                error.append(err)
                out[0] = out[1] = out[2] = float("nan")

        return torque


def _three(value, name):
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
