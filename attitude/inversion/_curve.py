"""`LightCurve`: epochs, magnitudes or flux, errors, and the directions of Sun and observer."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from attitude import frames
from attitude._support import markup, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude.epochs import _inputs, _instants
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.photometry._curve import numbered
from attitude.photometry._samples import HasSamples, Samples

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epoch, Epochs, FilePath, FloatArray, IntArray, Reals
    from attitude.paths._path import Path
    from attitude.photometry._curve import Contents
    from attitude.scene._scene import Scene


LEAST_POINTS = 20
# Errors, mag, that are assumed where none are given.
UNKNOWN_SIGMA = 0.02
# Standard deviation, mag, of the zero points of sessions whose magnitudes share one system.
CALIBRATED = 0.1
_MAGNITUDE = 2.5 / np.log(10.0)
# The share of points that have the brightest magnitude exactly, from which they may be saturated.
_SATURATED = 0.05
# Latitude of the Sun, deg, as seen from the Earth, at most.
_ON_ECLIPTIC = 0.1
_J2000 = Instant(0.0)
_WAYS = "sun= and observer= (vectors from the body), scene=, or path= with site="


@dataclass(frozen=True, eq=False, init=False)
class LightCurve(Immutable, HasSamples):
    """Magnitudes of a body with the geometry of each.

    Parameters
    ----------
    times : array_like of N epochs
        At which light was received: dates, Time objects, or plain TDB seconds since `epoch`.
    magnitude, flux : (N,) array_like
        One of them: apparent magnitudes, or flux in any linear unit.
    sigma : (N,) array_like or float, optional
        Standard errors, mag, or in the unit of the flux.  Zeros are unknown errors.
    sun, observer : (N, 3) array_like
        Vectors from the body, m or Quantities, over the axes of `frame`; of the observer, to where
        the light of the body arrived at `times` from where the body was when it left.
    scene : Scene, optional
        In place of sun and observer: its places, light time included.
    path, site : Path, optional
        In place of both: the path of the body, and the observer (a path, or a name such as
        "earth").
    session, filter : (N,) array_like of text or numbers, optional
        The session (night, observer) and the filter of each point.
    zero_points : str, float or sequence
        What sessions share: "auto" (those given are calibrated to 0.1 mag unless the curve shows
        otherwise), "shared", "free", a standard deviation in mag, or the names of the sessions
        that have zero points of their own.  Filters always have their own.
    light_time : bool
        Whether `times` are those of reception.  False: light left the body at `times`.
    epoch : epoch, optional
        To which plain seconds refer; J2000.
    frame : str
        Axes of the vectors: "icrf", "ecliptic", ...
    name : str, optional

    Attributes
    ----------
    epoch : Instant
        The middle of the epochs of emission, to the second.
    seconds, emission : (N,) arrays
        Epochs of reception and emission, TDB s since the epoch.
    magnitude, sigma : (N,) arrays
        Apparent magnitudes in time order.
    sun, observer : (N, 3) arrays
        m, ICRF.
    session, filter : (N,) arrays of int
        Numbers into `sessions` and `filters`; without sessions all 0.
    sessions, filters : tuple of str
    zero_points : str, float or tuple of str
    notes : tuple of str
        What was assumed or is doubtful: errors, epochs that occur twice, which are averaged, a
        frame in which the Sun leaves the ecliptic.
    name : str or None

    Raises
    ------
    AttitudeError
        For arrays of other lengths, fewer than 20 points, numbers that are not finite, a flux that
        is not positive, errors below zero, and missing geometry.
    """

    epoch: Instant
    seconds: FloatArray
    emission: FloatArray
    magnitude: FloatArray
    sigma: FloatArray
    sun: FloatArray
    observer: FloatArray
    session: IntArray
    filter: IntArray
    sessions: tuple[str, ...]
    filters: tuple[str, ...]
    zero_points: Any
    notes: tuple[str, ...]
    name: str | None

    def __init__(
        self,
        times: Epochs,
        magnitude: Reals | None = None,
        sigma: Reals | None = None,
        *,
        flux: Reals | None = None,
        sun: Reals | None = None,
        observer: Reals | None = None,
        scene: Scene | None = None,
        path: Path | None = None,
        site: Path | str = "earth",
        session: ArrayLike | None = None,
        filter: ArrayLike | None = None,
        zero_points: str | float | tuple[str, ...] = "auto",
        light_time: bool = True,
        epoch: Epoch | None = None,
        frame: str = "icrf",
        name: str | None = None,
    ) -> None:
        start = _J2000 if epoch is None else _inputs.instant(epoch)
        hi, lo = _inputs.seconds_since(start, times, name="times")
        t = np.asarray(hi + (0.0 if lo is None else lo), dtype=float)
        if t.ndim != 1 or not np.all(np.isfinite(t)):
            raise AttitudeError(
                f"times has shape {t.shape} and {np.count_nonzero(~np.isfinite(t))} entries that "
                "are not epochs; give a list of N epochs."
            )
        if len(t) < LEAST_POINTS:
            raise AttitudeError(
                f"the light curve has {len(t)} points; give at least {LEAST_POINTS}, better some "
                "hundred."
            )
        notes: list[str] = []
        values, errors = _brightness(magnitude, flux, sigma, len(t), notes)
        to_sun, to_observer = _geometry(times, start, t, sun, observer, scene, path, site, frame)
        left = t - (np.linalg.norm(to_observer, axis=1) / SPEED_OF_LIGHT_M_S if light_time else 0.0)
        named = numbered(session, len(t), "session"), numbered(filter, len(t), "filter")
        _doubts(values, notes)
        first, values, errors = _without_twice(start, t, named, values, errors, notes)
        if sun is not None:
            _doubt_frame(frame, to_sun - to_observer, notes)
        t, left, to_sun, to_observer = (each[first] for each in (t, left, to_sun, to_observer))
        order = np.argsort(t, kind="stable")
        middle = float(np.round(0.5 * (left.min() + left.max())))
        self._set("epoch", start.after(middle))
        self._set("seconds", frozen(t[order] - middle))
        self._set("emission", frozen(left[order] - middle))
        for key, each in (("magnitude", values), ("sigma", errors)):
            self._set(key, frozen(each[order]))
        self._set("sun", frozen(to_sun[order]))
        self._set("observer", frozen(to_observer[order]))
        for key, (words, numbers) in zip(("session", "filter"), named, strict=True):
            self._set(key, frozen(numbers[first][order]))
            self._set(f"{key}s", words)
        self._set("zero_points", _known_zero_points(zero_points, self.sessions))
        self._set("notes", tuple(notes))
        self._set("name", name)

    @classmethod
    def read(cls, path: FilePath, /, **given: Any) -> Self:
        """The light curve in a file of any format that `attitude.photometry.read` reads.

        Parameters
        ----------
        path : str or path
            Named columns as in `attitude.photometry._files`, ALCDEF, ADES, MPC, DAMIT.
        given
            Keywords of the class; geometry that the file does not have, `frame`, `zero_points`.
        """

        keywords, notes = columns(path, given)
        made = cls(**keywords)
        made._set("notes", (*notes, *made.notes))
        return made

    def __len__(self) -> int:
        return len(self.seconds)

    def __repr__(self) -> str:
        span = float(np.ptp(self.seconds)) / 86400.0
        return (
            f"<LightCurve of {len(self)} points in {len(self.sessions)} sessions over "
            f"{span:.4g} d about {self.epoch.utc_iso} UTC>"
        )

    def _repr_html_(self) -> str:
        """A table for notebooks, and the reduced magnitudes against time."""
        days = (self.seconds - self.seconds.min()) / 86400.0
        rows = [
            ("points", str(len(self))),
            ("sessions", str(len(self.sessions))),
            ("span", f"{np.ptp(days):.6g} d about {self.epoch.utc_iso} UTC"),
            ("errors", f"{np.median(self.sigma):.3g} mag (median)"),
            ("zero points", str(self.zero_points)),
        ]
        picture = markup.line_plot(
            [(days, self.reduced)],
            f"reduced magnitude over {np.ptp(days):.4g} d",
            is_downward=True,
            is_dotted=True,
        )
        return markup.table(f"Light curve {self.name or ''}".strip(), rows, picture)

    def samples(self) -> Samples:
        """Reduced magnitudes at the epochs of emission, a zero point a session and filter.

        Or one a filter: those of the curve that are "free" or "shared" are known.
        """
        keys = self.session * len(self.filters) + self.filter
        curve, joined = (
            np.unique(each, return_inverse=True)[1].reshape(-1).astype(np.int64)
            for each in (keys, self.filter)
        )
        given = np.array(self.emission), self.reduced, np.array(self.sigma)
        if self.zero_points == "shared":
            curve = joined
        is_known = self.zero_points in ("shared", "free")
        return Samples(*given, curve, self.epoch, joined=None if is_known else joined)

    @property
    def span(self) -> float:
        """From the first to the last emission, s."""
        return float(np.ptp(self.emission))

    @property
    def reduced(self) -> FloatArray:
        """Magnitudes (N,) at 1 au from Sun and observer."""
        size = np.linalg.norm(self.sun, axis=1) * np.linalg.norm(self.observer, axis=1)
        found: FloatArray = self.magnitude - 5.0 * np.log10(size / ASTRONOMICAL_UNIT_M**2)
        return found

    @property
    def phase_angle(self) -> FloatArray:
        """Angle (N,) at the body between Sun and observer, rad."""
        cross = np.linalg.norm(np.cross(self.sun, self.observer), axis=1)
        found: FloatArray = np.arctan2(cross, np.sum(self.sun * self.observer, axis=1))
        return found


def _brightness(magnitude, flux, sigma, count, notes):
    if (magnitude is None) == (flux is None):
        raise AttitudeError("give either magnitude or flux, of each epoch.")
    name = "magnitude" if flux is None else "flux"
    given = magnitude if flux is None else flux
    values = validation.real(given, name, finite=False, unit="mag" if flux is None else None)
    if values.shape != (count,):
        raise AttitudeError(f"{name} has shape {values.shape}; give one for each of {count} times.")
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise AttitudeError(
            f"{name} holds {len(bad)} entries that are not finite, the first at row {bad[0]}; "
            "leave these points out."
        )
    errors = np.zeros(count)
    if sigma is not None:
        unit = "mag" if flux is None else None
        errors = np.broadcast_to(validation.real(sigma, "sigma", unit=unit), (count,)).copy()
        if np.any(errors < 0.0):
            raise AttitudeError("sigma has entries below zero; give standard errors.")
    if flux is not None:
        if np.any(values <= 0.0):
            raise AttitudeError(
                f"flux has {np.count_nonzero(values <= 0.0)} entries that are not positive; leave "
                "these points out, or add the background that was taken off too much."
            )
        errors = _MAGNITUDE * errors / values
        values = -2.5 * np.log10(values)
    unknown = errors == 0.0
    if np.any(unknown):
        known = errors[~unknown]
        assumed = max(UNKNOWN_SIGMA, float(np.median(known)) if len(known) else 0.0)
        errors[unknown] = assumed
        notes.append(
            f"{np.count_nonzero(unknown)} of {count} points have no error; {assumed:.3f} mag is "
            "assumed."
        )
    return values, errors


def _geometry(times, start, t, sun, observer, scene, path, site, frame):
    """Vectors (N, 3) to Sun and observer, m, ICRF."""
    ways = [sun is not None or observer is not None, scene is not None, path is not None]
    if sum(ways) != 1:
        raise AttitudeError(f"the geometry is given in {sum(ways)} ways; give one of {_WAYS}.")
    if ways[0]:
        if sun is None or observer is None:
            missing = "sun" if sun is None else "observer"
            raise AttitudeError(f"{missing} is missing; give {_WAYS}.")
        turn = frames.matrix_to_icrf(frame)
        both = []
        for given, name in ((sun, "sun"), (observer, "observer")):
            vectors = validation.real(given, name, unit="m")
            if vectors.shape not in ((len(t), 3), (3,)):
                raise AttitudeError(
                    f"{name} has shape {vectors.shape}; give a vector for each of {len(t)} epochs."
                )
            vectors = np.broadcast_to(vectors, (len(t), 3)) @ turn.T
            if np.any(np.linalg.norm(vectors, axis=1) == 0.0):
                raise AttitudeError(f"{name} has a vector of length zero; give directions.")
            both.append(vectors)
        return both[0], both[1]
    if scene is None:
        from attitude.scene._scene import Scene

        scene = Scene(None, path, site)
    view = scene.at(_instants.times(start, t, np.zeros_like(t)))
    sizes = []
    for name in ("sun", "observer"):
        place = getattr(scene, name)
        distance = 1.0 if place.is_direction else getattr(view, f"{name}_distance")
        unit = np.broadcast_to(getattr(view, f"{name}_direction_icrf"), (len(t), 3))
        sizes.append(unit * np.reshape(distance, (-1, 1)))
    return sizes[0], sizes[1]


def _without_twice(start, t, named, values, errors, notes):
    """Rows (M,) of distinct epochs, and their magnitudes and errors, weighted means of equal ones.

    Equal are epochs of one session and filter.
    """
    rows = np.stack([t, *(numbers.astype(float) for _, numbers in named)], axis=1)
    _, first, which = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    which = which.reshape(-1)
    counts = np.bincount(which)
    if not np.any(counts > 1):
        return np.arange(len(t)), values, errors
    twice = np.sort(first[counts > 1])
    jd = _instants.times(start, t[twice[:1]], np.zeros(1))[0]
    notes.append(
        f"{len(twice)} epochs occur more than once in one session and filter, the first at row "
        f"{twice[0]}, JD {jd.jd:.6f} (TDB), {jd.utc.isot[:19]} UTC; such points are averaged."
    )
    total = np.bincount(which, errors**-2.0)
    mean = np.bincount(which, values * errors**-2.0) / total
    if len(mean) < LEAST_POINTS:
        raise AttitudeError(
            f"the light curve has {len(mean)} points at different epochs; give at least "
            f"{LEAST_POINTS}, better some hundred."
        )
    return first, mean, total**-0.5


def _doubt_frame(frame, to_sun, notes):
    """Note vectors (N, 3), ICRF, from observer to Sun, that fit the Earth in another frame alone.

    The Sun stands on the ecliptic of an observer on the Earth; not so of a spacecraft, so that the
    frame stays as it was given.
    """
    unit = to_sun / np.maximum(np.linalg.norm(to_sun, axis=1), 1e-300)[:, None]
    given = unit @ frames.matrix_to_icrf(frame)
    north = frames.matrix_to_icrf("ecliptic")[:, 2]
    latitude = {}
    for each in dict.fromkeys((frame.lower(), "icrf", "ecliptic")):
        turned = given @ frames.matrix_to_icrf(each).T
        latitude[each] = math.degrees(math.asin(min(1.0, np.abs(turned @ north).max())))
    other = min(latitude, key=lambda each: latitude[each])
    if latitude[frame.lower()] > _ON_ECLIPTIC > latitude[other]:
        notes.append(
            f"the vectors are given over the axes {frame!r}, where the observer sees the Sun up to "
            f"{latitude[frame.lower()]:.1f} degrees from the ecliptic; over {other!r} it lies on "
            "the ecliptic, as it does for the Earth. If the observer was there, give "
            f"frame={other!r}."
        )


def _doubts(magnitude, notes):
    brightest = np.count_nonzero(magnitude == magnitude.min())
    if brightest >= 5 and brightest > _SATURATED * len(magnitude) and np.ptp(magnitude) > 0.0:
        notes.append(
            f"{brightest} points share the brightest magnitude {magnitude.min():.3f} exactly, as "
            "saturated ones do; leave such points out."
        )


def _known_zero_points(given, sessions):
    if isinstance(given, str):
        return validation.one_of(given, "zero_points", ("auto", "shared", "free"))
    if isinstance(given, (list, tuple, set)):
        names = tuple(str(each) for each in given)
        for each in names:
            if each not in sessions:
                raise AttitudeError(
                    f"zero_points names the session {each!r}; the curve has "
                    f"{', '.join(sessions[:8])}."
                )
        return names
    return validation.positive(given, "zero_points", unit="mag")


# ---- Light curves with geometry, for the inversion, from any file that `photometry.read` reads

_PLACES = ("sun", "observer", "frame")


def columns(path: FilePath, given: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Keywords of `LightCurve` from a file, replaced by those given, and the notes of the file."""
    from attitude.photometry import _files

    found = _files.opened(path, bad="refuse")
    if found.time_of in ("barycenter", "heliocenter"):
        raise AttitudeError(
            f"{found.name}: its dates are those of light at the {found.time_of}; give dates at the "
            "observer, or photometry.read(file).reduced(path), which converts them."
        )
    keywords = found.keywords()
    keywords.pop("site", None)
    if any(each in given for each in ("scene", "path", "sun", "observer")):
        for key in _PLACES:
            keywords.pop(key, None)
    elif "frame" in keywords:  # of the file, whatever the frame of other files
        given = {key: each for key, each in given.items() if key != "frame"}
    if found.time_of == "emission":
        keywords["light_time"] = False
    if found.unit_distances:
        _dim(keywords, found)
    name = os.path.splitext(os.path.basename(found.name))[0]
    return {"name": name, **keywords, **given}, found.notes


def _dim(keywords: dict[str, Any], found: Contents) -> None:
    """Brightness at unit distances as apparent brightness, which `LightCurve` takes."""
    import numpy as np

    if not {"sun", "observer"} <= keywords.keys():
        raise AttitudeError(
            f"{found.name}: holds brightness at 1 au, and no vectors to Sun and observer; give a "
            "file of apparent brightness."
        )
    size = [np.linalg.norm(keywords[key], axis=1) / ASTRONOMICAL_UNIT_M for key in _PLACES[:2]]
    if found.is_flux:
        keywords["flux"] = keywords["flux"] / (size[0] * size[1]) ** 2
        if "sigma" in keywords:
            keywords["sigma"] = keywords["sigma"] / (size[0] * size[1]) ** 2
    else:
        keywords["magnitude"] = keywords["magnitude"] + 5.0 * np.log10(size[0] * size[1])
