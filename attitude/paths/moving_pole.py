"""Frames of the moving Earth against GCRS: where its pole is, and how far it has turned about it.

The celestial pole moves by 20 arcsec a year and wobbles with periods of days and more; its series
cost 100 to 300 microseconds an epoch.  Here they are fitted once for every two days that occur,
and evaluated for tens of nanoseconds.  A frame of date is three numbers: the coordinates x and y
of its pole in GCRS, and a third, the angle about the pole from the point that has no spin there.

Sources: IERS Conventions (2010), section 5.4.4 (the matrix of x, y and s); Capitaine et al., A&A
355, 398 (2000).
"""

from functools import partial

import numpy as np

from attitude import chebyshev
from attitude.epochs import time_scales
from attitude.immutable import read_only

# Two days and 10 nodes: 1e-15 rad against the series themselves, 7e-9 m at the Earth's surface.
_WIDTH = 2.0 * time_scales.DAY
_COUNT = 10
_MOST_PIECES = 4096
_pieces = {}


def pole_at(series, hi, lo):
    """The three numbers (3, N) of a frame at TDB seconds past J2000 in two doubles.

    Parameters
    ----------
    series : callable
        Takes a two-part Julian date of TDB, (N,) arrays; returns (3, N).  One of this module's:
        what is fitted is kept for each.
    hi, lo : (N,) arrays
    """
    from attitude.paths import chebyshev_loops

    number = np.floor(hi / _WIDTH)
    found, piece = np.unique(number, return_inverse=True)
    records = read_only(_fitted(series, found))
    x = 2.0 * (((hi - number * _WIDTH) + lo) / _WIDTH) - 1.0
    out = np.empty((3, hi.size))
    chebyshev_loops.values(records, 0, _COUNT, piece.ravel().astype(np.int64), x, 1.0, out)
    return out


def _fitted(series, numbers):
    """The records of pieces with these numbers; threads may fit one twice, to the same bits."""
    keys = [(series, int(number)) for number in numbers]
    have = {key: _pieces.get(key) for key in keys}
    missing = [key for key in keys if have[key] is None]
    if missing:
        start = np.array([key[1] for key in missing]) * _WIDTH
        x = chebyshev.nodes(_COUNT)
        at = start + 0.5 * _WIDTH * (x[:, None] + 1.0)
        sampled = series(*time_scales.jd_from_seconds(at.ravel(), np.zeros(at.size)))
        table = chebyshev.coefficients(sampled.reshape(3, *at.shape).transpose(1, 2, 0))
        rows = np.ascontiguousarray(table.transpose(1, 2, 0)).reshape(len(missing), -1)
        have.update(zip(missing, rows, strict=True))
        if len(_pieces) + len(missing) > _MOST_PIECES:
            _pieces.clear()
        if len(missing) <= _MOST_PIECES:
            _pieces.update(zip(missing, rows, strict=True))
    return np.array([have[key] for key in keys])


def to_gcrs(x, y, angle, vectors):
    """GCRS components (3, N) of vectors (3, N) given in the frame of date.

    Q(x, y) R3(-angle), with x, y the pole of date and angle that of its x axis.
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


def erfa_series(jd1, jd2):
    """x, y and s of the celestial intermediate pole: IAU 2006/2000A, ERFA's xys06a."""
    import erfa

    return np.stack(erfa.xys06a(*_tt(jd1, jd2)))


def teme_series(jd1, jd2):
    """The frame of SGP4 (true equator, mean equinox) as skyfield has it.

    IAU 2000A nutation; the mean equinox is that of the Greenwich mean sidereal time of 1982.
    """
    from skyfield.sgp4lib import TEME

    time = timescale().tt_jd(*_tt(jd1, jd2))
    to_teme = TEME.rotation_at(time)
    x, y, z = to_teme[2]
    # The x axis of date in GCRS, and its components along the axes without spin.
    cosine = to_teme[0, 0] * (1.0 - x * x / (1.0 + z)) - to_teme[0, 1] * x * y / (1.0 + z)
    cosine -= to_teme[0, 2] * x
    sine = -to_teme[0, 0] * x * y / (1.0 + z) + to_teme[0, 1] * (1.0 - y * y / (1.0 + z))
    sine -= to_teme[0, 2] * y
    return np.stack([x, y, np.arctan2(sine, cosine)])


def timescale():
    """skyfield's timescale from the tables that it brings; no file and no network is asked."""
    global _timescale
    if _timescale is None:
        from skyfield.api import load

        _timescale = load.timescale(builtin=True)
    return _timescale


_timescale = None


def _tt(jd1, jd2):
    """A two-part Julian date of TT from one of TDB."""
    return jd1, jd2 - time_scales.tdb_minus_tt(jd1, jd2) / time_scales.DAY


pole_of_date = partial(pole_at, erfa_series)
pole_of_teme = partial(pole_at, teme_series)
