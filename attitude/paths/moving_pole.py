"""Earth frames of date relative to GCRS: the celestial pole, and the angle about it.

The celestial pole moves by 20 arcsec a year and wobbles with periods of days and more; its series
cost 100 to 300 microseconds an epoch.  This module fits them once for every two days that occur,
and evaluates the fit in tens of nanoseconds.  A frame of date is three numbers: the coordinates x
and y of its pole in GCRS, and the angle s about the pole from the non-rotating origin.

Sources: IERS Conventions (2010), section 5.4.4 (the matrix of x, y and s); Capitaine et al., A&A
355, 398 (2000).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import chebyshev
from attitude.epochs import time_scales
from attitude.immutable import read_only

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from skyfield.timelib import Timescale

    from attitude.annotations import FloatArray

    # A two-part Julian date of TDB, (N,) arrays, to the three numbers of a frame (3, N).
    Series: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]

# Two days and 10 nodes: 1e-15 rad from the series themselves, 7e-9 m at the Earth's surface.
_WIDTH = 2.0 * time_scales.DAY
_COUNT = 10
_MOST_PIECES = 4096
# Records by series and number of the two days.
_pieces: dict[tuple[Series, int], FloatArray] = {}


def pole_at(series: Series, hi: FloatArray, lo: FloatArray) -> FloatArray:
    """The three numbers (3, N) of a frame at TDB seconds hi + lo past J2000: x, y (1) and s (rad).

    Parameters
    ----------
    series : callable
        `erfa_series` or `teme_series`; the fits of each are cached.
    hi, lo : (N,) arrays
    """
    from attitude.paths import chebyshev_loops

    number = np.floor(hi / _WIDTH)
    if hi.size and (number == number[0]).all():  # nearly always; sorting takes as long as the rest
        found, piece = number[:1], np.zeros(hi.size, np.int64)
    else:
        found, index = np.unique(number, return_inverse=True)
        piece = index.ravel().astype(np.int64)
    records = read_only(_fitted(series, found))
    x = 2.0 * (((hi - number * _WIDTH) + lo) / _WIDTH) - 1.0
    out = np.empty((3, hi.size))
    chebyshev_loops.values(records, 0, _COUNT, piece, x, 1.0, out)
    return out


def _fitted(series, numbers):
    """The records of pieces with these numbers; two threads may fit one, with the same result."""
    keys = [(series, int(number)) for number in numbers]
    known = {key: _pieces.get(key) for key in keys}
    missing = [key for key in keys if known[key] is None]
    if missing:
        start = np.array([key[1] for key in missing]) * _WIDTH
        x = chebyshev.nodes(_COUNT)
        at = start + 0.5 * _WIDTH * (x[:, None] + 1.0)
        sampled = series(*time_scales.jd_from_seconds(at.ravel(), np.zeros(at.size)))
        table = chebyshev.coefficients(sampled.reshape(3, *at.shape).transpose(1, 2, 0))
        rows = np.ascontiguousarray(table.transpose(1, 2, 0)).reshape(len(missing), -1)
        known.update(zip(missing, rows, strict=True))
        if len(_pieces) + len(missing) > _MOST_PIECES:
            _pieces.clear()
        if len(missing) <= _MOST_PIECES:
            _pieces.update(zip(missing, rows, strict=True))
    return np.array([known[key] for key in keys]).reshape(len(keys), 3 * _COUNT)


def to_gcrs(x: FloatArray, y: FloatArray, angle: FloatArray, vectors: FloatArray) -> FloatArray:
    """GCRS components (3, N) of vectors (3, N) given in the frame of date.

    Q(x, y) R3(-angle), with x, y (N,) the pole of date and angle (N,) that of its x axis in rad.
    """
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
    """x, y (1) and s (rad) of the celestial intermediate pole (3, N), by ERFA's xys06a.

    IAU 2006/2000A; jd1 + jd2 is the Julian date of TDB.
    """
    import erfa

    return np.stack(erfa.xys06a(*_tt(jd1, jd2)))


def teme_series(jd1: FloatArray, jd2: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of the frame of SGP4 (true equator, mean equinox), by skyfield: (3, N).

    IAU 2000A nutation; the mean equinox is that of the Greenwich mean sidereal time of 1982.
    jd1 + jd2 is the Julian date of TDB.
    """
    from skyfield.sgp4lib import TEME

    time = timescale().tt_jd(*_tt(jd1, jd2))
    to_teme = TEME.rotation_at(time)
    x, y, z = to_teme[2]
    # The components of the x axis of date along the non-rotating axes.
    cosine = to_teme[0, 0] * (1.0 - x * x / (1.0 + z)) - to_teme[0, 1] * x * y / (1.0 + z)
    cosine -= to_teme[0, 2] * x
    sine = -to_teme[0, 0] * x * y / (1.0 + z) + to_teme[0, 1] * (1.0 - y * y / (1.0 + z))
    sine -= to_teme[0, 2] * y
    return np.stack([x, y, np.arctan2(sine, cosine)])


def timescale() -> Timescale:
    """skyfield's timescale from the tables in its package; no other file is read or downloaded."""
    global _timescale
    if _timescale is None:
        from skyfield.api import load

        _timescale = load.timescale(builtin=True)
    return _timescale


_timescale = None


def _tt(jd1, jd2):
    """A two-part Julian date of TT from one of TDB."""
    return jd1, jd2 - time_scales.tdb_minus_tt(jd1, jd2) / time_scales.DAY


def pole_of_date(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of `erfa_series`, (3, N), at TDB seconds hi + lo past J2000."""
    return pole_at(erfa_series, hi, lo)


def pole_of_teme(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """x, y (1) and s (rad) of `teme_series`, (3, N), at TDB seconds hi + lo past J2000."""
    return pole_at(teme_series, hi, lo)
