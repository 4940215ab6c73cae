"""Reference axes of attitudes in files, by their names.

Fixed axes lead to ICRF by one quaternion; turning axes (Earth-fixed, of date, of an orbit) by one
for each epoch, and they have an angular velocity.

========================  =========================================================================
icrf                      ICRF, ICRF1 to ICRF3, GCRF, BCRF
eme2000                   EME2000, J2000 (in CCSDS and STK: with the frame bias of 23 mas)
ecliptic                  ECLIPTIC, ECLIPTICJ2000, ECLIPJ2000
itrf                      ITRF, ITRF-97, ITRF2000, ..., ITRS: IAU 2006/2000A with the Earth
                          orientation of astropy-iers-data
teme                      TEME, TEMEOFDATE
rtn                       RTN, RSW, RIC, QSW: x away from the center, z along the orbit's momentum
lvlh                      LVLH, VVLH: z to the center, y against the orbit's momentum
========================  =========================================================================

Axes of an orbit whose names end in _INERTIAL have rates relative to inertial space; the others,
with _ROTATING or without, have rates relative to the axes as they turn.

Sources: SANA registry of celestial body and orbit-relative reference frames; IERS Conventions
(2010), chapter 5, as in ERFA's c2t06a; Vallado et al., AIAA 2006-6753 (TEME).
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, frames, pairs, quaternion
from attitude import representations as forms
from attitude.epochs import time_scales
from attitude.errors import AttitudeError
from attitude.paths.path import Path

if TYPE_CHECKING:
    from attitude.annotations import FloatArray

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
# Kind -> name in written files.
WRITTEN: dict[str, str] = {
    **{"icrf": "ICRF", "gcrf": "GCRF", "eme2000": "EME2000", "ecliptic": "ECLIPTICJ2000"},
    **{"itrf": "ITRF", "teme": "TEME", "rtn": "RTN", "lvlh": "LVLH"},
}
# Epochs of two files are equal if they differ by at most the last decimal, s.
_SAME = 1e-12
# Step, s, of the differences that give the rate of turning axes: error 6e-14 rad/s for the Earth.
_STEP = 1.0


class Axes:
    """Reference axes: their orientation relative to ICRF and their angular velocity.

    Parameters
    ----------
    name : str
    kind : str
    inertial : bool
        Whether rates in these axes are relative to inertial space.

    Attributes
    ----------
    name : str
        Name in the file.
    kind : str
        "icrf", "gcrf", "eme2000", "ecliptic", "itrf", "teme", "rtn" or "lvlh".
    turning : bool
        Whether the axes turn relative to ICRF.
    """

    def __init__(self, name: str, kind: str, *, inertial: bool = False):
        self.name: str = name
        self.kind: str = kind
        self.turning: bool = kind not in frames.FRAMES
        self._inertial = inertial

    def to_icrf(
        self,
        epoch: epochs.Instant,
        hi: FloatArray | float,
        lo: FloatArray | float | None,
        orbit: Path | None = None,
    ) -> FloatArray:
        """Quaternions from these axes to ICRF, scalar first.

        Parameters
        ----------
        epoch : Instant
        hi, lo : (N,) arrays
            hi + lo are TDB seconds since the epoch; lo may be None.
        orbit : Path, optional
            Path of the body about its center; axes of an orbit need it.

        Returns
        -------
        (4,) array for fixed axes, (N, 4) array for turning ones

        Raises
        ------
        AttitudeError
            If axes of an orbit are given no orbit, or an epoch lies outside of its span or of the
            installed table of Earth orientation.
        """
        if not self.turning:
            return frames.wxyz_to_icrf(self.kind)
        hi, lo = pairs.add((hi, 0.0 if lo is None else lo), epoch.seconds, epoch.low)
        return _turned(self.kind, hi, lo, orbit, self.name)

    def angular_velocity(
        self,
        epoch: epochs.Instant,
        hi: FloatArray,
        lo: FloatArray | float | None,
        orbit: Path | None = None,
    ) -> FloatArray | None:
        """Angular velocity of the axes, (N, 3) rad/s in ICRF; see `to_icrf` for the parameters.

        None for fixed axes, and for axes whose rates are relative to inertial space.
        """
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


def known(name: str) -> Axes | None:
    """The Axes with a name, or None if the table above does not list it."""
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


def named(name: str, keyword: str = "frame") -> Axes:
    """The Axes with a name.

    `keyword` is the name of the argument or of the file's keyword in the error message.

    Raises
    ------
    AttitudeError
        For a name that the table above does not list.
    """
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
    """The path itself; AttitudeError for anything else."""
    if isinstance(orbit, Path):
        return orbit
    given = "" if orbit is None else f", and orbit is {type(orbit).__name__}"
    raise AttitudeError(
        f"the attitude refers to {name}, axes of the orbit{given}; give orbit=, the path of the "
        "body about its center (on the command line --orbit, a file with the path)."
    )


def _sides(hi, lo, orbit):
    """1 if the path begins less than a step before the epoch, -1 if it ends as soon, else 0."""
    side = np.zeros(hi.shape)
    for _, sign, inside in _ends(orbit, hi, lo):
        side[inside < _STEP] = sign
    return side


def _ends(orbit, hi, lo):
    """Ends of the span of a path, if it has one: (end, sign, seconds of the epochs inside of it).

    The sign is 1 for the first end, -1 for the last.
    """
    for end, sign in zip(orbit.span or (), (1.0, -1.0), strict=False):
        yield end, sign, sign * ((hi - end.seconds) + (lo - end.low))


def _central(turned):
    turn = quaternion.multiply(turned(_STEP), quaternion.conjugate(turned(-_STEP)))
    return forms.to_rotation_vector(turn) / (2.0 * _STEP)


def _one_sided(turned, side):
    """Angular velocity from two steps to one side.

    Its error is 4e-11 rad/s in a low Earth orbit of eccentricity 0.05.
    """
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
            "an epoch lies outside of the installed table of Earth orientation, which Earth-fixed "
            "axes need; update the package astropy-iers-data."
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
