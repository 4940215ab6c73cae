"""Axes of the Earth, of date and Earth-fixed, as quaternions to ICRF; the pole of date.

The celestial pole moves by 20 arcsec a year and wobbles with periods of days and more; its series
cost 100 to 300 microseconds an epoch.  This module fits them once for every two days that occur,
and evaluates the fit in tens of nanoseconds.  A frame of date is three numbers: the coordinates x
and y of its pole in GCRS, and the angle s about the pole from the non-rotating origin.

Sources: IERS Conventions (2010), section 5.4.4 (the matrix of x, y and s); Capitaine et al., A&A
355, 398 (2000).
"""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from attitude._solver import chebyshev
from attitude._support import pairs
from attitude._support.arrays import frozen, read_only
from attitude._support.constants import DAY_S
from attitude.epochs import _time_scales
from attitude.errors import AttitudeError
from attitude.frames import quaternion
from attitude.frames import representations as forms

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from skyfield.timelib import Timescale

    from attitude._support.annotations import FloatArray

    Series: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]


# Two days and 10 nodes: 1e-15 rad from the series themselves, 7e-9 m at the Earth's surface.
_WIDTH = 2.0 * DAY_S
_COUNT = 10
# Records by series and number of the two days; 4096 are 1 MB and 22 years.
_pieces = chebyshev.KeptPieces(4096)


def pole_at(series: Series, hi: FloatArray, lo: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of a frame (3, N) at TDB seconds hi + lo (N,) past J2000."""
    number = np.floor(hi / _WIDTH)
    if hi.size and (number == number[0]).all():  # nearly always; sorting takes as long as the rest
        numbers, piece = number[:1], np.zeros(hi.size, np.int64)
    else:
        numbers, index = np.unique(number, return_inverse=True)
        piece = index.ravel().astype(np.int64)
    records = read_only(_fitted(series, numbers))
    x = 2.0 * (((hi - number * _WIDTH) + lo) / _WIDTH) - 1.0
    out = np.empty((3, hi.size))
    chebyshev.values(records, 0, _COUNT, piece, x, 1.0, out)
    return out


def _fitted(series, numbers):
    """The records of pieces with these numbers."""

    def fitted(missing):
        start = np.array([key[1] for key in missing]) * _WIDTH
        x = chebyshev.nodes(_COUNT)
        at = start + 0.5 * _WIDTH * (x[:, None] + 1.0)
        sampled = series(*_time_scales.jd_from_seconds(at.ravel(), np.zeros(at.size)))
        table = chebyshev.coefficients(sampled.reshape(3, *at.shape).transpose(1, 2, 0))
        return np.ascontiguousarray(table.transpose(1, 2, 0)).reshape(len(missing), -1)

    keys = [(series, int(number)) for number in numbers]
    return np.array(_pieces.of(keys, fitted)).reshape(len(keys), 3 * _COUNT)


def to_gcrs(x: FloatArray, y: FloatArray, angle: FloatArray, vectors: FloatArray) -> FloatArray:
    """GCRS components (3, N) of vectors (3, N) in the frame of date: Q(x, y) R3(-angle)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    a = cosine * vectors[0] - sine * vectors[1]
    b = sine * vectors[0] + cosine * vectors[1]
    c = vectors[2]
    # 1 - z without cancellation is (x^2 + y^2) / (1 + z).
    square = x * x + y * y
    z = np.sqrt(1.0 - square)
    along = (x * a + y * b) / (1.0 + z)
    out = np.empty((3, x.size))
    out[0] = a + x * (c - along)
    out[1] = b + y * (c - along)
    out[2] = z * c - (x * a + y * b)
    return out


def erfa_series(jd1: FloatArray, jd2: FloatArray) -> FloatArray:
    """x, y (1), s (rad) of the CIP (3, N), IAU 2006/2000A, by ERFA's xys06a, at jd1 + jd2, TDB."""
    import erfa

    return np.stack(erfa.xys06a(*_tt(jd1, jd2)))


def teme_series(jd1: FloatArray, jd2: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of the frame of SGP4 (true equator, mean equinox), by skyfield: (3, N).

    IAU 2000A nutation; the mean equinox is that of the Greenwich mean sidereal time of 1982.
    jd1 + jd2 is the Julian date of TDB.
    """
    from skyfield.sgp4lib import TEME

    to_teme = TEME.rotation_at(timescale().tt_jd(*_tt(jd1, jd2)))
    x, y, z = to_teme[2]
    # The components of the x axis of date along the non-rotating axes.
    cosine = to_teme[0, 0] * (1.0 - x * x / (1.0 + z)) - to_teme[0, 1] * x * y / (1.0 + z)
    cosine -= to_teme[0, 2] * x
    sine = -to_teme[0, 0] * x * y / (1.0 + z) + to_teme[0, 1] * (1.0 - y * y / (1.0 + z))
    sine -= to_teme[0, 2] * y
    return np.stack([x, y, np.arctan2(sine, cosine)])


@cache
def timescale() -> Timescale:
    """skyfield's timescale from the tables in its package; no other file is read or downloaded."""
    from skyfield.api import load

    return load.timescale(builtin=True)


def _tt(jd1, jd2):
    """A two-part Julian date of TT from one of TDB."""
    return jd1, jd2 - _time_scales.tdb_minus_tt(jd1, jd2) / DAY_S


def pole_of_date(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of `erfa_series`, (3, N), at TDB seconds hi + lo past J2000."""
    return pole_at(erfa_series, hi, lo)


def pole_of_teme(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of `teme_series`, (3, N), at TDB seconds hi + lo past J2000."""
    return pole_at(teme_series, hi, lo)


# ---- Axes of the Earth: of date, Earth-fixed, and of B1950, as quaternions to ICRF
# itrf      Earth-fixed: IAU 2006/2000A with the Earth orientation of astropy-iers-data
# tirs      itrf without polar motion, from the celestial intermediate origin
# cirs      equator of date, celestial intermediate origin
# gtod      equator of date, Greenwich meridian by apparent sidereal time: itrf without polar motion
# tod       true equator and equinox of date: precession IAU 2006, nutation IAU 2000A
# mod       mean equator and equinox of date: precession IAU 2006
# teme      true equator, mean equinox, as SGP4 uses it
# b1950     mean equator and equinox of the Besselian epoch 1950, by the precession of IAU 1976 from
#           J2000: SPICE's B1950
#
# Orekit, STK and older software may compute tod and mod with the precession of IAU 1976 and the
# nutation of IAU 1980, 0.1 arcsec away today.
#
# Sources: IERS Conventions (2010), chapter 5, as in ERFA's c2t06a, pnm06a, pmat06, gst06a; Vallado
# et al., AIAA 2006-6753 (TEME); Lieske, A&A 73, 282 (1979), as in ERFA's prec76 (B1950).

# Names in files, in capital letters without hyphens, underscores and blanks, and the kind of axes.
# Source: SANA registry of celestial body reference frames; EME2000 and J2000 are those of CCSDS and
# STK, with the frame bias.
FIXED_NAMES: dict[str, str] = {
    **dict.fromkeys(("ICRF", "ICRF1", "ICRF2", "ICRF3", "GCRF", "BCRF"), "icrf"),
    **dict.fromkeys(("ICRS", "GCRS", "BCRS"), "icrf"),
    **dict.fromkeys(("EME2000", "J2000"), "eme2000"),
    **dict.fromkeys(("ECLIPTIC", "ECLIPTICJ2000", "ECLIPJ2000"), "ecliptic"),
    **dict.fromkeys(("B1950", "EME1950"), "b1950"),
}
TURNING_NAMES: dict[str, str] = {
    **dict.fromkeys(("TEME", "TEMEOFDATE"), "teme"),
    **dict.fromkeys(("ITRF", "ITRS"), "itrf"),
    **dict.fromkeys(("TOD", "TODEARTH", "TRUEOFDATE"), "tod"),
    **dict.fromkeys(("MOD", "MODEARTH", "MEANOFDATE"), "mod"),
    **dict.fromkeys(("GTOD", "TDR"), "gtod"),
    **{"CIRS": "cirs", "TIRS": "tirs"},
}
# Those that turn with the Earth, so that rates of vectors include its rotation.
_EARTH_FIXED = ("itrf", "tirs", "gtod")
# s: half the interval of the differences of an Earth-fixed vector, whose rate then errs by 3e-15
# of its length a second, and by its rounding.
_STEP = 0.25
# The Besselian epoch 1950.0 as Julian date.
_B1950 = 2433282.42345905


def normal(name: str) -> str:
    """A name in capital letters without hyphens, underscores and blanks."""
    return re.sub(r"[-_ ]", "", name).upper()


def kind_of(name: str) -> str | None:
    """The kind of axes that a name in a file means, of fixed axes and of the Earth's, or None.

    >>> kind_of("ITRF-97"), kind_of("J2000"), kind_of("LVLH")
    ('itrf', 'eme2000', None)
    """
    plain = normal(name)
    if re.fullmatch(r"ITRF(19|20)?\d\d", plain):
        plain = "ITRF"
    return FIXED_NAMES.get(plain) or TURNING_NAMES.get(plain)


def vectors_to_icrf(
    kind: str, hi: FloatArray, lo: FloatArray, vectors: FloatArray, rates: FloatArray | None
) -> tuple[FloatArray, FloatArray | None]:
    """Vectors (N, 3) over axes of the Earth, and their rates as seen from these, over ICRF.

    Axes of date are taken as at rest, as SGP4 and the standards of orbits do (1e-11 rad/s).
    """

    axes = b1950() if kind == "b1950" else to_icrf(kind, hi, lo)
    turned = quaternion.rotate(axes, vectors)
    if rates is None:
        return turned, None
    rates = quaternion.rotate(axes, rates)
    if kind in _EARTH_FIXED:
        later, earlier = (to_icrf(kind, *pairs.add((hi, lo), step)) for step in (_STEP, -_STEP))
        change = quaternion.rotate(later, vectors) - quaternion.rotate(earlier, vectors)
        rates += change / (2.0 * _STEP)
    return turned, rates


def to_icrf(kind: str, hi: FloatArray, lo: FloatArray) -> FloatArray:
    """Quaternions (N, 4), continuous in sign, to ICRF from axes of the Earth at hi + lo (N,)."""
    return forms.continuous(forms.from_dcm(_matrices(kind, hi, lo)))


@cache
def b1950() -> FloatArray:
    """The quaternion (4,) to ICRF from B1950."""
    import erfa

    from attitude import frames

    zeta, z, theta = erfa.prec76(_B1950, 0.0, _time_scales.J2000, 0.0)
    # From the axes of B1950 to those of J2000.
    matrix = erfa.rz(-z, erfa.ry(theta, erfa.rz(-zeta, np.eye(3))))
    turn = quaternion.from_matrix(matrix)
    return frozen(quaternion.multiply(frames.wxyz_to_icrf("eme2000"), turn))


def _matrices(kind, hi, lo):
    """Matrices (N, 3, 3) from ICRF to axes of the Earth."""
    import erfa

    if kind == "teme":
        pole = pole_of_teme(hi, lo)
        axes = np.array([to_gcrs(*pole, axis[:, None]) for axis in np.eye(3)])
        return np.moveaxis(axes, -1, 0)
    tt = _time_scales.tt_from_tdb(hi, lo)
    tt1, tt2 = _time_scales.jd_from_seconds(*tt)
    if kind == "tod":
        return erfa.pnm06a(tt1, tt2)
    if kind == "mod":
        return erfa.pmat06(tt1, tt2)
    if kind == "cirs":
        return erfa.c2i06a(tt1, tt2)
    ut1, ut2, x, y = _orientation(tt)
    if kind == "gtod":
        return erfa.rz(erfa.gst06a(ut1, ut2, tt1, tt2), np.eye(3)) @ erfa.pnm06a(tt1, tt2)
    if kind == "tirs":
        return erfa.rz(erfa.era00(ut1, ut2), np.eye(3)) @ erfa.c2i06a(tt1, tt2)
    return erfa.c2t06a(tt1, tt2, ut1, ut2, x, y)


def _orientation(tt):
    """UT1 as a two-part Julian date, and the coordinates of the pole in rad."""
    import erfa

    tai = pairs.add(tt, -_time_scales.TT_MINUS_TAI)
    utc1, utc2 = erfa.ufunc.taiutc(*_time_scales.jd_from_seconds(*tai))[:2]
    table = _time_scales.earth_orientation()
    dut1, status = table.ut1_utc(utc1, utc2, return_status=True)
    if np.any(status < 0):
        raise AttitudeError(
            "an epoch lies outside of the installed table of Earth orientation, which Earth-fixed "
            "axes need; update the package astropy-iers-data."
        )
    ut1, ut2 = erfa.ufunc.utcut1(utc1, utc2, dut1.to_value("s"))[:2]
    x, y = (angle.to_value("rad") for angle in table.pm_xy(utc1, utc2))
    return ut1, ut2, x, y
