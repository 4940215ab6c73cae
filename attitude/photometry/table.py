"""`Photometry`: the brightness of one body at epochs, with errors, filters, sites and sessions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import epochs, frames, validation
from attitude.epochs.instants import Instant
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.photometry.contents import PLACES, BadRow
from attitude.spectrum.samples import HasSamples, Samples

if TYPE_CHECKING:
    from collections.abc import Sequence

    from astropy.table import QTable
    from astropy.time import Time
    from numpy.typing import ArrayLike

    from attitude.annotations import Epoch, Epochs, FilePath, FloatArray, IntArray, Real, Reals
    from attitude.paths import Path

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
        start = _J2000 if epoch is None else epochs.instant(epoch)
        hi, lo = epochs.seconds_since(start, times, name="times")
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

    # What it holds --------------------------------------------------------------------------------

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
        return epochs.times(self.epoch, self.seconds)

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

    # What it becomes ------------------------------------------------------------------------------

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

        Parameters, errors and accuracy as of `attitude.photometry.reduction.reduced`.
        """
        from attitude.photometry import reduction

        return reduction.reduced(self, path, site=site, phase_function=phase_function, g=g)

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
        from attitude.photometry import writing

        writing.write(path, self)

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure of the points against time; saved if a path is given."""
        from attitude.photometry import figures

        return figures.of_photometry(self, path)


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
    """The names of filters, sites or sessions, and the number of each of `count` points.

    Raises
    ------
    AttitudeError
        For another shape than one text, or one entry for each point; `name` is in the message.
    """
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
