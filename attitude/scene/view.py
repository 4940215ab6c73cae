"""A scene at some epochs, which makes what it is asked for, once."""

import numpy as np

from attitude import epochs, paths
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen, read_only
from attitude.physical_constants import SPEED_OF_LIGHT_M_S
from attitude.scene import angles, lines_of_sight, shadow
from attitude.scene.lazy import Quantity, kept, quantity
from attitude.scene.light_time import Sightline
from attitude.scene.photometry import Brightness
from attitude.scene.pointing import Pointing
from attitude.scene.sky import Sky

_XYZ = ("x", "y", "z")
_NO_LOW = frozen(np.zeros(1))


class View(Pointing, Sky, Brightness, Immutable):
    """What is seen at some epochs of reception.  Made by ``scene.at(times)``.

    S is the shape of the times.  Vectors are (S, 3), views of component-major memory; all arrays
    are read-only.  Radians, metres, seconds.

    Attributes
    ----------
    scene : Scene
    epoch : Instant
    seconds, low : S arrays (low may be None)
        TDB seconds from `epoch` at which light is received.
    evaluated : tuple of str
        What was made so far, in that order.
    """

    def __init__(self, scene, epoch, seconds, low):
        self._set("scene", scene)
        self._set("epoch", epoch)
        self._set("seconds", frozen(seconds))
        self._set("low", None if low is None else frozen(low))
        self._set("_evaluated", [])

    @property
    def evaluated(self):
        return tuple(self._evaluated)

    @property
    def shape(self):
        return self.seconds.shape

    def __len__(self):
        if not self.shape:
            raise TypeError("a view of one scalar epoch has no length")
        return self.shape[0]

    def __repr__(self):
        return f"<View of {self.seconds.size} epochs; evaluated: {', '.join(self.evaluated)}>"

    @kept
    def time(self):
        """The epochs of reception as an astropy Time in TDB."""
        return epochs.times(self.epoch, self.seconds, self.low)

    @kept
    def emission_time(self):
        """The epochs at which the light left the body as an astropy Time in TDB."""
        hi, lo = self.emission
        rest = None if lo is None else lo.reshape(self.shape)
        return epochs.times(self.epoch, hi.reshape(self.shape), rest)

    # Lines of sight -------------------------------------------------------------------------------

    @kept
    def observer_line(self):
        """The `line.Line` from the body, as its light leaves, to the observer as it arrives."""
        scene = self.scene
        if scene.observer.is_direction:
            return lines_of_sight.fixed(scene.observer)
        found = self._sight(scene.center, scene.observer, self._reception(), sign=-1.0)
        self._refuse_inside(found, scene.observer)
        return found

    @kept
    def emission(self):
        """TDB seconds (hi, lo) from `epoch` at which the light leaves the body; flat arrays."""
        hi, lo = self._reception()
        if not self.scene.light_time or self.observer_line.distance is None:
            return hi, None if self.low is None else lo
        from attitude.scene import loops

        out = np.empty(hi.size), np.empty(hi.size)
        loops.earlier(
            read_only(hi),
            read_only(lo),
            read_only(self.observer_line.distance),
            SPEED_OF_LIGHT_M_S,
            *out,
        )
        return frozen(out[0]), frozen(out[1])

    @kept
    def sun_line(self):
        """The `line.Line` from the body, as its light leaves, to the Sun as it was then seen."""
        scene = self.scene
        if scene.sun.is_direction:
            return lines_of_sight.fixed(scene.sun)
        found = self._sight(scene.sun, scene.center, self._emission())
        self._refuse_inside(found, scene.sun)
        return found

    @kept
    def observer_sun_line(self):
        """The `line.Line` from the observer, as light is received, to the Sun."""
        scene = self.scene
        if scene.observer.is_direction:
            raise AttitudeError(
                "the observer is a direction, infinitely far away, from where the Sun has no "
                "direction of its own; give the path of an observer, or ask for phase_angle."
            )
        if scene.sun.is_direction:
            return lines_of_sight.fixed(scene.sun)
        return self._sight(scene.sun, scene.observer, self._reception())

    def _reception(self):
        lo = _NO_LOW if self.low is None else self.low.reshape(-1)
        return self.seconds.reshape(-1), lo

    def _emission(self):
        hi, lo = self.emission
        return hi, _NO_LOW if lo is None else lo

    def _sight(self, target, viewer, at, *, geometric=False, sign=1.0):
        """The Line from a viewer at some epochs to a target, or opposite to that."""
        scene, (hi, lo) = self.scene, at
        some = lines_of_sight.sample(self.epoch, hi, lo)
        if scene.light_time and not geometric:
            path = Sightline(target, viewer, scene.ephemeris, some)
        else:
            path = paths.relative(target, viewer, scene.ephemeris)
        return lines_of_sight.seen(path, self.epoch, hi, lo, some, scene.tolerance, sign)

    def _refuse_inside(self, found, place):
        radius = _radius(self.scene.shape)
        least = np.nanmin(found.distance, initial=np.inf)
        if least < radius:
            raise AttitudeError(
                f"{place.name} comes to {least:.6g} m from the center, into the "
                f"shape, whose farthest point is {radius:.6g} m from it; check the paths and the "
                "unit of the shape (m)."
            )

    def _rows(self, array):
        """A flat array (k, N) or (k, 1) as (S, k)."""
        if array.shape[1] != self.seconds.size:
            array = np.broadcast_to(array, (len(array), self.seconds.size))
        return np.moveaxis(array.reshape(len(array), *self.shape), 0, -1)

    def _flat(self, vectors):
        """A quantity (S, k) as (k, N)."""
        return np.moveaxis(vectors, -1, 0).reshape(vectors.shape[-1], -1)

    def _numbers(self, array):
        """A flat array (N,) or (1,) as S."""
        return np.broadcast_to(array, (self.seconds.size,)).reshape(self.shape)

    # Distances and directions that need no rotation -----------------------------------------------

    @quantity("m")
    def observer_distance(self):
        """From the body, as its light leaves, to the observer, as it arrives; inf for a direction.

        The length of ``light_time`` times the speed of light.
        """
        return self._distance(self.observer_line)

    @quantity("m")
    def sun_distance(self):
        """From the body, as its light leaves, to the Sun as then seen; inf for a direction."""
        return self._distance(self.sun_line)

    @quantity("s")
    def light_time(self):
        """observer_distance over the speed of light; 0 where the scene takes none into account."""
        if not self.scene.light_time or self.observer_line.distance is None:
            return np.zeros(self.shape)
        return self.observer_distance / SPEED_OF_LIGHT_M_S

    def _distance(self, found):
        if found.distance is None:
            return self._numbers(np.full(1, np.inf))
        return self._numbers(found.distance)

    @quantity("", _XYZ)
    def observer_direction_icrf(self):
        """Unit vector from the body to the observer, ICRF."""
        return self._rows(self.observer_line.unit)

    @quantity("", _XYZ)
    def sun_direction_icrf(self):
        """Unit vector from the body to the Sun, ICRF."""
        return self._rows(self.sun_line.unit)

    @quantity("rad")
    def phase_angle(self):
        """Angle at the body between Sun and observer, 0 to pi."""
        from attitude.solution.vectors import separation

        sun, observer = read_only(self.sun_line.unit), read_only(self.observer_line.unit)
        return self._numbers(separation(*sun, *observer))

    @quantity("rad", ("longitude", "latitude"))
    def phase_angle_bisector(self):
        """Ecliptic (J2000) longitude and latitude of -(s + o), s and o the two unit vectors."""
        return self._rows(angles.bisector(self.sun_line.unit, self.observer_line.unit))

    # Shadow of other bodies -----------------------------------------------------------------------

    @quantity()
    def lit_fraction(self):
        """How much of the Sun's disc the bodies of `scene.shadow_of` leave free: 1, ..., 0."""
        scene, lit = self.scene, np.ones(self.seconds.size)
        for body, radius in scene.shadow_of.items():
            far = scene.sun.is_direction
            found = self._sight(body, scene.center, self._emission(), geometric=far)
            lit -= 1.0 - shadow.lit_fraction(
                found.unit * found.distance,
                radius,
                self.sun_line.unit,
                self.sun_line.distance,
                flattening=shadow.flattening_of(body, radius),
            )
        return self._numbers(np.maximum(lit, 0.0))

    @quantity()
    def in_umbra(self):
        """Whether nothing of the Sun's disc is seen from the body's centre."""
        return self._numbers(np.asarray(self.lit_fraction == 0.0).reshape(-1))

    @quantity()
    def in_penumbra(self):
        """Whether a part of the Sun's disc is seen from the body's centre, but not all of it."""
        lit = np.asarray(self.lit_fraction)
        return self._numbers(((lit > 0.0) & (lit < 1.0)).reshape(-1))

    # Tables ---------------------------------------------------------------------------------------

    @classmethod
    def columns(cls):
        """The quantities that a table may hold, by name: a dict of `Quantity`."""
        return {
            name: value
            for owner in cls.__mro__
            for name, value in vars(owner).items()
            if isinstance(value, Quantity) and value.is_column
        }

    def table(self, *names):
        """Some quantities, by name, as an astropy QTable with the time (TDB) of reception."""
        from astropy.table import QTable
        from astropy.units import Unit

        known = self.columns()
        for name in names:
            if name not in known:
                raise AttitudeError(
                    f"{name!r} is no quantity of a view; give some of {', '.join(known)}."
                )
        if len(self.shape) != 1:
            raise AttitudeError(f"the times have shape {self.shape}; a table wants a row of them.")
        columns = {"time": self.time}
        for name in names:
            value = np.array(getattr(self, name))
            columns[name] = value * Unit(known[name].unit) if known[name].unit else value
        table = QTable(columns, meta={"scene": repr(self.scene), **self.sources})
        for name in names:
            table[name].info.description = known[name].about
        return table

    @property
    def sources(self):
        """Where the positions of all lines of sight made so far come from: a dict of texts."""
        lines = ("observer_line", "sun_line", "observer_sun_line")
        return {name: self.__dict__[name].source for name in lines if name in self.__dict__}


def _radius(shape):
    """Of the sphere about the centre of mass that holds a shape, m."""
    if shape is None:
        return 0.0
    if hasattr(shape, "semi_axes"):
        return float(np.max(shape.semi_axes))
    return float(np.max(np.linalg.norm(shape.vertices, axis=-1)))
