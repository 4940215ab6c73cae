"""Attitude, rates and inertia from the blocks of an Attitude Parameter Message."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.attitude_table.table import refuse_speed
from attitude.axes import axes
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.formats.apm.inertia import known_products, tensor
from attitude.formats.apm.keywords import META
from attitude.formats.apm.message import Block, needs, number, one_of
from attitude.formats.ccsds import attitude_types, old_rates
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.ccsds.attitude_types import Convention
from attitude.formats.rows import to_icrf
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.epochs import Instant
    from attitude.formats.apm.message import Collected
    from attitude.paths.path import Path

_DIRECTIONS = {"A2B": True, "B2A": False}


class Interpreted:
    """The state in the blocks of a message.

    Parameters
    ----------
    message : Collected
    tolerance, frame, orbit, products, rates
        As of `apm.read`.

    Attributes
    ----------
    epoch : Instant
        EPOCH of the message; set by `result`.
    """

    epoch: Instant

    def __init__(
        self,
        message: Collected,
        tolerance: float,
        frame: str | None,
        orbit: Path | None,
        products: str | None,
        rates: str | None = None,
    ):
        self._rates = old_rates.known(rates)
        self._message, self._tolerance = message, tolerance
        self._frame, self._orbit = frame, orbit
        self._old = message.version == "1.0"
        self._products = known_products(products, message.version)
        # Block -> name of the body's axes in it.
        self._bodies: dict[str, str] = {}

    def result(
        self,
    ) -> tuple[Instant, FloatArray | None, FloatArray | None, Body | None, dict[str, Any]]:
        """The fields of `Parameters`: epoch, attitude, angular velocity, body, meta.

        Raises
        ------
        AttitudeError
            For missing keywords, values that are not known, and an inertia that no body has.
        """
        message = self._message
        for keyword in META:
            if keyword != "CENTER_NAME":
                needs(message, keyword)
        try:
            scale = ccsds_epochs.known(message.meta["TIME_SYSTEM"])
            self.epoch = ccsds_epochs.instant(needs(message, "EPOCH"), scale)
        except ccsds_epochs.BadEpoch as err:
            raise message.fault(
                f"EPOCH is {message.meta['EPOCH'][:38]!r}, no epoch: {err.reason}.",
                message.lines["EPOCH"],
            ) from err
        except AttitudeError as err:
            if str(err).startswith("TIME_SYSTEM"):
                raise message.fault(str(err), message.lines["TIME_SYSTEM"]) from err
            raise
        wxyz, rates, body_frame = self._state()
        meta = {
            "format": f"APM {message.version}",
            "header": dict(message.header),
            "comments": tuple(message.comments),
            "keywords": dict(message.meta),
            "blocks": tuple((b.name, dict(b), tuple(b.comments)) for b in message.blocks),
            "object_name": message.meta["OBJECT_NAME"],
            "object_id": message.meta["OBJECT_ID"],
            "center": message.meta.get("CENTER_NAME"),
            "body_frame": body_frame,
            "inertia_frame": self._inertia_frame(body_frame),
        }
        return self.epoch, wxyz, rates, self._body(), meta

    def _blocks(self, name):
        return [block for block in self._message.blocks if block.name == name]

    def _state(self):
        """Attitude and rates, each from the first block that has it; name of the body's axes."""
        attitude = rates = of_attitude = of_rates = None
        for name, meaning in (("QUAT", self._quat), ("EULER", self._euler), ("SPIN", self._spin)):
            for block in self._blocks(name)[:1]:
                found = self._named(meaning, block)
                if attitude is None and found[0] is not None:
                    attitude, of_attitude = found[0], block
                if rates is None and found[1] is not None:
                    rates, of_rates = found[1], block
        if attitude is None and self._blocks("INERTIA") and not self._blocks("ANGVEL"):
            return None, None, None
        if attitude is None:
            raise self._message.fault("the message has no attitude.", None)
        for block in self._blocks("ANGVEL")[:1]:
            rates, of_rates = self._named(self._angvel, block, attitude), block
        body = self._bodies[of_attitude.name]
        if rates is not None and self._bodies[of_rates.name].upper() != body.upper():
            raise self._message.fault(
                f"the block {of_rates.name} has the rates of "
                f"{cut(self._bodies[of_rates.name], '')}, but the block {of_attitude.name} the "
                f"attitude of {cut(body, '')}; a message is read for one "
                "body: delete one of the blocks.",
                of_rates.line,
            )
        if callable(rates):
            rates = self._named(rates, attitude)
        self._refuse_speed(rates)
        return attitude, rates, body

    def _named(self, meaning, block, *more):
        """What a block means; errors of its axes name the file and the line too."""
        try:
            return meaning(block, *more)
        except AttitudeError as err:
            if str(err).startswith(self._message.path):
                raise
            line = block.line if isinstance(block, Block) else None
            raise self._message.fault(str(err), line) from err

    def _refuse_speed(self, rates):
        try:
            refuse_speed(rates)
        except AttitudeError as err:
            raise self._message.fault(str(err), None) from err

    def _axes(self, block):
        """The external axes; whether the rotation leads from them to the body; whether A is it.

        The name of the body's axes is noted in `_bodies`.
        """
        message = self._message
        names = [block.get(key) for key in ("REF_FRAME_A", "REF_FRAME_B")]
        for key, name in zip(("REF_FRAME_A", "REF_FRAME_B"), names, strict=True):
            if not name:
                raise message.fault(f"the block {block.name} lacks {key}.", block.line)
        try:
            found, body, body_is_a = axes.of_pair(*names, self._frame)
        except AttitudeError as err:
            raise message.fault(str(err), block.lines["REF_FRAME_B"]) from err
        self._bodies[block.name] = body
        to_body = not body_is_a
        if self._old and one_of(message, block, "DIR", _DIRECTIONS) is False:
            to_body = not to_body
        return found, to_body, body_is_a

    def _relative(self, kind, row, block, how, found):
        with np.errstate(over="ignore", invalid="ignore"):  # refuse_speed refuses overflow
            wxyz, rates = attitude_types.decoded(kind, np.array([row]), how)
        return self._to_icrf(forms.unit(wxyz), rates, found)

    def _to_icrf(self, wxyz, rates, found):
        zero = np.zeros(1)
        wxyz, rates = to_icrf(wxyz, rates, found, self.epoch, zero, zero, self._orbit)
        return wxyz[0], None if rates is None else rates[0]

    def _numbers(self, block, names, kind=None):
        return [number(self._message, block, name, kind) for name in names]

    def _quat(self, block):
        found, to_body, _ = self._axes(block)
        row = self._numbers(block, ("Q1", "Q2", "Q3", "QC"))
        off = abs(float(np.sqrt(np.sum(np.square(row)))) - 1.0)
        if off > self._tolerance:
            raise self._message.fault(
                f"the length of the quaternion is off 1 by {off:.3g}; up to {self._tolerance:g} is "
                "accepted as rounding (tolerance=).",
                block.lines["QC"],
            )
        dots = [f"{name}_DOT" for name in ("Q1", "Q2", "Q3", "QC")]
        kind = "QUATERNION"
        if any(name in block for name in dots):
            row += self._numbers(block, dots, "DOT")
            kind = "QUATERNION/DERIVATIVE"
        return self._relative(kind, row, block, Convention(to_body=to_body), found)

    def _euler(self, block):
        found, to_body, body_is_a = self._axes(block)
        try:
            sequence = quaternion.known_sequence(block.get("EULER_ROT_SEQ", "").upper())
        except AttitudeError as err:
            raise self._message.fault(
                f"EULER_ROT_SEQ: {err}", block.lines.get("EULER_ROT_SEQ", block.line)
            ) from err
        how = Convention(to_body=to_body, sequence=sequence)
        if self._old:
            return self._old_euler(block, how, found, body_is_a)
        row = self._numbers(block, ("ANGLE_1", "ANGLE_2", "ANGLE_3"), "ANGLE")
        kind = "EULER_ANGLE"
        dots = ("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT")
        if any(name in block for name in dots):
            row += self._numbers(block, dots, "RATE")
            kind = "EULER_ANGLE/DERIVATIVE"
        return self._relative(kind, row, block, how, found)

    def _old_euler(self, block, how, found, body_is_a):
        """Version 1: angles under the names of their axes, rates over the axes of a frame."""
        letters = [name[0] for name, _, _ in block.order if name.endswith("_RATE")]
        derivatives = self._rates == "euler" or len(set(letters)) < len(letters)
        angles = self._by_axis(block, "ANGLE", how.sequence)
        rates = self._by_axis(block, "RATE", how.sequence if derivatives else None)
        wxyz = None
        if angles is not None:
            wxyz = self._relative("EULER_ANGLE", angles, block, how, found)[0]
        if rates is None:
            return wxyz, None
        if derivatives:
            return wxyz, self._of_derivatives(np.radians(rates), how, found)
        if self._rates is None:
            old_rates.warn(self._message.path, "the block of Euler angles")
        frames = {"EULER_FRAME_A": body_is_a, "EULER_FRAME_B": not body_is_a}
        over_body = one_of(self._message, block, "RATE_FRAME", frames)
        return wxyz, self._body_rates(np.radians(rates), over_body, found)

    def _of_derivatives(self, change, how, found):
        """A function: attitude -> rates relative to ICRF, from derivatives of Euler angles."""
        self._refuse_speed(change)

        def of(wxyz):
            zero = np.zeros(1)
            outer = found.to_icrf(self.epoch, zero, zero, self._orbit).reshape(4)
            inner = quaternion.multiply(quaternion.conjugate(outer), wxyz)
            rates = attitude_types.of_euler_derivatives(inner[None], change[None], how)[0]
            own = found.angular_velocity(self.epoch, zero, zero, self._orbit)
            return (
                rates
                if own is None
                else rates + quaternion.rotate(quaternion.conjugate(wxyz), own[0])
            )

        return of

    def _body_rates(self, rates, over_body, found):
        """A function: attitude -> rates relative to ICRF, over the body axes."""

        self._refuse_speed(rates)

        def of(wxyz):
            zero = np.zeros(1)
            outer = found.to_icrf(self.epoch, zero, zero, self._orbit).reshape(4)
            body = quaternion.conjugate(wxyz)
            over = rates
            if not over_body:
                over = quaternion.rotate(quaternion.multiply(body, outer), rates)
            own = found.angular_velocity(self.epoch, zero, zero, self._orbit)
            return over if own is None else over + quaternion.rotate(body, own[0])

        return of

    def _by_axis(self, block, what, sequence):
        """Values of X_ANGLE, ... in the order of a sequence, or of X, Y, Z; None without any."""
        given = [item for item in block.order if item[0].endswith(f"_{what}")]
        if not given:
            return None
        needed = [f"{axis}_{what}" for axis in sequence or "XYZ"]
        names = [name for name, _, _ in given]
        if sorted(names) != sorted(needed):
            raise self._message.fault(
                f"the block EULER has {', '.join(names)}; {sequence or 'rates'} needs "
                f"{', '.join(needed)}.",
                given[0][2],
            )
        values = []
        for name in needed:
            place = next(k for k, item in enumerate(given) if item[0] == name)
            _, text, line = given.pop(place)
            block[name], block.lines[name] = text, line
            values.append(number(self._message, block, name, what))
        return values

    def _spin(self, block):
        found, _, _ = self._axes(block)
        row = self._numbers(block, ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE"), "ANGLE")
        row += self._numbers(block, ("SPIN_ANGLE_VEL",), "RATE")
        kind = "SPIN"
        if "NUTATION" in block:
            kind = "SPIN/NUTATION"
            row += self._numbers(block, ("NUTATION",), "ANGLE")
            row += self._numbers(block, ("NUTATION_PER",), "PERIOD")
            row += self._numbers(block, ("NUTATION_PHASE",), "ANGLE")
        elif "MOMENTUM_ALPHA" in block:
            kind = "SPIN/NUTATION_MOM"
            row += self._numbers(block, ("MOMENTUM_ALPHA", "MOMENTUM_DELTA"), "ANGLE")
            row += self._numbers(block, ("NUTATION_VEL",), "RATE")
        return self._relative(kind, row, block, Convention(), found)

    def _angvel(self, block, wxyz):
        found, to_body, body_is_a = self._axes(block)
        values = self._numbers(block, ("ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"), "RATE")
        a, b = block["REF_FRAME_A"].upper(), block["REF_FRAME_B"].upper()
        choices = {a: body_is_a, b: not body_is_a}
        over_body = one_of(self._message, block, "ANGVEL_FRAME", choices)
        rates = np.radians(values) * (1.0 if to_body else -1.0)
        return self._body_rates(rates, over_body, found)(wxyz)

    def _inertia_frame(self, body_frame):
        """Name of the axes of the inertia, by default the body's; None without inertia."""
        for block in self._blocks("INERTIA")[:1]:
            return block.get("INERTIA_REF_FRAME") or body_frame
        return None

    def _body(self):
        for block in self._blocks("INERTIA")[:1]:
            names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
            values = self._numbers(block, names, "INERTIA")
            try:
                return Body(tensor=tensor(values, self._products))
            except AttitudeError as err:
                raise self._message.fault(f"the inertia: {err}", block.line) from err
        return None
