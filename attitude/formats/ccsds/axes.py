"""The axes that attitudes in files refer to, by the names that files give them.

Each leads to ICRF: fixed axes by one quaternion, turning ones (Earth-fixed, of date, of an orbit)
by one for each epoch, and with their own angular velocity.

========================  =========================================================================
icrf                      ICRF, ICRF1 to ICRF3, GCRF, BCRF
eme2000                   EME2000, J2000 (of CCSDS and STK, with the frame bias of 23 mas)
ecliptic                  ECLIPTIC, ECLIPTICJ2000, ECLIPJ2000
itrf                      ITRF, ITRF-97, ITRF2000, ..., ITRS: IAU 2006/2000A with the Earth
                          orientation of astropy-iers-data
teme                      TEME, TEMEOFDATE
rtn                       RTN, RSW, RIC, QSW: x away from the center, z along the orbit's momentum
lvlh                      LVLH, VVLH: z to the center, y against the orbit's momentum
========================  =========================================================================

Of an orbit's axes, names that end in _INERTIAL say that rates are relative to axes that stand
still, others (and _ROTATING) that they are relative to axes that turn with the orbit.

Sources: SANA registry of celestial body and orbit-relative reference frames; IERS Conventions
(2010), chapter 5, as in ERFA's c2t06a; Vallado et al., AIAA 2006-6753 (TEME).
"""

import re

import numpy as np

from attitude import epochs, frames, pairs, quaternion
from attitude import representations as forms
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.paths.path import Path

_FIXED = {
    **dict.fromkeys(("ICRF", "ICRF1", "ICRF2", "ICRF3", "GCRF", "BCRF"), "icrf"),
    **dict.fromkeys(("EME2000", "J2000"), "eme2000"),
    **dict.fromkeys(("ECLIPTIC", "ECLIPTICJ2000", "ECLIPJ2000"), "ecliptic"),
}
_TURNING = {
    **dict.fromkeys(("TEME", "TEMEOFDATE"), "teme"),
    **dict.fromkeys(("ITRF", "ITRS"), "itrf"),
    **dict.fromkeys(("RTN", "RSW", "RIC", "QSW"), "rtn"),
    **dict.fromkeys(("LVLH", "VVLH"), "lvlh"),
}
_OF_ORBIT = ("rtn", "lvlh")
# How the axes are called in files that we write.
WRITTEN = {
    **{"icrf": "ICRF", "gcrf": "GCRF", "eme2000": "EME2000", "ecliptic": "ECLIPTICJ2000"},
    **{"itrf": "ITRF", "teme": "TEME", "rtn": "RTN", "lvlh": "LVLH"},
}
# Seconds: the decimals of files.  One epoch in two files may differ by the rounding of its reading.
_SAME = 1e-12
_STEP = 1.0  # seconds, for the rate of turning axes: errs by 6e-14 rad/s for the Earth


class Axes:
    """Axes by their name, and how they turn.

    Attributes
    ----------
    name : str
        As the file has it.
    kind : str
        One of the kinds above.
    turning : bool
    """

    def __init__(self, name, kind, *, inertial=False):
        self.name, self.kind, self._inertial = name, kind, inertial
        self.turning = kind not in frames.FRAMES

    def to_icrf(self, epoch, hi, lo, orbit=None):
        """The quaternions (N, 4) or (4,) from these axes to ICRF, at TDB seconds from an epoch."""
        if not self.turning:
            return frames.wxyz_to_icrf(self.kind)
        hi, lo = pairs.add((hi, 0.0 if lo is None else lo), epoch.seconds, epoch.low)
        return _turned(self.kind, hi, lo, orbit, self.name)

    def angular_velocity(self, epoch, hi, lo, orbit=None):
        """That of these axes themselves, (N, 3) rad/s in ICRF; None where they stand still."""
        if not self.turning or self._inertial:
            return None
        hi, lo = pairs.add((hi, 0.0 if lo is None else lo), epoch.seconds, epoch.low)
        side = np.zeros(hi.shape)
        if self.kind in _OF_ORBIT:
            side = _sides(hi, lo, _known_path(orbit, self.name))
        rates = np.empty((*hi.shape, 3))
        for s in np.unique(side):
            some = side == s

            def turned(h, some=some):
                return _turned(self.kind, hi[some] + h, lo[some], orbit, self.name)

            rates[some] = _central(turned) if s == 0.0 else _one_sided(turned, s)
        return rates


def known(name):
    """The Axes of a name, or None for one that is not in the table above."""
    given = re.sub(r"[-_ ]", "", name).upper()
    if given in _FIXED:
        return Axes(name, _FIXED[given])
    inertial = given.endswith("INERTIAL")
    given = given.removesuffix("INERTIAL").removesuffix("ROTATING")
    if re.fullmatch(r"ITRF(19|20)?\d\d", given):
        given = "ITRF"
    if given in _TURNING:
        return Axes(name, _TURNING[given], inertial=inertial)
    return None


def named(name, keyword="frame"):
    """The Axes of a name; AttitudeError for one that is not known."""
    found = known(name) if isinstance(name, str) else None
    if found is None:
        raise AttitudeError(
            f"{keyword} is {name!r}; known axes are {', '.join(sorted(_FIXED))}, "
            f"{', '.join(sorted(_TURNING))}."
        )
    return found


def _turned(kind, hi, lo, orbit, name):
    if kind in _OF_ORBIT:
        return _orbital(kind, hi, lo, orbit, name)
    return _earthly(kind, hi, lo)


def _orbital(kind, hi, lo, orbit, name):
    orbit = _known_path(orbit, name)
    for end, _, inside in _ends(orbit, hi, lo):
        beyond = (inside < 0.0) & (inside >= -_SAME)
        hi, lo = np.where(beyond, end.seconds, hi), np.where(beyond, end.low, lo)
    position, velocity = orbit.state(epochs.Instant(0.0), hi, lo)
    radial = _unit(position)
    normal = _unit(np.cross(position, velocity))
    if kind == "rtn":
        columns = radial, np.cross(normal, radial), normal
    else:
        columns = np.cross(normal, radial), -normal, -radial
    return forms.from_matrix(np.stack(columns, axis=-1))


def _known_path(orbit: object, name: str) -> Path:
    if isinstance(orbit, Path):
        return orbit
    given = "" if orbit is None else f", and orbit is {type(orbit).__name__}"
    raise AttitudeError(
        f"the attitude refers to {name}, axes of the orbit{given}; give orbit=, the path of the "
        "body about its center (on the command line --orbit, a file of it)."
    )


def _sides(hi, lo, orbit):
    """1 where the path begins less than a step before an epoch, -1 where it ends so soon, or 0."""
    side = np.zeros(hi.shape)
    for _, sign, inside in _ends(orbit, hi, lo):
        side[inside < _STEP] = sign
    return side


def _ends(orbit, hi, lo):
    """Each end of a path that has some, 1 or -1, and how many seconds inside of it epochs lie."""
    for end, sign in zip(orbit.span or (), (1.0, -1.0), strict=False):
        yield end, sign, sign * ((hi - end.seconds) + (lo - end.low))


def _central(turned):
    turn = quaternion.multiply(turned(_STEP), quaternion.conjugate(turned(-_STEP)))
    return forms.to_rotation_vector(turn) / (2.0 * _STEP)


def _one_sided(turned, side):
    """The same from two steps to one side: 4e-11 rad/s in a low orbit of eccentricity 0.05."""
    step, now = side * _STEP, quaternion.conjugate(turned(0.0))
    one, two = (
        forms.to_rotation_vector(quaternion.multiply(turned(k * step), now)) for k in (1, 2)
    )
    return (4.0 * one - two) / (2.0 * step)


def _earthly(kind, hi, lo):
    import erfa

    tt = time_scales.tt_from_tdb(hi, lo)
    tt1, tt2 = time_scales.jd_from_seconds(*tt)
    utc1, utc2 = erfa.ufunc.taiutc(
        *time_scales.jd_from_seconds(*pairs.add(tt, -time_scales.TT_MINUS_TAI))
    )[:2]
    table = time_scales.earth_orientation()
    dut1, status = table.ut1_utc(utc1, utc2, return_status=True)
    if np.any(status < 0):
        raise AttitudeError(
            "an epoch lies outside of the installed table of the Earth's rotation "
            "(astropy-iers-data), which Earth-fixed axes need; update astropy-iers-data."
        )
    ut1, ut2 = erfa.ufunc.utcut1(utc1, utc2, dut1.to_value("s"))[:2]
    x, y = (angle.to_value("rad") for angle in table.pm_xy(utc1, utc2))
    to_itrf = erfa.c2t06a(tt1, tt2, ut1, ut2, x, y)
    if kind == "teme":
        spin = erfa.rz(erfa.gmst82(ut1, ut2), np.eye(3))
        to_itrf = np.swapaxes(erfa.pom00(x, y, 0.0) @ spin, -1, -2) @ to_itrf
    return forms.continuous(forms.from_dcm(to_itrf))


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)
