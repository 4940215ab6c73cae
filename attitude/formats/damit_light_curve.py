"""Light curves of asteroids with their geometry, in files of DAMIT (lc.txt)."""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from attitude import frames
from attitude._support import pairs, validation
from attitude._support.arrays import Immutable, frozen
from attitude._support.constants import ASTRONOMICAL_UNIT_M
from attitude._textfiles.atomic_write import written_whole
from attitude._textfiles.lines import cut, is_number, opened
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError, AttitudeWarning

if TYPE_CHECKING:
    from astropy.time import Time
    from numpy.typing import ArrayLike

    from attitude._support.annotations import Epoch, Epochs, FilePath, FloatArray, Reals

__all__ = [
    "DamitLightCurve",
    "from_positions",
    "read_damit_light_curves",
    "write_damit_light_curves",
]


@dataclass(frozen=True, eq=False, repr=False, init=False)
class DamitLightCurve(Immutable):
    """One light curve of an asteroid with its geometry.

    Parameters
    ----------
    jd : (N,) array_like
        Julian dates at which the light left the asteroid.
    brightness : (N,) array_like
        Above zero, in units of intensity.
    sun, earth : (N, 3) array_like
        Vectors from the asteroid, au, ecliptic J2000 axes.
    calibrated : bool
        Whether the unit of brightness is shared with other curves.
    time_system : str
        Time scale of the dates: "UTC", "TAI", "TT", "TDB", ...  The files do not state it; they
        differ by about a minute, which does not matter for most asteroids.
    jd_low : (N,) array_like, optional
        The dates are jd + jd_low, accurate to the microsecond and below.

    Attributes
    ----------
    jd, brightness, sun, earth, jd_low : arrays
        Read-only.
    calibrated, time_system
        As given.

    Raises
    ------
    AttitudeError
        For shapes and values other than these, and intensities that are not above zero.

    >>> curve = DamitLightCurve([2460000.5], [1.0], [[1, 0, 0]], [[0, 0, 1]], calibrated=False)
    >>> curve.phase_angle
    array([1.57079633])
    """

    jd: FloatArray
    brightness: FloatArray
    sun: FloatArray
    earth: FloatArray
    calibrated: bool
    time_system: str
    jd_low: FloatArray

    def __init__(
        self,
        jd: ArrayLike,
        brightness: ArrayLike,
        sun: ArrayLike,
        earth: ArrayLike,
        calibrated: bool,
        time_system: str = "TDB",
        jd_low: ArrayLike | None = None,
    ):
        self._set("jd", frozen(validation.real(jd, "jd")))
        if self.jd.ndim != 1 or not self.jd.size:
            raise AttitudeError(f"jd has shape {self.jd.shape}; give (N,), one point or more.")
        count = len(self.jd)
        low = np.zeros(count) if jd_low is None else jd_low
        columns = {"jd_low": low, "brightness": brightness, "sun": sun, "earth": earth}
        for name, values in columns.items():
            shape = (count, 3) if name in ("sun", "earth") else (count,)
            self._set(name, frozen(validation.real(values, name, shape=shape)))
        _astropy_scale(time_system)
        self._set("time_system", time_system)
        if not isinstance(calibrated, (bool, np.bool_)):
            raise AttitudeError(f"calibrated is {calibrated!r}; give True or False.")
        self._set("calibrated", calibrated)
        for k in np.flatnonzero(~(self.brightness > 0.0))[:1]:
            raise AttitudeError(
                f"brightness[{k}] is {float(self.brightness[k])}; intensities are above zero. "
                "Convert magnitudes by 10**(-0.4 * magnitude)."
            )
        for name in ("sun", "earth"):
            for k in np.flatnonzero(~np.any(getattr(self, name), axis=1))[:1]:
                raise AttitudeError(
                    f"{name}[{k}] is zero; give the vector from the asteroid in au."
                )

    def __len__(self) -> int:
        return len(self.jd)

    def __repr__(self) -> str:
        kind = "calibrated" if self.calibrated else "relative"
        return f"<DamitLightCurve, {kind}: {len(self)} points from JD {self.jd[0]:.5f}>"

    @cached_property
    def time(self) -> Time:
        """The dates as an astropy Time in their time scale."""
        from astropy.time import Time

        scale = _astropy_scale(self.time_system)
        return Time(self.jd, self.jd_low, format="jd", scale=scale)

    def seconds_since(self, epoch: Epoch) -> tuple[FloatArray, FloatArray | None]:
        """TDB seconds since an epoch: (seconds, low), the arguments of ``motion.at``.

        The dates are corrected for light time, so that they are epochs of the motion.
        """
        return _inputs.seconds_since(_inputs.instant(epoch), self.time)

    @property
    def sun_direction(self) -> FloatArray:
        """(N, 3) unit vectors to the Sun, ICRF axes."""
        return _icrf_units(self.sun)

    @property
    def earth_direction(self) -> FloatArray:
        """(N, 3) unit vectors to the Earth, ICRF axes."""
        return _icrf_units(self.earth)

    @property
    def phase_angle(self) -> FloatArray:
        """(N,) angles at the asteroid between Sun and Earth, rad."""
        s, e = self.sun_direction, self.earth_direction
        return 2.0 * np.arctan2(
            np.sqrt(np.sum((s - e) ** 2, axis=-1)), np.sqrt(np.sum((s + e) ** 2, axis=-1))
        )

    @property
    def magnitude(self) -> FloatArray:
        """(N,) magnitudes, -2.5 lg of the brightness: relative to an unknown zero point."""
        return -2.5 * np.log10(self.brightness)


def from_positions(
    t: Epochs,
    brightness: ArrayLike,
    sun: Reals,
    earth: Reals,
    *,
    calibrated: bool,
    time_system: str = "TDB",
    frame: str = "icrf",
) -> DamitLightCurve:
    """A `DamitLightCurve` from epochs and vectors in metres.

    Parameters
    ----------
    t : astropy Time, dates
        Epochs at which the light left the asteroid; (N,).
    brightness : (N,) array_like
        Above zero, in units of intensity.
    sun, earth : (N, 3) array_like
        Vectors from the asteroid, m or a Quantity.
    calibrated : bool
        Whether the unit of brightness is shared with other curves.
    time_system : str
        Time scale of the dates of the curve.
    frame : str
        Axes of the vectors: "icrf", "gcrf", "eme2000" or "ecliptic".

    Raises
    ------
    AttitudeError
        As `DamitLightCurve`, and for epochs that cannot be read.
    """
    hi, lo = _inputs.seconds_since(_instants.J2000, t)
    instants = _instants.times(_instants.J2000, np.atleast_1d(hi), lo)
    dates = getattr(instants, _astropy_scale(time_system))
    turn = frames.matrix_to_icrf("ecliptic").T @ frames.matrix_to_icrf(frame)
    to_sun, to_earth = (
        validation.real(v, name, shape=(..., 3), unit="m") @ turn.T / ASTRONOMICAL_UNIT_M
        for v, name in ((sun, "sun"), (earth, "earth"))
    )
    jd, low = pairs.two_sum(dates.jd1, dates.jd2)
    return DamitLightCurve(jd, brightness, to_sun, to_earth, calibrated, time_system, low)


def _astropy_scale(time_system):
    """The time scale of a time system, in lower case; AttitudeError if astropy has none."""
    scale = ccsds_epochs.known(time_system, "time_system")
    if scale == "gps":
        raise AttitudeError(
            'time_system "GPS" has no Julian dates of its own; give "TAI" or "UTC".'
        )
    return scale


def _icrf_units(vectors):
    turned = vectors @ frames.matrix_to_icrf("ecliptic").T
    return turned / np.sqrt(np.sum(turned * turned, axis=-1, keepdims=True))


# ---- Light curves in the format of DAMIT (lc.txt) and of its inversion programs
#     2                                   number of light curves
#     3 1                                 points; 1: calibrated, 0: relative
#     2454035.6182 1.0421 -1.2 0.3 0.1 -0.4 0.9 0.1
#     ...
#
# Each line is one point: the Julian date corrected for light time (when the light left the
# asteroid), the brightness in units of intensity, not magnitudes, and the vectors from the asteroid
# to the Sun and to the Earth in au, over ecliptic J2000 axes.  Calibrated curves share one unit of
# brightness; a relative curve has its own.  Entries behind the eighth number of a line (with a
# warning if they are numbers) or behind the second of a header are ignored, as by DAMIT's programs.
#
# Format: M. Kaasalainen, J. Torppa, J. Durech, documentation of convexinv, in DAMIT
# (https://astro.troja.mff.cuni.cz/projects/damit); Durech, Sidorin, Kaasalainen, A&A 513, A46,
# 2010.


# What DAMIT's programs hold (constants.h of convexinv): points of a curve, curves, and points.
POINTS_OF_A_CURVE: Final = 1000
_CURVES = 100
_POINTS = 10_000

# Largest count of points in a curve; a larger number is misplaced.
_MOST = 100_000_000


def read_damit_light_curves(path: FilePath, *, time_system: str = "TDB") -> list[DamitLightCurve]:
    """All light curves of a file.

    Parameters
    ----------
    path : str or path
    time_system : str
        Time scale of the dates.

    Raises
    ------
    AttitudeError
        With file and line, for a file that does not follow the format: wrong counts, missing lines,
        numbers that cannot be read or are not finite, intensities that are not above zero.
    """
    ccsds_epochs.known(time_system, "time_system")
    with opened(path) as lines:
        rows = _rows(lines)
        header = next(rows, None)
        if header is None:
            raise lines.fault("the file is empty; a light-curve file begins with their number.", 1)
        count = _count(lines, header[0], "the number of light curves")
        longer: list[int] = []
        curves = [_curve(lines, rows, k, count, time_system, longer) for k in range(count)]
        if next(rows, None) is not None:
            raise lines.fault(
                f"there is more after the {count} light curves that line 1 announces; is their "
                "number correct?"
            )
    if longer:
        warnings.warn(
            f"{lines.path}, line {longer[0]}: it has more than eight numbers, as have "
            f"{len(longer) - 1} others; what is behind the eighth, as an exposure, is not read.",
            AttitudeWarning,
            stacklevel=2,
        )
    return curves


def write_damit_light_curves(
    path: FilePath, curves: DamitLightCurve | Iterable[DamitLightCurve]
) -> None:
    """Write light curves.

    Parameters
    ----------
    path : str or path
        Appears whole or not at all.
    curves : DamitLightCurve or list of them
        In one time system.

    Raises
    ------
    AttitudeError
        If there are no curves or they differ in time system, and if the file cannot be written.

    Notes
    -----
    DAMIT's programs hold 1000 points a curve, 100 curves and 10,000 points.  A calibrated curve
    of more points is written as several, which mean the same; of all else beyond these limits the
    function warns (`AttitudeWarning`): each part of a relative curve would have a unit of its own.

    Numbers are written with all their digits, dates to 1e-20 d.  A date without `jd_low` is
    written with the fewest digits that are read as the same `jd`; the difference between these
    decimals and the double, 20 microseconds at most, is then read as `jd_low`.
    """
    if isinstance(curves, DamitLightCurve):
        curves = [curves]
    elif not isinstance(curves, Iterable):
        raise AttitudeError(f"curves is {curves!r}; give one DamitLightCurve, or a list of them.")
    curves = list(curves)
    for item in curves:
        if not isinstance(item, DamitLightCurve):
            raise AttitudeError(
                f"{type(item).__name__} is given to be written; give DamitLightCurve objects."
            )
    if not curves:
        raise AttitudeError("there are no light curves to write; give one or more.")
    if len({ccsds_epochs.known(item.time_system, "time_system") for item in curves}) > 1:
        raise AttitudeError(
            "the light curves differ in time_system, which the file does not hold; write a file "
            "for each."
        )
    parts = [(curve, run) for curve in curves for run in _parts(curve)]
    _warn_beyond_limits(parts)
    with written_whole(path) as file:
        file.write(f"{len(parts)}\n")
        for curve, run in parts:
            file.write(f"{len(run)} {int(curve.calibrated)}\n")
            for k in run:
                numbers = (curve.brightness[k], *curve.sun[k], *curve.earth[k])
                date = _date(curve.jd[k], curve.jd_low[k])
                file.write(f"{date} {' '.join(repr(float(x)) for x in numbers)}\n")


def _parts(curve):
    """The points of a curve, cut where DAMIT's programs need it and the meaning allows it."""
    count = len(curve)
    if not curve.calibrated or count <= POINTS_OF_A_CURVE:
        return [range(count)]
    ends = np.linspace(0, count, -(-count // POINTS_OF_A_CURVE) + 1).astype(int).tolist()
    return [range(a, b) for a, b in itertools.pairwise(ends)]


def _warn_beyond_limits(parts):
    longest, total = max(len(run) for _, run in parts), sum(len(run) for _, run in parts)
    for count, limit, what in (
        (longest, POINTS_OF_A_CURVE, "points in a relative curve"),
        (len(parts), _CURVES, "curves"),
        (total, _POINTS, "points in all"),
    ):
        if count > limit:
            warnings.warn(
                f"the file holds {count} {what}, and DAMIT's programs take {limit} unless they are "
                "compiled with larger limits; write fewer, or larger values in their constants.h.",
                AttitudeWarning,
                stacklevel=3,
            )


def _rows(lines):
    """The tokens of each line that has any."""
    for line in lines:
        if b"\x00" in line:
            raise lines.fault("it holds zero bytes; is it a text file?")
        tokens = line.removeprefix(b"\xef\xbb\xbf").split()
        if tokens:
            yield tokens


def _curve(lines, rows, number, count, time_system, longer):
    where = f"light curve {number + 1} of {count}"
    header = next(rows, None)
    if header is None:
        raise lines.fault(f"the file ends before {where}.")
    points = _count(lines, header[0], f"the number of points of {where}")
    if len(header) < 2 or header[1] not in (b"0", b"1"):
        raise lines.fault(
            f"the kind of {where} is missing or not known; write 1 (calibrated) or 0 (relative) "
            "behind the number of points."
        )
    table, low = [], []
    for k in range(points):
        tokens = next(rows, None)
        if tokens is None:
            raise lines.fault(f"the file ends after {k} of the {points} points of {where}.")
        longer += [lines.number] * (len(tokens) > 8 and is_number(tokens[8]))
        table.append(_point(lines, tokens, f"point {k + 1} of {where}"))
        # The difference between the decimals of a date and its double, exact before rounding.
        low.append(float(Decimal(tokens[0].decode("ascii")) - Decimal(table[-1][0])))
    jd, brightness, sun, earth = np.split(np.array(table), [1, 2, 5], axis=1)
    is_calibrated = header[1] == b"1"
    return DamitLightCurve(
        jd[:, 0], brightness[:, 0], sun, earth, is_calibrated, time_system, np.array(low)
    )


def _point(lines, tokens, where):
    if len(tokens) < 8:
        raise lines.fault(
            f"{where} has {len(tokens)} numbers; it needs eight: date, brightness, and the vectors "
            "to the Sun and to the Earth."
        )
    for token in tokens[:8]:
        if not is_number(token) or not np.isfinite(float(token)):
            shown = token[:40].decode("utf-8", "replace")
            raise lines.fault(f"{cut(shown)} in {where} is not a finite number.")
    numbers = [float(token) for token in tokens[:8]]
    if not numbers[1] > 0.0:
        raise lines.fault(
            f"the brightness of {where} is {numbers[1]!r}; intensities are above zero. Are these "
            "magnitudes?"
        )
    for name, vector in (("Sun", numbers[2:5]), ("Earth", numbers[5:8])):
        if not any(vector):
            raise lines.fault(f"the vector to the {name} of {where} is zero.")
    return numbers


def _count(lines, token, name):
    shown = token[:40].decode("utf-8", "replace")
    if not token.isdigit() or not 0 < int(token[:20]) <= _MOST:
        raise lines.fault(f"{name} is {cut(shown)}; it must be a whole number above zero.")
    return int(token)


def _date(jd, low):
    """The sum in as many decimals as both parts need to be read back."""
    if low == 0.0:
        return repr(float(jd))
    digits = str(round(Decimal(float(jd)) + Decimal(float(low)), 20))
    return digits.rstrip("0").rstrip(".") if "." in digits else digits
