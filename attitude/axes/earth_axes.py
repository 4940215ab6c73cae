"""Axes of the Earth: of date, Earth-fixed, and of B1950, as quaternions to ICRF.

========  =========================================================================================
itrf      Earth-fixed: IAU 2006/2000A with the Earth orientation of astropy-iers-data
tirs      itrf without polar motion, from the celestial intermediate origin
cirs      equator of date, celestial intermediate origin
gtod      equator of date, Greenwich meridian by apparent sidereal time: itrf without polar motion
tod       true equator and equinox of date: precession IAU 2006, nutation IAU 2000A
mod       mean equator and equinox of date: precession IAU 2006
teme      true equator, mean equinox, as SGP4 uses it
b1950     mean equator and equinox of the Besselian epoch 1950, by the precession of IAU 1976 from
          J2000: SPICE's B1950
========  =========================================================================================

Orekit, STK and older software may compute tod and mod with the precession of IAU 1976 and the
nutation of IAU 1980, 0.1 arcsec away today.

Sources: IERS Conventions (2010), chapter 5, as in ERFA's c2t06a, pnm06a, pmat06, gst06a; Vallado et
al., AIAA 2006-6753 (TEME); Lieske, A&A 73, 282 (1979), as in ERFA's prec76 (B1950).
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from attitude import pairs
from attitude import representations as forms
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.immutable import frozen

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

# The Besselian epoch 1950.0 as Julian date, and J2000.
_B1950 = 2433282.42345905
_J2000 = 2451545.0


def to_icrf(kind: str, hi: FloatArray, lo: FloatArray) -> FloatArray:
    """Quaternions (N, 4), continuous in sign, to ICRF from axes of the Earth.

    Parameters
    ----------
    kind : str
        A name of the table above, but b1950.
    hi, lo : (N,) arrays
        hi + lo are TDB seconds since J2000.

    Raises
    ------
    AttitudeError
        If an epoch lies outside of the installed table of Earth orientation (itrf, tirs, gtod,
        teme).
    """
    tt = time_scales.tt_from_tdb(hi, lo)
    return forms.continuous(forms.from_dcm(_matrices(kind, tt)))


@cache
def b1950() -> FloatArray:
    """The quaternion (4,) to ICRF from B1950."""
    import erfa

    from attitude import frames, quaternion

    zeta, z, theta = erfa.prec76(_B1950, 0.0, _J2000, 0.0)
    # From the axes of B1950 to those of J2000.
    matrix = erfa.rz(-z, erfa.ry(theta, erfa.rz(-zeta, np.eye(3))))
    return frozen(quaternion.multiply(frames.wxyz_to_icrf("eme2000"), forms.from_matrix(matrix)))


def _matrices(kind, tt):
    """Matrices (N, 3, 3) from ICRF to axes of the Earth."""
    import erfa

    tt1, tt2 = time_scales.jd_from_seconds(*tt)
    if kind == "tod":
        return erfa.pnm06a(tt1, tt2)
    if kind == "mod":
        return erfa.pmat06(tt1, tt2)
    if kind == "cirs":
        return erfa.c2i06a(tt1, tt2)
    ut1, ut2, x, y = _orientation(tt)
    if kind == "gtod":
        angle = erfa.gst06a(ut1, ut2, tt1, tt2)
        return erfa.rz(angle, np.eye(3)) @ erfa.pnm06a(tt1, tt2)
    if kind == "tirs":
        return erfa.rz(erfa.era00(ut1, ut2), np.eye(3)) @ erfa.c2i06a(tt1, tt2)
    to_itrf = erfa.c2t06a(tt1, tt2, ut1, ut2, x, y)
    if kind == "teme":
        spin = erfa.rz(erfa.gmst82(ut1, ut2), np.eye(3))
        return np.swapaxes(erfa.pom00(x, y, 0.0) @ spin, -1, -2) @ to_itrf
    return to_itrf


def _orientation(tt):
    """UT1 as a two-part Julian date, and the coordinates of the pole in rad."""
    import erfa

    utc1, utc2 = erfa.ufunc.taiutc(
        *time_scales.jd_from_seconds(*pairs.add(tt, -time_scales.TT_MINUS_TAI))
    )[:2]
    table = time_scales.earth_orientation()
    dut1, status = table.ut1_utc(utc1, utc2, return_status=True)
    if np.any(status < 0):
        raise AttitudeError(
            "an epoch lies outside of the installed table of Earth orientation, which Earth-fixed "
            "axes need; update the package astropy-iers-data."
        )
    ut1, ut2 = erfa.ufunc.utcut1(utc1, utc2, dut1.to_value("s"))[:2]
    x, y = (angle.to_value("rad") for angle in table.pm_xy(utc1, utc2))
    return ut1, ut2, x, y
