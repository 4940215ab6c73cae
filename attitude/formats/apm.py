"""CCSDS Attitude Parameter Messages, versions 1.0 and 2.0, KVN and XML: one state and the inertia.

An APM with inertia and angular velocity determines a Body and a Spin; a FreeRotation is written as
one APM.  Conventions of quaternions, angles, rates and spin are those of `_records`; the
sign of the products of inertia is that of each version's book unless `products` is given (see
`_messages`).  Maneuvers are kept among the keywords only.

If a message has the attitude in several forms, the first of quaternion, Euler angles and spin is
used, and for the rates the first of ANGVEL, derivatives of the quaternion, of the angles, spin.  Of
several blocks of a name those whose axes cannot be computed are left out; those of one body must
agree.
"""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._textfiles import messages
from attitude._textfiles.lines import cut, prefixed
from attitude._textfiles.messages import Form, Generator, comparable
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.formats import _messages, _records
from attitude.formats._format import OpenedFile, message_labels, refuse_foreign, register_message
from attitude.formats._messages import GROUPS, INERTIA, OLD_ANGLES, OLD_INERTIA, OLD_RATES, VERSIONS
from attitude.formats._records import (
    ANGLES,
    ANGLES_DOT,
    ANGVEL,
    Q_DOT,
    SPIN,
    TOLERANCE,
    Convention,
    Q,
    in_icrf,
    known_tolerance,
    refuse_length,
)
from attitude.formats._sampling import refuse_breaks
from attitude.frames import quaternion as forms
from attitude.frames import representations as frames_representations
from attitude.motions import _axes as motions_axes
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.motions._table import AttitudeTable, refuse_speed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import FilePath, FloatArray
    from attitude.epochs._instants import Instant
    from attitude.paths._path import Path

__all__ = ["Parameters", "read", "write"]


# ---- The table of keywords; blocks have those of version 2, and some of version 1 that it lacks

_NUTATION = ("NUTATION", "NUTATION_PER", "NUTATION_PHASE")
_MOMENTUM = ("MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL")
_FRAMES = ("REF_FRAME_A", "REF_FRAME_B")
_MANEUVER = ("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME")
_TORQUE = ("MAN_TOR_X", "MAN_TOR_Y", "MAN_TOR_Z")

_OLD: dict[str, tuple[str, str]] = {
    **{name: ("QUAT", name) for name in (*Q, *Q_DOT)},
    **{name: ("EULER", name) for name in ("EULER_ROT_SEQ", "RATE_FRAME")},
    **{name: ("EULER", name) for name in (*OLD_ANGLES, *OLD_RATES)},
    **{name: ("SPIN", name) for name in (*SPIN, *_NUTATION)},
    **{name: ("MAN", name) for name in _MANEUVER},
    **{f"MAN_TOR_{k + 1}": ("MAN", name) for k, name in enumerate(_TORQUE)},
    **{old: ("INERTIA", new) for old, new in zip(OLD_INERTIA, INERTIA, strict=True)},
    "INERTIA_REF_FRAME": ("INERTIA", "INERTIA_REF_FRAME"),
}
for _prefix, _name in (("Q", "QUAT"), ("EULER", "EULER"), ("SPIN", "SPIN")):
    _OLD |= {f"{_prefix}_FRAME_{k}": (_name, f"REF_FRAME_{k}") for k in "AB"}
    _OLD[f"{_prefix}_DIR"] = _name, "DIR"

_FORM = Form(
    "APM",
    VERSIONS,
    _messages.HEADER,
    meta=("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "TIME_SYSTEM", "EPOCH"),
    blocks={
        "QUAT": (*_FRAMES, *Q, *Q_DOT),
        "EULER": (*_FRAMES, "EULER_ROT_SEQ", *ANGLES, *ANGLES_DOT),
        "ANGVEL": (*_FRAMES, "ANGVEL_FRAME", *ANGVEL),
        "SPIN": (*_FRAMES, *SPIN, *_NUTATION, *_MOMENTUM),
        "INERTIA": ("INERTIA_REF_FRAME", *INERTIA),
        "MAN": (*_MANEUVER, *_TORQUE, "MAN_DELTA_MASS"),
    },
    needed=("OBJECT_NAME", "OBJECT_ID", "TIME_SYSTEM", "EPOCH"),
    units=_messages.UNITS,
    elements={
        **dict.fromkeys(("eulerAngleState", "eulerElementsThree"), "EULER"),
        **dict.fromkeys(("spin", "eulerElementsSpin"), "SPIN"),
        **dict.fromkeys(("inertia", "spacecraftParameters"), "INERTIA"),
        "quaternionState": "QUAT",
        "angularVelocity": "ANGVEL",
        "maneuverParameters": "MAN",
    },
    repeated=(*OLD_ANGLES, *OLD_RATES),  # for sequences such as 313
    old=_OLD,
    groups=("quaternion", "quaternionDot", "quaternionRate", "rotationAngles", "rotationRates"),
    anywhere=("EPOCH",),
)


# ---- Attitude and rates from the blocks of a message

# Block -> attitude types, and keywords of which one says that it is of this type.
_KINDS: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    "QUAT": (("QUATERNION/DERIVATIVE", Q_DOT), ("QUATERNION", ())),
    "EULER": (("EULER_ANGLE/DERIVATIVE", ANGLES_DOT), ("EULER_ANGLE", ())),
    "SPIN": (
        ("SPIN/NUTATION", ("NUTATION",)),
        ("SPIN/NUTATION_MOM", ("MOMENTUM_ALPHA",)),
        ("SPIN", ()),
    ),
}


class _BlockState(NamedTuple):
    """What a block holds: attitude (4,), rates or a function of the attitude, or None; the body."""

    block: Any
    body: str
    wxyz: Any
    rates: Any


class _State:
    """The state in the blocks of a message; parameters as in `apm.read`."""

    def __init__(self, message, epoch, tolerance, frame, orbit, rates):
        self._message, self._tolerance, self._frame, self._rates = message, tolerance, frame, rates
        # What axes turn with.
        self._where = epoch, np.zeros(1), np.zeros(1), orbit
        self._is_old = message.version == "1.0"

    def result(self):
        """Attitude and rates, each from the first block that has it; name of the body's axes."""
        message = self._message
        states = [self._state(b) for name in ("ANGVEL", *_KINDS) for b in self._known(name)]
        attitudes = [state for state in states if state.wxyz is not None]
        if not attitudes:
            if message.all("INERTIA") and not message.all("ANGVEL"):
                return None, None, None
            raise message.fault("the message has no attitude.", None)
        first = attitudes[0]
        for state in attitudes[1:]:
            self._refuse_contradiction(first, state)
        rated = [state for state in states if state.rates is not None]
        of_body = [state for state in rated if comparable(state.body) == comparable(first.body)]
        if rated and not of_body:
            other = rated[0]
            raise other.block.fault(
                f"the block {other.block.name} has the rates of {cut(other.body, '')}, but the "
                f"block {first.block.name} the attitude of {cut(first.body, '')}; a message is "
                "read for one body: delete one of the blocks."
            )
        with message.meta.located():
            return first.wxyz, self._rates_of_body(of_body, first.wxyz), first.body

    def _known(self, name):
        """The blocks of a name; of several, those in axes that can be computed, if there are."""
        blocks = self._message.all(name)
        return [block for block in blocks if self._is_known(block)] or blocks[:1]

    def _is_known(self, block):
        """Whether the axes of a block can be computed, or it lacks their names and is refused."""
        if not block.keys() >= set(_FRAMES):
            return True
        try:
            axes = _messages.axes_of(block, self._frame)[0]
        except AttitudeError:
            return False
        return axes.kind not in motions_axes.OF_ORBIT or self._where[3] is not None

    def _state(self, block):
        """The _BlockState of a block."""
        with block.located():
            of_block = self._angvel if block.name == "ANGVEL" else self._of_block
            return _BlockState(block, _messages.axes_of(block, self._frame)[1], *of_block(block))

    def _rates_of_body(self, states, wxyz):
        """The rates of the first of some states, if any; AttitudeError if its like differ."""
        rates = None
        for state in [state for state in states if state.block.name == states[0].block.name]:
            speed = state.rates(wxyz) if callable(state.rates) else state.rates
            refuse_speed(speed)
            rates = speed if rates is None else rates
            apart = np.linalg.norm(speed - rates)
            if apart > 10.0 * self._tolerance * np.linalg.norm(rates):
                raise state.block.fault(
                    f"its rates are {apart:.3g} rad/s from those of the block {state.block.name} "
                    f"in line {states[0].block.line}; delete one of the blocks."
                )
        return rates

    def _refuse_contradiction(self, one, two):
        """AttitudeError for attitudes of one body in two blocks of a name that differ."""
        names = comparable(one.body), one.block.name
        if names != (comparable(two.body), two.block.name):
            return
        turn = forms.multiply(forms.conjugate(one.wxyz), two.wxyz)
        angle = frames_representations.to_axis_angle(turn)[1]
        if angle > 10.0 * self._tolerance:
            raise two.block.fault(
                f"its attitude is {angle:.3g} rad from that of the block {two.block.name} in line "
                f"{one.block.line}; delete one of the blocks."
            )

    def _of_block(self, block):
        """Attitude and rates of a block; rates may be a function of the attitude."""
        axes, to_body, body_is_a = self._axes(block)
        sequence = _messages.sequence_of(block) if block.name == "EULER" else None
        convention = Convention(to_body=to_body, sequence=sequence)
        if block.name == "EULER" and self._is_old:
            return self._old_euler(block, convention, axes, body_is_a)
        kinds = _KINDS[block.name]
        kind = next(kind for kind, words in kinds if not words or block.keys() & set(words))
        row = [block.number(name) for name in _records.COLUMNS[kind]]
        if block.name == "QUAT":
            place = [block.lines["QC"]]
            refuse_length(np.array([row[:4]]), place, self._tolerance, self._message.fault)
        return self._relative(kind, row, convention, axes)

    def _axes(self, block):
        """The external axes; whether the rotation leads from them to the body; whether A is it."""
        axes, _, body_is_a = _messages.axes_of(block, self._frame)
        is_turned = self._is_old and block.one_of("DIR", ("A2B", "B2A")) == "B2A"
        return axes, body_is_a == is_turned, body_is_a

    def _relative(self, kind, row, convention, axes):
        """Attitude (4,) and rates (3,) relative to ICRF from the numbers of an attitude type."""
        wxyz, rates = in_icrf(kind, np.array([row]), convention, axes, self._where)
        return wxyz[0], None if rates is None else rates[0]

    def _old_euler(self, block, convention, axes, body_is_a):
        """Version 1: angles under the names of their axes, rates over the axes of a frame."""
        letters = [name[0] for name, _, _ in block.order if name.endswith("_RATE")]
        is_of_angles = self._rates == "euler" or len(set(letters)) < len(letters)
        angles = _by_axis(block, "ANGLE", convention.sequence)
        rates = _by_axis(block, "RATE", convention.sequence if is_of_angles else None)
        wxyz = None
        if angles is not None:
            wxyz = self._relative("EULER_ANGLE", angles, convention, axes)[0]
        if rates is None:
            return wxyz, None
        if is_of_angles:
            return wxyz, self._rates_of(np.radians(rates), axes, convention=convention)
        if self._rates is None:
            _records.warn(self._message.path, "the block of Euler angles")
        frames = {"EULER_FRAME_A": body_is_a, "EULER_FRAME_B": not body_is_a}
        over_body = frames[block.one_of("RATE_FRAME", frames)]
        return wxyz, self._rates_of(np.radians(rates), axes, over_body)

    def _angvel(self, block):
        """No attitude, and the rates of a block of version 2, as a function of the attitude."""
        axes, to_body, body_is_a = self._axes(block)
        values = [block.number(name) for name in ANGVEL]
        choices = {block["REF_FRAME_A"]: body_is_a, block["REF_FRAME_B"]: not body_is_a}
        over_body = choices[block.one_of("ANGVEL_FRAME", choices)]
        rates = np.radians(values) * (1.0 if to_body else -1.0)
        return None, self._rates_of(rates, axes, over_body)

    def _rates_of(self, rates, axes, over_body=True, convention=None):
        """A function: attitude -> rates in ICRF; `convention`: from derivatives of the angles."""
        refuse_speed(rates)

        def of(wxyz):
            body, relative = forms.conjugate(wxyz), rates
            outer = axes.to_icrf(*self._where).reshape(4)
            if convention is not None:
                inner = forms.multiply(forms.conjugate(outer), wxyz)[None]
                relative = _records.of_euler_derivatives(inner, rates[None], convention)[0]
            elif not over_body:
                relative = forms.rotate(forms.multiply(body, outer), rates)
            turning = axes.angular_velocity(*self._where)
            return relative if turning is None else relative + forms.rotate(body, turning[0])

        return of


def _by_axis(block, what, sequence):
    """Values of X_ANGLE, ... in the order of a sequence, or of X, Y, Z; None without any."""
    items = [item for item in block.order if item[0].endswith(f"_{what}")]
    if not items:
        return None
    needed = [f"{axis}_{what}" for axis in sequence or "XYZ"]
    names = [name for name, _, _ in items]
    if sorted(names) != sorted(needed):
        raise block.message.fault(
            f"the block EULER has {', '.join(names)}; {sequence or 'rates'} needs "
            f"{', '.join(needed)}.",
            items[0][2],
        )
    values = []
    for name in needed:
        place = next(k for k, item in enumerate(items) if item[0] == name)
        _, text, line = items.pop(place)
        block[name], block.lines[name] = text, line
        values.append(block.number(name))
    return values


# ---- Writing

# Block -> its element in each version, of the blocks that are written.
_ELEMENTS = {
    "1.0": {
        "QUAT": "quaternionState",
        "EULER": "eulerElementsThree",
        "INERTIA": "spacecraftParameters",
    },
    "2.0": {"QUAT": "quaternionState", "ANGVEL": "angularVelocity", "INERTIA": "inertia"},
}


def _blocks(version, frame, body, wxyz, rates, meaning):
    """The blocks, names and entries, of attitude (4,) and rates (3,)."""
    quaternions = [*zip(Q, np.roll(wxyz, -1).tolist(), strict=True)]
    if version == "1.0":
        dots = np.roll(frames_representations.quaternion_rate(wxyz, rates), -1).tolist()
        first = [("Q_FRAME_A", frame), ("Q_FRAME_B", body), ("Q_DIR", "A2B")]
        blocks = [("QUAT", [*first, *quaternions, *zip(Q_DOT, dots, strict=True)])]
        if meaning is not None:
            blocks.append(("EULER", _euler(frame, body, wxyz, rates, meaning)))
        return blocks
    frames = [("REF_FRAME_A", frame), ("REF_FRAME_B", body)]
    speeds = zip(ANGVEL, np.degrees(rates).tolist(), strict=True)
    rated = [*frames, ("ANGVEL_FRAME", body), *speeds]
    return [("QUAT", [*frames, *quaternions]), ("ANGVEL", rated)]


def _euler(frame, body, wxyz, rates, meaning):
    """The keywords of the block of Euler angles of version 1."""
    angles = frames_representations.to_euler("ZYX", wxyz)
    speeds = np.degrees(rates)[::-1]
    if meaning == "euler":
        speeds = np.degrees(frames_representations.euler_rates("ZYX", angles, rates))
    return [
        ("EULER_FRAME_A", frame),
        ("EULER_FRAME_B", body),
        ("EULER_DIR", "A2B"),
        ("EULER_ROT_SEQ", "321"),
        ("RATE_FRAME", "EULER_FRAME_B"),
        *zip(OLD_ANGLES[::-1], np.degrees(angles).tolist(), strict=True),
        *zip(OLD_RATES[::-1], speeds.tolist(), strict=True),
    ]


def _inertia(version, body, frame, products):
    """The block of inertia."""
    if body.relative:
        raise AttitudeError(
            "the moments of the body are relative, but an APM has kg m2; give moments in kg m2, or "
            "inertia=False."
        )
    values = _messages.inertia_values(body.tensor, products, version)
    names = OLD_INERTIA if version == "1.0" else INERTIA
    return "INERTIA", [("INERTIA_REF_FRAME", frame), *zip(names, values, strict=True)]


@dataclass(frozen=True, eq=False)
class Parameters:
    """The content of an APM.

    Attributes
    ----------
    epoch : Instant
    wxyz : (4,) array or None
        Attitude, body to ICRF, scalar first; None in a message with an inertia alone.
    angular_velocity : (3,) array or None
        rad/s over the body axes, relative to inertial space.
    body : Body or None
        Over the axes that INERTIA_REF_FRAME names (``meta["inertia_frame"]``).
    meta : dict
        Keywords of the header, the meta data and each block, and comments.
    """

    epoch: Instant
    wxyz: FloatArray | None
    angular_velocity: FloatArray | None
    body: Body | None
    meta: dict[str, Any] = field(repr=False)

    @property
    def spin(self) -> Spin:
        """The Spin, in ICRF; AttitudeError if the message has no attitude or angular velocity."""
        if self.wxyz is None or self.angular_velocity is None:
            lacking = "attitude" if self.wxyz is None else "angular velocity"
            raise AttitudeError(
                f"the message has no {lacking}; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        return Spin(self.epoch, self.wxyz, self.angular_velocity)

    @property
    def motion(self) -> FreeRotation:
        """The FreeRotation from this state; AttitudeError if the message lacks rates or inertia.

        An AttitudeWarning says that maneuvers are left out.
        """
        if self.body is None:
            raise AttitudeError(
                "the message has no inertia, without which no motion follows; give it in the "
                "message, or in Python a Body: FreeRotation(body, parameters.spin)."
            )
        self.refuse_other_axes()
        if any(name == "MAN" for name, *_ in self.meta["blocks"]):
            warnings.warn(
                "the maneuvers (MAN) of the message are left out: its motion is free, also after "
                "them. Give their torques or impulses in Python, to TorquedRotation or Arcs.",
                AttitudeWarning,
                stacklevel=2,
            )
        return FreeRotation(self.body, self.spin)

    def refuse_other_axes(self) -> None:
        """AttitudeError if the inertia is over other axes than those whose attitude is given."""
        _messages.refuse_other_axes(self.meta["inertia_frame"], self.meta["body_frame"])


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    products: str | None = None,
    rates: str | None = None,
) -> Parameters:
    """A message as `Parameters`.

    Parameters
    ----------
    path, tolerance, frame, orbit
        As in `aem.read`.
    products : str, optional
        "tensor" if IXY is the entry of the inertia tensor, "integral" if the entry is -IXY; by
        default as in the book of the message's version.
    rates : str, optional
        What X_RATE, Y_RATE, Z_RATE of version 1 are, as in `aem.read`.

    Raises
    ------
    AttitudeError
        As `aem.read`.
    """
    known_tolerance(tolerance)
    rates = _records.known_rates(rates)
    message = messages.read(path, _FORM)
    products = _messages.known_products(products, message.version)
    epoch = _messages.epoch_of(message.meta, "EPOCH", _messages.scale_of(message.meta))
    wxyz, speeds, body = _State(message, epoch, tolerance, frame, orbit, rates).result()
    meta = _messages.said_by(message, message.meta, f"APM {message.version}", "OBJECT_ID") | {
        "blocks": tuple((b.name, dict(b), tuple(b.comments)) for b in message.blocks),
        "body_frame": body,
    }
    meta["inertia_frame"], inertia = _inertia_of(message, body, products)
    return Parameters(epoch, wxyz, speeds, inertia, meta)


def _inertia_of(message, body, products):
    """The axes and the Body of the first block INERTIA over the body's axes, else of the first."""
    inertias = [
        (block.get("INERTIA_REF_FRAME") or body, _messages.body_of(block, products), block)
        for block in message.all("INERTIA")
    ]
    of_body = [item for item in inertias if body and comparable(item[0]) == comparable(body)]
    for _, inertia, block in of_body[1:]:
        apart = np.max(np.abs(inertia.tensor - of_body[0][1].tensor))
        if apart > 1e-6 * np.max(np.abs(inertia.tensor)):
            raise block.fault(
                "its inertia is not that of the block INERTIA in line "
                f"{of_body[0][2].line}, over the same axes; delete one of the blocks."
            )
    return (of_body or inertias or [(None, None)])[0][:2]


def write(
    path: FilePath,
    motion: FreeRotation | Parameters,
    *,
    version: str = "2.0",
    xml: bool = False,
    frame: str | None = None,
    time_system: str = "UTC",
    inertia: bool = True,
    products: str | None = None,
    rates: str | None = None,
    object_name: str | None = None,
    object_id: str | None = None,
    center: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    creation_date: str | None = None,
    digits: int | None = None,
) -> None:
    """Write the state and the inertia of a FreeRotation as an APM.

    Version 1 has the rates as derivatives of the quaternion; on those of its block of Euler angles
    readers disagree.

    Parameters
    ----------
    motion : FreeRotation or Parameters
        Names and comments of Parameters are kept unless others are given.
    frame : str, optional
        The external axes, which must be fixed; by default those of the spin.
    inertia : bool
        False leaves the inertia out (relative moments have no unit and cannot be written).
    products : str, optional
        As in `read`: the sign of the products of inertia.
    rates : str, optional
        Version 1.0: write the block of Euler angles (321) too, with "body" or "euler" rates.

    The other parameters are those of `aem.write`.

    Raises
    ------
    AttitudeError
        For unknown names of versions, axes or time systems, a state without rates or inertia, a
        motion whose angular velocity jumps, and a file that cannot be written.
    """
    refuse_foreign(path, "apm")
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; APM has {' and '.join(VERSIONS)}.")
    refuse_breaks(motion, "an APM")
    spin, body = motion.spin, motion.body if inertia else None
    if inertia and body is None:
        raise AttitudeError("there is no inertia to be written; give inertia=False.")
    meta: dict[str, Any] = {}
    if isinstance(motion, Parameters):
        meta = motion.meta
        if inertia:
            motion.refuse_other_axes()
    body_frame = _messages.written_body(body_frame, meta)
    axes = motions_axes.named(frame or motions_axes.WRITTEN[spin.frame])
    if axes.turning:
        raise AttitudeError(f"an APM is written in axes that do not turn, not {axes.name}.")
    wxyz = spin.wxyz
    if axes.kind != spin.frame:
        outer = forms.conjugate(axes.to_icrf(spin.epoch, np.zeros(()), None))
        wxyz = forms.multiply(outer, spin.wxyz_icrf)
    scale = ccsds_epochs.writable(time_system)
    epoch = ccsds_epochs.texts(spin.epoch, np.zeros(1), None, scale, digits)[0]
    meaning = _records.known_rates(rates)
    blocks = _blocks(version, axes.name, body_frame, wxyz, spin.angular_velocity, meaning)
    if body is not None:
        blocks.append(_inertia(version, body, body_frame, products))
    in_block = xml and version == "1.0"
    if in_block:
        blocks[0][1].insert(0, ("EPOCH", epoch))

    def write_data(out: Generator) -> None:
        if not in_block:
            out.entry("EPOCH", epoch)
        for name, entries in blocks:
            with out.part(_ELEMENTS[version][name], "" if version == "1.0" else name):
                out.grouped(entries, GROUPS)

    names = _messages.written_names(meta, object_name, object_id, center)
    messages.write(
        path,
        _FORM,
        version,
        _messages.written_header(meta, creation_date, originator, comments),
        [({**names, "TIME_SYSTEM": scale.upper()}, (), write_data)],
        xml=xml,
    )


def _opened(path, **keywords):
    message = read(path, **keywords)
    names = ("object_name", "object_id", "center", "comments")
    said = {name: message.meta[name] for name in names}
    with prefixed(path):
        if message.body is not None or message.wxyz is None:
            return OpenedFile(message.motion, said)
        warnings.warn(
            f"{os.fspath(path)}: the message has no inertia, without which no motion follows: its "
            "one attitude is read.",
            AttitudeWarning,
            stacklevel=2,
        )
        rates = message.angular_velocity
        return OpenedFile(
            AttitudeTable(
                message.epoch,
                [0.0],
                message.wxyz[None],
                angular_velocity=None if rates is None else rates[None],
                meta=message.meta,
            ),
            said,
        )


def _labels(motion, said):
    """Names and comments, and whether the inertia has a unit to be written in."""
    if motion.body.relative:
        warnings.warn(
            "the moments are relative, and those of an APM in kg m2: it is written without inertia",
            AttitudeWarning,
            stacklevel=2,
        )
    return {"inertia": not motion.body.relative, **message_labels(motion, said)}


register_message(
    "apm",
    "CCSDS APM",
    write,
    module=__name__,
    read=_opened,
    reading=("tolerance", "frame", "orbit", "rates"),
    read_message=read,
    writing=("version", "frame", "time_system", "rates"),
    holds="motion",
    labels=_labels,
)
