"""Reference axes of attitudes in files, by their names; histories relative to them.

Fixed axes lead to ICRF by one quaternion; turning axes (Earth-fixed, of date, of an orbit) by one
for each epoch, and they have an angular velocity.

========================  =========================================================================
icrf                      ICRF, ICRF1 to ICRF3, GCRF, BCRF
eme2000                   EME2000, J2000 (in CCSDS and STK: with the frame bias of 23 mas)
ecliptic                  ECLIPTIC, ECLIPTICJ2000, ECLIPJ2000
b1950                     B1950, EME1950
itrf, tirs, cirs, gtod    ITRF, ITRF-97, ..., ITRS; TIRS; CIRS; GTOD, TDR: see `frames._earth`
tod, mod, teme            TOD, TOD_EARTH, TRUEOFDATE; MOD, MOD_EARTH, MEANOFDATE; TEME, TEMEOFDATE
rtn, lvlh, tnw, ntw, vnc  RTN, RSW, RIC, QSW; LVLH, VVLH; TNW; NTW; VNC: see below
========================  =========================================================================

Axes of an orbit whose names end in _INERTIAL have rates relative to inertial space; the others,
with _ROTATING or without, have rates relative to the axes as they turn.  Axes of date at one epoch
are fixed.
"""

from __future__ import annotations

import difflib
import re
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import frames
from attitude._support import pairs, validation
from attitude._support.arrays import between, frozen, units
from attitude._textfiles.lines import cut
from attitude.epochs import _instants
from attitude.errors import AttitudeError
from attitude.frames import _earth
from attitude.frames import quaternion as forms
from attitude.frames import representations as frames_representations
from attitude.frames._earth import normal
from attitude.frames.representations import Attitudes
from attitude.paths._composed import relative
from attitude.paths._foreign import place_of
from attitude.paths._path import Path, label_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from attitude._support.annotations import FloatArray, Reals
    from attitude._support.tables import FlatTable

__all__ = ["WRITTEN", "Axes", "body_name_fault", "known", "named", "of_pair"]


# ---- Names of reference axes in files, and what each of them means
# Three sorts: axes that this package computes (`meaning`), axes that standards name but this
# package does not compute (`named_elsewhere`), and names that look like one of both but are none
# (`looks_like`).  None of the three can be the name of a body's own axes.
#
# Source: SANA registries of celestial body, orbit-relative and spacecraft body reference frames.

FIXED: dict[str, str] = _earth.FIXED_NAMES
TURNING: dict[str, str] = {
    **_earth.TURNING_NAMES,
    **dict.fromkeys(("RTN", "RSW", "RIC", "QSW"), "rtn"),
    **dict.fromkeys(("LVLH", "VVLH"), "lvlh"),
    **{"TNW": "tnw", "NTW": "ntw", "VNC": "vnc"},
}
# What sentences say of axes that a file does not name.
AS_FRAME: str = "frame=, such as frame='ICRF' (on the command line --frame-in)"
OF_ORBIT: tuple[str, ...] = ("rtn", "lvlh", "tnw", "ntw", "vnc")
# Axes at one epoch that the file gives (STK): name -> kind of the axes of date.
OF_EPOCH: dict[str, str] = {"TRUEOFEPOCH": "tod", "MEANOFEPOCH": "mod", "TEMEOFEPOCH": "teme"}
# Kind -> name in written files.
WRITTEN: dict[str, str] = {
    **{kind: kind.upper() for kind in ("gcrf", *FIXED.values(), *TURNING.values())},
    "ecliptic": "ECLIPTICJ2000",
}
# Axes that the registries name and that are not computed here.
_ELSEWHERE = re.compile(
    r"(NSW|SEZ|PQW|EQW|ENU|NED|LTP|GRC|GRCS|EFG|FIXED|FK4|DTRF(19|20)?\d\d|UVWGO|UVW|ECI|ECEF|ECF|INERTIAL"
    r"|ALIGN(CB|EARTH)|FIXED(CB|EARTH|MOON)?|(MOE|TOE|TEME?OE|TEMEOFEPOCH|TRUEOFEPOCH|MEANOFEPOCH)"
    r"|(MOD|TOD|MOE|TOE)(CB|MOON)|MOON(ME|MEIAUE|PA)\w*|MCI|MEIAU\w*|PALUN\w*|LVLHMOON)"
)
# Names of axes of spacecraft and their parts in the registry, with or without a number.
_OF_BODIES = re.compile(
    r"(ACC|ACTUATOR|AST|CSS|DSS|ESA|GYRO(FRAME)?|IMU(FRAME)?|INSTRUMENT|MTA|RW|SA|SC(BODY)?"
    r"|SENSOR|STARTRACKER|TAM|SCFRAME)\w{0,4}"
)
_ALIKE = 0.86


def meaning(name: str) -> tuple[str, bool] | None:
    """Kind of axes that a name means, and whether rates in them are relative to inertial space.

    None for other names.

    >>> meaning("LVLH_ROTATING"), meaning("ITRF-97"), meaning("SC_BODY_1")
    (('lvlh', False), ('itrf', False), None)
    """
    plain = normal(name)
    if plain in FIXED:
        return FIXED[plain], False
    inertial = plain.endswith("INERTIAL")
    plain = plain.removesuffix("INERTIAL").removesuffix("ROTATING")
    kind = TURNING.get(plain) or _earth.kind_of(plain)
    return None if kind is None or plain in FIXED else (kind, inertial)


def named_elsewhere(name: str) -> bool:
    """Whether a standard gives this name to axes that this package does not compute."""
    plain = normal(name)
    stem = plain.removesuffix("INERTIAL").removesuffix("ROTATING")
    return any(map(_ELSEWHERE.fullmatch, (plain, stem)))


def looks_like(name: str) -> str | None:
    """The name of known axes of which another name is probably a misspelling, or None.

    >>> looks_like("LVLHX"), looks_like("EME200"), looks_like("SC_BODY_1"), looks_like("SPACECRAFT")
    ('LVLH', 'EME2000', None, None)
    """
    plain = normal(name).removesuffix("INERTIAL").removesuffix("ROTATING")
    if _OF_BODIES.fullmatch(plain):
        return None
    # Names of three letters differ by one letter from many.
    longer = [word for word in (*FIXED, *TURNING) if len(word) > 3]
    alike = difflib.get_close_matches(plain, longer, n=1, cutoff=_ALIKE)
    if not alike:
        known = "|".join(sorted((*TURNING, *FIXED), key=len, reverse=True))
        matched = re.fullmatch(rf"({known})(ROTATING|INERTIAL)?[A-Z0-9]?", plain)
        alike = [matched.group(1)] if matched and meaning(name) is None else []
    return alike[0] if alike else None


# ---- Axes of an orbit, from the position and velocity of the body about its center
# rtn   x away from the center, z along the orbit's momentum
# lvlh  z to the center, y against the orbit's momentum
# tnw   x along the velocity, z along the orbit's momentum
# ntw   y along the velocity, z along the orbit's momentum
# vnc   x along the velocity, y along the orbit's momentum
#
# Source: SANA registry of orbit-relative reference frames.

# Epochs of two files are equal if they differ by at most the last decimal, s.
_SAME = 1e-12


def to_icrf(kind: str, hi: FloatArray, lo: FloatArray, orbit: Path | None, name: str) -> FloatArray:
    """Quaternions (N, 4) to ICRF from axes of an orbit; hi, lo (N,)."""
    position, velocity = state(hi, lo, orbit, name)
    momentum = np.cross(position, velocity)
    _refuse_no_plane(momentum, -1, orbit)
    normal = units(momentum)
    if kind in ("rtn", "lvlh"):
        radial = units(position)
        transverse = np.cross(normal, radial)
        columns = (radial, transverse, normal) if kind == "rtn" else (transverse, -normal, -radial)
    else:
        along = units(velocity)
        columns = {
            "tnw": (along, np.cross(normal, along), normal),
            "ntw": (np.cross(along, normal), along, normal),
            "vnc": (along, normal, np.cross(along, normal)),
        }[kind]
    return forms.from_matrix(np.stack(columns, axis=-1))


def state(
    hi: FloatArray, lo: FloatArray, orbit: Path | None, name: str
) -> tuple[FloatArray, FloatArray]:
    """Position (N, 3) m and velocity (N, 3) m/s, over ICRF axes; see `to_icrf`."""
    orbit = known_path(orbit, name)
    for end, _, inside in ends(orbit, hi, lo):
        beyond = (inside < 0.0) & (inside >= -_SAME)
        hi, lo = np.where(beyond, end.seconds, hi), np.where(beyond, end.low, lo)
    position, velocity = orbit.state(_instants.J2000, hi, lo)
    return position, velocity


def known_path(orbit: object, name: str) -> Path:
    """The path itself; AttitudeError for anything else."""
    if isinstance(orbit, Path):
        return orbit
    hint = "" if orbit is None else f", and orbit is {type(orbit).__name__}"
    raise AttitudeError(
        f"the attitude refers to {cut(name, '')}, axes of the orbit{hint}; give orbit=, the path "
        "of the body about its center (on the command line --orbit, a file with the path)."
    )


def ends(
    orbit: Path, hi: FloatArray, lo: FloatArray
) -> Iterator[tuple[_instants.Instant, float, FloatArray]]:
    """Ends of the span of a path, if any: (end, 1 first or -1 last, seconds of epochs within)."""
    for end, sign in zip(orbit.span or (), (1.0, -1.0), strict=False):
        yield end, sign, sign * ((hi - end.seconds) + (lo - end.low))


def _refuse_no_plane(momentum, axis, orbit):
    """AttitudeError where the momentum of an orbit, its components along an axis, is zero."""
    if not momentum.any(axis).all():
        raise AttitudeError(
            f"{orbit.name} rests relative to {label_of(orbit.center)}, or moves straight to or "
            "from it, so that its orbit has no plane; give the path of a body about its center."
        )


# Step, s, of the differences that give the rate of turning axes: error 6e-14 rad/s for the Earth.
_STEP = 1.0


class Axes:
    """Reference axes: their orientation relative to ICRF and their angular velocity.

    inertial: whether rates in these axes are relative to inertial space.
    at: axes of date at this epoch, which are fixed.

    name: name in the file.
    kind: one of the table above, or "gcrf".
    turning: whether the axes turn relative to ICRF.
    """

    def __init__(
        self, name: str, kind: str, *, inertial: bool = False, at: _instants.Instant | None = None
    ):
        self.name: str = name
        self.kind: str = kind
        self._at = at
        self.turning: bool = kind not in (*frames.FRAMES, "b1950") and at is None
        self._inertial = inertial

    def to_icrf(
        self,
        epoch: _instants.Instant,
        hi: FloatArray,
        lo: FloatArray | None,
        orbit: Path | None = None,
    ) -> FloatArray:
        """Quaternions from these axes to ICRF, scalar first; hi, lo (N,)."""
        if self._at is not None:
            hi, lo = np.array([self._at.seconds]), np.array([self._at.low])
            return _turned(self.kind, hi, lo, orbit, self.name)[0]
        if self.kind == "b1950":
            return _earth.b1950()
        if not self.turning:
            return frames.wxyz_to_icrf(self.kind)
        hi, lo = pairs.Seconds(hi, lo).plus(epoch.seconds, epoch.low)
        return _turned(self.kind, hi, lo, orbit, self.name)

    def angular_velocity(
        self,
        epoch: _instants.Instant,
        hi: FloatArray,
        lo: FloatArray | None,
        orbit: Path | None = None,
    ) -> FloatArray | None:
        """Angular velocity (N, 3), rad/s in ICRF; None for fixed axes and for inertial rates."""
        if not self.turning or self._inertial:
            return None
        hi, lo = pairs.Seconds(hi, lo).plus(epoch.seconds, epoch.low)
        side = np.zeros(hi.shape)
        if self.kind in OF_ORBIT:
            side = _sides(hi, lo, known_path(orbit, self.name))
        rates = np.empty((*hi.shape, 3))
        for s in np.unique(side):
            some = side == s

            def turned(h, some=some):
                return _turned(self.kind, hi[some] + h, lo[some], orbit, self.name)

            rates[some] = _central(turned) if s == 0.0 else _one_sided(turned, s)
        return rates


def known(name: str) -> Axes | None:
    """The Axes with a name, or None if the table above does not list it."""
    axes = meaning(name)
    return None if axes is None else Axes(name, axes[0], inertial=axes[1])


def body_name_fault(name: str) -> str | None:
    """Why a name cannot be that of a body's own axes, as the end of a sentence; None if it can."""
    if meaning(name) is not None:
        return "is the name of other axes"
    if named_elsewhere(name):
        return "is the name of reference axes that this package does not compute"
    alike = looks_like(name)
    return None if alike is None else f"looks like a misspelled {alike}"


def of_pair(a: str, b: str, frame: str | None) -> tuple[Axes, str, bool]:
    """The external axes of a rotation from A to B, the body's name, and whether the body is A."""
    axes_of_a, axes_of_b = known(a), known(b)
    if frame is not None:
        body_is_a = axes_of_a is None and axes_of_b is not None
        return named(frame), a if body_is_a else b, body_is_a
    shown = f"REF_FRAME_A is {cut(a)} and REF_FRAME_B is {cut(b)}"
    if axes_of_a is not None and axes_of_b is not None:
        raise AttitudeError(
            f"{shown}, both of them known external axes; one of them must be the body's."
        )
    for name in (a, b):
        why = body_name_fault(name)
        if known(name) is None and why is not None:
            raise AttitudeError(
                f"{shown}; {cut(name)} {why}. If it is the body's own frame, name the external "
                f"axes with {AS_FRAME}."
            )
    if axes_of_a is not None:
        return axes_of_a, b, False
    if axes_of_b is not None:
        return axes_of_b, a, True
    raise AttitudeError(
        f"{shown}, and none is known as ICRF, EME2000, ITRF, TEME, TOD, RTN, LVLH or other "
        f"external axes; give the name of the external axes with {AS_FRAME}."
    )


def named(name: str, keyword: str = "frame") -> Axes:
    """The Axes with a name; `keyword` is of the argument or of the file in the error."""
    axes = known(name) if isinstance(name, str) else None
    if axes is None:
        raise AttitudeError(
            f"{keyword} is {cut(name)}; known axes are {', '.join(sorted(FIXED))}, "
            f"{', '.join(sorted(TURNING))}."
        )
    return axes


def _turned(kind, hi, lo, orbit, name):
    """Quaternions (N, 4) to ICRF from turning axes, NaN at epochs that are NaN."""
    known = ~np.isnan(hi + lo)
    wxyz = np.full((*known.shape, 4), np.nan)
    if known.any():
        at = hi[known], np.broadcast_to(lo, known.shape)[known]
        of_orbit = kind in OF_ORBIT
        wxyz[known] = to_icrf(kind, *at, orbit, name) if of_orbit else _earth.to_icrf(kind, *at)
    return wxyz


def _sides(hi, lo, orbit):
    """1 if the path begins less than a step before the epoch, -1 if it ends as soon, else 0."""
    side = np.zeros(hi.shape)
    for _, sign, inside in ends(orbit, hi, lo):
        side[inside < _STEP] = sign
    return side


def _central(turned):
    turn = forms.multiply(turned(_STEP), forms.conjugate(turned(-_STEP)))
    return frames_representations.to_rotation_vector(turn) / (2.0 * _STEP)


def _one_sided(turned, side):
    """Angular velocity from two steps to one side, to 4e-11 rad/s in a low orbit."""
    step, now = side * _STEP, forms.conjugate(turned(0.0))
    one, two = (
        frames_representations.to_rotation_vector(forms.multiply(turned(k * step), now))
        for k in (1, 2)
    )
    return (4.0 * one - two) / (2.0 * step)


# ---- A history relative to other axes than ICRF: of an orbit, of the Earth, or inertial ones

# Epochs at a time, so that temporary arrays stay in the caches.
_BLOCK = 1 << 13


class FramedHistory(Attitudes):
    """Attitudes and rates relative to named axes; made by ``history.in_frame``.

    S is the shape of the epochs.

    history: relative to ICRF.
    seconds: TDB seconds (S) since the epoch of the history.
    frame: as given, in lower case.
    wxyz: (S, 4), body to frame, scalar first; continuous in sign along one row of epochs.
    """

    history: Any
    frame: str

    def __init__(self, history: Any, frame: str, orbit: Any = None) -> None:
        known = named(frame)
        if normal(frame) == "J2000":
            frames.known(frame)  # which raises: the name means EME2000 in files only
        self._set_all(
            history=history, seconds=history.seconds, frame=str(frame).lower(), _axes=known
        )
        self._axes: Axes
        self._orbit: Path | None
        self._set("_orbit", _orbit_of(orbit, known.kind, frame))
        to_icrf = known.to_icrf(history.epoch, *self._flat_epochs(), orbit=self._orbit)
        self._set("_to_icrf", np.broadcast_to(to_icrf, (self.seconds.size, 4)))
        self._to_icrf: FloatArray
        wxyz = forms.multiply(forms.conjugate(self._to_icrf), history.wxyz.reshape(-1, 4))
        if self.seconds.ndim == 1:
            wxyz = frames_representations.continuous(wxyz)
        self._set("wxyz", frozen(wxyz.reshape(*self.shape, 4)))

    def _flat_epochs(self) -> tuple[FloatArray, FloatArray]:
        return pairs.Seconds.of(self.history).flat

    @cached_property
    def angular_velocity(self) -> FloatArray:
        """(S, 3) rad/s relative to the frame, over the body axes."""
        rates = self.history.angular_velocity
        turning = self._axes.angular_velocity(
            self.history.epoch, *self._flat_epochs(), orbit=self._orbit
        )
        if turning is None:
            return frozen(np.array(rates))
        return frozen(rates - self.history.inertial_to_body(turning.reshape(*self.shape, 3)))

    @cached_property
    def angular_velocity_in_frame(self) -> FloatArray:
        """(S, 3) rad/s relative to the frame, over the axes of the frame."""
        return frozen(self.body_to_frame(self.angular_velocity))

    def body_to_frame(self, v: Reals) -> FloatArray:
        """Components (S, 3) in the frame of vectors (3,) or (S, 3) in body axes."""
        return forms.rotate(self.wxyz, validation.rows(v, "v", 3))

    def frame_to_body(self, v: Reals) -> FloatArray:
        """Components (S, 3) in body axes of vectors (3,) or (S, 3) in the frame."""
        return forms.rotate(forms.conjugate(self.wxyz), validation.rows(v, "v", 3))

    def table(self, *, rates: bool = True) -> FlatTable:
        """An astropy QTable: time (TDB), wxyz, angular_velocity (rad/s, over the body axes).

        AttitudeError for epochs of any shape other than (N,).
        """
        columns: FlatTable = self.history.table(rates=rates)
        columns["wxyz"] = np.array(self.wxyz)
        if rates:
            columns["angular_velocity"] = (
                np.array(self.angular_velocity) * columns["angular_velocity"].unit
            )
        name = self.frame.upper()
        columns.meta.update(frame=name, wxyz=f"body to {name}, scalar first")
        return columns

    def to_pandas(self, *, rates: bool = True) -> Any:
        """A pandas DataFrame with an index of UTC: the columns of `table`, a component each."""
        return self.table(rates=rates).to_pandas().set_index("time")

    def __repr__(self) -> str:
        return f"<FramedHistory of {self.seconds.size} epochs in {self.frame.upper()}>"


def _orbit_of(orbit: Any, kind: str, frame: str) -> Path | None:
    """The path of an orbit about its focus, if the axes need one."""
    if kind not in OF_ORBIT:
        return None
    place = place_of(orbit, "orbit")
    orbit = orbit if place is None else place
    if not isinstance(orbit, Path):
        hint = "" if orbit is None else f", and orbit is {validation.shown(orbit)}"
        raise AttitudeError(
            f"{frame} are axes of an orbit{hint}; give orbit=, the path of the body about its "
            'center: paths.tle("x.tle"), paths.oem("x.oem"), paths.kepler(...).'
        )
    if orbit.center == "ssb":
        raise AttitudeError(
            f"orbit is the path of {orbit.name} about the barycenter of the solar system; give it "
            'about the focus of the orbit: paths.relative(path, "earth").'
        )
    return orbit


def obliquity(
    pole: FloatArray, orbit: Any, instant: _instants.Instant, hi: FloatArray, lo: FloatArray
) -> FloatArray:
    """Angles, of the shape of hi, of a pole (3,) to the momentum of an orbit, 0 to pi rad."""
    place = place_of(orbit, "orbit")
    known = orbit if place is None else place
    if not isinstance(known, Path):
        raise AttitudeError(
            f"orbit is {validation.shown(orbit)}; give the path of the body: paths.mpc_orbit(...), "
            "paths.kepler(...), paths.tle(...)."
        )
    if known.center == "ssb":
        known = relative(known, "sun")
    shape, pole = np.shape(hi), np.atleast_2d(pole).T
    hi, lo = np.ravel(hi), np.ravel(np.broadcast_to(lo, shape))
    angles = np.empty(hi.size)
    for begin in range(0, hi.size, _BLOCK):
        block = slice(begin, begin + _BLOCK)
        position, velocity = known.state(instant, hi[block], lo[block])
        momentum = _cross(position.T, velocity.T)
        _refuse_no_plane(momentum, 0, known)
        angles[block] = between(momentum, pole if pole.shape[1] == 1 else pole[:, block])
    return angles.reshape(shape)


def _cross(a, b):
    """a x b (3, N) of rows of components, which numpy's cross would copy."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
