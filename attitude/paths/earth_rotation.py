"""The rotation of the Earth: from ITRS, in which a ground site rests, to GCRS.

IAU 2006/2000A precession and nutation, the Earth rotation angle of UT1, and polar motion, as in
astropy and ERFA.  UT1 and the pole come from the table of the package astropy-iers-data,
interpolated linearly from day to day as astropy does; the table is read from the installed file,
never from the network.

The table ends with predictions about a year after its release.  Beyond it, and before 1973, only
a model of delta T exists (skyfield's, after Morrison, Stephenson, Hohenkerk & Zawilski 2020),
without polar motion, which long_term=True enables.

Source: IERS Conventions (2010), chapter 5.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude.epochs import time_scales
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.paths.moving_pole import pole_of_date, timescale, to_gcrs
from attitude.paths.path import spelled

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# rad/s of UT1, IERS Conventions (2010) eq. 5.15: 2 pi 1.00273781191135448 / 86400.
RATE: float = 7.292115146706980e-5
_ARCSEC = np.pi / 648000.0


def to_celestial(
    hi: FloatArray,
    lo: FloatArray,
    vector: FloatArray,
    *,
    long_term: bool = False,
    name: str = "the ground site",
    rates: bool = True,
) -> tuple[FloatArray, FloatArray | None]:
    """GCRS components (3, N) and their rates per second of a vector (3,) that rests in ITRS.

    Parameters
    ----------
    hi, lo : (N,) arrays
        TDB seconds past J2000 in two doubles.
    vector : (3,) array
        Of any unit.
    long_term : bool
        Whether a model of delta T replaces the IERS table at epochs outside of the table.
    name : str
        For messages.
    rates : bool
        Whether the rates are computed; None in their place if not.

    Raises
    ------
    AttitudeError
        For an epoch outside of the table, unless long_term.
    """
    tt = pairs.add((hi, lo), -time_scales.difference_at(hi, lo))
    tai = pairs.add(tt, -time_scales.TT_MINUS_TAI)
    ut1_minus_tai, x_pole, y_pole = _orientation(tai, tt, long_term, name)
    ut1 = pairs.add(tai, ut1_minus_tai)
    x, y, s = pole_of_date(hi, lo)
    # Polar motion with the locator s': IERS Conventions (2010), eq. 5.3 and 5.13.
    centuries = tt[0] / (36525.0 * time_scales.DAY)
    intermediate = _without_polar_motion(vector, x_pole, y_pole, -47e-6 * _ARCSEC * centuries)
    angle = rotation_angle(*ut1)
    position = to_gcrs(x, y, angle - s, intermediate)
    if not rates:
        return position, None
    turning = RATE * np.stack([-intermediate[1], intermediate[0], np.zeros(hi.size)])
    return position, to_gcrs(x, y, angle - s, turning)


def rotation_angle(hi: FloatArray, lo: FloatArray) -> FloatArray:
    """The Earth rotation angle in rad at UT1 seconds hi + lo past J2000 (ERFA's era00).

    Accurate to 1e-15 of a turn; IERS Conventions (2010) eq. 5.15.
    """
    whole = np.rint(hi / time_scales.DAY)
    part = ((hi - whole * time_scales.DAY) + lo) / time_scales.DAY
    turns = 0.7790572732640 + part + 0.00273781191135448 * (whole + part)
    return 2.0 * np.pi * (turns - np.floor(turns))


def _without_polar_motion(vector, x_pole, y_pole, locator):
    """R3(-s') R2(xp) R1(yp) of a vector: ITRS to the terrestrial intermediate frame."""
    cosine, sine = np.cos(y_pole), np.sin(y_pole)
    a = np.broadcast_to(vector[0], x_pole.shape)
    b = cosine * vector[1] + sine * vector[2]
    c = cosine * vector[2] - sine * vector[1]
    cosine, sine = np.cos(x_pole), np.sin(x_pole)
    a, c = cosine * a - sine * c, sine * a + cosine * c
    cosine, sine = np.cos(locator), np.sin(locator)
    return np.stack([cosine * a - sine * b, sine * a + cosine * b, c])


def table_span() -> tuple[Instant, Instant]:
    """The first and last epoch of the installed IERS table."""
    tai = _table()[0][[0, -1]]
    hi, lo = (np.asarray(each) for each in time_scales.tdb_from("tai", tai, np.zeros(2)))
    first, last = (Instant(*pair) for pair in zip(hi.tolist(), lo.tolist(), strict=True))
    return first, last


def _orientation(tai, tt, long_term, name):
    """UT1 - TAI in s, and the coordinates of the pole in rad."""
    nodes, ut1, x_pole, y_pole = _table()
    seconds = tai[0]
    # The ends belong to the table, whatever the rounding of TDB; beyond them by rounding alone,
    # numpy.interp returns the last value.
    outside = (seconds < nodes[0] - 1e-6) | (seconds > nodes[-1] + 1e-6)
    found = [np.interp(seconds, nodes, values) for values in (ut1, x_pole, y_pole)]
    if not outside.any():
        return found
    if not long_term:
        first, last = (spelled(each) for each in table_span())
        bad = Instant(float(tt[0][np.argmax(outside)]))
        raise AttitudeError(
            f"an epoch for {name} is {spelled(bad)}, but the Earth's rotation is tabulated from "
            f"{first} to {last} only (astropy-iers-data); leave that epoch out, update "
            "astropy-iers-data, or give long_term=True for a model that errs by some hundred "
            "metres within years."
        )
    time = timescale().tt_jd(*time_scales.jd_from_seconds(tt[0][outside], tt[1][outside]))
    found[0][outside] = time_scales.TT_MINUS_TAI - time.delta_t
    for pole in found[1:]:
        pole[outside] = 0.0
    return found


@lru_cache(maxsize=1)
def _table():
    """TAI seconds past J2000, UT1 - TAI in s and the pole in rad, for each day of the table.

    UT1 - TAI has no leap seconds, so that the interpolation from day to day crosses them.
    """
    table = time_scales.earth_orientation()
    day = np.asarray(table["MJD"].to_value("d"), dtype=np.float64)
    ut1_minus_utc = np.asarray(table["UT1_UTC"].to_value("s"), dtype=np.float64)
    poles = [
        np.asarray(table[name].to_value("arcsec"), dtype=np.float64) * _ARCSEC
        for name in ("PM_x", "PM_y")
    ]
    known = np.isfinite(ut1_minus_utc) & np.isfinite(poles[0]) & np.isfinite(poles[1])
    day, ut1_minus_utc = day[known], ut1_minus_utc[known]
    tai = time_scales.tai_from_utc_day(day, np.zeros_like(day))[0]
    utc_minus_tai = (day - 51544.5) * time_scales.DAY - tai
    columns = tai, ut1_minus_utc + utc_minus_tai, poles[0][known], poles[1][known]
    for column in columns:
        column.setflags(write=False)
    return columns
