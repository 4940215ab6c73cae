"""`Scene`: a motion, the path of its body, an observer and the Sun; quantities as observables."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude._support import markup, pairs, quantity_text, validation
from attitude._support.arrays import Immutable, copied
from attitude._support.synonyms import arguments, named
from attitude.catalog import motion_of
from attitude.conditions._conditions import Observable
from attitude.conditions._moments import Source, lengths
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError
from attitude.paths import _composed, _path, _solar_system
from attitude.paths._foreign import place_of
from attitude.paths._path import Place
from attitude.scattering._law import law as known_law
from attitude.scene import _shadow
from attitude.scene._light_time import Steps
from attitude.scene._view import View

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epochs, FilePath, FloatArray, Real, Reals
    from attitude.conditions._moments import Moment, Pair
    from attitude.light_curve._visibility import Visibility
    from attitude.motions._motion import HasAttitudes, Motion
    from attitude.paths._path import Direction, Ephemeris, EphemerisLike, Path
    from attitude.scattering._law import Law
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh

    Radii: TypeAlias = Mapping[str, Real | None] | Mapping[int, Real | None]


# ---- What a Scene is given, checked: places, a shape, shadows, times


def refuse_plain(times: Any, name: str = "times") -> None:
    """AttitudeError for plain seconds and lengths of time, in a scene without a motion."""
    kind, _, _ = _inputs.entries(times, name, _inputs.DATES)
    if kind in _inputs.LENGTHS and np.size(times):
        raise AttitudeError(
            f"{name} is {validation.shown(times)}, but a scene without a motion has no epoch to "
            f"count from; give {_inputs.DATES}."
        )


def place(
    value: Any, name: str, ephemeris: Ephemeris | None, *, is_direction_allowed: bool = False
) -> Place:
    """The path or direction given, that of astropy or skyfield, or of a body by name or number."""
    if isinstance(value, (list, tuple)) and any(
        (item[:1].isalpha() if isinstance(item, str) else isinstance(item, (Place, Mapping)))
        or place_of(item, name) is not None
        for item in value
    ):
        raise AttitudeError(f"{name} holds {len(value)} places; give one, and a Scene for each.")
    is_vector = isinstance(value, (list, tuple))
    if isinstance(value, np.ndarray):  # as an EarthLocation is
        is_vector = place_of(value, name) is None
    if is_vector and is_direction_allowed:
        return _path.direction(value, name=name)
    from attitude.paths import _places

    known = _places.place(value, name, is_observer=name == "observer", ephemeris=ephemeris)
    if known.is_direction and not is_direction_allowed:
        raise AttitudeError(
            f"{name} is {known!r}, infinitely far away; give a path or a body, or None where Sun "
            "and observer are directions."
        )
    return known


def known_shape(shape: Any, law: Law) -> Ellipsoid | Mesh | None:
    """The shape itself; AttitudeError for anything else, and a material that the law lacks."""
    if shape is None:
        return None
    from attitude.shape._ellipsoid import Ellipsoid
    from attitude.shape._mesh import Mesh

    if isinstance(shape, Mesh):
        law.rows(shape.materials)
    elif not isinstance(shape, Ellipsoid):
        raise AttitudeError(
            f"shape is {type(shape).__name__}; give an Ellipsoid or Mesh of attitude.shape, "
            "such as attitude.shape.read(file)."
        )
    return shape


def known_shadows(shadows: Any) -> bool | Visibility:
    """True, False or a Visibility, which is loaded only if one is given."""
    if isinstance(shadows, (bool, np.bool_)):
        return bool(shadows)
    from attitude.light_curve._visibility import Visibility

    if not isinstance(shadows, Visibility):
        raise AttitudeError(
            f"shadows is {validation.shown(shadows)}; give True, False or a Visibility."
        )
    return shadows


# ---- Quantities of a view as observables: with extrema, and conditions by comparison

# Quantities that are true or false, that have kinks or jumps, and that may be NaN or infinite: all
# others are smooth, so that their samples bound their derivatives.
_FLAGS = ("in_umbra", "in_penumbra", "sky_dark", "is_observable")
_ROUGH = ("lit_fraction", "airmass", "brightness", "reduced_magnitude", "magnitude")
_JUMPS = {"longitude", "right_ascension", "azimuth", "long_axis_position_angle"}
# Part of |r| / |v| that is the spacing of samples, of a body or observer about its center, and of
# a body about one that shades it.
_OF_ORBIT = 1.0 / 30.0
# That of the two relative to each other.
_OF_RANGE = 1.0 / 4.0
# Epochs of a span at which these are sampled.
_SAMPLES = 129
# Spacings of samples in a span, at least.
_FEWEST = 16
# Part of a spacing that is the next finer one towards a close encounter.
_FINER = 8.0
# Of the bracket of an encounter: to 1e-7 of the distance of two samples.
_HALVINGS = 24
# m/s: that of a path at rest, which has no encounters.
_TINY = 1e-30


@dataclass(frozen=True)
class OfColumn:
    """A quantity of a view by name, or one part of its last axis; for a block of epochs."""

    name: str
    number: int | None = None

    def __call__(self, moment: Moment) -> FloatArray:
        """The values (N,)."""
        values = np.asarray(getattr(moment.view, self.name), dtype=np.float64)
        return values if self.number is None else values[..., self.number]


@dataclass(frozen=True)
class OfFunction:
    """A function of a view, for a block of epochs."""

    function: Callable[[View], ArrayLike]

    def __call__(self, moment: Moment) -> FloatArray:
        """The values (N,)."""
        values = validation.returned(self.function(moment.view), "the function of a view")
        if values.shape != moment.hi.shape:
            raise AttitudeError(
                f"the function of a view returns shape {values.shape} for {moment.hi.size} epochs; "
                "it must return one number for each."
            )
        return values


# What to give for arguments that a Scene does not have.
_HINTS = {
    **dict.fromkeys(("path", "orbit", "position", "body", "target"), "give center="),
    **dict.fromkeys(("site", "telescope", "station", "camera"), "give observer="),
    **dict.fromkeys(("scattering", "brdf", "material", "materials"), "give law="),
    **dict.fromkeys(("mesh", "model", "facets"), "give shape="),
    **dict.fromkeys(("light", "source"), "give sun="),
    **dict.fromkeys(("times", "epochs", "t"), "give times to .at(times)"),
}


class OfView(Observable):
    """A number of a view at every epoch of reception, or a flag; made by ``scene.quantity``."""

    def __init__(
        self,
        scene: Scene,
        value: OfColumn | OfFunction,
        name: str,
        *,
        is_flag: bool = False,
        **options: Any,
    ) -> None:
        super().__init__(Source(scene.motion, scene), value, **options)
        self.name, self.is_flag = name, is_flag

    @property
    def key(self) -> Hashable:
        """The quantity, with the stated step and rate."""
        return self.value, self.step, self.rate

    def spacing(self, start: Pair, stop: Pair) -> float:
        """The spacing of samples in a span, s: `step`, or from what the value depends on.

        Of an attitude 0.05 rad of rotation; of lines of sight 1/30 of the least |r|/|v|, and of
        the body about what shades it.
        """
        if self.step is not None:
            return self.step
        view, length = self._sampled(start, stop)
        return self._spacing(view, length, _paths(view), start, stop)

    def _spacing(self, view, length, paths, start, stop):
        """The spacing by the view of samples of a span and its paths."""
        spacings = [length / _FEWEST] if length > 0.0 else [1.0]
        if "attitude" in view.evaluated:
            spacings.append(super().spacing(start, stop))
        return min([*spacings, *(_scale(view, path, share) for path, share in paths)])

    def _sampled(self, start, stop):
        """The view of samples of a span, in which the value is evaluated, and its length, s."""
        length = (stop[0] - start[0]) + (stop[1] - start[1])
        moment = self.source.at(*pairs.add(start, np.linspace(0.0, length, _SAMPLES)))
        self.value(moment)
        return moment.view, length

    def _searches(self, start: Pair, stop: Pair) -> tuple[tuple[Pair, Pair, float], ...]:
        """The parts of a span and their spacings, which are finer about close encounters."""
        if self.step is not None:
            return super()._searches(start, stop)
        view, length = self._sampled(start, stop)
        paths = _paths(view)
        spacing = self._spacing(view, length, paths, start, stop)
        finer = []
        for path, share in paths:
            for time, least in _encounters(view, path):
                # A line of sight changes by `share` of |r|/|v|, which grows as the time from it.
                step = spacing
                while share * least < step / 2.0:
                    reach, step = step / share, max(share * least, step / _FINER)
                    finer.append((time - start[0] - reach, time - start[0] + reach, step))
        inner = {float(edge) for *ends, _ in finer for edge in ends if 0.0 < edge < length}
        knots = [0.0, *sorted(inner), length]
        ends = [start, *(pairs.add(start, knot) for knot in knots[1:-1]), stop]
        steps = [
            min([spacing, *(step for a, b, step in finer if a < 0.5 * (begin + end) < b)])
            for begin, end in pairwise(knots)
        ]
        return tuple((*edges, step) for edges, step in zip(pairwise(ends), steps, strict=True))

    def __repr__(self) -> str:
        return f"<{self.name}{f' in {self.unit}' if self.unit else ''} of a scene>"


def _per_second(rate: Real | None, unit: str) -> float | None:
    """The bound of a derivative by time of values in a unit."""
    if rate is None:
        return None
    return validation.positive(rate, "rate", unit=f"{unit} / s" if unit else "1 / s")


def _paths(view):
    """The paths from which lines of sight follow, and the part of |r|/|v| that is the spacing."""
    scene = view.scene
    places = [end for end in (scene.center, scene.observer) if isinstance(end, _path.Path)]
    paths = [(place, _OF_ORBIT) for place in places]
    if len(places) == 2:
        paths.append((_composed.relative(*places, scene.ephemeris), _OF_RANGE))
    if "lit_fraction" in view.evaluated:
        about = (_composed.relative(places[0], body, scene.ephemeris) for body in scene.shadow_of)
        paths += [(path, _OF_ORBIT) for path in about]
    return paths


def _scale(view, path, share):
    """A share of the least |r|/|v| of a path at the epochs of a view, s; infinite at rest."""
    state = path.state(view.epoch, view.seconds, view.low)
    size, speed = (lengths(vectors) for vectors in state)
    moving = (speed > 0.0) & (size > 0.0)
    return share * float(np.min(size[moving] / speed[moving], initial=np.inf))


def _encounters(view, path):
    """Pairs (time, |r|/|v|), s, of the pericenters between the samples of a view.

    None of an orbit with more of them than _FEWEST, whose phases the samples cover.
    """

    def approaching(seconds, low=None):
        position, velocity = path.state(view.epoch, seconds, low)
        return np.sum(position * velocity, axis=-1) < 0.0

    inward = approaching(view.seconds, view.low)
    k = np.flatnonzero(inward[:-1] & ~inward[1:])
    if not 0 < len(k) <= _FEWEST:
        return []
    a, b = view.seconds[k], view.seconds[k + 1]
    for _ in range(_HALVINGS):
        middle = 0.5 * (a + b)
        before = approaching(middle)
        a, b = np.where(before, middle, a), np.where(before, b, middle)
    size, speed = (lengths(vectors) for vectors in path.state(view.epoch, middle))
    return list(zip(middle.tolist(), (size / np.maximum(speed, _TINY)).tolist(), strict=True))


class Scene(Immutable):
    """A rotating body, its path, its observer, and the Sun that lights it.

    Parameters
    ----------
    motion : Motion, object with ``at(t)``, or None
        A FreeRotation, Arcs, an AttitudeTable, ...; None for quantities that need no attitude.
    center : str, int, Path or None
        The path (`attitude.paths`) of the body's centre of mass, the name or NAIF number of a
        body of the ephemeris, or a file, an orbit line or elements as `paths.place` takes them.
        None if Sun and observer are directions, infinitely far away.
    observer, sun : str, int, Path, Direction or (3,) array_like
        A body, a path, a `paths.direction`, a vector in ICRF as a direction, or text as
        `paths.place` takes it: "568", "-70.7, -30.2 deg, 2700 m".  A Scene keeps
        each place as a path or a direction; a body given by name as the path of this name, which
        opens the ephemeris when a position is needed.
    shape : Ellipsoid or Mesh, optional
        Of `attitude.shape`, in m; brightness and magnitudes need it.
    law : str or Law
        Scattering law of the surface; see `attitude.scattering`.
    night : float, Quantity or text
        Elevation of the Sun, rad, below which the sky of a ground site is dark (``view.sky_dark``).
    site_limits : bool
        Whether magnitudes from a ground site are NaN by day (as `night` says) and while the body is
        below the horizon.  False: magnitudes at all epochs.
    light_time : bool
        Whether positions are corrected for light time.  False evaluates all of them at the epochs
        given.
    aberration : bool
        Whether the observer's velocity shifts the directions that the observer measures (apparent
        direction, position angle, elongation, elevation).  It does not change which side of the
        body is seen.
    ephemeris : path of an SPK kernel, name such as "builtin", Ephemeris, or None
        Source of the bodies given by name; see `paths.ephemeris`.
    shadow_of : str, int, sequence or dict, optional
        Bodies whose shadow may fall on this one; a dict gives their radii in m (None: the radius
        in `scene.shadow`).  By default the body that `center` is a path about, if it is a planet
        or the Moon.  () for none.
    tolerance : float or None
        Largest error of the Chebyshev pieces from which many epochs are evaluated where that is
        cheaper, m; they turn no direction by more than 4e-10 rad.  None: no Chebyshev pieces.
    shadows, threads
        Shadows of the body on itself, and threads: see `light_curve.brightness`.
    sun_magnitude : float, optional
        Magnitude of the Sun at 1 au in the band of the observation; Johnson V by default.
    phase_function : callable, optional
        Mean reduced magnitude over all orientations as a function of the phase angle in rad.
        Magnitudes follow it, and size and albedo do not enter; for H = 19.09 and G = 0.24 give
        ``lambda alpha: scattering.hg(alpha, 19.09, 0.24)``.  See `light_curve.phased_magnitude`.

    Attributes
    ----------
    motion : Motion or None
    center : Path or None
    observer, sun : Path or Direction
    ephemeris : Ephemeris or None
        None: the source that `paths.ephemeris` takes by default.
    law : Law
    night : float
        rad.
    shape, site_limits, light_time, aberration, shadows, threads, sun_magnitude, phase_function
        As given.
    shadow_of : dict
        Radii in m by the names of the bodies.
    tolerance : float or None
        m.

    Raises
    ------
    AttitudeError
        For arguments of other types, unknown bodies, a motion with unknown epoch, and a missing
        center of a scene whose observer or Sun is at a finite distance.

    Notes
    -----
    Directions are light-time corrected from barycentric positions: SPICE's "CN", skyfield's
    ``observe``.  Against both: below 1e-12 rad and 1e-11 s (benchmarks/scene.py).

    >>> from attitude import Body, FreeRotation, Spin
    >>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
    >>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    >>> view = Scene(motion, center=None, observer=(1, 0, 0), sun=(0, 1, 0)).at([0.0, 5.0 * np.pi])
    >>> view.sun_direction.round(12) + 0.0                        # a quarter turn about z
    array([[0., 1., 0.],
           [1., 0., 0.]])
    >>> view.phase_angle.round(6), view.evaluated[-2:]
    (array([1.570796, 1.570796]), ('sun_direction', 'phase_angle'))
    """

    motion: Motion | None
    center: Path | None
    observer: Path | Direction
    sun: Path | Direction
    ephemeris: Ephemeris | None
    shape: Ellipsoid | Mesh | None
    law: Law
    night: float
    site_limits: bool
    light_time: bool
    aberration: bool
    shadow_of: dict[str, float]
    tolerance: float | None
    shadows: bool | Visibility
    threads: int
    sun_magnitude: float | None
    phase_function: Callable[[FloatArray], FloatArray] | None

    @arguments(_HINTS, 'Scene(motion, center="mars barycenter", observer="earth")')
    def __init__(
        self,
        motion: HasAttitudes | str | None,
        center: Path | str | int | None = None,
        observer: Path | Direction | str | int | Reals = "earth",
        sun: Path | Direction | str | int | Reals = "sun",
        *,
        shape: Ellipsoid | Mesh | None = None,
        law: str | Law = "lommel-seeliger",
        night: Real = "-6 deg",
        site_limits: bool = True,
        light_time: bool = True,
        aberration: bool = False,
        ephemeris: EphemerisLike = None,
        shadow_of: str | int | Iterable[str | int] | Radii | None = None,
        tolerance: Real | None = 1e-3,
        shadows: bool | Visibility = True,
        threads: int = 1,
        sun_magnitude: Real | None = None,
        phase_function: Callable[[FloatArray], FloatArray] | None = None,
    ) -> None:
        self._set("motion", None if motion is None else motion_of(motion))
        self._set("law", known_law(law))
        source = None if ephemeris is None else _solar_system.ephemeris(ephemeris)
        self._set("ephemeris", source)
        self._set("center", None if center is None else place(center, "center", source))
        self._set("observer", place(observer, "observer", source, is_direction_allowed=True))
        self._set("sun", place(sun, "sun", source, is_direction_allowed=True))
        self._require_center()
        self._set("shape", known_shape(shape, self.law))
        self._set("night", validation.angle_from_plane(night, "night", "-6 deg"))
        flags = {"site_limits": site_limits, "light_time": light_time, "aberration": aberration}
        for name, value in flags.items():
            self._set(name, validation.flag(value, name))
        if tolerance is not None:
            tolerance = validation.positive(tolerance, "tolerance", unit="m")
        self._set("tolerance", tolerance)
        self._set("shadow_of", self._occulters(shadow_of))
        self._set("shadows", known_shadows(shadows))
        self._set("threads", validation.count(threads, "threads"))
        if sun_magnitude is not None:
            sun_magnitude = validation.number(sun_magnitude, "sun_magnitude", unit="mag")
        self._set("sun_magnitude", sun_magnitude)
        if phase_function is not None and not callable(phase_function):
            raise AttitudeError(
                f"phase_function is {validation.shown(phase_function)}; give a function of the "
                "phase angle in rad, such as lambda alpha: scattering.hg(alpha, 19.09, 0.24)."
            )
        if phase_function is not None and sun_magnitude is not None:
            raise AttitudeError(
                "phase_function and sun_magnitude are given, but magnitudes follow the phase "
                "function alone; leave out sun_magnitude."
            )
        self._set("phase_function", phase_function)

    def at(self, times: Epochs, low: ArrayLike | None = None) -> View:
        """The scene as seen by the light received at some epochs.

        Parameters
        ----------
        times : array_like
            Epochs of any type that `FreeRotation.at` takes; plain numbers are TDB seconds since
            the epoch of the motion.  With an observer that is a direction, the epochs are those
            at the body.
        low : array_like, optional
            With plain numbers: a second double; the seconds are times + low.

        Returns
        -------
        View

        Raises
        ------
        AttitudeError
            For epochs that cannot be read, infinite ones, and plain numbers in a scene without a
            motion.
        """
        start = self.epoch
        if start is None:
            refuse_plain(times)
            start = _instants.J2000
        hi, lo = _inputs.seconds_since(start, times, low, "times")
        return self.since(start, hi, lo)

    def view(self, output: FilePath | None = None, **settings: Any) -> Any:
        """A page with the body, Sun, observer and light curve: `attitude.viewer.view`.

        Parameters
        ----------
        output : str or path, optional
            File to write, x.html; by default none.
        settings
            start=, stop=, title= and others of `attitude.viewer.view`.

        Returns
        -------
        attitude.viewer.Viewer
            In a notebook it shows itself.

        Raises
        ------
        AttitudeError
            As `attitude.viewer.view`.
        """
        return named("attitude.viewer:view")(self, output=output, **settings)

    def since(
        self, start: _instants.Instant, seconds: ArrayLike, low: ArrayLike | None = None
    ) -> View:
        """As `at`, for TDB seconds + low since an Instant."""
        _instants.require(start, "start")
        # Copies, since the arrays of a view are read-only.
        times = _inputs.plain_seconds(seconds, low).mapped(copied)
        if np.isinf(times.hi).any():
            raise AttitudeError(
                "times holds an infinite epoch; give finite epochs, or NaN for a missing one."
            )
        epoch_of_scene = self.epoch
        if epoch_of_scene is not None and start != epoch_of_scene:
            past_j2000 = pairs.Seconds(*times.plus(start.seconds, start.low))
            start = epoch_of_scene
            times = pairs.Seconds(*past_j2000.plus(-start.seconds, -start.low))
        return View(self, start, *times)

    def quantity(
        self,
        name: str | Callable[[View], ArrayLike],
        *,
        unit: str = "",
        rate: Real | None = None,
        step: Real | None = None,
    ) -> OfView:
        """A number of the view at every epoch; a comparison makes it a condition of events.

        ``(scene.quantity("elevation") > "10 deg") & events.glint(scene, n)``.

        Parameters
        ----------
        name : str or function
            A quantity of `View.columns`, with the part of its last axis after a dot, as in
            "sub_solar.latitude"; or a function of a View (N,) that returns (N,) numbers.  One that
            is true or false, such as "sky_dark", is a condition itself.
        unit : str
            Of the values of a function, for thresholds with units.
        rate : float or Quantity, optional
            Upper bound of the derivative, units per second: no change is missed.
        step : float or Quantity, optional
            s; spacing of samples.  Without it, from the rotation and the orbits on which the value
            depends; changes of values with kinks (brightness, lit_fraction, functions) that are
            reversed between two samples are missed.

        Raises
        ------
        AttitudeError
            For an unknown quantity, a missing or unknown part, and bounds that are not positive.
        """
        if step is not None:
            step = validation.positive(step, "step", unit="s")
        if not isinstance(name, str):
            if not callable(name):
                raise AttitudeError(
                    f"quantity is {validation.shown(name)}; give the name of a quantity of a view, "
                    'such as "elevation", or a function of a view.'
                )
            function = OfFunction(name)
            if unit:
                quantity_text.unit_of(unit, "unit")
            rate = _per_second(rate, unit)
            return OfView(self, function, "function", unit=unit, rate=rate, step=step)
        column, _, component = name.partition(".")
        known = View.columns()
        if column not in known:
            raise AttitudeError(
                f"{name!r} is not a quantity of a view; give one of {', '.join(known)}."
            )
        parts, own_unit = known[column].parts, known[column].unit
        if parts and component not in parts:
            raise AttitudeError(
                f"{column} has the parts {', '.join(parts)}; give one of them, as in "
                f'"{column}.{parts[0]}".'
            )
        if component and not parts:
            raise AttitudeError(f"{column} has no parts; give {column!r}.")
        if unit and unit != own_unit:
            raise AttitudeError(
                f"{column} is in {own_unit or 'no unit'}; leave unit out, and give thresholds with "
                'their units, as in > "10 deg".'
            )
        is_flag = column in _FLAGS
        is_rough = column in _ROUGH or column.endswith("_sigma") or {column, component} & _JUMPS
        rate = _per_second(rate, own_unit)
        return OfView(
            self,
            OfColumn(column, parts.index(component) if component else None),
            name,
            unit=own_unit,
            rate=rate,
            step=step,
            is_smooth=not (is_flag or is_rough),
            is_flag=is_flag,
        )

    @property
    def epoch(self) -> _instants.Instant | None:
        """The epoch of the motion, from which plain seconds count; None without a motion."""
        return None if self.motion is None else self.motion.epoch

    def steps(self, target: Path | str, viewer: Path) -> Steps:
        """The paths that connect two places of the scene, found at the first call and kept."""
        known: dict[Any, Steps] = self.__dict__.setdefault("_steps", {})
        step = known.get((target, viewer))
        if step is None:
            step = known[target, viewer] = Steps.of(target, viewer, self.ephemeris)
        return step

    def __getstate__(self) -> dict[str, Any]:
        # What is found anew, such as the steps of an ephemeris, is not pickled.
        return {name: value for name, value in self.__dict__.items() if name != "_steps"}

    def _require_center(self) -> None:
        for place, name in ((self.observer, "observer"), (self.sun, "sun")):
            if self.center is None and not place.is_direction:
                raise AttitudeError(
                    f"center is None, but {name} is {place.name!r} at a finite distance; give "
                    f"center, or give {name} as a direction: paths.direction((x, y, z))."
                )

    def _occulters(self, bodies: Any) -> dict[str, float]:
        if bodies is None:
            about = None if self.center is None else self.center.center
            named = isinstance(about, str) and _shadow.radius_of(about) is not None
            bodies = (about,) if named else ()
        spheres = _shadow.occulters(bodies)
        if spheres and self.center is None:
            raise AttitudeError(
                "shadow_of is given, but center is None, so that no shadow can be found; give "
                "center, or leave out shadow_of."
            )
        return spheres

    def _repr_html_(self) -> str:
        """A table for notebooks, with a light curve where it needs no ephemeris and no mesh."""
        rows = [
            ("motion", "none" if self.motion is None else type(self.motion).__name__),
            ("center", "none" if self.center is None else self.center.name),
            ("observer", self.observer.name),
            ("Sun", self.sun.name),
            ("shape", "none" if self.shape is None else repr(self.shape)),
            ("scattering law", self.law.name or type(self.law).__name__),
        ]
        if self.epoch is not None:
            rows.append(("epoch", f"{self.epoch.utc_iso} UTC"))
        return markup.table("Scene", rows, *self._pictures())

    def _pictures(self) -> list[str]:
        """The light curve of a scene of directions and an ellipsoid, over two turns."""
        from attitude.shape._ellipsoid import Ellipsoid

        is_cheap = isinstance(self.shape, Ellipsoid) and self.law.has_ellipsoid_form
        if not is_cheap or self.motion is None or self.center is not None:
            return []
        with suppress(AttitudeError):  # a table may not cover two turns from its epoch
            rate = float(np.linalg.norm(self.motion.at(0.0).angular_velocity))
            if rate > 0.0:
                times = np.linspace(0.0, 4.0 * np.pi / rate, 201)
                magnitudes = self.at(times).reduced_magnitude
                caption = f"reduced magnitude over {times[-1]:.4g} s"
                return [markup.line_plot([(times, magnitudes)], caption, is_downward=True)]
        return []

    def __repr__(self) -> str:
        motion = "no motion" if self.motion is None else type(self.motion).__name__
        center = None if self.center is None else self.center.name
        return (
            f"<Scene: {motion} at {center}, seen from {self.observer.name}, lit by {self.sun.name}>"
        )
