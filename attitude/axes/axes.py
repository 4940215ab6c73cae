"""Reference axes of attitudes in files, by their names.

Fixed axes lead to ICRF by one quaternion; turning axes (Earth-fixed, of date, of an orbit) by one
for each epoch, and they have an angular velocity.

========================  =========================================================================
icrf                      ICRF, ICRF1 to ICRF3, GCRF, BCRF
eme2000                   EME2000, J2000 (in CCSDS and STK: with the frame bias of 23 mas)
ecliptic                  ECLIPTIC, ECLIPTICJ2000, ECLIPJ2000
b1950                     B1950, EME1950
itrf, tirs, cirs, gtod    ITRF, ITRF-97, ..., ITRS; TIRS; CIRS; GTOD, TDR: see `earth_axes`
tod, mod, teme            TOD, TOD_EARTH, TRUEOFDATE; MOD, MOD_EARTH, MEANOFDATE; TEME, TEMEOFDATE
rtn, lvlh, tnw, ntw, vnc  RTN, RSW, RIC, QSW; LVLH, VVLH; TNW; NTW; VNC: see `orbit_axes`
========================  =========================================================================

Axes of an orbit whose names end in _INERTIAL have rates relative to inertial space; the others,
with _ROTATING or without, have rates relative to the axes as they turn.  Axes of date at one epoch
are fixed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude import epochs, frames, pairs, quaternion
from attitude import representations as forms
from attitude.axes import axis_names, earth_axes, orbit_axes
from attitude.axes.axis_names import OF_ORBIT, WRITTEN
from attitude.errors import AttitudeError
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.paths.path import Path

__all__ = ["WRITTEN", "Axes", "body_name_fault", "known", "named", "of_pair"]

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
    at : Instant, optional
        Axes of date at this epoch, which are fixed.

    Attributes
    ----------
    name : str
        Name in the file.
    kind : str
        One of the table above, or "gcrf".
    turning : bool
        Whether the axes turn relative to ICRF.
    """

    def __init__(
        self, name: str, kind: str, *, inertial: bool = False, at: epochs.Instant | None = None
    ):
        self.name: str = name
        self.kind: str = kind
        self._at = at
        self.turning: bool = kind not in (*frames.FRAMES, "b1950") and at is None
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
        if self._at is not None:
            one = np.array([self._at.seconds]), np.array([self._at.low])
            return _turned(self.kind, *one, orbit, self.name)[0]
        if self.kind == "b1950":
            return earth_axes.b1950()
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
        if self.kind in OF_ORBIT:
            side = _sides(hi, lo, orbit_axes.known_path(orbit, self.name))
        rates = np.empty((*hi.shape, 3))
        for s in np.unique(side):
            some = side == s

            def turned(h, some=some):
                return _turned(self.kind, hi[some] + h, lo[some], orbit, self.name)

            rates[some] = _central(turned) if s == 0.0 else _one_sided(turned, s)
        return rates


def known(name: str) -> Axes | None:
    """The Axes with a name, or None if the table above does not list it."""
    found = axis_names.meaning(name)
    return None if found is None else Axes(name, found[0], inertial=found[1])


def body_name_fault(name: str) -> str | None:
    """Why a name cannot be that of a body's own axes, as the end of a sentence; None if it can."""
    if axis_names.meaning(name) is not None:
        return "is the name of other axes"
    if axis_names.named_elsewhere(name):
        return "is the name of reference axes that this package does not compute"
    near = axis_names.looks_like(name)
    return None if near is None else f"looks like a misspelled {near}"


def of_pair(a: str, b: str, frame: str | None) -> tuple[Axes, str, bool]:
    """The external axes of a rotation from A to B, the body's name, and whether the body is A.

    Parameters
    ----------
    a, b : str
        REF_FRAME_A and REF_FRAME_B.
    frame : str or None
        The external axes, if their name in the file is not known.

    Raises
    ------
    AttitudeError
        If not one of the two is known external axes and the other a name that a body's own frame
        can have.
    """
    both = [known(name) for name in (a, b)]
    if frame is not None:
        body_is_a = both[0] is None and both[1] is not None
        return named(frame), a if body_is_a else b, body_is_a
    shown = f"REF_FRAME_A is {cut(a)} and REF_FRAME_B is {cut(b)}"
    if both[0] is not None and both[1] is not None:
        raise AttitudeError(
            f"{shown}, both of them known external axes; one of them must be the body's."
        )
    for name in (a, b):
        why = body_name_fault(name)
        if known(name) is None and why is not None:
            raise AttitudeError(
                f"{shown}; {cut(name)} {why}. If it is the body's own frame, name the external "
                "axes with frame=."
            )
    if both[0] is not None:
        return both[0], b, False
    if both[1] is not None:
        return both[1], a, True
    raise AttitudeError(
        f"{shown}, and none is known as ICRF, EME2000, ITRF, TEME, TOD, RTN, LVLH or other "
        "external axes; give the name of the external axes with frame=."
    )


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
            f"{keyword} is {cut(name)}; known axes are {', '.join(sorted(axis_names.FIXED))}, "
            f"{', '.join(sorted(axis_names.TURNING))}."
        )
    return found


def _turned(kind, hi, lo, orbit, name):
    if kind in OF_ORBIT:
        return orbit_axes.to_icrf(kind, hi, lo, orbit, name)
    return earth_axes.to_icrf(kind, hi, lo)


def _sides(hi, lo, orbit):
    """1 if the path begins less than a step before the epoch, -1 if it ends as soon, else 0."""
    side = np.zeros(hi.shape)
    for _, sign, inside in orbit_axes.ends(orbit, hi, lo):
        side[inside < _STEP] = sign
    return side


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
