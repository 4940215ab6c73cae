"""Light curves as DAMIT keeps them (lc.txt), and as its inversion programs read and write them.

    2                                   number of light curves
    3 1                                 points; 1: calibrated, 0: relative
    2454035.6182 1.0421 -1.2 0.3 0.1 -0.4 0.9 0.1
    ...

Each line is one point: the Julian date corrected for light time (when the light left the
asteroid), the brightness in units of intensity, not magnitudes, and the vectors from the asteroid
to the Sun and to the Earth in au, over ecliptic J2000 axes.  Calibrated curves share one unit of
brightness; a relative curve has one of its own.  What stands behind the eighth number of a line or
behind the second of a header is left alone by DAMIT's programs, and here.

Format: M. Kaasalainen, J. Torppa, J. Durech, documentation of convexinv, in DAMIT
(https://astro.troja.mff.cuni.cz/projects/damit); Durech, Sidorin, Kaasalainen, A&A 513, A46, 2010.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from attitude import epochs, frames, pairs, validation
from attitude.errors import AttitudeError
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.immutable import Immutable, frozen
from attitude.physical_constants import ASTRONOMICAL_UNIT_M
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import is_number, opened

# Points in one curve: more is not a count but a misplaced number.
_MOST = 100_000_000


@dataclass(frozen=True, eq=False, repr=False)
class DamitLightCurve(Immutable):
    """One light curve of an asteroid with its geometry.

    Parameters
    ----------
    jd : (N,) array_like
        Julian dates at which the light left the asteroid.
    brightness : (N,) array_like
        Above zero, in units of intensity.
    sun, earth : (N, 3) array_like
        au, from the asteroid, ecliptic J2000 axes.
    calibrated : bool
    time_system : str
        Of the dates: "UTC", "TAI", "TT", "TDB", ...  The files do not say; the minute between
        them is nothing to most asteroids.
    jd_low : (N,) array_like, optional
        What `jd` leaves out: the dates are jd + jd_low, to the microsecond and below.

    >>> curve = DamitLightCurve([2460000.5], [1.0], [[1, 0, 0]], [[0, 0, 1]], calibrated=False)
    >>> curve.phase_angle
    array([1.57079633])
    """

    jd: np.ndarray
    brightness: np.ndarray
    sun: np.ndarray
    earth: np.ndarray
    calibrated: bool
    time_system: str = "TDB"
    jd_low: np.ndarray = None

    def __post_init__(self):
        self._set("jd", frozen(validation.real(self.jd, "jd")))
        if self.jd.ndim != 1 or not self.jd.size:
            raise AttitudeError(f"jd has shape {self.jd.shape}; give (N,), one point or more.")
        count = len(self.jd)
        low = np.zeros(count) if self.jd_low is None else self.jd_low
        self._set("jd_low", frozen(validation.real(low, "jd_low", shape=(count,))))
        for name, shape in (("brightness", (count,)), ("sun", (count, 3)), ("earth", (count, 3))):
            self._set(name, frozen(validation.real(getattr(self, name), name, shape=shape)))
        self._set("_scale", _astropy_scale(ccsds_epochs.known(self.time_system, "time_system")))
        if not isinstance(self.calibrated, (bool, np.bool_)):
            raise AttitudeError(f"calibrated is {self.calibrated!r}; give True or False.")
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

    def __len__(self):
        return len(self.jd)

    def __repr__(self):
        kind = "calibrated" if self.calibrated else "relative"
        return f"<DamitLightCurve, {kind}: {len(self)} points from JD {self.jd[0]:.5f}>"

    @cached_property
    def time(self):
        """The dates as an astropy Time in their scale."""
        from astropy.time import Time

        return Time(self.jd, self.jd_low, format="jd", scale=self._scale)

    def seconds_since(self, epoch):
        """(seconds, low), TDB, from an epoch: what ``motion.at`` takes, with no light time left.

        Parameters
        ----------
        epoch : Instant, or any epoch
        """
        return epochs.seconds_since(epochs.instant(epoch), self.time)

    @property
    def sun_direction(self):
        """(N, 3) unit vectors to the Sun, ICRF axes."""
        return _icrf_units(self.sun)

    @property
    def earth_direction(self):
        """(N, 3) unit vectors to the Earth, ICRF axes."""
        return _icrf_units(self.earth)

    @property
    def phase_angle(self):
        """(N,) rad, between Sun and Earth."""
        s, e = _icrf_units(self.sun), _icrf_units(self.earth)
        return 2.0 * np.arctan2(
            np.sqrt(np.sum((s - e) ** 2, axis=-1)), np.sqrt(np.sum((s + e) ** 2, axis=-1))
        )

    @property
    def magnitude(self):
        """(N,) magnitudes, -2.5 lg of the brightness: relative to an unknown zero."""
        return -2.5 * np.log10(self.brightness)


def from_positions(t, brightness, sun, earth, *, calibrated, time_system="TDB", frame="icrf"):
    """A `DamitLightCurve` from epochs and vectors in metres.

    Parameters
    ----------
    t : astropy Time, dates
        When the light left the asteroid; (N,).
    brightness : (N,) array_like
    sun, earth : (N, 3) array_like
        m (or a Quantity), from the asteroid.
    calibrated : bool
    time_system : str
        Of the dates to be written.
    frame : str
        Axes of the vectors.
    """
    hi, lo = epochs.seconds_since(epochs.Instant(0.0), t)
    instants = epochs.times(epochs.Instant(0.0), np.atleast_1d(hi), lo)
    dates = getattr(instants, _astropy_scale(ccsds_epochs.known(time_system, "time_system")))
    turn = frames.matrix_to_icrf("ecliptic").T @ frames.matrix_to_icrf(frame)
    vectors = [
        validation.real(v, name, shape=(..., 3), unit="m") @ turn.T / ASTRONOMICAL_UNIT_M
        for v, name in ((sun, "sun"), (earth, "earth"))
    ]
    jd, low = pairs.two_sum(dates.jd1, dates.jd2)
    return DamitLightCurve(
        jd, brightness, *vectors, calibrated=calibrated, time_system=time_system, jd_low=low
    )


def read_damit_light_curves(path, *, time_system="TDB"):
    """All light curves of a file, a list of `DamitLightCurve`.

    Parameters
    ----------
    path : str or path
    time_system : str
        In which the dates are taken to be.

    Raises
    ------
    AttitudeError
        With file and line, for whatever is not as the format wants it: a count that is none, a
        file cut short, a number that cannot be read, NaN, a magnitude where an intensity belongs.
    """
    ccsds_epochs.known(time_system, "time_system")
    with opened(path) as lines:
        rows = _rows(lines)
        header = next(rows, None)
        if header is None:
            raise lines.fault("the file is empty; a light-curve file begins with their number.", 1)
        count = _count(lines, header[0], "the number of light curves")
        curves = [_curve(lines, rows, k, count, time_system) for k in range(count)]
        extra = next(rows, None)
        if extra is not None:
            raise lines.fault(
                f"there is more after the {count} light curves that line 1 announces; is their "
                "number right?"
            )
    return curves


def write_damit_light_curves(path, curves):
    """Write light curves; the file appears whole or not at all.

    Parameters
    ----------
    path : str or path
    curves : DamitLightCurve or list of them

    Notes
    -----
    Numbers are written with all their digits, dates to 1e-20 d.  A date without `jd_low` is
    written in the fewest digits that are read as the same `jd`; what these decimals differ by from
    the double, 20 microseconds at most, reading then tells as `jd_low`.
    """
    if isinstance(curves, DamitLightCurve):
        curves = [curves]
    elif not isinstance(curves, Iterable):
        raise AttitudeError(f"curves is {curves!r}; give one DamitLightCurve, or a list of them.")
    curves = list(curves)
    for each in curves:
        if not isinstance(each, DamitLightCurve):
            raise AttitudeError(
                f"{type(each).__name__} is given to be written; give DamitLightCurve objects."
            )
    if not curves:
        raise AttitudeError("there are no light curves to write; give one or more.")
    if len({each._scale for each in curves}) > 1:
        raise AttitudeError("the light curves differ in time_system, which the file cannot tell.")
    with written_whole(path) as file:
        file.write(f"{len(curves)}\n")
        for curve in curves:
            file.write(f"{len(curve)} {int(curve.calibrated)}\n")
            for k in range(len(curve)):
                numbers = (curve.brightness[k], *curve.sun[k], *curve.earth[k])
                date = _date(curve.jd[k], curve.jd_low[k])
                file.write(f"{date} {' '.join(repr(float(x)) for x in numbers)}\n")


def _astropy_scale(scale):
    if scale == "gps":
        raise AttitudeError(
            'time_system "GPS" has no Julian dates of its own; give "TAI" or "UTC".'
        )
    return scale


def _rows(lines):
    """The tokens of each line that has any."""
    for line in lines:
        if b"\x00" in line:
            raise lines.fault("it holds zero bytes; is it a text file?")
        tokens = line.removeprefix(b"\xef\xbb\xbf").split()
        if tokens:
            yield tokens


def _curve(lines, rows, number, count, time_system):
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
        table.append(_point(lines, tokens, f"point {k + 1} of {where}"))
        low.append(_rest(tokens[0], table[-1][0]))
    table = np.array(table)
    return DamitLightCurve(
        table[:, 0],
        table[:, 1],
        table[:, 2:5],
        table[:, 5:8],
        calibrated=header[1] == b"1",
        time_system=time_system,
        jd_low=np.array(low),
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
            raise lines.fault(f"{shown!r} in {where} is not a finite number.")
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
        raise lines.fault(f"{name} is {shown!r}; it must be a whole number above zero.")
    return int(token)


def _rest(token, jd):
    """What the double of a date leaves of its decimals: exact, for dates of many digits."""
    from decimal import Decimal

    return float(Decimal(token.decode("ascii")) - Decimal(jd))


def _date(jd, low):
    """The sum in decimals, as many as are needed for both parts to come back."""
    from decimal import Decimal

    if low == 0.0:
        return repr(float(jd))
    digits = str(round(Decimal(float(jd)) + Decimal(float(low)), 20))
    return digits.rstrip("0").rstrip(".") if "." in digits else digits


def _icrf_units(vectors):
    turned = vectors @ frames.matrix_to_icrf("ecliptic").T
    return turned / np.sqrt(np.sum(turned * turned, axis=-1, keepdims=True))
