"""What is seen from where: a motion, the path of its body, an observer and the Sun."""

import datetime

import numpy as np

from attitude import epochs, pairs, paths, validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable
from attitude.motion import motion_of
from attitude.paths.bodies import body_name, naif_index
from attitude.paths.composed import NamedBody
from attitude.paths.ephemeris_source import Ephemeris
from attitude.paths.place import Place
from attitude.scattering import law as known_law
from attitude.scene import shadow
from attitude.scene.view import View


class Scene(Immutable):
    """A rotating body, where it is, who looks at it, and what lights it.

    Parameters
    ----------
    motion : object with ``at(t)``, or None
        A FreeRotation, Arcs, an AttitudeTable, ...; None where only places are asked for.
    center : str, Path or None
        Where the body's centre of mass is: a path (`attitude.paths`), or a body of the ephemeris.
        None where Sun and observer are directions, infinitely far away.
    observer, sun : str, Path, direction or (3,) array_like
        A body, a path, a `paths.direction`, or the numbers of one in ICRF.  A Scene keeps each
        place as a path or a direction; a body given by name as the path of this name, which opens
        the ephemeris when a position is needed.
    shape : Ellipsoid or Mesh, optional
        Of `attitude.shape`; magnitudes need it.
    law : str or Law
        How its surface scatters; see `attitude.scattering`.
    light_time : bool
        Whether light takes its time.  False puts everything at the epochs given.
    aberration : bool
        Whether what the observer sees (apparent direction, position angle, elongation,
        elevation) is shifted by the observer's own velocity.  What is seen of the body is not.
    ephemeris : path of an SPK kernel, name such as "builtin", Ephemeris, or None
        Where bodies given by name are; see `paths.ephemeris`.
    shadow_of : str, sequence or dict, optional
        Bodies whose shadow may fall on this one; as a dict with their radii in m.  Unless given:
        the body that `center` is a path about, if it is a planet or the Moon.  () for none.
    tolerance : float or None
        m.  Many epochs are evaluated from Chebyshev pieces where that pays, which err by at most
        so much, and turn no direction by more than 4e-10 rad.  None: never.
    shadows, threads, sun_magnitude
        As in `attitude.light_curve`: of the body on itself, and so on.
    phase_function : callable, optional
        Reduced magnitude at phase angles in rad, in the mean over all orientations: magnitudes
        follow it, with ``lambda alpha: scattering.hg(alpha, 19.09, 0.24)`` for H = 19.09 and
        G = 0.24, and size and albedo do not enter; see `light_curve.phased_magnitude`.

    Raises
    ------
    AttitudeError
        For what is none of these, bodies that the ephemeris lacks, and an observer or Sun at a
        finite distance from a center that is not given.

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

    def __init__(
        self,
        motion,
        center=None,
        observer="earth",
        sun="sun",
        *,
        shape=None,
        law="lommel-seeliger",
        light_time=True,
        aberration=False,
        ephemeris=None,
        shadow_of=None,
        tolerance=1e-3,
        shadows=True,
        threads=1,
        sun_magnitude=None,
        phase_function=None,
    ):
        self._set("motion", None if motion is None else motion_of(motion))
        source = None if ephemeris is None else paths.ephemeris(ephemeris)
        self._set("ephemeris", source)
        self._set("center", None if center is None else _place(center, "center", source))
        self._set("observer", _place(observer, "observer", source, is_direction_allowed=True))
        self._set("sun", _place(sun, "sun", source, is_direction_allowed=True))
        self._require_center()
        self._set("shape", _known_shape(shape))
        self._set("law", known_law(law))
        self._set("light_time", _flag(light_time, "light_time"))
        self._set("aberration", _flag(aberration, "aberration"))
        if tolerance is not None:
            tolerance = validation.positive(tolerance, "tolerance", unit="m")
        self._set("tolerance", tolerance)
        self._set("shadow_of", self._occulters(shadow_of))
        self._set("shadows", shadows)
        self._set("threads", threads)
        self._set("sun_magnitude", sun_magnitude)
        if phase_function is not None and not callable(phase_function):
            raise AttitudeError(
                f"phase_function is {validation.shown(phase_function)}; give a function of the "
                "phase angle in rad, such as lambda alpha: scattering.hg(alpha, 19.09, 0.24)."
            )
        if phase_function is not None and sun_magnitude is not None:
            raise AttitudeError(
                "phase_function tells how bright the body is by itself; leave out sun_magnitude."
            )
        self._set("phase_function", phase_function)

    def at(self, times, low=None):
        """The scene as its light is received at some epochs.

        Parameters
        ----------
        times : array_like
            Epochs of any kind that `FreeRotation.at` takes; plain numbers are TDB seconds since
            the epoch of the motion.  With an observer that is a direction, the epochs are those
            at the body.
        low : array_like, optional
            With plain numbers: a second double, times + low being the seconds.

        Returns
        -------
        View
        """
        start = self.epoch
        if start is None:
            _refuse_plain(times)
            start = epochs.Instant(0.0)
        hi, lo = epochs.seconds_since(start, times, low, "times")
        return self.since(start, hi, lo)

    def since(self, start, seconds, low=None):
        """As `at`, for TDB seconds (and a second double of them) since an Instant."""
        # Copies: what a view keeps is read-only.
        seconds = np.array(seconds, dtype=np.float64)
        low = None if low is None else np.array(np.broadcast_to(low, seconds.shape), dtype=float)
        if np.isinf(seconds).any():
            raise AttitudeError("times holds an infinite epoch; give finite ones, or NaN for none.")
        own = self.epoch
        if own is not None and start != own:
            zero = np.zeros(seconds.shape) if low is None else low
            past_j2000 = pairs.add((seconds, zero), start.seconds, start.low)
            seconds, low = pairs.add(past_j2000, -own.seconds, -own.low)
            start = own
        return View(self, start, seconds, low)

    @property
    def epoch(self):
        """The Instant from which plain numbers count: that of the motion, or None without one."""
        return None if self.motion is None else self.motion.epoch

    def _require_center(self):
        for place, name in ((self.observer, "observer"), (self.sun, "sun")):
            if self.center is None and not place.is_direction:
                raise AttitudeError(
                    f"center is None, but {name} is {place.name!r} at a finite distance; say where "
                    f"the body is, or give {name} as a direction: paths.direction((x, y, z))."
                )

    def _occulters(self, given):
        if given is None:
            about = None if self.center is None else self.center.center
            named = isinstance(about, str) and shadow.radius_of(about) is not None
            given = (about,) if named else ()
        found = shadow.occulters(given)
        if found and self.center is None:
            raise AttitudeError(
                "shadow_of is given, but center is None, so that no shadow can be found; say "
                "where the body is."
            )
        return found

    def __repr__(self):
        motion = "no motion" if self.motion is None else type(self.motion).__name__
        center = None if self.center is None else self.center.name
        return (
            f"<Scene: {motion} at {center}, seen from {self.observer.name}, lit by {self.sun.name}>"
        )


def _refuse_plain(times):
    first = times
    while isinstance(first, (list, tuple)) and first:
        first = first[0]
    kind = getattr(getattr(first, "dtype", None), "kind", "")
    is_length = isinstance(first, (int, float, datetime.timedelta)) or kind in ("f", "i", "u", "m")
    if is_length or type(first).__name__ == "TimeDelta":
        raise AttitudeError(
            "times are plain seconds, but a scene without a motion has no epoch to count them "
            "from; give dates: ISO text in UTC, astropy or skyfield Times, datetimes."
        )


def _place(
    value: object, name: str, ephemeris: Ephemeris | None, *, is_direction_allowed: bool = False
) -> Place:
    """The path or direction that a user gives, or the path of a body given by its name."""
    if isinstance(value, Place):
        if is_direction_allowed or not value.is_direction:
            return value
        raise AttitudeError(
            f"{name} is {value!r}, infinitely far away; give a path or a body, or None where Sun "
            "and observer are directions."
        )
    if isinstance(value, (list, tuple, np.ndarray)) and is_direction_allowed:
        return paths.direction(value, name=name)
    if isinstance(value, str) or naif_index(value) is not None:
        return NamedBody(body_name(value, name), ephemeris)
    raise AttitudeError(
        f"{name} is {type(value).__name__}; give the name of a body, a path of attitude.paths"
        + (", or a direction (x, y, z) in ICRF." if is_direction_allowed else ".")
    )


def _known_shape(shape):
    if shape is None:
        return None
    from attitude.shape import Ellipsoid, Mesh

    if not isinstance(shape, (Ellipsoid, Mesh)):
        raise AttitudeError(
            f"shape is {type(shape).__name__}; give an Ellipsoid or Mesh of attitude.shape."
        )
    return shape


def _flag(value, name):
    return validation.one_of(value, name, (True, False))
