"""The base classes of paths and ephemerides, names of bodies, and the simplest paths.

The methods of a path take arrays of epochs, each the sum of an `Instant` and one or two doubles of
seconds, as `epochs.seconds_since` returns them, so that no epoch is rounded to a single double of
seconds or days.  Positions are in metres and velocities in m/s, on ICRF axes, relative to
`path.center`: the name of a body ("ssb", "sun", "earth", ...) or another path.  `relative` joins
paths with different centers.

What a new kind of path defines
-------------------------------
``name``, ``center``, ``source`` and ``span`` as attributes or properties, and two methods over
flat arrays of finite epochs: ``_position(instant, hi, lo)``, which returns (3, N), and
``_state(instant, hi, lo)``, which returns two of them.  hi has shape (N,), lo (N,) or (1,).
"""

from __future__ import annotations

import operator
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias, cast

import numpy as np

from attitude import frames
from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, components_last, frozen
from attitude._support.validation import unit_vector
from attitude.epochs import _inputs, _time_scales
from attitude.epochs._instants import J2000, Instant, require
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epoch, FloatArray, Reals


# m in the kilometre of kernels, messages and SGP4.
KM: float = 1000.0

# ---- Names and NAIF numbers of the bodies of the solar system

SSB: str = "ssb"

# One name for each number; a planet and the barycentre of its system are two bodies, up to
# 100 km apart for Jupiter.
_NUMBERS = {
    SSB: 0,
    "mercury barycenter": 1,
    "venus barycenter": 2,
    "emb": 3,
    "mars barycenter": 4,
    "jupiter barycenter": 5,
    "saturn barycenter": 6,
    "uranus barycenter": 7,
    "neptune barycenter": 8,
    "pluto barycenter": 9,
    "sun": 10,
    "mercury": 199,
    "venus": 299,
    "earth": 399,
    "moon": 301,
    "mars": 499,
    "jupiter": 599,
    "saturn": 699,
    "uranus": 799,
    "neptune": 899,
    "pluto": 999,
}
_NAMES = {number: name for name, number in _NUMBERS.items()}
_OTHER_NAMES = {
    "solar system barycenter": SSB,
    "earth barycenter": "emb",
    "earth moon barycenter": "emb",
    "earth-moon barycenter": "emb",
    "geocenter": "earth",
    "luna": "moon",
}


def naif_index(value: Any) -> int | None:
    """A whole number of any type as an int; None for a bool and for values of other types."""
    if isinstance(value, bool):
        return None
    try:
        return operator.index(value)
    except TypeError:
        return None


def body_name(body: Any, name: str = "body") -> str:
    """The unique name of a body given by a name or a NAIF number.

    body: a number without a name here (an asteroid, a spacecraft) gives its digits.
    name: name of the parameter in the error message.
    AttitudeError for a name that is not known.

    >>> body_name("Earth Barycenter"), body_name(10), body_name("2099942")
    ('emb', 'sun', '2099942')
    """
    if isinstance(body, str):
        words = " ".join(body.lower().replace("_", " ").replace("barycentre", "barycenter").split())
        words = _OTHER_NAMES.get(words, words)
        if words in _NUMBERS:
            return words
        if words.lstrip("-").isdigit():
            return _NAMES.get(int(words), str(int(words)))
    elif (number := naif_index(body)) is not None:
        return _NAMES.get(number, str(number))
    raise AttitudeError(
        f"{name} is {body!r}, which is not the name of a body; give a NAIF number, or one of "
        f"{', '.join(_NUMBERS)}."
    )


# ---- The base class of ephemerides: sources of paths of the bodies of the solar system


class Ephemeris:
    """Bodies of the solar system by name or NAIF number; the base of all sources of them.

    What a new source defines
    -------------------------
    ``source``
        Text with the origin of the numbers; also the ``source`` of the paths.
    ``bodies``
        The names of all bodies of the source and of the centers of their paths, as
        `body_name` spells them.
    ``_step(name)``
        The `Path` of one of these bodies, or None for a body that the source lacks.  The
        ``center`` of that path is the name of another body of the source; the chain of centers
        ends at "ssb", the solar system barycentre.  `step` calls ``_step`` once for each body.
    ``advice`` (optional)
        End of the error message for a body that the source lacks: what the user can do.

    A new source needs a file of its own and one line in `_solar_system.SOURCES`: `paths.ephemeris`,
    `Scene` and mission files take the name in that table.  The first two also take an Ephemeris
    object, without that line.

    >>> import numpy as np
    >>> class Resting(Ephemeris):
    ...     '''A Sun at the barycentre, and an Earth at rest.'''
    ...     source, bodies = "two fixed points", ("ssb", "sun", "earth")
    ...     def _step(self, name):
    ...         from attitude import paths
    ...         places = {"sun": (0.0, 0.0, 0.0), "earth": (1.5e11, 0.0, 0.0)}
    ...         return paths.fixed(places[name], name=name) if name in places else None
    >>> from attitude import epochs, paths
    >>> path = paths.body("earth", Resting(), center="sun")
    >>> path.position(epochs.instant("2026-01-01"), np.zeros(1))
    array([[1.5e+11, 0.0e+00, 0.0e+00]])
    """

    source: str = "given"
    advice: str = "Give one of these, or another ephemeris."

    @property
    def bodies(self) -> tuple[str, ...]:
        """The names of the bodies, and of the centers of their paths."""
        raise NotImplementedError(f"{type(self).__name__} defines no bodies")

    @cached_property
    def _steps(self) -> dict[str, Path]:
        """The results of `_step` by the names of the bodies."""
        return {}

    def step(self, body: str | int) -> Path:
        """The path of a body relative to the center that this source gives the body.

        Parameters
        ----------
        body : str or int
            A name or a NAIF number.

        Raises
        ------
        AttitudeError
            For a name that is not known, and a body that the source lacks.
        """
        name = body_name(body)
        path = self.step_within(name, self)
        if path is None:
            hint = ""
            if f"{name} barycenter" in self.bodies:
                hint = f' It has the barycentre of its system: "{name} barycenter".'
            lack = f"no {name}"
            if name in self.bodies:
                lack = f"no path of {name}, only of bodies about it"
            raise AttitudeError(
                f"the ephemeris ({self.source}) has {lack}; it has "
                f"{', '.join(self.bodies)}.{hint} {self.advice}"
            )
        return path

    def step_within(self, name: str, whole: Ephemeris) -> Path | None:
        """The path of a body by its name, or None; `whole` is the ephemeris of which this is part.

        A source uses it for bodies whose center differs from time to time.
        """
        path = self._steps.get(name)
        if path is None and (path := self._step(name)) is not None:
            self._steps[name] = path
        return path

    def to_barycentre(self, path: Path) -> Path:
        """A path whose center is a body of this source, relative to "ssb"."""
        steps = [path]
        while (center := steps[-1].center) != SSB:
            step = self.step(cast("str", center))
            if step in steps:
                raise ring_error(path.name, step)
            steps.append(step)
        return path if len(steps) == 1 else Composed(tuple(steps), (), path.name, SSB)

    def _step(self, name: str) -> Path | None:
        """The path of a body by its name, or None for a body that the source lacks."""
        raise NotImplementedError(f"{type(self).__name__} defines no _step")

    def __repr__(self) -> str:
        return f"<{self.source}: {', '.join(self.bodies)}>"


def ring_error(start: object, step: Path) -> AttitudeError:
    """The error for centers that lead back to one before; `step` is the path that does."""
    return AttitudeError(
        f"the centers of {start} lead back to {label_of(step.center)} ({step.source}), and not to "
        "the solar system barycentre; give another ephemeris."
    )


class JoinedEphemeris(Ephemeris):
    """Several ephemerides as one: each body is that of the first that has it."""

    advice = "Give one of these, or one ephemeris more."

    def __init__(self, parts: tuple[Ephemeris, ...]) -> None:
        self.parts = parts
        self.source = ", ".join(dict.fromkeys(source.source for source in parts))

    def __reduce__(self) -> tuple[Any, ...]:
        return JoinedEphemeris, (self.parts,)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The names of the bodies of all parts, in order."""
        return tuple(dict.fromkeys(name for source in self.parts for name in source.bodies))

    def _step(self, name: str) -> Path | None:
        paths = (source.step_within(name, self) for source in self.parts)
        return next((path for path in paths if path is not None), None)


# Arguments of `paths.ephemeris`: an ephemeris, a file, a name, None for the default, or several.
_OneEphemeris: TypeAlias = Ephemeris | str | os.PathLike[str] | None
EphemerisLike: TypeAlias = _OneEphemeris | Sequence[_OneEphemeris]


# ---- The base class of paths and directions: the center, the observer and the Sun of a scene


class Place:
    """The base of `Path` and `Direction`: the members that other code may use of either.

    A direction is infinitely far away; a place on the ground has a horizon and a `zenith_path`.
    """

    name: str = "place"
    is_direction: bool = False
    has_horizon: bool = False

    def zenith(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Unit vectors (..., 3) towards the zenith, ICRF axes; AttitudeError without a horizon."""
        return self.zenith_path.position(instant, seconds, low)

    @property
    def zenith_path(self) -> Path:
        """A path whose position is the vector of 1 m to the zenith, and its velocity the rate.

        AttitudeError for a place without a horizon.
        """
        raise AttitudeError(
            f"the observer is {self.name}, which has no horizon; give a ground site: "
            "paths.site(longitude, latitude) or paths.observatory(code)."
        )

    @property
    def pole_path(self) -> Path:
        """As `zenith_path`, towards the pole on the horizon: north of a ground site."""
        return self.zenith_path


class Path(Place):
    """Something with a position and a velocity at any TDB epoch; the base of all kinds of paths.

    Attributes
    ----------
    name : str
        Name of the body, spacecraft or place that moves along the path.
    center : str or Path
        Origin of the positions: the name of a body, or another path.
    source : str
        Origin of the numbers: the kernel, file or model.
    span : (Instant, Instant) or None
        First and last epoch; None where there is no limit.
    roughness : float
        Upper bound in m of the distance from a smooth curve, for a source that rounds positions
        more coarsely than a double of metres does.
    is_slow : bool
        Whether a position costs tens of microseconds, so that a few hundred are fitted faster.
    is_direction : bool
        False.
    has_horizon : bool
        True for a place on the ground, which defines `zenith`.
    """

    name: str = "path"
    center: str | Path = "ssb"
    source: str = "given"
    span: tuple[Instant, Instant] | None = None
    roughness: float = 0.0
    is_slow: bool = False

    def position(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Position relative to the center in m, ICRF axes.

        Parameters
        ----------
        instant : epochs.Instant
        seconds : (...) float64 array
            TDB seconds from the instant.
        low : (...) float64 array, optional
            What `seconds` rounds off; the epochs are instant + seconds + low.

        Returns
        -------
        (..., 3) float64 array
            A view of component-major memory.  NaN where the epoch is NaN.

        Raises
        ------
        AttitudeError
            For an epoch outside of `span`.
        """
        return self._evaluate(instant, seconds, low, lambda *at: (self._position(*at),))[0]

    def velocity(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> FloatArray:
        """Velocity relative to the center in m/s of TDB, ICRF axes; see `position`."""
        return self._evaluate(instant, seconds, low, lambda *at: self._state(*at)[1:])[0]

    def state(
        self, instant: Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Position in m and velocity in m/s; see `position`."""
        return self._evaluate(instant, seconds, low, self._state)

    def _position(self, instant: Instant, hi: FloatArray, lo: FloatArray) -> FloatArray:
        """Positions (3, N) at finite epochs instant + hi + lo."""
        return self._state(instant, hi, lo)[0]

    def _state(self, instant, hi, lo):
        """Positions and velocities (3, N) at finite epochs instant + hi + lo."""
        raise NotImplementedError(f"{type(self).__name__} defines no _state")

    def _evaluate(self, instant, seconds, low, method):
        """Results (..., 3) of a method that takes flat arrays of finite epochs."""
        require(instant, "instant")
        epochs = pairs.Seconds(validation.seconds(seconds, "seconds"))
        if low is not None:
            second = validation.seconds(low, "low")
            try:
                epochs = pairs.Seconds(*np.broadcast_arrays(epochs.hi, second))
            except ValueError:
                raise AttitudeError(
                    f"low has shape {second.shape}, seconds has {epochs.hi.shape}; give both in "
                    "the same shape."
                ) from None
        shape, (hi, lo) = epochs.hi.shape, epochs.compact
        if not hi.size:
            return (np.zeros((*shape, 3)),) * (2 if method == self._state else 1)
        # The sum is finite exactly where every term of it is.
        if np.isfinite(hi.sum() + lo.sum()) or np.isfinite(hi + lo).all():
            rows = method(instant, hi, lo)
        else:
            rows = self._without_nan(instant, hi, lo, method)
        return tuple(components_last(row.reshape(3, *shape)) for row in rows)

    def _without_nan(self, instant, hi, lo, method):
        """Results (3, N) of a method, NaN where the epoch is NaN."""
        total = hi + lo
        known = ~np.isnan(total)
        if np.isinf(total).any():
            raise AttitudeError(
                f"an epoch for {self.name} is infinite; give finite seconds, or NaN where there is "
                "no epoch."
            )
        results = method(instant, hi[known], np.broadcast_to(lo, hi.shape)[known])
        rows = np.full((len(results), 3, hi.size), np.nan)
        rows[:, :, known] = results
        return rows

    def refuse_outside(self, instant: Instant, seconds: float) -> NoReturn:
        """Raise the AttitudeError for the epoch instant + seconds, which is outside of the span."""
        listed = ", ".join(f"{spelled(first)} to {spelled(last)}" for first, last in self._spans())
        raise AttitudeError(
            f"{self.name} is known from {listed} ({self.source}), but an epoch is "
            f"{spelled(instant.after(float(seconds)))}; leave that epoch out, or give a path that "
            "covers it."
        )

    def _spans(self) -> list[tuple[Instant, Instant]]:
        """The spans in which the path is known: one, or several with gaps between them."""
        return [] if self.span is None else [self.span]

    def check_span(self, instant: Instant, hi: FloatArray, lo: FloatArray) -> None:
        """Raise an AttitudeError if an epoch instant + hi + lo lies outside of the span."""
        if self.span is None or not hi.size:
            return
        first, last = (since(end, instant) for end in self.span)
        # Mostly the sums of the extremes lie within, and no other sum is needed.
        least, most = (hi.min(), lo.min()), (hi.max(), lo.max())
        if _later(least, first) > 0.0 and _later(last, most) > 0.0:
            return
        for bound, side in ((first, 1.0), (last, -1.0)):
            # The sum is rounded once, which matters between neighbouring doubles only.
            beyond = side * ((hi - bound[0]) + (lo - bound[1]))
            if beyond.min() < 0.0:
                self.refuse_outside(instant, hi[np.argmin(beyond)])

    def __repr__(self) -> str:
        return f"<path of {self.name} from {label_of(self.center)}: {self.source}>"


def label_of(center: str | Path) -> str:
    """The name of a center: of a body, or of a path."""
    return center if isinstance(center, str) else center.name


def _later(one, other):
    """Seconds from another epoch to one, each in two parts, rounded once or twice."""
    return (one[0] - other[0]) + (one[1] - other[1])


def since(instant: Instant, start: Instant) -> tuple[float, float]:
    """TDB seconds from start to instant as two floats."""
    return pairs.add((instant.seconds, instant.low), -start.seconds, -start.low)


def julian(instant: Instant, hi: FloatArray, lo: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A two-part Julian date of TDB for the epochs instant + hi + lo, to 5e-12 s."""
    date = _time_scales.jd_from_seconds(*pairs.add((hi, lo), instant.seconds, instant.low))
    return cast("tuple[FloatArray, FloatArray]", date)


def spelled(instant: Instant) -> str:
    """An instant as text in TDB to the millisecond, for messages."""
    import erfa

    jd = _time_scales.jd_from_seconds(np.float64(instant.seconds), np.float64(instant.low))
    year, month, day, clock = erfa.ufunc.d2dtf(b"TDB", 3, *jd)[:4]
    hour, minute, second, milli = (clock[name] for name in ("h", "m", "s", "f"))
    return f"{year:04d}-{month:02d}-{day:02d}T{hour:02d}:{minute:02d}:{second:02d}.{milli:03d} TDB"


def common_span(paths: Iterable[Any]) -> tuple[Instant, Instant] | None:
    """First and last epoch that all paths (or motions) cover, or None if none has a limit."""
    spans = [path.span for path in paths if path.span is not None]
    if not spans:
        return None
    order = operator.attrgetter("seconds", "low")
    firsts, lasts = zip(*spans, strict=True)
    return max(firsts, key=order), min(lasts, key=order)


@dataclass(frozen=True, eq=False, repr=False)
class Composed(Path):
    """A sum of paths, each with its sign.  Made by `relative`."""

    plus: tuple[Path, ...]
    minus: tuple[Path, ...]
    name: str
    center: str | Path

    @property
    def source(self) -> str:  # type: ignore[override]  # computed
        """The sources of the parts, separated by commas."""
        return ", ".join(dict.fromkeys(path.source for path in self.plus + self.minus))

    @property
    def span(self) -> tuple[Instant, Instant] | None:  # type: ignore[override]  # computed
        """First and last epoch that all parts cover; None if no part has a limit."""
        return common_span(self.plus + self.minus)

    @property
    def roughness(self) -> float:  # type: ignore[override]  # computed
        """Sum of the roughness of the parts, m; see `Path`."""
        return sum(path.roughness for path in self.plus + self.minus)

    @property
    def is_slow(self) -> bool:  # type: ignore[override]  # computed
        """Whether a part is; see `Path`."""
        return any(path.is_slow for path in self.plus + self.minus)

    def _position(self, instant, hi, lo):
        return self._added(np.zeros((3, hi.size)), lambda path: path._position(instant, hi, lo))

    def _state(self, instant, hi, lo):
        return self._added(np.zeros((2, 3, hi.size)), lambda path: path._state(instant, hi, lo))

    def _added(self, total, vectors_of):
        """A total to which the vectors of the parts are added, each with its sign."""
        for path in self.plus:
            total += vectors_of(path)
        for path in self.minus:
            total -= vectors_of(path)
        return total


# ---- The simplest paths: a point at rest or in uniform motion; and directions without a distance


class FrozenArrays(Immutable):
    """The base of dataclasses that make the arrays among their fields read-only."""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                frozen(value)


@dataclass(frozen=True, eq=False, repr=False)
class Uniform(FrozenArrays, Path):
    """Uniform motion start + speed (t - epoch), m and m/s.  Made by `uniform` and `fixed`."""

    start: FloatArray
    speed: FloatArray
    epoch: Instant
    center: str | Path
    name: str
    source: str = "uniform motion"

    def _position(self, instant, hi, lo):
        if not self.speed.any():
            return np.repeat(self.start[:, None], hi.size, axis=1)
        base = since(instant, self.epoch)
        whole, elapsed = pairs.two_sum(hi, base[0])
        seconds = whole + (base[1] + lo)
        # The rounding error of that sum: at 1e9 s, 1e-7 s at a velocity of 30 km/s are 3 mm.
        elapsed += (whole - seconds) + (base[1] + lo)
        return self.start[:, None] + (self.speed[:, None] * seconds + self.speed[:, None] * elapsed)

    def _state(self, instant, hi, lo):
        return self._position(instant, hi, lo), np.repeat(self.speed[:, None], hi.size, axis=1)


def uniform(
    position: Reals,
    velocity: Reals,
    epoch: Epoch,
    *,
    center: Path | str | int = SSB,
    frame: str = "icrf",
    name: str = "uniform motion",
) -> Uniform:
    """The path of uniform motion: r(t) = position + velocity (t - epoch).

    Parameters
    ----------
    position, velocity : (3,) array_like or Quantity
        m and m/s relative to the center, at the epoch.
    epoch : anything that `epochs.instant` takes
    center : Path, str or int
        A path, or a body by name or NAIF number.
    frame : str
        Axes of position and velocity, one of `frames.FRAMES`.
    name : str
        For messages.

    Raises
    ------
    AttitudeError
        For other shapes, units, names, and numbers that are not finite.
    """
    matrix = frames.matrix_to_icrf(frame)
    position = validation.real(position, "position", shape=(3,), unit="m")
    velocity = validation.real(velocity, "velocity", shape=(3,), unit="m/s")
    start = _inputs.instant(epoch)
    return Uniform(matrix @ position, matrix @ velocity, start, known_center(center), name)


def fixed(
    position: Reals,
    *,
    center: Path | str | int = SSB,
    frame: str = "icrf",
    name: str = "fixed point",
) -> Uniform:
    """The path of a point that rests relative to its center.

    Parameters
    ----------
    position : (3,) array_like or Quantity
        m relative to the center.
    center, frame, name
        See `uniform`.

    Raises
    ------
    AttitudeError
        For other shapes, units, names, and numbers that are not finite.
    """
    position = validation.real(position, "position", shape=(3,), unit="m")
    turned = frames.matrix_to_icrf(frame) @ position
    return Uniform(turned, np.zeros(3), J2000, known_center(center), name, "fixed point")


@dataclass(frozen=True, eq=False, repr=False)
class Direction(FrozenArrays, Place):
    """Something infinitely far away: a Sun or an observer in a constant direction.

    A direction has no position; `is_direction` distinguishes it from a path, so that a scene opens
    no ephemeris for it.  Made by `direction`.

    Attributes
    ----------
    unit : (3,) float64 array, read-only
        Unit vector towards it from any place, ICRF axes.
    name : str
    """

    unit: FloatArray
    name: str = "direction"

    is_direction = True

    def __repr__(self) -> str:
        x, y, z = self.unit.tolist()
        return f"<{self.name}, infinitely far towards ({x:.6g}, {y:.6g}, {z:.6g})>"


def direction(vector: Reals, *, frame: str = "icrf", name: str = "direction") -> Direction:
    """A place infinitely far away in the direction of a vector.

    Parameters
    ----------
    vector : (3,) array_like
        Of any length but zero.
    frame : str
        Axes of the vector, one of `frames.FRAMES`.
    name : str
        For messages.

    Raises
    ------
    AttitudeError
        For a zero vector, another shape, a frame that is not known.

    >>> direction((0, 0, 2), name="Sun")
    <Sun, infinitely far towards (0, 0, 1)>
    """
    return Direction(frames.matrix_to_icrf(frame) @ unit_vector(vector, "vector"), name)


def known_center(center: Path | str | int) -> Path | str:
    """A center as paths hold it: a path, or the name of a body as `body_name` spells it."""
    return center if isinstance(center, Path) else body_name(center, "center")
