"""`Photometry` of one body, its reduction to 1 au, and its rows in files."""

from __future__ import annotations

import re
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from attitude import frames
from attitude._support import validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.constants import ASTRONOMICAL_UNIT_M, SPEED_OF_LIGHT_M_S
from attitude._textfiles.atomic_write import written_whole
from attitude.epochs import _inputs, _instants
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.formats import _ccsds_epochs as ccsds_epochs
from attitude.paths import _composed
from attitude.photometry._samples import HasSamples, Samples
from attitude.scattering import _weighted

if TYPE_CHECKING:
    from collections.abc import Sequence

    from astropy.table import QTable
    from astropy.time import Time
    from numpy.typing import ArrayLike

    from attitude._support.annotations import (
        Epoch,
        Epochs,
        FilePath,
        FloatArray,
        IntArray,
        Real,
        Reals,
    )
    from attitude.paths._path import Path
    from attitude.scene._scene import Scene


# Magnitudes beyond these stand for missing values in catalogues (99, 99.99, -99, 999).
_MISSING = (-50.0, 50.0)
# Julian dates of the years -2000 to 4700.
_JULIAN = (990_000.0, 3_440_000.0)
_BLANK = ("", "nan", "--", "-", "none", "null", "n/a", "inf", "-inf")
# Bad rows that a message names.
_NAMED = 6
# What a file may say about its epochs and magnitudes.
PLACES: Final = ("reception", "emission", "barycenter", "heliocenter")


class BadRow(NamedTuple):
    """A row of a file that is left out: its line, counted from 1, and the reason."""

    line: int
    reason: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.reason}"


class RawPoint(NamedTuple):
    """One observation as text, as it stands in a file; "" where the file has no entry."""

    line: int
    time: str
    value: str
    error: str = ""
    filter: str = ""
    site: str = ""
    session: str = ""


@dataclass
class Contents:
    """The rows of a file that can be used.

    Attributes
    ----------
    name : str
        Of the file, in messages.
    times : Time or list of str
        Epochs (N,).
    value, error : (N,) arrays
        Magnitudes or fluxes; NaN where an error is unknown.
    is_flux : bool
    filter, site, session : list of str or None
    time_of : str
        Where light is at the times, one of `PLACES`.
    unit_distances : bool
        Whether the brightness is that at 1 au from Sun and observer.
    rows : (N,) array of int
        The numbers of the good rows among all of them.
    bad : list of BadRow
    notes : list of str
    more : dict
        Further keywords of `Photometry`, such as vectors to Sun and observer.
    """

    name: str
    times: Any
    value: FloatArray
    error: FloatArray
    is_flux: bool = False
    filter: list[str] | None = None
    site: list[str] | None = None
    session: list[str] | None = None
    time_of: str = "reception"
    unit_distances: bool = False
    rows: Any = None
    bad: list[BadRow] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)

    def keywords(self) -> dict[str, Any]:
        """The keywords of `Photometry` and of `LightCurve`, as far as the file has them."""
        found: dict[str, Any] = {
            "times": self.times,
            "flux" if self.is_flux else "magnitude": self.value,
        }
        if np.any(np.isfinite(self.error)):
            found["sigma"] = np.where(np.isfinite(self.error), self.error, 0.0)
        for name in ("filter", "site", "session"):
            words = getattr(self, name)
            if words is not None and any(words):
                found[name] = words
        return found | self.more


def of_rows(
    rows: Sequence[RawPoint],
    name: str,
    *,
    scale: str | None = None,
    offset: float = 0.0,
    is_flux: bool = False,
    bad: list[BadRow] | None = None,
) -> Contents:
    """The `Contents` of rows of text."""
    left_out, kept, numbers = list(bad or ()), [], []
    without = 0
    word = "flux" if is_flux else "magnitude"
    for k, row in enumerate(rows):
        if row.value.strip().lower() in _BLANK:
            without += 1
            continue
        reason, value, error = _numbers(row, word, is_flux)
        if reason is None and scale is not None:
            reason = _julian_fault(row.time, offset)
        if reason is None:
            kept.append(k)
            numbers.append((value, error))
        else:
            left_out.append(BadRow(row.line, reason))
    times, good, faults = _times([rows[k] for k in kept], scale, offset)
    left_out += faults
    kept, numbers = [kept[k] for k in good], [numbers[k] for k in good]
    left_out.sort(key=lambda each: each.line)
    if not kept:
        raise AttitudeError(
            f"{name}: no row can be used"
            + (f" ({without} rows have no {word})" if without else "")
            + (f"; {_listed(left_out)}" if left_out else "")
            + "."
        )
    notes = [f"{without} of {len(rows)} rows have no {word}."] if without else []
    notes += _repeated([rows[k] for k in kept], word)
    both = np.array(numbers).reshape(-1, 2)
    words: dict[str, Any] = {
        key: each if any(each) else None
        for key in ("filter", "site", "session")
        for each in [[getattr(rows[k], key).strip() for k in kept]]
    }
    return Contents(
        name,
        times,
        both[:, 0],
        both[:, 1],
        is_flux=is_flux,
        rows=np.array(kept),
        bad=left_out,
        notes=notes,
        filter=words["filter"],
        site=words["site"],
        session=words["session"],
    )


def _repeated(rows: Sequence[RawPoint], word: str) -> list[str]:
    """A note of rows that repeat others, and of the sessions that consist of such rows."""
    first: dict[tuple[str, ...], RawPoint] = {}
    repeats: list[tuple[RawPoint, RawPoint]] = []
    for row in rows:
        key = tuple(each.strip() for each in (row.time, row.value, row.filter, row.site))
        if (earlier := first.setdefault(key, row)) is not row:
            repeats.append((row, earlier))
    if not repeats:
        return []
    count = Counter(row.session for row in rows)
    again = Counter((row.session, earlier.session) for row, earlier in repeats)
    whole = [
        f"session {row[:40]!r} repeats {earlier[:40]!r}"
        for (row, earlier), many in again.items()
        if row != earlier and many == count[row]
    ]
    row, earlier = repeats[0]
    return [
        f"{len(repeats)} of {len(rows)} rows repeat the date, {word}, filter and site of others "
        f"(line {row.line} those of line {earlier.line})"
        + (f"; {listed(whole)}" if whole else "")
        + ": they count twice."
    ]


def listed(items: Sequence[object]) -> str:
    """The first six of some items, and how many follow."""
    more = len(items) - _NAMED
    return ", ".join(map(str, items[:_NAMED])) + (f" and {more} more" if more > 0 else "")


def report(contents: Contents, bad: str) -> None:
    """Warn of bad rows, or raise an AttitudeError for them."""
    if not contents.bad or bad == "ignore":
        return
    many = len(contents.bad)
    said = (
        f"{contents.name}: {many} row{'s' if many > 1 else ''} cannot be used: "
        f"{_listed(contents.bad)}"
    )
    if bad == "refuse":
        raise AttitudeError(f'{said}; correct or delete them, or give bad="warn".')
    warnings.warn(f"{said}. Left out.", AttitudeWarning, stacklevel=3)


def _listed(bad: Sequence[BadRow]) -> str:
    more = len(bad) - _NAMED
    return "; ".join(map(str, bad[:_NAMED])) + (f"; and {more} more" if more > 0 else "")


def _numbers(row: RawPoint, word: str, is_flux: bool) -> tuple[str | None, float, float]:
    """What is wrong with the numbers of a row, or None; its value and error."""
    text = row.value.strip()
    if text[:1] in "<>":
        return f"the {word} {text[:20]!r} is a limit", 0.0, 0.0
    value, error = _float(text), np.nan
    if value is None:
        return f"the {word} is {text[:20]!r}, which is no number", 0.0, 0.0
    if not np.isfinite(value) or not (is_flux or _MISSING[0] < value < _MISSING[1]):
        return f"the {word} {text[:20]} stands for a missing value", 0.0, 0.0
    if row.error.strip().lower() not in _BLANK:
        found = _float(row.error)
        if found is None:
            return f"the error is {row.error.strip()[:20]!r}, which is no number", 0.0, 0.0
        if found < 0.0 or found > 1e300:
            return f"the error is {row.error.strip()[:20]}, not above zero", 0.0, 0.0
        error = found if found > 0.0 else np.nan
    return None, value, error


def _float(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _julian_fault(text: str, offset: float) -> str | None:
    found = _float(text)
    if found is None:
        return f"the date is {text.strip()[:30]!r}, which is no number"
    if not _JULIAN[0] < found + offset < _JULIAN[1]:
        return f"the date {text.strip()[:30]} is no Julian date"
    return None


def _times(
    rows: Sequence[RawPoint], scale: str | None, offset: float
) -> tuple[Any, list[int], list[BadRow]]:
    """Epochs of rows, the numbers of the rows whose dates can be read, and the others."""
    everything = list(range(len(rows)))
    if not rows:
        return [], [], []
    if scale is not None:
        return julian([each.time for each in rows], scale, offset), everything, []
    dates = [iso(each.time) for each in rows]
    try:
        _inputs.past_j2000(dates)
    except AttitudeError:
        good, faults = [], []
        for k, row in enumerate(rows):
            try:
                _inputs.past_j2000([dates[k]])
                good.append(k)
            except AttitudeError as err:
                faults.append(
                    BadRow(row.line, str(err).split(";")[0].replace("t is ", "the date "))
                )
        return [dates[k] for k in good], good, faults
    return dates, everything, []


def iso(text: str) -> str:
    """A date as it stands in files, in the spelling of ISO 8601.

    >>> iso("2011/09/13 7:46:00")
    '2011-09-13 07:46:00'
    """
    found = re.fullmatch(
        r"\s*(\d{4})[-/. ](\d{1,2})[-/. ](\d{1,2})(?:[T ]+(\d{1,2})(:.*))?\s*", text
    )
    if found is None:
        return text.strip()
    year, month, day, hour, rest = found.groups()
    date = f"{year}-{int(month):02d}-{int(day):02d}"
    return date if hour is None else f"{date} {int(hour):02d}{rest}"


def julian(days: Sequence[str] | FloatArray, scale: str, offset: float = 0.0) -> Any:
    """Julian dates as a Time: the whole days and the rest are two doubles."""
    from astropy.time import Time

    parts = [str(each).strip().partition(".") for each in days]
    exact = all(re.fullmatch(r"\d+", a) and re.fullmatch(r"\d*", b) for a, _, b in parts)
    if exact:
        whole = np.array([float(a) for a, _, _ in parts])
        rest = np.array([float(f"0.{b or 0}") for _, _, b in parts])
    else:
        given = np.array([float(each) for each in days])
        whole = np.floor(given)
        rest = given - whole
    added = np.floor(offset)
    return Time(whole + added, rest + (offset - added), format="jd", scale=scale)


# ---- Brightness at 1 au from Sun and observer, when the light left the body, at zero phase angle

# Rounds of the correction of a date at the barycenter: each gains four digits.
_ROUNDS = 4
_CENTERS = {"barycenter": None, "heliocenter": "sun"}


def reduced(
    data: Photometry,
    path: Path | None = None,
    *,
    site: Any = None,
    phase_function: Callable[[FloatArray], FloatArray] | str | None = None,
    g: Real | None = None,
) -> Photometry:
    """The photometry at 1 au from Sun and observer, at the times at which light left the body.

    Light time as in `Scene`; dates of light at the barycenter of the solar system are converted to
    those of reception first, to 1e-6 s for a body beyond 0.01 au.
    """
    if path is None and (data.sun is None or data.observer is None):
        raise AttitudeError(
            "the photometry has no vectors to Sun and observer; give the path of the body, as in "
            "reduced(paths.mpc_orbit(line)) or reduced(paths.oem(file))."
        )
    if path is None:
        sun, observer = np.array(data.sun), np.array(data.observer)
        received = data.seconds
    else:
        sun, observer, received = _from_path(data, path, site)
    far = [np.linalg.norm(each, axis=1) for each in (sun, observer)]
    left = received if data.time_of == "emission" else received - far[1] / SPEED_OF_LIGHT_M_S
    shift = np.zeros(len(data))
    if not data.unit_distances:
        shift -= 5.0 * np.log10(far[0] * far[1] / ASTRONOMICAL_UNIT_M**2)
    function = _function(phase_function, g)
    if function is not None:
        if data.zero_phase:
            raise AttitudeError("the photometry is at zero phase angle already.")
        alpha = np.arctan2(
            np.linalg.norm(np.cross(sun, observer), axis=1), np.sum(sun * observer, axis=1)
        )
        shift -= function(alpha) - function(np.zeros(1))[0]
    factor = 10.0 ** (-0.4 * shift)
    changed: dict[str, Any] = {"magnitude": data.value + shift}
    if data.is_flux:
        changed = {"flux": data.value * factor, "sigma": data.sigma * factor}
    return data.replaced(
        times=left,
        sun=sun,
        observer=observer,
        time_of="emission",
        unit_distances=True,
        zero_phase=data.zero_phase or function is not None,
        **changed,
    )


def phase_angle(data: Photometry) -> FloatArray:
    """Angle (N,) at the body between Sun and observer, rad; AttitudeError without vectors."""
    if data.sun is None or data.observer is None:
        raise AttitudeError("the photometry has no vectors to Sun and observer; see reduced.")
    cross = np.linalg.norm(np.cross(data.sun, data.observer), axis=1)
    found: FloatArray = np.arctan2(cross, np.sum(data.sun * data.observer, axis=1))
    return found


def _function(given: Any, g: Real | None) -> Callable[[FloatArray], FloatArray] | None:
    if given is None and g is None:
        return None
    if given is None or given == "hg":
        slope = 0.15 if g is None else validation.number(g, "g")
        return lambda alpha: _weighted.hg(alpha, 0.0, slope)
    if g is not None or not callable(given):
        raise AttitudeError(
            f"phase_function is {validation.shown(given)}; give a function of the phase angle in "
            'rad without g, or "hg" with g.'
        )
    return given


def _from_path(
    data: Photometry, path: Path, site: Any
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Vectors (N, 3) to Sun and observer, m, and seconds (N,) of reception, or of emission."""
    from attitude.scene._scene import Scene

    sun, observer = np.empty((len(data), 3)), np.empty((len(data), 3))
    received = np.array(data.seconds)
    light_time = data.time_of != "emission"
    for number, name in enumerate(data.sites):
        here = data.site == number
        scene = Scene(None, path, _place(name, site), light_time=light_time)
        if data.time_of in _CENTERS:
            received[here] = _received(data, here, scene)
        view = scene.at(_instants.times(data.epoch, received[here]))
        for out, key in ((sun, "sun"), (observer, "observer")):
            unit = getattr(view, f"{key}_direction_icrf")
            out[here] = unit * np.reshape(getattr(view, f"{key}_distance"), (-1, 1))
    return sun, observer, received


def _received(data: Photometry, here: Any, scene: Scene) -> FloatArray:
    """Seconds of reception from those of light in the plane through the barycenter or the Sun."""
    given = data.seconds[here]
    found = np.array(given)
    center = _CENTERS[data.time_of]
    assert scene.center is not None
    for _ in range(_ROUNDS):
        view = scene.at(_instants.times(data.epoch, found))
        towards = -view.observer_direction_icrf
        place = scene.observer.position(data.epoch, found)  # type: ignore[union-attr]
        if center is not None:
            place = place - _composed.body(center).position(data.epoch, found)
        found = given - np.sum(place * towards, axis=-1) / SPEED_OF_LIGHT_M_S
    return found


def _place(name: str, site: Any) -> Any:
    """The observer of points of a site."""
    if isinstance(site, dict):
        if name not in site:
            raise AttitudeError(f"site has no {name!r}; it has {', '.join(map(repr, site))}.")
        return site[name]
    if site is not None:
        return site
    if not name:
        return "earth"
    from attitude.paths import _places

    try:
        return _places.place(name, "site", is_observer=True)
    except AttitudeError as err:
        raise AttitudeError(f"{err} Or give site= for points of {name!r}.") from None


# ---- `Photometry`: the brightness of one body at epochs, with errors, filters, sites and sessions

_MAGNITUDE = 2.5 / np.log(10.0)
_WORDS = ("filter", "site", "session")
_J2000 = Instant(0.0)
_AS_GIVEN = ("epoch", "time_of", "unit_distances", "zero_phase", "is_flux", "notes", "name")


@dataclass(frozen=True, eq=False, init=False)
class Photometry(Immutable, HasSamples):
    """The brightness of a body at epochs, in time order.

    Parameters
    ----------
    times : array_like of N epochs
        Time objects, dates, or plain TDB seconds since `epoch`.
    magnitude, flux : (N,) array_like
        One of them; Quantities, or flux in any linear unit.
    sigma : (N,) array_like or float, optional
        Standard errors in the unit of the brightness; zero and NaN are unknown errors.
    filter, site, session : (N,) array_like of text or numbers, or one text, optional
        Filter, code of the observatory, and session (night, observer).
    time_of : str
        Where light is at `times`: "reception" by the observer, "emission" by the body, at the
        "barycenter" of the solar system (BJD), or the "heliocenter" (HJD).
    unit_distances : bool
        Whether the brightness is that at 1 au from Sun and observer.
    zero_phase : bool
        Whether it is that at zero phase angle.
    sun, observer : (N, 3) array_like, optional
        Vectors from the body, m or Quantities, over the axes of `frame`.
    epoch : epoch, optional
        To which plain seconds refer; J2000.
    frame : str
    name : str, optional
        Of the body.
    bad : sequence of BadRow
        Rows of the file that were left out.
    notes : sequence of str

    Attributes
    ----------
    epoch : Instant
        The middle of the epochs, to the second.
    seconds : (N,) array
        TDB s from the epoch.
    value, sigma : (N,) arrays
        Magnitudes or fluxes; NaN where the error is unknown.
    is_flux : bool
    filter, site, session : (N,) arrays of int
        Numbers into the tuples `filters`, `sites` and `sessions` of str.
    sun, observer : (N, 3) arrays or None
        m, ICRF.
    time_of, unit_distances, zero_phase, name, bad, notes
        As given.

    Raises
    ------
    AttitudeError
        For arrays of other lengths, numbers that are not finite and errors below zero.

    >>> data = Photometry(["2026-01-01", "2026-01-02"], magnitude=[15.0, 15.5], filter="V")
    >>> data
    <Photometry: 2 magnitudes in V over 1 d about 2026-01-01>
    """

    epoch: Instant
    seconds: FloatArray
    value: FloatArray
    sigma: FloatArray
    is_flux: bool
    filter: IntArray
    site: IntArray
    session: IntArray
    filters: tuple[str, ...]
    sites: tuple[str, ...]
    sessions: tuple[str, ...]
    sun: FloatArray | None
    observer: FloatArray | None
    time_of: str
    unit_distances: bool
    zero_phase: bool
    name: str | None
    bad: tuple[BadRow, ...]
    notes: tuple[str, ...]

    def __init__(
        self,
        times: Epochs,
        magnitude: Reals | None = None,
        sigma: Reals | None = None,
        *,
        flux: Reals | None = None,
        filter: ArrayLike | None = None,
        site: ArrayLike | None = None,
        session: ArrayLike | None = None,
        time_of: str = "reception",
        unit_distances: bool = False,
        zero_phase: bool = False,
        sun: Reals | None = None,
        observer: Reals | None = None,
        epoch: Epoch | None = None,
        frame: str = "icrf",
        name: str | None = None,
        bad: Sequence[BadRow] = (),
        notes: Sequence[str] = (),
    ) -> None:
        start = _J2000 if epoch is None else _inputs.instant(epoch)
        hi, lo = _inputs.seconds_since(start, times, name="times")
        if hi.ndim != 1 or not hi.size or not np.all(np.isfinite(hi)):
            raise AttitudeError(
                f"times has shape {hi.shape} and {np.count_nonzero(~np.isfinite(hi))} entries that "
                "are not epochs; give a list of N epochs."
            )
        middle = float(np.round(0.5 * (hi.min() + hi.max())))
        t = (hi - middle) + (0.0 if lo is None else lo)
        order = np.argsort(t, kind="stable")
        values, errors = _brightness(magnitude, flux, sigma, len(t))
        self._set("epoch", start.after(middle))
        self._set("is_flux", flux is not None)
        for key, array in (("seconds", t), ("value", values), ("sigma", errors)):
            self._set(key, frozen(np.asarray(array[order])))
        for key, given in zip(_WORDS, (filter, site, session), strict=True):
            words, numbers = numbered(given, len(t), key)
            self._set(key, frozen(numbers[order]))
            self._set(f"{key}s", words)
        for key, vectors in (("sun", sun), ("observer", observer)):
            self._set(key, _vectors(vectors, key, frame, order))
        self._set("time_of", validation.one_of(time_of, "time_of", PLACES))
        self._set("unit_distances", validation.flag(unit_distances, "unit_distances"))
        self._set("zero_phase", validation.flag(zero_phase, "zero_phase"))
        self._set("name", name)
        self._set("bad", tuple(bad))
        self._set("notes", tuple(notes))

    # ---- What it holds

    def __len__(self) -> int:
        return len(self.seconds)

    def __repr__(self) -> str:
        what = "fluxes" if self.is_flux else "magnitudes"
        words = [f"{len(self)} {what}"]
        bands = ", ".join(each for each in self.filters if each)
        if bands:
            words.append(f"in {bands}")
        if len(self.sessions) > 1:
            words.append(f"in {len(self.sessions)} sessions")
        span = self.span / 86400.0
        words.append(f"over {span:.4g} d about {self.epoch.utc_iso[:10]}")
        return f"<Photometry{' of ' + self.name if self.name else ''}: {' '.join(words)}>"

    @property
    def times(self) -> Time:
        """The epochs (N,) as an astropy Time in TDB."""
        return _instants.times(self.epoch, self.seconds)

    @property
    def span(self) -> float:
        """From the first to the last epoch, s."""
        return float(np.ptp(self.seconds))

    @property
    def magnitude(self) -> FloatArray:
        """Magnitudes (N,); of fluxes -2.5 log10, which have an unknown zero point."""
        if not self.is_flux:
            return self.value
        if np.any(self.value <= 0.0):
            raise AttitudeError(
                f"{np.count_nonzero(self.value <= 0.0)} fluxes are not above zero, and have no "
                "magnitude; leave these points out."
            )
        found: FloatArray = -2.5 * np.log10(self.value)
        return found

    @property
    def magnitude_sigma(self) -> FloatArray:
        """Errors (N,) of the magnitudes, NaN where they are unknown."""
        return _MAGNITUDE * self.sigma / np.abs(self.value) if self.is_flux else self.sigma

    def __getitem__(self, which: Any) -> Photometry:
        """The points of a mask, of a slice or of whole numbers."""
        chosen = np.atleast_1d(np.arange(len(self))[which])
        if not chosen.size:
            raise AttitudeError("no point is left; choose others.")
        return self.replaced(chosen)

    def select(
        self, *, filter: str | None = None, site: str | None = None, session: str | None = None
    ) -> Photometry:
        """The points with a filter, of a site, of a session; AttitudeError if there are none."""
        mask = np.ones(len(self), bool)
        for key, word in (("filter", filter), ("site", site), ("session", session)):
            if word is not None:
                words = getattr(self, f"{key}s")
                validation.one_of(str(word), key, words)
                mask &= getattr(self, key) == words.index(str(word))
        return self[mask]

    def replaced(self, chosen: IntArray | None = None, **changes: Any) -> Photometry:
        """The points with these numbers, all by default, with other values of attributes.

        `changes` are keywords of the class; arrays are those of the chosen points.
        """
        which: Any = slice(None) if chosen is None else chosen
        keywords = {key: getattr(self, key) for key in _AS_GIVEN if key != "is_flux"}
        keywords["bad"] = self.bad
        for key in _WORDS:
            words = getattr(self, f"{key}s")
            if any(words):
                keywords[key] = [words[k] for k in getattr(self, key)[which]]
        for key in ("sun", "observer"):
            vectors = getattr(self, key)
            keywords[key] = None if vectors is None else vectors[which]
        keywords["flux" if self.is_flux else "magnitude"] = self.value[which]
        keywords |= {"times": self.seconds[which], "sigma": self.sigma[which]}
        if changes.keys() & {"magnitude", "flux"}:
            for key in ("magnitude", "flux"):
                keywords.pop(key, None)
        return Photometry(**keywords | changes)

    # ---- What it becomes

    def samples(self) -> Samples:
        """The `Samples` for periods: a zero point for each session and filter, or each filter."""
        keys = self.session * len(self.filters) + self.filter
        _, first, curve = np.unique(keys, return_index=True, return_inverse=True)
        names = tuple(
            " ".join(
                each
                for each in (self.sessions[self.session[k]], self.filters[self.filter[k]])
                if each
            )
            for k in first
        )
        known = np.isfinite(self.sigma) & (self.sigma > 0.0)
        errors = None
        if np.any(known):
            errors = np.where(known, self.sigma, np.median(self.sigma[known]))
        return Samples(
            np.array(self.seconds),
            np.array(self.value),
            errors,
            np.asarray(curve, np.int64).reshape(-1),
            self.epoch,
            is_flux=self.is_flux,
            names=names,
            joined=np.unique(self.filter, return_inverse=True)[1].reshape(-1).astype(np.int64),
        )

    def shared(self) -> Photometry:
        """The same points as one session, so that all share a zero point (filters keep theirs)."""
        return self.replaced(session=None)

    def reduced(
        self,
        path: Path | None = None,
        *,
        site: Any = None,
        phase_function: Any = None,
        g: Real | None = None,
    ) -> Photometry:
        """At 1 au from Sun and observer, at the times at which the light left the body.

        Parameters
        ----------
        path : Path, optional
            Of the body; not needed where the data have vectors to Sun and observer.
        site : Path, name, dict of them by the names of sites, optional
            The observer; by default the sites of the data (codes of observatories, or longitude
            and latitude), and the centre of the Earth for points without a site.
        phase_function : callable or "hg", optional
            Mean magnitude as a function of the phase angle in rad, which is taken off less its
            value at zero; "hg" with `g` (0.15).
        g : float, optional
            Slope parameter: the same as phase_function="hg".

        Returns
        -------
        Photometry
            With `sun` and `observer`, ``time_of="emission"``.

        Raises
        ------
        AttitudeError
            Without a path and vectors, and for sites that are not known.

        Notes
        -----
        Light time as in `Scene`; dates of light at the barycenter of the solar system are converted
        to those of reception first, to 1e-6 s for a body beyond 0.01 au.
        """

        return reduced(self, path, site=site, phase_function=phase_function, g=g)

    def table(self) -> QTable:
        """A row for each point, with Times and units."""
        from astropy import units
        from astropy.table import QTable

        unit = units.dimensionless_unscaled if self.is_flux else units.mag
        found = QTable({"time": self.times})
        found["flux" if self.is_flux else "magnitude"] = self.value * unit
        found["sigma"] = self.sigma * unit
        for key in _WORDS:
            words = getattr(self, f"{key}s")
            if any(words):
                found[key] = [words[k] for k in getattr(self, key)]
        found.meta = {key: str(getattr(self, key)) for key in ("name", "time_of")}
        return found

    def write(self, path: FilePath) -> None:
        """Write the points as a CSV with named columns, which `photometry.read` reads.

        Raises
        ------
        AttitudeError
            If the file cannot be written.
        """

        write(path, self)

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure of the points against time; saved if a path is given."""
        from attitude.photometry import _figures

        return _figures.of_photometry(self, path)


def _brightness(magnitude: Any, flux: Any, sigma: Any, count: int) -> tuple[FloatArray, FloatArray]:
    if (magnitude is None) == (flux is None):
        raise AttitudeError("give either magnitude or flux, of each epoch.")
    name, given = ("magnitude", magnitude) if flux is None else ("flux", flux)
    unit = getattr(given, "unit", None) if flux is not None else None
    values = _plain(given, name, unit, "mag" if flux is None else None)
    if values.shape != (count,):
        raise AttitudeError(f"{name} has shape {values.shape}; give one for each of {count} times.")
    errors = np.full(count, np.nan)
    if sigma is not None:
        found = _plain(sigma, "sigma", unit, "mag" if flux is None else None, finite=False)
        errors = np.broadcast_to(found, (count,)).copy()
        if np.any(errors < 0.0):
            raise AttitudeError("sigma has entries below zero; give standard errors.")
        errors[~np.isfinite(errors) | (errors == 0.0)] = np.nan
    return values, errors


def _plain(given: Any, name: str, unit: Any, own: str | None, finite: bool = True) -> FloatArray:
    """Numbers in `own`, or of Quantities in the unit of the flux."""
    if unit is not None and hasattr(given, "unit"):
        given = getattr(given, "quantity", given).to_value(unit)
    return validation.real(given, name, finite=finite, unit=own)


def numbered(given: Any, count: int, name: str) -> tuple[tuple[str, ...], IntArray]:
    """The names of filters, sites or sessions, and the number of each of `count` points."""
    if given is None:
        return ("",), np.zeros(count, np.int64)
    array = np.asarray(given)
    if array.shape == ():
        array = np.full(count, array)
    if array.shape != (count,):
        raise AttitudeError(
            f"{name} has shape {array.shape}; give one for each of {count} points, text or numbers."
        )
    words, numbers = np.unique(array.astype(str), return_inverse=True)
    return tuple(words.tolist()), numbers.astype(np.int64)


def _vectors(given: Any, name: str, frame: str, order: IntArray) -> FloatArray | None:
    if given is None:
        return None
    vectors = validation.real(given, name, unit="m")
    if vectors.shape not in ((len(order), 3), (3,)):
        raise AttitudeError(
            f"{name} has shape {vectors.shape}; give a vector for each of {len(order)} epochs."
        )
    turned = np.broadcast_to(vectors, (len(order), 3)) @ frames.matrix_to_icrf(frame).T
    return frozen(np.ascontiguousarray(turned[order]))


# ---- Photometry as CSV with named columns

# Names of the columns of dates that are not those of an observer.
_COLUMN_OF_CENTER = {"barycenter": "bjd_tdb", "heliocenter": "hjd"}

# What a spreadsheet runs as a formula; a sign before a number is none.
_FORMULA = re.compile(r"[=@]|[+-](?![\d., +-]*(deg)?$)")


def write(path: FilePath, data: Photometry) -> None:
    """Write the points as CSV; see `Photometry.write`.

    Dates at the barycenter or the Sun are Julian dates, others ISO dates in UTC; vectors to Sun and
    observer are in au over the axes of ICRF.  What the dates and the brightness mean stands in the
    remarks above the names.
    """
    center = _COLUMN_OF_CENTER.get(data.time_of)
    brightness = "flux" if data.is_flux else "reduced_mag" if data.unit_distances else "mag"
    names = [
        center or ("utc_emission" if data.time_of == "emission" else "utc"),
        brightness,
        "sigma",
    ]
    if center:
        time = data.times.tdb if center == "bjd_tdb" else data.times.utc
        dates = [
            f"{np.longdouble(a) + np.longdouble(b):.12f}"
            for a, b in zip(time.jd1, time.jd2, strict=True)
        ]
    else:
        dates = ccsds_epochs.texts(data.epoch, data.seconds, None, "utc")
    columns: list[list[str]] = [list(dates), [repr(float(each)) for each in data.value]]
    columns.append([repr(float(each)) if each > 0.0 else "" for each in data.sigma])
    for key in ("filter", "site", "session"):
        words = getattr(data, f"{key}s")
        if any(words):
            names.append(key)
            cells = [_cell(word) for word in words]
            columns.append([cells[k] for k in getattr(data, key)])
    for key in ("sun", "observer"):
        vectors = getattr(data, key)
        if vectors is not None:
            names += [f"{key}_{axis}" for axis in "xyz"]
            columns += [[repr(float(x)) for x in each] for each in vectors.T / ASTRONOMICAL_UNIT_M]
    with written_whole(path, "photometry") as file:
        file.write(f"# {_remark(data.name or 'photometry')}: times of {data.time_of}\n")
        file.write(",".join(names) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*columns, strict=True))


def _cell(word: str) -> str:
    """A word as a cell: in quotes where CSV needs them, behind ' where a spreadsheet would run it.

    >>> print(_cell("T, W"), _cell("=1+A1"), _cell("-70.7, -30.2 deg"))
    "T, W" "'=1+A1" "-70.7, -30.2 deg"
    """
    word = " ".join(word.split())
    runs = _FORMULA.match(word) is not None
    if not runs and not any(mark in word for mark in ',;"'):
        return word
    return '"' + ("'" if runs else "") + word.replace('"', '""') + '"'


def _remark(text: str) -> str:
    """A text on one line whose parts between separators are no formulas."""
    return re.sub(r"[,;]\s*(?=[=+@-])", " ", " ".join(text.split()))
