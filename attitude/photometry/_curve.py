"""`LightCurve`: brightness at epochs with errors, sessions and sites, and the geometry of each."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from attitude import frames
from attitude._support import markup, quantity_text, validation
from attitude._support.arrays import Immutable, between, frozen
from attitude._support.constants import (
    ASTRONOMICAL_UNIT_M,
    DAY_S,
    MAGNITUDES_PER_E,
    SPEED_OF_LIGHT_M_S,
)
from attitude._support.quantity_text import counted, quoted
from attitude._support.synonyms import arguments
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import path_text
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _inputs, _instants
from attitude.epochs._instants import J2000, Instant
from attitude.errors import AttitudeError
from attitude.paths import _composed, _places
from attitude.paths._path import Path, Place
from attitude.photometry import _files
from attitude.photometry._files import PLACES, BadRow
from attitude.scattering import _weighted

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

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
    from attitude.scene._scene import Scene

    Site = Place | str | ArrayLike | Mapping[str, Any]


_WORDS = ("filter", "site", "session")
_AS_GIVEN = ("epoch", "time_of", "unit_distances", "zero_phase", "notes", "name", "zero_points")
# Latitude of the Sun, deg, as seen from the Earth, at most.
_ON_ECLIPTIC = 0.1
# Rounds of the correction of a date at the barycenter or the body: each gains four digits.
_ROUNDS = 4
# Part of the median error below which normal equations in doubles lose the other points.
_SMALL = 1e-5
_CENTERS: Final = {"barycenter": "ssb", "heliocenter": "sun"}
WAYS: Final = "sun= and observer= (vectors from the body), scene=, or path= with site="


_HINTS = {
    **dict.fromkeys(("jd", "mjd", "t", "time"), "give times=, such as an astropy Time"),
    **dict.fromkeys(("mag", "mags", "magnitudes", "values", "y"), "give magnitude="),
    **dict.fromkeys(("err", "error", "errors", "uncertainty"), "give sigma="),
    **dict.fromkeys(("band", "filters"), "give filter="),
    "orbit": "give path=",
}


@dataclass(frozen=True, eq=False, init=False)
class LightCurve(Immutable):
    """The brightness of a body at epochs, in time order, with the geometry if it is known.

    Parameters
    ----------
    times : array_like of N epochs
        Time objects, dates, or plain TDB seconds since `epoch`.
    magnitude, flux : (N,) array_like
        One of them; Quantities, or flux in any linear unit.
    sigma : (N,) array_like or float, optional
        Standard errors in the unit of the brightness; zero, NaN and masked ones are unknown.
    sun, observer : (N, 3) array_like, optional
        Vectors from the body, m or Quantities, over the axes of `frame`; of the observer, to where
        the light of the body arrived from where the body was when it left.
    scene : Scene, optional
        In place of sun and observer: its places, light time included; of a scene without light
        time, times are those of emission.
    path : Path, name, file or text, optional
        In place of both: the path of the body, with `site`.
    site : (N,) array_like of text, or one place, or dict, optional
        The site of each point: codes or names of observatories, longitude and latitude; one place
        for all points, also a Path; or the places by the names of the sessions.  Points without a
        site are of the centre of the Earth.
    places : dict, optional
        The places by the names of sites, where they are not known by these names.
    session, filter : (N,) array_like of text or numbers, or one text, optional
        The session (night, observer) and the filter of each point.
    exposure : float, text or (N,) array_like, optional
        Exposure times, s, of which the epochs are the middles; zero and NaN are unknown.
    zero_points : str, float or sequence
        What sessions share: "auto" (those given are calibrated to 0.1 mag unless the curve shows
        otherwise), "shared", "free", a standard deviation in mag, or the names of the sessions
        that have zero points of their own.  Filters always have their own.
    time_of : str
        Where light is at `times`: "reception" by the observer, "emission" by the body, at the
        "barycenter" of the solar system (BJD), or the "heliocenter" (HJD); the last two become
        reception where `path` is given.
    light_time : bool
        False: the same as time_of="emission".
    unit_distances : bool
        Whether the brightness is that at 1 au from Sun and observer.
    zero_phase : bool
        Whether it is that at zero phase angle.
    epoch : epoch, optional
        To which plain seconds refer; J2000.
    frame : str
        Axes of the vectors: "icrf", "ecliptic", ...
    name : str, optional
        Of the body.
    bad : sequence of BadRow
        Rows of the file that were left out.
    notes : sequence of str
    labels : sequence of str, optional
        Of the points, such as lines of a file, which notes name.

    Attributes
    ----------
    epoch : Instant
        The middle of the epochs, to the second; of those of emission if the geometry is known.
    seconds : (N,) array
        TDB s from the epoch.
    value, sigma : (N,) arrays
        Magnitudes or fluxes; NaN where the error is unknown.
    is_flux : bool
    filter, site, session : (N,) arrays of int
        Numbers into the tuples `filters`, `sites` and `sessions` of str.
    exposure : (N,) array
        s; zero where it is unknown.
    sun, observer : (N, 3) arrays or None
        m, ICRF.
    scenes : dict
        The Scene of each site, where path= or scene= was given.
    notes : tuple of str
        What was assumed or is doubtful: epochs that occur twice in one session and filter, which
        are averaged, a frame in which the Sun leaves the ecliptic, notes of the file.
    zero_points, time_of, unit_distances, zero_phase, name, bad
        As given.

    Raises
    ------
    AttitudeError
        For arrays of other lengths, numbers that are not finite, errors below zero, geometry that
        is given twice or by half, and sites that are not known.

    >>> data = LightCurve(["2026-01-01", "2026-01-02"], magnitude=[15.0, 15.5], filter="V")
    >>> data
    <LightCurve: 2 magnitudes in V over 24 h about 2026-01-01>
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
    exposure: FloatArray
    sun: FloatArray | None
    observer: FloatArray | None
    scenes: dict[str, Scene]
    zero_points: str | float | tuple[str, ...]
    time_of: str
    unit_distances: bool
    zero_phase: bool
    name: str | None
    bad: tuple[BadRow, ...]
    notes: tuple[str, ...]

    @arguments(
        _HINTS,
        "LightCurve(times, magnitude, sigma, path=orbit, site=site)",
    )
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
        path: Path | str | None = None,
        site: Site | None = None,
        places: Mapping[str, Any] | None = None,
        session: ArrayLike | None = None,
        filter: ArrayLike | None = None,
        exposure: Reals | None = None,
        zero_points: str | float | Sequence[str] = "auto",
        time_of: str = "reception",
        light_time: bool = True,
        unit_distances: bool = False,
        zero_phase: bool = False,
        epoch: Epoch | None = None,
        frame: str = "icrf",
        name: str | None = None,
        bad: Sequence[BadRow] = (),
        notes: Sequence[str] = (),
        labels: Sequence[str] | None = None,
    ) -> None:
        start, t = _seconds(times, epoch)
        values, errors = _brightness(magnitude, flux, sigma, len(t))
        refuse_small(errors, None if flux is None else values, "sigma", labels)
        site, places = _sites(site, places, session)
        named = [
            _numbered(words, word, len(t))
            for words, word in zip((filter, site, session), _WORDS, strict=True)
        ]
        notes = list(notes)
        rows, values, errors = _without_twice(start, t, named, values, errors, labels, notes)
        self._set_all(is_flux=flux is not None, value=frozen(values), sigma=frozen(errors))
        for key, (words, numbers) in zip(_WORDS, named, strict=True):
            self._set(key, frozen(numbers[rows]))
            self._set(f"{key}s", words)
        self._set("exposure", frozen(_exposures(exposure, len(t))[rows]))
        self._set("zero_points", _known_zero_points(zero_points, self.sessions))
        validation.one_of(time_of, "time_of", PLACES)
        time_of = time_of if validation.flag(light_time, "light_time") else "emission"
        vectors = _vectors(sun, observer, frame, rows, len(t), notes)
        self._set("scenes", _scenes(vectors is not None, scene, path, places, self.sites))
        t = t[rows]
        if self.scenes:
            vectors, received = _of_scenes(self.scenes, self.sites, self.site, start, t, time_of)
            t, time_of = (received, "reception") if time_of in _CENTERS else (t, time_of)
            if not all(scene.light_time for scene in self.scenes.values()):
                time_of = "emission"  # which is reception there
        late = _late(vectors, time_of)
        middle = float(np.round(0.5 * ((t - late).min() + (t - late).max())))
        self._set("epoch", start.after(middle))
        self._set("seconds", frozen(t - middle))
        for k, key in enumerate(("sun", "observer")):
            self._set(key, None if vectors is None else frozen(vectors[k]))
        self._set("time_of", time_of)
        self._set("unit_distances", validation.flag(unit_distances, "unit_distances"))
        self._set("zero_phase", validation.flag(zero_phase, "zero_phase"))
        self._set("name", name)
        self._set("bad", tuple(bad))
        self._set("notes", tuple(dict.fromkeys(notes)))

    @classmethod
    @arguments({}, 'LightCurve.read("curve.csv"); path= is the orbit of the body')
    def read(
        cls,
        path: FilePath,
        /,
        *,
        format: str | None = None,
        columns: Mapping[str, str] | None = None,
        bad: str = "warn",
        encoding: str | None = None,
        **replacing: Any,
    ) -> Self:
        """The light curve in a file.

        Parameters
        ----------
        path : str or path
            CSV or other separated text and ECSV with named columns (`attitude.photometry._files`
            lists the names), ALCDEF, ADES in PSV or XML, MPC records of 80 columns, DAMIT.
        format : str, optional
            One of "csv", "ecsv", "alcdef", "ades-psv", "ades-xml", "mpc" and "damit"; by default
            from the content.
        columns : dict, optional
            For named columns: the name in the file, by the name it stands for, such as
            {"magnitude": "Vcal", "jd": "T"}.
        bad : "warn", "refuse" or "ignore"
            What happens if rows cannot be used: a warning that names their lines and reasons, an
            error, or neither.  `LightCurve.bad` lists them.
        encoding : str, optional
            Of the text, as Python names it; by default UTF-8, or with a note Latin-1 where it is
            not.
        **replacing
            Keywords of the class, which replace those of the file; geometry that the file does not
            have (``path=``, ``site=``), `frame`, `zero_points`, `exposure`.

        Raises
        ------
        AttitudeError
            For a file that cannot be read, an unknown format, a file without any usable row, and
            as the class.
        """
        replaced = dict(replacing)
        opened = _files.opened(path, format=format, columns=columns, bad=bad, encoding=encoding)
        keywords = {key: value for key, value in opened.items() if key != "rows"}
        if any(key in replaced for key in ("scene", "path", "sun", "observer")):
            for key in ("sun", "observer", "frame"):
                keywords.pop(key, None)
        elif "frame" in keywords and "frame" in replaced:
            # that of the file holds, but it has to be one
            frames.matrix_to_icrf(replaced.pop("frame"))
        if "flux" in replaced or "magnitude" in replaced:
            keywords.pop("flux", None)
            keywords.pop("magnitude", None)
        if isinstance(replaced.get("site"), Mapping) and "site" in keywords:
            replaced["places"] = replaced.pop("site")
        return cls(**keywords | replaced)

    # ---- What it holds

    def __len__(self) -> int:
        return len(self.seconds)

    def __repr__(self) -> str:
        what = ("flux", "fluxes") if self.is_flux else ("magnitude",)
        words = [counted(len(self), *what)]
        bands = ", ".join(band for band in self.filters if band)
        if bands:
            words.append(f"in {quoted(bands, 60, '')}")
        if len(self.sessions) > 1:
            words.append(f"in {len(self.sessions)} sessions")
        span = quantity_text.of_time(self.span, 4)
        words.append(f"over {span} about {self.epoch.utc_iso[:10]}")
        name = f" of {quoted(self.name, 60, '')}" if self.name else ""
        return f"<LightCurve{name}: {' '.join(words)}>"

    def _repr_html_(self) -> str:
        """A table for notebooks, and the brightness against time."""
        days = (self.seconds - self.seconds[:1]) / DAY_S
        rows = [
            ("points", f"{len(self)}{' fluxes' if self.is_flux else ''}"),
            ("sessions", str(len(self.sessions))),
            ("filters", ", ".join(band for band in self.filters if band) or "-"),
            ("span", f"{quantity_text.of_time(self.span)} about {self.epoch.utc_iso} UTC"),
            ("errors", f"{np.nanmedian(self.sigma):.3g} (median)" if np.any(self.sigma) else "-"),
            ("geometry", "known" if self.has_geometry else "not known"),
        ]
        picture = markup.line_plot(
            [(days, self.value)],
            f"{'flux' if self.is_flux else 'magnitude'} over {quantity_text.of_time(self.span, 4)}",
            is_downward=not self.is_flux,
            is_dotted=True,
        )
        return markup.table(f"Light curve {self.name or ''}".strip(), rows, picture)

    @property
    def times(self) -> Time:
        """The epochs (N,) as an astropy Time in TDB."""
        return _instants.times(self.epoch, self.seconds)

    @property
    def has_geometry(self) -> bool:
        """Whether the vectors to Sun and observer are known."""
        return self.sun is not None

    @property
    def vectors(self) -> tuple[FloatArray, FloatArray]:
        """Vectors (N, 3) to Sun and observer, m, ICRF; AttitudeError if they are not known."""
        if self.sun is None or self.observer is None:
            raise AttitudeError(
                f"the light curve has no vectors to Sun and observer; give {WAYS}, as in "
                'LightCurve.read(file, path="orbit.oem", site="568") or curve.reduced(path).'
            )
        return self.sun, self.observer

    @property
    def emission(self) -> FloatArray:
        """TDB s (N,) from the epoch, at which the light left the body."""
        vectors = self.vectors
        if self.time_of in _CENTERS:
            raise AttitudeError(
                f"the dates of the light curve are those of light at the {self.time_of}; give "
                "path=, as in LightCurve.read(file, path=orbit), which converts them."
            )
        return self.seconds - _late(vectors, self.time_of)

    @property
    def span(self) -> float:
        """From the first to the last epoch, s; of emission if the geometry is known."""
        is_known = self.has_geometry and self.time_of not in _CENTERS
        return float(np.ptp(self.emission if is_known else self.seconds))

    @property
    def magnitude(self) -> FloatArray:
        """Magnitudes (N,); of fluxes -2.5 log10, which have an unknown zero point."""
        if not self.is_flux:
            return self.value
        wrong = int(np.count_nonzero(self.value <= 0.0))
        if wrong:
            verb = counted(wrong, "flux is", "fluxes are")
            raise AttitudeError(
                f"{verb} not above zero, and {'has' if wrong == 1 else 'have'} no magnitude; leave "
                "such points out, or add the background that was taken off too much."
            )
        return -2.5 * np.log10(self.value)

    @property
    def magnitude_sigma(self) -> FloatArray:
        """Errors (N,) of the magnitudes, NaN where they are unknown."""
        return MAGNITUDES_PER_E * self.sigma / np.abs(self.value) if self.is_flux else self.sigma

    @property
    def dimming(self) -> FloatArray:
        """Magnitudes (N,) by which distances make the values fainter than they are at 1 au."""
        if self.unit_distances:
            return np.zeros(len(self))
        return dimming(*self.vectors)

    @property
    def reduced_magnitude(self) -> FloatArray:
        """Magnitudes (N,) at 1 au from Sun and observer."""
        return self.magnitude - self.dimming

    @property
    def phase_angle(self) -> FloatArray:
        """Angle (N,) at the body between Sun and observer, rad."""
        return angle_between(*self.vectors)

    def __getitem__(self, which: Any) -> LightCurve:
        """The points of a mask, of a slice or of whole numbers."""
        chosen = np.atleast_1d(np.arange(len(self))[which])
        if not chosen.size:
            raise AttitudeError("no point is left; choose others.")
        return self.replaced(chosen)

    def select(
        self, *, filter: str | None = None, site: str | None = None, session: str | None = None
    ) -> LightCurve:
        """The points with a filter, of a site, of a session; AttitudeError if there are none."""
        mask = np.ones(len(self), bool)
        for key, word in (("filter", filter), ("site", site), ("session", session)):
            if word is not None:
                words = getattr(self, f"{key}s")
                if str(word) not in words:
                    allowed = f"it must be one of {_listed(words)}"
                    raise AttitudeError(
                        f"{key} is {quoted(str(word))}"
                        + (f"; {allowed}." if any(words) else f", but no point has a {key}.")
                    )
                mask &= getattr(self, key) == words.index(str(word))
        return self[mask]

    def replaced(self, chosen: IntArray | None = None, **changes: Any) -> LightCurve:
        """The points with these numbers, all by default, with other values of attributes.

        `changes` are keywords of the class; arrays are those of the chosen points.
        """
        try:
            which = np.arange(len(self))[slice(None) if chosen is None else chosen]
        except (IndexError, ValueError):
            raise AttitudeError(
                f"chosen is {quoted(chosen)}; give whole numbers from 0 to {len(self) - 1}."
            ) from None
        keywords = {key: getattr(self, key) for key in _AS_GIVEN}
        keywords |= {"bad": self.bad, "exposure": self.exposure[which]}
        keywords |= self._words(which)
        for key in ("sun", "observer"):
            vectors = getattr(self, key)
            keywords[key] = None if vectors is None else vectors[which]
        keywords["flux" if self.is_flux else "magnitude"] = self.value[which]
        keywords |= {"times": self.seconds[which], "sigma": self.sigma[which]}
        if changes.keys() & {"magnitude", "flux"}:
            for key in ("magnitude", "flux"):
                keywords.pop(key, None)
        if isinstance(self.zero_points, tuple) and "zero_points" not in changes:
            left = set(keywords.get("session", ()) if "session" not in changes else ())
            keywords["zero_points"] = tuple(label for label in self.zero_points if label in left)
        curve = LightCurve(**keywords | changes)
        if not curve.scenes:
            kept = {key: path for key, path in self.scenes.items() if key in curve.sites}
            curve._set("scenes", kept)
        return curve

    def _words(self, which: Any = slice(None)) -> dict[str, list[str]]:
        """The filter, site and session of some points, where these have names."""
        return {
            key: [words[k] for k in getattr(self, key)[which]]
            for key in _WORDS
            if any(words := getattr(self, f"{key}s"))
        }

    # ---- What it becomes

    def shared(self) -> LightCurve:
        """The same points as one session, so that all share a zero point (filters keep theirs)."""
        return self.replaced(session=None, zero_points="auto")

    def reduced(
        self,
        path: Path | str | None = None,
        *,
        site: Site | None = None,
        phase_function: Any = None,
        g: Real | None = None,
    ) -> LightCurve:
        """At 1 au from Sun and observer, at the times at which the light left the body.

        Parameters
        ----------
        path : Path, optional
            Of the body; not needed where the geometry is known.
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
        LightCurve
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
        if path is not None:
            where = "places" if isinstance(site, Mapping) and any(self.sites) else "site"
            changes: dict[str, Any] = {} if site is None else {where: site}
            return self.replaced(sun=None, observer=None, path=path, **changes).reduced(
                phase_function=phase_function, g=g
            )
        shift = -self.dimming
        function = _phase_function(phase_function, g)
        if function is not None:
            if self.zero_phase:
                raise AttitudeError("the light curve is at zero phase angle already.")
            shift -= function(self.phase_angle) - function(np.zeros(1))[0]
        changed: dict[str, Any] = {"magnitude": self.value + shift}
        if self.is_flux:
            factor = 10.0 ** (-0.4 * shift)
            changed = {"flux": self.value * factor, "sigma": self.sigma * factor}
        return self.replaced(
            times=self.emission,
            time_of="emission",
            unit_distances=True,
            zero_phase=self.zero_phase or function is not None,
            **changed,
        )

    def table(self) -> QTable:
        """A row for each point, with Times and units."""
        from astropy import units
        from astropy.table import QTable

        unit = units.dimensionless_unscaled if self.is_flux else units.mag
        table = QTable({"time": self.times})
        table["flux" if self.is_flux else "magnitude"] = self.value * unit
        table["sigma"] = self.sigma * unit
        for key, words in self._words().items():
            table[key] = words
        if np.any(self.exposure):
            table["exposure"] = self.exposure * units.s
        table.meta = {key: str(getattr(self, key)) for key in ("name", "time_of")}
        return table

    def write(self, path: FilePath) -> None:
        """Write the points as a CSV (.csv) with named columns, which `LightCurve.read` reads.

        Dates at the barycenter or the Sun are Julian dates, others ISO dates in UTC; vectors to Sun
        and observer are in au over the axes of ICRF.  What the dates are stands in the remark above
        the names.

        Raises
        ------
        AttitudeError
            For another ending, and if the file cannot be written.
        """
        if os.path.splitext(path_text(path))[1].lower() != ".csv":
            raise AttitudeError(
                f"the file of photometry is {os.fspath(path)!r}; it is written as CSV: give a name "
                "that ends in .csv."
            )
        center = _COLUMN_OF_CENTER.get(self.time_of)
        columns: dict[str, list[str]] = {}
        if center:
            time = self.times.tdb if center == "bjd_tdb" else self.times.utc
            columns[center] = [
                f"{Decimal(a) + Decimal(b):.12f}" for a, b in zip(time.jd1, time.jd2, strict=True)
            ]
        else:
            key = "utc_emission" if self.time_of == "emission" else "utc"
            columns[key] = ccsds_epochs.texts(self.epoch, self.seconds, None, "utc")
        key = ("reduced_" if self.unit_distances else "") + ("flux" if self.is_flux else "mag")
        columns[key] = [repr(float(number)) for number in self.value]
        columns["sigma"] = [repr(float(number)) if number > 0.0 else "" for number in self.sigma]
        columns |= {key: list(map(cell, words)) for key, words in self._words().items()}
        if self.zero_phase:
            columns["zero_phase"] = ["yes"] * len(self)
        if self.zero_points != "auto":
            columns["zero_points"] = self._zero_points_of_rows()
        if np.any(self.exposure):
            columns["exposure"] = [repr(float(t)) if t > 0.0 else "" for t in self.exposure]
        for key in ("sun", "observer"):
            vectors = getattr(self, key)
            if vectors is not None:
                for axis, numbers in zip("xyz", vectors.T / ASTRONOMICAL_UNIT_M, strict=True):
                    columns[f"{key}_{axis}"] = [repr(float(x)) for x in numbers]
        # On one line, whose parts between separators are no formulas.
        name = re.sub(r"[,;]\s*(?=[=+@-])", " ", " ".join((self.name or "").split()))
        with written_whole(path, "photometry") as file:
            file.write(f"# {name}{': ' * bool(name)}times of {self.time_of}\n")
            file.write(",".join(columns) + "\n")
            file.writelines(",".join(row) + "\n" for row in zip(*columns.values(), strict=True))

    def _zero_points_of_rows(self) -> list[str]:
        """Zero points as a column of a file, "free" or "shared" by sessions, or a number."""
        if not isinstance(self.zero_points, tuple):
            return [str(self.zero_points)] * len(self)
        words = ["free" if name in self.zero_points else "shared" for name in self.sessions]
        return [words[k] for k in self.session]

    def plot(self, path: FilePath | None = None) -> Any:
        """A figure of the points against time; saved if a path is given."""
        from attitude.photometry import _figures

        return _figures.of_light_curve(self, path)


# ---- Arguments of the class


def _seconds(times: Any, epoch: Any) -> tuple[Instant, FloatArray]:
    """The middle of epochs, and seconds (N,) from it."""
    start = J2000 if epoch is None else _inputs.instant(epoch)
    seconds = _inputs.seconds_since(start, times, name="times")
    hi = seconds.hi
    if hi.ndim != 1 or not hi.size or not np.all(np.isfinite(hi)):
        raise AttitudeError(
            f"times has shape {hi.shape} and {np.count_nonzero(~np.isfinite(hi))} entries that "
            "are not epochs; give a list of N epochs."
        )
    middle = float(np.round(0.5 * (hi.min() + hi.max())))
    return start.after(middle), (hi - middle) + seconds.low


def _brightness(magnitude: Any, flux: Any, sigma: Any, count: int) -> tuple[FloatArray, FloatArray]:
    if (magnitude is None) == (flux is None):
        raise AttitudeError("give either magnitude or flux, of each epoch.")
    name, brightness = ("magnitude", magnitude) if flux is None else ("flux", flux)
    unit, usual = (None, "mag") if flux is None else (getattr(flux, "unit", None), None)
    values = _plain(brightness, name, unit, usual)
    if values.shape != (count,):
        raise AttitudeError(f"{name} has shape {values.shape}; give one for each of {count} times.")
    wrong = np.flatnonzero(~np.isfinite(values))
    if len(wrong):
        raise AttitudeError(
            f"{name} holds {len(wrong)} entries that are not finite, the first at row {wrong[0]}; "
            "leave these points out."
        )
    if sigma is None:
        return values, np.full(count, np.nan)
    if hasattr(sigma, "filled"):  # masked errors are unknown
        sigma = sigma.astype(float).filled(np.nan)
    errors = _of_each(_plain(sigma, "sigma", unit, usual), "sigma", count, "times").copy()
    if np.any(errors < 0.0):
        raise AttitudeError("sigma has entries below zero; give standard errors.")
    errors[~np.isfinite(errors) | (errors == 0.0)] = np.nan
    return values, errors


def refuse_small(
    errors: FloatArray, flux: FloatArray | None, name: str, labels: Sequence[str] | None = None
) -> None:
    """AttitudeError for errors (N,) so small that fits would lose all points beside them.

    With fluxes, which may have other units in other sessions, those alone that are small for the
    flux too.
    """
    known = errors[errors > 0.0]
    least = _SMALL * float(np.median(known)) if known.size else 0.0
    small = errors < least
    if flux is not None:
        small &= (errors < _SMALL * np.abs(flux)) | (flux == 0.0)
    if np.any(small):
        k = int(np.flatnonzero(small)[0])
        raise AttitudeError(
            f"{name} is {errors[k]:.3g} at {f'row {k}' if labels is None else labels[k]}, and the "
            f"median is {least / _SMALL:.3g}; give errors of at least {_SMALL:g} of the median, or "
            "leave such points out."
        )


def _plain(numbers, name, unit, own_unit):
    """Numbers in `own`, or of Quantities in the unit of the flux."""
    if unit is not None and hasattr(numbers, "unit"):
        numbers = getattr(numbers, "quantity", numbers).to_value(unit)
    return validation.real(numbers, name, finite=False, unit=own_unit)


def _of_each(numbers, name, count, what):
    """Numbers () or (N,) as (N,), read-only."""
    if numbers.shape not in ((), (count,)):
        raise AttitudeError(
            f"{name} has shape {numbers.shape}; give one number, or one for each of {count} {what}."
        )
    return np.broadcast_to(numbers, (count,))


def _numbered(labels: Any, name: str, count: int) -> tuple[tuple[str, ...], IntArray]:
    """The names of filters, sites or sessions, and the number of each of `count` points."""
    if labels is None:
        return ("",), np.zeros(count, np.int64)
    array = np.asarray(labels)
    if array.shape == ():
        array = np.full(count, array)
    if array.shape != (count,):
        raise AttitudeError(
            f"{name} has shape {array.shape}; give one for each of {count} points, text or numbers."
        )
    words, numbers = np.unique(array.astype(str), return_inverse=True)
    return tuple(words.tolist()), numbers.reshape(-1).astype(np.int64)


def _sites(site: Any, places: Any, session: Any) -> tuple[Any, dict[str, Any]]:
    """The names of the sites of the points, and the places that are given by name."""
    known = {} if places is None else {str(key): place for key, place in dict(places).items()}
    if isinstance(site, Mapping):
        known |= {str(key): place for key, place in site.items()}
        if session is None:
            raise AttitudeError(
                "site is a dict, by the names of sessions, but the light curve has no sessions; "
                "give session=, or the site of each point."
            )
        return session, known
    is_array = isinstance(site, (list, tuple, np.ndarray)) and np.ndim(site) > 0
    if site is not None and not is_array and not isinstance(site, (str, int, np.integer)):
        word = str(getattr(site, "name", None) or type(site).__name__)
        return word, known | {word: site}
    return site, known


def _exposures(exposure: Any, count: int) -> FloatArray:
    """Exposure times (N,), s; zero where they are unknown."""
    if exposure is None:
        return np.zeros(count)
    numbers = validation.real(exposure, "exposure", finite=False, unit="s")
    numbers = _of_each(numbers, "exposure", count, "points")
    if np.any(numbers < 0.0) or np.any(np.isinf(numbers)):
        raise AttitudeError("exposure has entries that are not times; give s, or zero if unknown.")
    return np.nan_to_num(numbers, nan=0.0)


def _known_zero_points(
    zero_points: Any, sessions: tuple[str, ...]
) -> str | float | tuple[str, ...]:
    if isinstance(zero_points, str):
        return validation.one_of(zero_points, "zero_points", ("auto", "shared", "free"))
    if isinstance(zero_points, (list, tuple, set)):
        names = tuple(str(label) for label in zero_points)
        for label in names:
            if label not in sessions:
                raise AttitudeError(
                    f"zero_points names the session {quoted(label)}; the curve has "
                    f"{_listed(sessions)}."
                )
        return names
    return validation.positive(zero_points, "zero_points", unit="mag")


def _listed(words: Sequence[str]) -> str:
    """Names, as far as a sentence holds them."""
    return quoted(", ".join(map(repr, words)), 120, "")


def _without_twice(start, t, named, values, errors, labels, notes):
    """Rows (M,) of distinct epochs in time order, and their values and errors.

    Points of one epoch, session, filter and site are weighted means; exact repeats count once.
    """
    keys = np.stack([t, *(numbers.astype(float) for _, numbers in named)], axis=1)
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    which = which.reshape(-1)
    counts = np.bincount(which)
    if np.any(counts > 1):
        twice = np.sort(first[counts > 1])
        jd = _instants.times(start, t[twice[:1]], np.zeros(1))[0]
        label = f"row {twice[0]}" if labels is None else labels[twice[0]]
        notes.append(
            f"{counted(len(twice), 'epoch occurs', 'epochs occur')} more than once in one "
            f"session, filter and site, the first at {label}, JD {jd.jd:.6f} (TDB), "
            f"{jd.utc.isot[:19]} UTC; such points are averaged, and exact repeats count once."
        )
        pairs = np.column_stack([which.astype(float), values, np.nan_to_num(errors)])
        single = np.unique(pairs, axis=0, return_index=True)[1]
        known = np.bincount(which, np.isnan(errors)) == 0
        weights = np.where(known[which], np.nan_to_num(errors, nan=1.0), 1.0) ** -2.0
        total = np.bincount(which[single], weights[single], len(first))
        mean = np.bincount(which[single], (weights * values)[single], len(first)) / total
        values = np.where(counts > 1, mean, values[first])
        errors = np.where(counts > 1, np.where(known, total**-0.5, np.nan), errors[first])
    else:
        values, errors = values[first], errors[first]
    order = np.argsort(first, kind="stable")
    order = order[np.argsort(t[first[order]], kind="stable")]
    return first[order], values[order], errors[order]


# ---- The geometry


def _vectors(sun, observer, frame, rows, count, notes):
    """Vectors (M, 3) to Sun and observer that are given, m, ICRF, of some of `count` rows."""
    turn = frames.matrix_to_icrf(frame)
    if sun is None and observer is None:
        return None
    if sun is None or observer is None:
        raise AttitudeError(f"{'sun' if sun is None else 'observer'} is missing; give {WAYS}.")
    both = []
    for direction, name in ((sun, "sun"), (observer, "observer")):
        vectors = validation.real(direction, name, unit="m")
        if vectors.shape not in ((count, 3), (3,)):
            raise AttitudeError(
                f"{name} has shape {vectors.shape}; give a vector for each of {count} epochs."
            )
        vectors = np.broadcast_to(vectors, (count, 3)) @ turn.T
        if np.any(np.linalg.norm(vectors, axis=1) == 0.0):
            raise AttitudeError(f"{name} has a vector of length zero; give directions.")
        both.append(np.ascontiguousarray(vectors[rows]))
    _doubt_frame(frame, both[0] - both[1], notes)
    return both[0], both[1]


def _doubt_frame(frame: str, to_sun: FloatArray, notes: list[str]) -> None:
    """Note vectors (N, 3), ICRF, from observer to Sun, that fit the Earth in another frame alone.

    A spacecraft may see the Sun off the ecliptic: the frame stays as it was given.
    """
    unit = to_sun / np.maximum(np.linalg.norm(to_sun, axis=1), 1e-300)[:, None]
    directions = unit @ frames.matrix_to_icrf(frame)
    north = frames.matrix_to_icrf("ecliptic")[:, 2]
    latitude = {}
    for other_frame in dict.fromkeys((frame.lower(), "icrf", "ecliptic")):
        turned = directions @ frames.matrix_to_icrf(other_frame).T
        latitude[other_frame] = math.degrees(math.asin(min(1.0, np.abs(turned @ north).max())))
    other = min(latitude, key=lambda site: latitude[site])
    if latitude[frame.lower()] > _ON_ECLIPTIC > latitude[other]:
        notes.append(
            f"the vectors are given over the axes {frame!r}, where the observer sees the Sun up to "
            f"{latitude[frame.lower()]:.1f} degrees from the ecliptic; over {other!r} it lies on "
            "the ecliptic, as it does for the Earth. If the observer was there, give "
            f"frame={other!r}."
        )


def _scenes(has_vectors, scene, path, places, sites):
    """The scene of each site; empty where the geometry is given as vectors, or not at all."""
    from attitude.scene._scene import Scene

    ways = [has_vectors, scene is not None, path is not None]
    if sum(ways) > 1:
        raise AttitudeError(f"the geometry is given in {sum(ways)} ways; give one of {WAYS}.")
    if scene is not None:
        if not isinstance(scene, Scene):
            raise AttitudeError(f"scene is {validation.shown(scene)}; give a Scene.")
        return dict.fromkeys(sites, scene)
    if path is None:
        return {}
    body = _places.place(path, "path")
    return {name: Scene(None, body, _place(name, places)) for name in sites}


def _place(name: str, places: dict[str, Any]) -> Any:
    """The observer of points of a site."""
    if name in places:
        return _places.place(places[name], "site", is_observer=True)
    if places and not name:
        raise AttitudeError(
            f"some points have no site; the places are those of {_listed(tuple(places))}."
        )
    if not name:
        return "earth"
    try:
        return _places.place(name, "site", is_observer=True)
    except AttitudeError as err:
        raise AttitudeError(
            f"{err} Or give site= (--site) for all points, or a dict with the place of "
            f"{quoted(name)}: as site= of reduced and read, as places= of LightCurve."
        ) from None


def _of_scenes(scenes, sites, site, epoch, t, time_of):
    """Vectors (N, 3) to Sun and observer, m, ICRF, and seconds (N,) of reception."""
    sun, observer, received = np.empty((len(t), 3)), np.empty((len(t), 3)), np.array(t)
    for number, name in enumerate(sites):
        points = site == number
        if np.any(points):
            received[points] = reception(scenes[name], epoch, t[points], time_of)
            sun[points], observer[points] = vectors_of(scenes[name], epoch, received[points])
    return (sun, observer), received


def vectors_of(scene: Scene, epoch: Instant, seconds: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Vectors (N, 3) from the body to Sun and observer, m (directions: 1), ICRF, at reception."""
    view = scene.at(_instants.times(epoch, seconds, np.zeros_like(seconds)))
    both = []
    for name in ("sun", "observer"):
        is_direction = getattr(scene, name).is_direction
        distance = 1.0 if is_direction else getattr(view, f"{name}_distance")
        unit = np.broadcast_to(getattr(view, f"{name}_direction_icrf"), (len(seconds), 3))
        both.append(unit * np.reshape(distance, (-1, 1)))
    return both[0], both[1]


def reception(scene: Scene, epoch: Instant, emitted: FloatArray, time_of: str) -> FloatArray:
    """Seconds of reception from those of light at the body, or in the plane through a center."""
    if time_of == "reception" or scene.observer.is_direction or not scene.light_time:
        return emitted
    seconds = np.array(emitted)
    if time_of != "emission":
        place: Any = scene.observer
        from_center = _composed.relative(place, _CENTERS[time_of], scene.ephemeris)
    for _ in range(_ROUNDS):
        observer = vectors_of(scene, epoch, seconds)[1]
        far = np.linalg.norm(observer, axis=1)
        if time_of == "emission":
            seconds = emitted + far / SPEED_OF_LIGHT_M_S
            continue
        position = from_center.position(epoch, seconds)
        seconds = emitted + np.sum(position * observer, axis=1) / far / SPEED_OF_LIGHT_M_S
    return seconds


def _late(vectors: Any, time_of: str) -> Any:
    """Light time (N,), s, from the body to where light is at the epochs."""
    if vectors is None or time_of != "reception":
        return 0.0
    return np.linalg.norm(vectors[1], axis=1) / SPEED_OF_LIGHT_M_S


def angle_between(one: FloatArray, other: FloatArray) -> FloatArray:
    """Angles (N,) between vectors (N, 3), rad."""
    return between(one.T, other.T)


def dimming(sun: FloatArray, observer: FloatArray) -> FloatArray:
    """5 log10(r Delta) (N,), r and Delta in au, from vectors (N, 3), m."""
    size = np.linalg.norm(sun, axis=1) * np.linalg.norm(observer, axis=1)
    return 5.0 * np.log10(size / ASTRONOMICAL_UNIT_M**2)


def phase_angle(data: LightCurve) -> FloatArray:
    """Angle (N,) at the body between Sun and observer, rad; AttitudeError without vectors."""
    return data.phase_angle


def _phase_function(function: Any, g: Real | None) -> Callable[[FloatArray], FloatArray] | None:
    if function is None and g is None:
        return None
    if function is None or function == "hg":
        slope = 0.15 if g is None else validation.number(g, "g")
        return lambda alpha: _weighted.hg(alpha, 0.0, slope)
    if g is not None or not callable(function):
        raise AttitudeError(
            f"phase_function is {validation.shown(function)}; give a function of the phase angle "
            'in rad without g, or "hg" with g.'
        )
    return function


# ---- Light curves as CSV with named columns

# Names of the columns of dates that are not those of an observer.
_COLUMN_OF_CENTER = {"barycenter": "bjd_tdb", "heliocenter": "hjd"}

# What a spreadsheet runs as a formula; a sign before a number is none.
_FORMULA = re.compile(r"[=@]|[+-](?![\d., +-]*(deg)?$)")


def cell(word: str) -> str:
    """A word as a cell: in quotes where CSV needs them, behind ' where a spreadsheet would run it.

    >>> print(cell("T, W"), cell("=1+A1"), cell("-70.7, -30.2 deg"))
    "T, W" "'=1+A1" "-70.7, -30.2 deg"
    """
    word = " ".join(word.split())
    runs = _FORMULA.match(word) is not None
    if not runs and not any(mark in word for mark in ',;"'):
        return word
    return '"' + ("'" if runs else "") + word.replace('"', '""') + '"'
