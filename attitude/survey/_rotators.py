"""Rotators of a survey: states from columns or drawn, and their light relative to its mean.

Columns, one row for each object; those that an object does not need are NaN, empty, masked or
absent.  Columns with units are converted, those of semi-axes to m:

====================  ============================================================================
axis_a, axis_b,       Semi-axes of a homogeneous ellipsoid along the body axes x, y, z, in any unit;
axis_c                or
shape                 the name of one of the shapes given
pole_lon_deg,         Ecliptic longitude and latitude (J2000) of the angular momentum
pole_lat_deg
phi0_deg              Angle phi at the epoch of the state
spin_epochMJD_TDB     That epoch
period_h              Sidereal period of a relaxed rotator; or, of a tumbler,
P_psi_h, P_phi_h      the two periods,
mode, convention      "LAM" or "SAM", "L" or "S",
psi0_deg              the angle psi at the epoch, and
theta_branch          "acute" or "obtuse" where psi librates; "obtuse" for theta0 above 90 deg
====================  ============================================================================

They mean what `Spin.from_periods` says.  A column that is absent can be drawn: each number of an
object follows from a hash of its name, the name of the column and a seed, so that it depends
neither on the other objects nor on the division of a survey into chunks.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._compilation.decorators import entry_point, sized_entry_point
from attitude._support import validation
from attitude._support.arrays import between, read_only
from attitude._support.constants import DAY_S, JD_OF_MJD_0, SPEED_OF_LIGHT_M_S
from attitude.ensemble._ensemble import Ensemble
from attitude.ensemble._light import known_vectors
from attitude.ensemble._tables import (
    AXES,
    rotator_label,
    rotator_moments,
    rotator_numbers,
    rotator_states,
    words,
)
from attitude.epochs import _time_scales
from attitude.epochs._instants import J2000
from attitude.errors import AttitudeError
from attitude.light_curve._magnitudes import mean_brightness
from attitude.light_curve._sums import intensity
from attitude.motions._body import Body
from attitude.scattering._law import law as known_law
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from attitude._support.annotations import FloatArray, Reals
    from attitude.scattering._law import Law


# ---- The compiled loops over the rows of a survey: epochs, and brightness over its mean


@entry_point
def over_mean(areas, factor, sun, observer, brightness):
    """Divide brightness (R,), m2/sr, by its mean over all orientations, for Lommel-Seeliger's law.

    areas (R,): of bodies over that of the unit sphere; factor of the law; vectors (3, R) of any
    length.
    """
    scale = 0.25 * math.pi * factor
    for n in range(brightness.size):
        sx, sy, sz = sun[0, n], sun[1, n], sun[2, n]
        ox, oy, oz = observer[0, n], observer[1, n], observer[2, n]
        s = 1.0 / math.sqrt(sx * sx + sy * sy + sz * sz)
        o = 1.0 / math.sqrt(ox * ox + oy * oy + oz * oz)
        sphere = intensity(1.0, 1.0, 1.0, scale, sx * s, sy * s, sz * s, ox * o, oy * o, oz * o)
        brightness[n] /= sphere * areas[n]


@sized_entry_point
def interpolated(x, first, table, out):
    """Fill linear interpolations at x (R,) in a table of values at first, first + 1/2, ..."""
    for n in range(x.size):
        place = 2.0 * (x[n] - first)
        k = int(place)
        out[n] = table[k] + (place - k) * (table[k + 1] - table[k])


# Magnitudes fainter than the mean by which a body counts where none of its lit surface is seen.
UNSEEN: float = 50.0


class Rotators:
    """Rotating bodies, with shapes.

    Parameters
    ----------
    columns : mapping of str to (N,) arrays
        Those of the module's docstring; a pandas DataFrame is one.
    shape : Mesh or mapping of str to Mesh, optional
        One shape for all, or the shapes that the column ``shape`` names; without it the bodies are
        ellipsoids of the columns `AXES`.
    law : str or Law
        Scattering law with a mean in closed form: Lommel-Seeliger's; of meshes also Lambert's, or
        their sum.
    names : sequence of N, optional
        Names of the objects in error messages, in place of their numbers.

    Attributes
    ----------
    area : (N,) array
        Surface areas, in the unit of the shape squared.
    epochs : (N,) array
        Modified Julian dates, TDB, of the states.

    Raises
    ------
    AttitudeError
        For columns that are missing or of several lengths, shapes and laws of other kinds, and for
        the first object without an epoch or a state that is possible: its number and the reason.

    >>> fast = Rotators({
    ...     "axis_a": [3.0], "axis_b": [2.0], "axis_c": [1.0], "pole_lon_deg": [0.0],
    ...     "pole_lat_deg": [90.0], "phi0_deg": [0.0], "spin_epochMJD_TDB": [60000.0],
    ...     "period_h": [6.0],
    ... })
    >>> sun = observer = np.array([[1.0, 0.0, 0.0]] * 2)  # ICRF, at opposition
    >>> shift = fast.shifts([0, 0], [60000.0, 60000.0 + 1.5 / 24.0], sun, observer)
    >>> bool(abs(shift[0] - shift[1]) > 0.3)
    True
    """

    area: FloatArray
    epochs: FloatArray

    def __init__(
        self,
        columns: Mapping[str, Any],
        *,
        shape: Mesh | Mapping[str, Mesh] | None = None,
        law: str | Law = "lommel-seeliger",
        names: Sequence[object] | None = None,
    ) -> None:
        self._law = law_about_mean(law, shape)
        axes: Any = None
        if shape is None:
            self._shapes, moments = rotator_moments(columns, names)
            self.area = _areas(self._shapes)
            body: dict[str, Any] = {"moments": moments, "relative": True}
        else:
            moments, axes, body = self._of_meshes(columns, shape, names)
        states, self.epochs = rotator_states(columns, moments, axes, names)
        self.ensemble = Ensemble(
            wxyz=states.wxyz,
            angular_velocity=states.angular_velocity,
            epoch=J2000,
            frame="ecliptic",
            **body,
        )

    def __len__(self) -> int:
        return len(self.epochs)

    def _of_meshes(self, columns, shape, names):
        """Moments, axes and body of one shape for all, or one of several for each object."""
        count = len(rotator_numbers(columns, "phi0_deg"))
        if isinstance(shape, Mesh):
            shapes = [shape]
            which = np.zeros(count, dtype=np.int64)
        else:
            if "shape" not in columns:
                raise AttitudeError("the column shape is missing, which names one of the shapes.")
            labels, shapes = list(shape), list(shape.values())
            named = np.array(words(columns["shape"]), dtype=object)
            if named.shape != (count,):
                raise AttitudeError(
                    f"the column shape has shape {named.shape}; give one name for each object, "
                    f"({count},)."
                )
            unknown = [k for k, label in enumerate(named) if label not in shape]
            if unknown:
                raise AttitudeError(
                    f"{rotator_label(unknown[0], names)}: shape is {named[unknown[0]]!r}; it must "
                    f"be one of {', '.join(map(repr, labels))}."
                )
            which = np.array([labels.index(label) for label in named], dtype=np.int64)
        bodies = [Body.from_shape(mesh) for mesh in shapes]
        self._shapes = [shapes[k] for k in which]
        self.area = np.array([mesh.area for mesh in shapes])[which]
        moments = np.array([body.moments for body in bodies])[which]
        axes = np.array([body.principal_axes for body in bodies])[which]
        return moments, axes, {"body": [bodies[k] for k in which]}

    def shifts(
        self,
        member: ArrayLike,
        mjd_tdb: Reals,
        sun: Reals,
        observer: Reals,
        *,
        threads: int = 1,
    ) -> FloatArray:
        """Magnitudes (R,) relative to the mean over all orientations at the same phase angle.

        Parameters
        ----------
        member : (R,) array_like
            Numbers of the objects; rows of one object that stand together are fastest.
        mjd_tdb : (R,) array_like
            Modified Julian dates, TDB, at which the light leaves the body.
        sun, observer : (R, 3) or (3,) array_like
            Vectors from the body in ICRF, of any length above zero; NaN gives NaN.
        threads : int

        Returns
        -------
        (R,) array
            mag, positive where fainter; `UNSEEN` where none of the lit surface is seen.

        Raises
        ------
        AttitudeError
            For other shapes, and numbers of no object.

        Notes
        -----
        A convex body is as bright in the mean over all orientations as a sphere of its surface
        area; for a mesh that casts shadows on itself the mean is that without shadows.
        """
        who, _ = self.ensemble._members_of(member)
        mjd = validation.real(mjd_tdb, "mjd_tdb", finite=False)
        if who.ndim != 1 or mjd.shape != who.shape:
            raise AttitudeError(
                f"member has shape {who.shape}, mjd_tdb {mjd.shape}; give both as (R,)."
            )
        sun, observer = (
            known_vectors(vectors, name, who.shape)
            for vectors, name in ((sun, "sun"), (observer, "observer"))
        )
        t = (mjd - self.epochs[who]) * DAY_S
        one = isinstance(self._shapes, list) and len(set(map(id, self._shapes))) == 1
        bright = self.ensemble.brightness(
            t,
            who,
            sun,
            observer,
            shape=self._shapes[0] if one else self._shapes,
            law=self._law,
            threads=threads,
        )
        areas = (self.area / _SPHERE.area)[who]
        assert self._law.weights is not None  # the constructor refuses others
        if self._law.has_phase or self._law.weights[1] != 0.0:
            phase = between(sun.T, observer.T)
            bright /= mean_brightness(_SPHERE, self._law, phase) * areas
        else:
            by_parts = (read_only(np.ascontiguousarray(rows.T)) for rows in (sun, observer))
            over_mean(areas, float(self._law.weights[0]), *by_parts, bright)
        with np.errstate(divide="ignore"):
            np.log10(bright, out=bright)
        bright *= -2.5
        return np.minimum(bright, UNSEEN, out=bright)

    def brightest(self) -> FloatArray:
        """Least shift (N,) in mag that an object can have at phase angles up to 30 degrees.

        From the largest area seen from any side over its mean, twice, since amplitudes grow with
        the phase angle: by up to 3 % a degree (Zappala et al., A&A 231, 548, 1990).
        """
        if isinstance(self._shapes, list):
            radii = np.array([np.linalg.norm(mesh.vertices, axis=1).max() for mesh in self._shapes])
            largest = math.pi * radii**2
        else:
            ordered = np.sort(self._shapes, axis=1)
            largest = math.pi * ordered[:, 1] * ordered[:, 2]
        return -5.0 * np.log10(np.maximum(4.0 * largest / self.area, 1.0))


_SPHERE = Ellipsoid((1.0, 1.0, 1.0))


def law_about_mean(law: str | Law, shape: object) -> Law:
    """The law; AttitudeError for a shape or a law without magnitudes about a mean."""
    meshes = list(shape.values()) if isinstance(shape, Mapping) else [shape]
    if shape is not None and not (meshes and all(isinstance(mesh, Mesh) for mesh in meshes)):
        raise AttitudeError(
            f"shape is {validation.shown(shape)}; give a Mesh of attitude.shape, or a dict of "
            f"them by name; ellipsoids are given by the columns {', '.join(AXES)}."
        )
    known = known_law(law)
    if known.weights is None:
        raise AttitudeError(
            f"law is {law!r}; magnitudes about a mean need Lambert's or Lommel-Seeliger's law."
        )
    if shape is None and not known.has_ellipsoid_form:
        raise AttitudeError(
            f"law is {law!r}; ellipsoids need Lommel-Seeliger's law: give that, or meshes as shape."
        )
    return known


def emission(mjd_tai: Reals, distance_km: Reals) -> FloatArray:
    """Modified Julian dates, TDB, at which light left that is received at dates in TAI.

    Distances in km; to 1e-6 s, the resolution of such a date.
    """
    tai = np.asarray(mjd_tai, dtype=np.float64)
    light = np.asarray(distance_km, dtype=np.float64) * (1e3 / SPEED_OF_LIGHT_M_S)
    return tai + (_time_scales.TT_MINUS_TAI + _tdb_minus_tt(tai) - light) / DAY_S


def _tdb_minus_tt(mjd):
    """TDB - TT in s, to 1e-7 s: linear between values of each half of a day."""
    is_finite = mjd.size and np.isfinite(mjd).all()
    first, last = (math.floor(mjd.min()), math.floor(mjd.max()) + 1) if is_finite else (0, 1)
    if not is_finite or last - first > mjd.size:
        return _time_scales.tdb_minus_tt(JD_OF_MJD_0, mjd)
    table = _time_scales.tdb_minus_tt(JD_OF_MJD_0, first + 0.5 * np.arange(2 * (last - first) + 1))
    difference = np.empty(mjd.shape)
    flat = read_only(np.ascontiguousarray(mjd).reshape(-1))
    interpolated(flat, float(first), read_only(table), difference.reshape(-1))
    return difference


def drawn(
    names: Any, column: str, seed: int, distribution: Callable[[FloatArray], Reals] | Any
) -> FloatArray:
    """Numbers (N,) of a column for objects (N,): of a number, (low, high), or an inverse of a
    distribution function.

    >>> drawn(["A", "B"], "period_h", 1, (2.0, 2.0))
    array([2., 2.])
    """
    count = validation.count(seed, "seed", 0)
    key = hashlib.blake2b(f"{count}/{column}".encode(), digest_size=8).digest()
    hashes = np.array(
        [
            int.from_bytes(hashlib.blake2b(str(name).encode(), key=key, digest_size=8).digest())
            for name in names
        ],
        dtype=np.uint64,
    )
    uniform: FloatArray = np.ldexp((hashes >> np.uint64(11)).astype(np.float64), -53)
    if callable(distribution):
        values = validation.returned(distribution(uniform), f"the distribution of {column}")
        if values.shape == uniform.shape:
            return values
        raise AttitudeError(
            f"the distribution of {column} returns shape {values.shape} for {len(uniform)} "
            "objects; it must return one number for each."
        )
    bounds = validation.real(distribution, column)
    if bounds.shape not in ((), (2,)):
        raise AttitudeError(
            f"the distribution of {column} has shape {bounds.shape}; give a number, (low, high), "
            "or a function of numbers uniform from 0 to 1."
        )
    low, high = np.broadcast_to(bounds, 2)
    return low + (high - low) * uniform


def _areas(axes):
    """Surface areas (N,) of ellipsoids with semi-axes (N, 3), by Carlson's R_G."""
    from scipy.special import elliprg

    squares = axes**2
    x, y, z = (squares[:, i] * squares[:, j] for i, j in ((0, 1), (0, 2), (1, 2)))
    return 4.0 * math.pi * elliprg(x, y, z)
