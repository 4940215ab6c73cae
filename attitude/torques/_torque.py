"""`Torque`, the contract; gravity gradient, constant torques, damping, dissipation, functions."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._compilation.callbacks import Callback, callback_of, is_compiled
from attitude._compilation.pointers import C_FUNCTION
from attitude._solver.march_layout import BY_ATTITUDE, BY_RATE, LINEAR, SLIP
from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.pairs import Seconds
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.paths import _two_body
from attitude.paths._path import Path, body_name, since

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import ArrayLike, NDArray

    from attitude._support.annotations import FloatArray, Real, Reals
    from attitude.epochs._instants import Instant
    from attitude.motions._body import Body
    from attitude.motions._history import AttitudeHistory
    from attitude.torques._rheology import Rheology

    TorqueFunction: TypeAlias = Callable[[float, FloatArray, FloatArray], ArrayLike]
    PositionFunction: TypeAlias = Callable[[FloatArray], NDArray[Any]]
    AnyPath: TypeAlias = Path | PositionFunction
    AnyTorques: TypeAlias = "Torque | TorqueFunction | Iterable[Torque | TorqueFunction]"


class Torque(Immutable):
    """The base of all torques.

    Attributes
    ----------
    kind : int
        BY_ATTITUDE, BY_RATE, SLIP or LINEAR.
    columns : int
        Count of the numbers that `sample` returns for each epoch.
    is_users : bool
        Whether the function is a user's, which only machine code calls: its exceptions, and
        Ctrl-C, then leave the state of the motion as it was.
    changes_inertia : bool
        Whether it is an `InertiaHistory`.
    """

    kind: int = BY_ATTITUDE
    columns: int = 0
    is_users: bool = False
    changes_inertia: bool = False
    path: Path | None = None
    # Names of the functions of `_compiled` at the addresses below.
    _function: str = ""
    _slope: str = ""

    @property
    def is_of_seconds(self) -> bool:
        """Whether it depends on a function of seconds since the epoch of the spin."""
        return isinstance(self.path, FunctionPath)

    def address(self) -> int:
        """Address of the compiled function of the torque; see `attitude._solver.torqued_step`."""
        if not self._function:
            raise NotImplementedError(f"{type(self).__name__} defines no address")
        return address_of(self._function)

    def slope_address(self) -> int:
        """Address of the compiled function for the scheme "force-gradient"; 0 without one.

        The function takes a vector y, constant over the body axes, in place of the angular
        velocity, and returns the derivatives of N . y by turns about the body axes.  For a torque
        that depends on the attitude but has no potential it returns (y . d) N - N x y, which
        equals these derivatives where a potential exists.
        """
        return address_of(self._slope) if self._slope else 0

    def parameters(self, body: Body) -> FloatArray:
        """Constants (P,) that the compiled function takes, for a body."""
        return np.zeros(0)

    def by_rate(self) -> FloatArray:
        """The matrix (3, 3) of a LINEAR torque, N m s: torque by angular velocity, body axes."""
        return np.zeros((3, 3))

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """Numbers (K, columns) that the compiled function takes at each epoch.

        Parameters
        ----------
        instant : Instant
        seconds, low : (K,) float64 arrays
            The epochs are instant + seconds + low, TDB.
        """
        return np.zeros((len(seconds), 0))

    def sample_apart(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """As `sample`, at epochs that lie so far apart that no fit between them pays."""
        return self.sample(instant, seconds, low)

    def span(self, instant: Instant) -> tuple[float, float]:
        """First and last TDB seconds since an instant that its path, where it has one, covers."""
        return (-np.inf, np.inf) if self.path is None else span_of(self.path, instant)


def refuse_relative(body: Body, what: str) -> None:
    """AttitudeError for a body with relative moments, under what is in newtons."""
    if body.relative:
        raise AttitudeError(
            f"the moments of the body are relative, and {what}; give a Body with moments in kg m2."
        )


def matrix_of(value: Real | Reals, name: str, unit: str) -> FloatArray:
    """A matrix (3, 3); of a number that multiple of the unit matrix."""
    matrix = validation.real(value, name, unit=unit)
    return validation.real(matrix if matrix.shape else matrix * np.eye(3), name, shape=(3, 3))


class FunctionPath(Path):
    """Positions by a function of TDB seconds since the instant; `positions` checks them."""

    name, center, source = "path", "point mass", "function of seconds"

    def __init__(self, function: PositionFunction) -> None:
        self.function = function

    def position(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Result of the function: positions (..., 3) in m, ICRF axes; `low` is not used."""
        return self.function(np.asarray(seconds, dtype=np.float64))


def positions(
    path: Path, instant: Instant, seconds: FloatArray, low: FloatArray, name: str
) -> FloatArray:
    """Positions (K, 3) in m along a path, ICRF axes, at instant + seconds + low."""
    places = path.position(instant, seconds, low)
    try:
        places = np.asarray(places, dtype=np.float64)
    except (TypeError, ValueError) as err:
        raise AttitudeError(
            f"{name} did not return an array of numbers ({err}); it must return positions "
            "(..., 3) in m over ICRF axes."
        ) from None
    if places.shape != (len(seconds), 3):
        raise AttitudeError(
            f"{name} returned an array of shape {places.shape} for {len(seconds)} epochs; it must "
            "return positions (..., 3) in m over ICRF axes for an array of seconds (...)."
        )
    if not np.all(np.isfinite(places)):
        bad = float(seconds[np.flatnonzero(~np.all(np.isfinite(places), axis=-1))[0]])
        raise AttitudeError(
            f"{name} is not finite {bad:.9g} s after the epoch of the spin; give a path that "
            "covers the span."
        )
    return places


def span_of(path: Path, instant: Instant) -> tuple[float, float]:
    """First and last TDB seconds since an instant that a path covers, rounded inwards."""
    if path.span is None:
        return -np.inf, np.inf
    first, last = (sum(since(end, instant)) for end in path.span)
    return float(np.nextafter(first, last)), float(np.nextafter(last, first))


def path_of(path: AnyPath, name: str) -> Path:
    """The path itself, or the `FunctionPath` of a function of seconds."""
    if isinstance(path, Path):
        return path
    validation.refuse_class(path, name)
    if not callable(path):
        raise AttitudeError(
            f"{name} is {path!r}; give a path, or a function of seconds (...) since the epoch of "
            "the spin that returns positions (..., 3) in m over ICRF axes."
        )
    return FunctionPath(path)


# ---- The torque of a point mass on an extended body


@dataclass(frozen=True, eq=False, init=False)
class GravityGradient(Torque):
    """The gravity-gradient torque 3 GM/r^3 u x (I u) of a point mass.

    Parameters
    ----------
    path : Path, or function
        The body's centre of mass from the point mass, or the reverse: the sign has no effect.
        A function takes TDB seconds (...) since the epoch of the spin and returns (..., 3), m,
        over ICRF axes.
    mu : float, Quantity or str
        GM of the point mass in m3/s2, or a body by name or digits of its NAIF number: "sun",
        "moon", a planet alone ("saturn") or with its moons ("saturn barycenter").

    Attributes
    ----------
    path : Path
    mu : float
        m3/s2.

    Raises
    ------
    AttitudeError
        For a path or GM of another type, a body whose GM is not known, a path from another named
        body than that one, a GM that is not positive.

    Notes
    -----
    MacCullagh's formula, the first term of the expansion in (size of the body)/r.  The scheme
    "force-gradient" accepts one or several of these torques.
    """

    path: Path
    mu: float
    columns = 3
    _function = "gravity_gradient"
    _slope = "gravity_gradient_slope"

    def __init__(self, path: AnyPath, mu: Real) -> None:
        self._set("path", path_of(path, "path"))
        if isinstance(mu, str):
            mu = self._gm_of(body_name(mu, "mu"))
        self._set("mu", validation.positive(mu, "mu", unit="m3/s2"))

    def _gm_of(self, mass: str) -> float:
        """The GM in m3/s2 of a body by name, which is at one end of the path."""
        names = str(self.path.center), self.path.name.lower()
        ends = [name.removesuffix(" barycenter") for name in names]
        if ends[0] in _two_body.GM and mass.removesuffix(" barycenter") not in ends:
            raise AttitudeError(
                f"path is relative to {names[0]}, and mu is that of {mass}; give a path "
                f"relative to {mass}, or mu in m3/s2."
            )
        return _two_body.gm_of(mass, "mu")

    def parameters(self, body: Body) -> FloatArray:
        """GM, and the upper triangle by rows of the tensor less a multiple of the identity (7,)."""
        # A spherical part of the tensor causes no torque, and would only cancel.
        tensor = body.tensor - np.min(np.diag(body.tensor)) * np.eye(3)
        return np.concatenate([[self.mu], tensor[np.triu_indices(3)]])

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """Positions (K, 3) in m along the path, ICRF axes.

        Raises
        ------
        AttitudeError
            If one of them is the zero vector, or not finite.
        """
        places = positions(self.path, instant, seconds, low, "path")
        if not np.all(np.any(places != 0.0, axis=-1)):
            raise AttitudeError("path passes through the point mass; give a path at a distance.")
        return places

    def potential(self, body: Body, history: AttitudeHistory) -> FloatArray:
        """The potential energy (S,) in J of the torque, at the epochs of a history.

        GM/(2 r^3) (3 u . I u - tr I), without the part -GM m/r, which no attitude changes.
        """
        r = self.sample(history.epoch, *Seconds.of(history).flat).reshape(*history.shape, 3)
        distance = np.sqrt(np.sum(r * r, axis=-1))
        u = quaternion.rotate(quaternion.conjugate(history.wxyz), r / distance[..., None])
        form = np.sum(u * (u @ body.tensor), axis=-1)
        return 0.5 * self.mu / distance**3 * (3.0 * form - np.trace(body.tensor))


# ---- A torque that is fixed in the body: a thruster, a leak


@dataclass(frozen=True, eq=False, init=False)
class ConstantTorque(Torque):
    """A torque with constant components over the body axes.

    Parameters
    ----------
    torque : (3,) array_like or Quantity
        N m (in the body's unit of inertia per s2, if that is relative).

    Raises
    ------
    AttitudeError
        For another shape or unit, and for numbers that are not finite.
    """

    torque: FloatArray
    _function = "constant"
    _slope = "constant_slope"

    def __init__(self, torque: Reals) -> None:
        self._set("torque", frozen(validation.real(torque, "torque", shape=(3,), unit="N m")))

    def parameters(self, body: Body) -> FloatArray:
        """The torque (3,), N m over the body axes."""
        return np.array(self.torque)


# ---- Losses: drag from outside, and friction within the body


@dataclass(frozen=True, eq=False, init=False)
class LinearDamping(Torque):
    """A drag torque -C w from outside: it removes energy and angular momentum.

    Parameters
    ----------
    coefficient : float, Quantity or (3, 3) array_like
        C in N m s (in the body's unit of inertia per s, if that is relative), over the body axes.
        A matrix must not add energy: its symmetric part has no negative eigenvalue.

    Attributes
    ----------
    coefficient : (3, 3) float64 array, read-only

    Raises
    ------
    AttitudeError
        For another shape or unit, and for a matrix that adds energy.
    """

    coefficient: FloatArray
    kind = LINEAR
    _function = "linear_damping"

    def __init__(self, coefficient: Real | Reals) -> None:
        numbers = matrix_of(coefficient, "coefficient", "N m s")
        least = np.linalg.eigvalsh(numbers + numbers.T).min()
        if least < -1e-12 * np.max(np.abs(numbers)):
            raise AttitudeError(
                "coefficient would add energy: its symmetric part has a negative eigenvalue. "
                "Give a matrix that is positive semidefinite."
            )
        self._set("coefficient", frozen(numbers))

    def parameters(self, body: Body) -> FloatArray:
        """The matrix C by rows (9,), N m s."""
        return self.coefficient.reshape(9).copy()

    def by_rate(self) -> FloatArray:
        """-C, N m s."""
        return -self.coefficient


@dataclass(frozen=True, eq=False, init=False)
class InternalDissipation(Torque):
    """Friction within the body: energy falls at fixed angular momentum, towards short-axis spin.

    The body turns by an additional ``strength * (l x w)`` under its momentum, l being the
    direction of the momentum over the body axes, so that

        dE/dt = -strength L |l x w|^2 <= 0   and   L is fixed in space, to rounding.

    Angular velocities w of the spin and of the motion are I^-1 L; the attitude turns with w and the
    slip, which `AttitudeHistory.turning_rate` has.

    Parameters
    ----------
    strength : float or Rheology
        Pure number, not negative.  Of a solid of radius a about rho a^2 w^2/(mu Q), 1e-13 of rock
        that turns in days: take a `Rheology`, whose strength is that which takes its mean power
        over the nutation of the present energy and momentum: the same evolution over many
        nutations, not within one.

    Raises
    ------
    AttitudeError
        For a negative strength; from a motion, as `Rheology`.

    Notes
    -----
    Double-bracket dissipation (Bloch, Krishnaprasad, Marsden & Ratiu 1996, Commun. Math. Phys.
    175, 1), the simplest model with these two laws.
    """

    strength: float | Rheology
    kind = SLIP

    def __init__(self, strength: Real | Rheology) -> None:
        from attitude.torques._rheology import Rheology

        if isinstance(strength, Rheology):
            self._set("strength", strength)
            return
        number = validation.number(strength, "strength")
        if number < 0.0:
            raise AttitudeError(f"strength is {number!r}; friction does not add energy: give >= 0.")
        self._set("strength", number)

    def address(self) -> int:
        """Address of `_compiled.internal_dissipation`, or of `rheological_dissipation`."""
        is_number = isinstance(self.strength, float)
        return address_of("internal_dissipation" if is_number else "rheological_dissipation")

    def parameters(self, body: Body) -> FloatArray:
        """The strength and the tensor's upper triangle by rows (7,); of a rheology its table."""
        if isinstance(self.strength, float):
            return np.concatenate([[self.strength], body.tensor[np.triu_indices(3)]])
        from attitude.torques import _rheology

        return _rheology.parameters(self.strength, body)

    def strength_at(self, body: Body, momentum: ArrayLike, sine_squared: ArrayLike) -> FloatArray:
        """The strength (...) at momenta and energies (...), as `Rheology.power` takes them."""
        if isinstance(self.strength, float):
            shape = np.broadcast_shapes(np.shape(momentum), np.shape(sine_squared))
            return np.full(shape, self.strength)
        return self.strength.strength_at(body, momentum, sine_squared)


# ---- A body whose inertia changes: a deployment, jets, melting


@dataclass(frozen=True, eq=False, init=False)
class InertiaHistory(Torque):
    """A tensor of inertia that changes with time; the momentum is kept.

    A slip of the body under its momentum L: it turns with I(t)^-1 L in place of I^-1 L.  Other
    torques may act beside it.

    Parameters
    ----------
    change : function
        Of seconds (K,) since the epoch of the spin, returns I(t) - I (K, 3, 3) over the body axes,
        kg m2 (the body's unit, if its moments are relative), I being the tensor of the body; zero
        at the epoch.

    Raises
    ------
    AttitudeError
        For anything but a function; from a motion, for another shape, matrices that are not
        symmetric or finite, a change at the epoch, a body that would have no positive moments, a
        second `InertiaHistory`, and torques that take the angular velocity or the tensor.

    Notes
    -----
    d(I w)/dt + w x I w = N, which is dL/dt = N over inertial axes: matter that leaves takes the
    momentum of its place along, and moves on straight or radial lines over the body (Thomson,
    Introduction to Space Dynamics, 1986, section 7.3).  Angular velocities that the motion returns
    are I(t)^-1 L; its angular accelerations are refused.

    >>> from attitude import Body, Spin
    >>> from attitude.splitting import TorquedRotation
    >>> def boom(t):  # grows in 100 s
    ...     return np.clip(t / 100.0, 0.0, 1.0)[:, None, None] * np.diag([4.0, 0.0, 4.0])
    >>> body, spin = Body(moments=(10, 20, 26)), Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0.3))
    >>> TorquedRotation(body, spin, InertiaHistory(boom), step=0.5).at(200.0).angular_velocity
    array([0.  , 0.  , 0.26])
    """

    change: Callable[[FloatArray], FloatArray]
    kind = SLIP
    _function = "inertia_history"
    columns = 6
    changes_inertia = True
    is_of_seconds = True

    def __init__(self, change: Callable[[FloatArray], FloatArray]) -> None:
        validation.refuse_class(change, "change")
        if not callable(change):
            raise AttitudeError(
                f"change is {validation.shown(change)}; give a function of seconds (K,) that "
                "returns the change of the tensor of inertia (K, 3, 3) in kg m2."
            )
        self._set("change", change)

    def parameters(self, body: Body) -> FloatArray:
        """The upper triangle of the body's tensor by rows (6,)."""
        first = self.tensors(np.zeros(1))[0]
        if np.max(np.abs(first)) > 1e-9 * float(np.max(body.moments)):
            raise AttitudeError(
                f"the change of an InertiaHistory is {first.tolist()} at the epoch of the spin; "
                "give the difference from the tensor of the body, which is zero there."
            )
        return body.tensor[np.triu_indices(3)]

    def sample(self, instant: Instant, seconds: FloatArray, low: FloatArray) -> FloatArray:
        """Upper triangles (K, 6) of the change by rows."""
        one, two = np.triu_indices(3)
        return self.tensors(seconds + low)[:, one, two]

    def tensors(self, seconds: FloatArray) -> FloatArray:
        """The change (K, 3, 3) at seconds (K,), checked; NaN where they are."""
        unknown = np.isnan(seconds)
        rates = np.asarray(self.change(np.where(unknown, 0.0, seconds)))
        if rates.shape != (len(seconds), 3, 3) or rates.dtype.kind not in "fiu":
            raise AttitudeError(
                f"change of an InertiaHistory returned {validation.shown(rates)} for "
                f"{len(seconds)} epochs; it must return numbers (K, 3, 3) for seconds (K,)."
            )
        rates = rates.astype(np.float64)
        size = np.max(np.abs(rates), initial=0.0)
        skew = np.max(np.abs(rates - np.swapaxes(rates, 1, 2)), initial=0.0)
        if not np.all(np.isfinite(rates)) or skew > 1e-9 * size:
            raise AttitudeError(
                "change of an InertiaHistory returned a matrix that is not finite or not "
                "symmetric; a tensor of inertia is."
            )
        return np.where(unknown[:, None, None], np.nan, rates)


# ---- A torque by a function of the user, in plain Python or compiled by numba


@dataclass(frozen=True, eq=False)
class CustomTorque(Torque):
    """Any function of time, attitude and angular velocity.

    Parameters
    ----------
    function : function
        ``function(t, wxyz, omega)`` of TDB seconds since the epoch of the spin, the attitude (4,)
        body to ICRF and the angular velocity (3,) in rad/s over the body axes; returns three
        numbers, N m (as of `ConstantTorque`) over the body axes.  One compiled by ``numba.njit``
        runs at full speed, a plain one costs a few microseconds a call.  Its exceptions propagate
        to the caller of the motion, with their traceback.
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
    is_of_seconds = True

    def __post_init__(self) -> None:
        validation.flag(self.depends_on_rate, "depends_on_rate")
        self._set_all(kind=BY_RATE if self.depends_on_rate else BY_ATTITUDE, _callbacks={})
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
            is_fast = is_compiled(function)
            self._callbacks[name] = callback_of(function) if is_fast else _plain(function, name)
        callback = self._callbacks[name]
        if isinstance(callback, Callback):
            return callback.address
        return ctypes.cast(callback, ctypes.c_void_p).value


def _plain(function, name):
    """A C function that calls the Python one."""

    @C_FUNCTION
    def torque(t, wxyz, omega, samples, parameters, out):
        # Copies: the function may store its arguments.
        q, w = np.array(wxyz[0:4]), np.array(omega[0:3])
        out[0], out[1], out[2] = _three(function(t + parameters[0], q, w), name)

    return torque


def address_of(name: str) -> int:
    """Address of a function of `_compiled`."""
    from attitude.torques import _compiled

    return getattr(_compiled, name).address


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
