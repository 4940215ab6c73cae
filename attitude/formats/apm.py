"""CCSDS Attitude Parameter Messages, versions 1.0 and 2.0, KVN and XML: one state and the inertia.

An APM with inertia and angular velocity is a complete Body and Spin, and a FreeRotation goes into
one.  Conventions of quaternions, angles, rates and spin are those of `attitude_types`; the
entries IXX, IXY, ... (I11, I12, ...) are taken as those of the inertia tensor, so that products of
inertia have their minus sign, as in Orekit.  Maneuvers are kept among the keywords, no more.

Where a message tells the attitude in several ways, the first of quaternion, Euler angles and spin
counts, and for the rates the first of ANGVEL, derivatives of the quaternion, of the angles, spin.
"""

import datetime
from dataclasses import dataclass, field

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.attitude_table import refuse_speed
from attitude.body import Body
from attitude.epochs import Instant
from attitude.errors import AttitudeError
from attitude.formats import attitude_types, axes, ccsds_epochs, kvn
from attitude.formats.aem import refuse_line_breaks
from attitude.formats.apm_blocks import (
    META,
    VERSIONS,
    XML_NAMES,
    XmlReader,
    needs,
    number,
    one_of,
    read_kvn,
)
from attitude.formats.aside import written_whole
from attitude.formats.attitude_types import Convention
from attitude.formats.lines import opened
from attitude.formats.segment import TOLERANCE, to_icrf
from attitude.free_rotation import FreeRotation
from attitude.spin import Spin

_DIRECTIONS = {"A2B": True, "B2A": False}


@dataclass(frozen=True, eq=False)
class Parameters:
    """What an APM says.

    Attributes
    ----------
    epoch : Instant
    wxyz : (4,) array
        Body to ICRF.
    angular_velocity : (3,) array or None
        rad/s over the body axes, relative to inertial space.
    body : Body or None
    meta : dict
        Keywords of the header, the meta data and each block, and comments.
    """

    epoch: Instant
    wxyz: np.ndarray
    angular_velocity: np.ndarray | None
    body: Body | None
    meta: dict = field(repr=False)

    @property
    def spin(self):
        """The Spin, in ICRF; AttitudeError without rates."""
        if self.angular_velocity is None:
            raise AttitudeError(
                "the message has no angular velocity; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        return Spin(self.epoch, self.wxyz, self.angular_velocity)

    @property
    def motion(self):
        """The FreeRotation from this state; AttitudeError without rates or inertia."""
        if self.body is None:
            raise AttitudeError(
                "the message has no inertia; give a Body: FreeRotation(body, parameters.spin)."
            )
        return FreeRotation(self.body, self.spin)


def read(path, *, tolerance=TOLERANCE, frame=None, orbit=None):
    """A message as `Parameters`; see `aem.read` for the arguments."""
    with opened(path) as lines:
        for line in lines:
            text = line.lstrip(b"\xef\xbb\xbf \t")
            if text.startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
                break
            if text:
                keyword, value = kvn.pair(lines, line)
                if keyword != "CCSDS_APM_VERS" or value not in VERSIONS:
                    raise lines.fault(
                        f"it begins with {kvn.shown(lines.text(line))}; an APM begins with "
                        f"CCSDS_APM_VERS = {' or '.join(VERSIONS)}."
                    )
                return _Interpreted(read_kvn(lines, value), tolerance, frame, orbit).result()
        else:
            raise lines.fault("the file is empty.")
    reader = XmlReader(path)
    reader.run()
    if reader.message is None:
        raise reader.fault("there is no <apm> message in it.")
    return _Interpreted(reader.message, tolerance, frame, orbit).result()


class _Interpreted:
    """The state that the blocks of a message mean."""

    def __init__(self, message, tolerance, frame, orbit):
        self._message, self._tolerance = message, tolerance
        self._frame, self._orbit = frame, orbit
        self._old = message.version == "1.0"

    def result(self):
        message = self._message
        for keyword in META:
            if keyword != "CENTER_NAME":
                needs(message, keyword)
        try:
            scale = ccsds_epochs.known(message.meta["TIME_SYSTEM"])
            self.epoch = ccsds_epochs.instant(needs(message, "EPOCH"), scale)
        except ccsds_epochs.BadEpoch as err:
            raise message.fault(
                f"EPOCH is {message.meta['EPOCH'][:60]!r}, no epoch: {err.reason}.",
                message.lines["EPOCH"],
            ) from err
        except AttitudeError as err:
            if str(err).startswith("TIME_SYSTEM"):
                raise message.fault(str(err), message.lines["TIME_SYSTEM"]) from err
            raise
        wxyz, rates = self._state()
        meta = {
            "format": f"APM {message.version}",
            "header": dict(message.header),
            "comments": tuple(message.comments),
            "keywords": dict(message.meta),
            "blocks": tuple((b.name, dict(b), tuple(b.comments)) for b in message.blocks),
            "object_name": message.meta["OBJECT_NAME"],
            "object_id": message.meta["OBJECT_ID"],
            "center": message.meta.get("CENTER_NAME"),
        }
        return Parameters(self.epoch, wxyz, rates, self._body(), meta)

    def _blocks(self, name):
        return [block for block in self._message.blocks if block.name == name]

    def _state(self):
        found = None
        for name, meaning in (("QUAT", self._quat), ("EULER", self._euler), ("SPIN", self._spin)):
            for block in self._blocks(name)[:1]:
                wxyz, rates = meaning(block)
                if found is None:
                    found = wxyz, rates
                elif found[0] is None:
                    found = wxyz, found[1] if found[1] is not None else rates
                elif found[1] is None:
                    found = found[0], rates
        for block in self._blocks("ANGVEL")[:1]:
            if found is not None and found[0] is not None:
                found = found[0], self._angvel(block, found[0])
        if found is None or found[0] is None:
            raise self._message.fault("the message has no attitude.", None)
        wxyz, rates = found
        if callable(rates):
            rates = rates(wxyz)
        self._refuse_speed(rates)
        return wxyz, rates

    def _refuse_speed(self, rates):
        try:
            refuse_speed(rates)
        except AttitudeError as err:
            raise self._message.fault(str(err), None) from err

    def _axes(self, block):
        """External axes and whether the rotation goes from them to the body."""
        message = self._message
        names = [block.get(key) for key in ("REF_FRAME_A", "REF_FRAME_B")]
        for key, name in zip(("REF_FRAME_A", "REF_FRAME_B"), names, strict=True):
            if not name:
                raise message.fault(f"the block {block.name} lacks {key}.", block.line)
        known = [axes.known(name) for name in names]
        if self._frame is not None:
            body_is_a = known[0] is None and known[1] is not None
            found = axes.named(self._frame)
        else:
            if (known[0] is None) == (known[1] is None):
                raise message.fault(
                    f"of the frames {names[0]} and {names[1]} one must be axes that are known "
                    "(ICRF, EME2000, ITRF, TEME, RTN, LVLH), the other those of the body; tell "
                    "with frame= what the first is.",
                    block.lines["REF_FRAME_A"],
                )
            body_is_a = known[0] is None
            found = known[1] if body_is_a else known[0]
        to_body = not body_is_a
        if self._old and one_of(message, block, "DIR", _DIRECTIONS) is False:
            to_body = not to_body
        return found, to_body, body_is_a

    def _relative(self, kind, row, block, how, found):
        with np.errstate(over="ignore", invalid="ignore"):  # refused below, as too fast
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
                "taken for rounding (tolerance=).",
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
        """Version 1: angles by the names of their axes, rates over the axes of a frame."""
        angles = self._by_axis(block, "ANGLE", how.sequence)
        rates = self._by_axis(block, "RATE", None)
        wxyz = None
        if angles is not None:
            wxyz = self._relative("EULER_ANGLE", angles, block, how, found)[0]
        if rates is None:
            return wxyz, None
        frames = {"EULER_FRAME_A": body_is_a, "EULER_FRAME_B": not body_is_a}
        over_body = one_of(self._message, block, "RATE_FRAME", frames)
        return wxyz, self._body_rates(np.radians(rates), over_body, found)

    def _body_rates(self, rates, over_body, found):
        """What makes rates relative to ICRF over the body axes, once the attitude is known."""

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
        """Numbers of X_ANGLE, ... in the order of a sequence, or of X, Y, Z; None without any."""
        given = [item for item in block.order if item[0].endswith(f"_{what}")]
        if not given:
            return None
        wanted = [f"{axis}_{what}" for axis in sequence or "XYZ"]
        names = [name for name, _, _ in given]
        if sorted(names) != sorted(wanted):
            raise self._message.fault(
                f"the block EULER has {', '.join(names)}; {sequence or 'rates'} needs "
                f"{', '.join(wanted)}.",
                given[0][2],
            )
        values = []
        for name in wanted:
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

    def _body(self):
        for block in self._blocks("INERTIA")[:1]:
            names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
            xx, yy, zz, xy, xz, yz = self._numbers(block, names, "INERTIA")
            try:
                return Body(tensor=[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            except AttitudeError as err:
                raise self._message.fault(f"the inertia: {err}", block.line) from err
        return None


# Writing ------------------------------------------------------------------------------------------


def write(
    path,
    motion,
    *,
    version="2.0",
    xml=False,
    frame=None,
    time_system="UTC",
    inertia=True,
    object_name="UNKNOWN",
    object_id="UNKNOWN",
    center=None,
    body_frame="SC_BODY_1",
    originator="ATTITUDE",
    comments=(),
    creation_date=None,
    digits=ccsds_epochs.DIGITS,
):
    """Write the state and the inertia of a FreeRotation as an APM.

    Parameters
    ----------
    motion : FreeRotation, or Parameters that were read
    frame : str, optional
        The external axes, fixed ones; those of the spin by default.
    inertia : bool
        False leaves the inertia out (relative moments have no unit and cannot be written).

    Others as of `aem.write`.  Version 1 has its rates among the Euler angles (321), beside the
    quaternion.
    """
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; APM has {' and '.join(VERSIONS)}.")
    spin, body = motion.spin, motion.body
    found = axes.named(frame or axes.WRITTEN[spin.frame])
    if found.turning:
        raise AttitudeError(f"an APM is written in axes that do not turn, not {found.name}.")
    if axes.known(body_frame) is not None:
        raise AttitudeError(f"body_frame is {body_frame!r}, the name of other axes; give another.")
    wxyz = spin.wxyz
    if found.kind != spin.frame:
        outer = quaternion.conjugate(found.to_icrf(spin.epoch, 0.0, None))
        wxyz = quaternion.multiply(outer, spin.wxyz_icrf)
    scale = ccsds_epochs.known(time_system)
    if scale.upper() not in ccsds_epochs.WRITTEN:
        raise AttitudeError(f"epochs are not written in {time_system}.")
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%S")
    message = {
        "version": version,
        "header": {"CREATION_DATE": creation_date or now, "ORIGINATOR": originator},
        "comments": list(comments),
        "meta": {
            "OBJECT_NAME": object_name,
            "OBJECT_ID": object_id,
            **({"CENTER_NAME": center} if center else {}),
            "TIME_SYSTEM": scale.upper(),
        },
        "epoch": ccsds_epochs.texts(spin.epoch, np.zeros(1), None, scale, digits)[0],
        "blocks": _blocks(version, found.name, body_frame, wxyz, spin.angular_velocity),
    }
    if inertia:
        message["blocks"].append(_inertia(version, body, body_frame))
    for text in (*message["header"].values(), *message["meta"].values(), *comments, body_frame):
        refuse_line_breaks(text)
    with written_whole(path, "the APM") as file:
        (_write_xml if xml else _write_kvn)(file, message)


def _blocks(version, frame, body, wxyz, rates):
    """Name, and triples of keyword, value and unit, of the blocks of attitude and rates."""
    quaternions = [
        (k, float(q), "") for k, q in zip(("Q1", "Q2", "Q3", "QC"), np.roll(wxyz, -1), strict=True)
    ]
    rates = [float(rate) for rate in np.degrees(rates)]
    if version == "1.0":
        angles = np.degrees(forms.to_euler("ZYX", wxyz)).tolist()
        return [
            (
                "QUAT",
                [
                    ("Q_FRAME_A", frame, ""),
                    ("Q_FRAME_B", body, ""),
                    ("Q_DIR", "A2B", ""),
                    *quaternions,
                ],
            ),
            (
                "EULER",
                [
                    *(("EULER_FRAME_A", frame, ""), ("EULER_FRAME_B", body, "")),
                    *(("EULER_DIR", "A2B", ""), ("EULER_ROT_SEQ", "321", "")),
                    ("RATE_FRAME", "EULER_FRAME_B", ""),
                    *((f"{a}_ANGLE", angle, "deg") for a, angle in zip("ZYX", angles, strict=True)),
                    *((f"{a}_RATE", rates["XYZ".index(a)], "deg/s") for a in "ZYX"),
                ],
            ),
        ]
    frames = [("REF_FRAME_A", frame, ""), ("REF_FRAME_B", body, "")]
    components = [(f"ANGVEL_{a}", rate, "deg/s") for a, rate in zip("XYZ", rates, strict=True)]
    return [
        ("QUAT", [*frames, *quaternions]),
        ("ANGVEL", [*frames, ("ANGVEL_FRAME", body, ""), *components]),
    ]


def _inertia(version, body, frame):
    if body.relative:
        raise AttitudeError(
            "the moments of the body are relative, and an APM has kg m2; give moments in kg m2, or "
            "write inertia=False."
        )
    names = "123" if version == "1.0" else "XYZ"
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    entries = [(f"I{names[i]}{names[j]}", float(body.tensor[i, j]), "kg*m**2") for i, j in pairs]
    return "INERTIA", [("INERTIA_REF_FRAME", frame, ""), *entries]


def _write_kvn(file, message):
    version = message["version"]
    file.write(f"CCSDS_APM_VERS = {version}\n")
    file.writelines(f"COMMENT {text}\n" for text in message["comments"])
    for part in ("header", "meta"):
        file.writelines(f"{key} = {value}\n" for key, value in message[part].items())
    file.write(f"EPOCH = {message['epoch']}\n")
    for name, entries in message["blocks"]:
        file.write("\n" if version == "1.0" else f"\n{name}_START\n")
        for key, value, unit in entries:
            shown = value if isinstance(value, str) else repr(value)
            file.write(f"{key} = {shown}{f' [{unit}]' if unit else ''}\n")
        if version != "1.0":
            file.write(f"{name}_STOP\n")


def _write_xml(file, message):
    from xml.sax.saxutils import escape

    version = message["version"]
    schema = "2.0.0-master-2.0" if version == "1.0" else "4.0.0-master-4.0"

    def leaf(indent, key, value, unit="", attribute=""):
        shown = escape(value) if isinstance(value, str) else repr(value)
        units = f' units="{unit}"' if unit else ""
        file.write(f"{' ' * indent}<{key}{attribute}{units}>{shown}</{key}>\n")

    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<apm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        '     xsi:noNamespaceSchemaLocation="https://sanaregistry.org/r/ndmxml_unqualified/'
        f'ndmxml-{schema}.xsd"\n     id="CCSDS_APM_VERS" version="{version}">\n  <header>\n'
    )
    for text in message["comments"]:
        leaf(4, "COMMENT", text)
    for key, value in message["header"].items():
        leaf(4, key, value)
    file.write("  </header>\n  <body>\n    <segment>\n      <metadata>\n")
    for key, value in message["meta"].items():
        leaf(8, key, value)
    file.write("      </metadata>\n      <data>\n")
    if version != "1.0":
        leaf(8, "EPOCH", message["epoch"])
    for name, entries in message["blocks"]:
        element = XML_NAMES[version][name]
        file.write(f"        <{element}>\n")
        if version == "1.0" and name == "QUAT":
            leaf(10, "EPOCH", message["epoch"])
        _write_entries(file, leaf, entries)
        file.write(f"        </{element}>\n")
    file.write("      </data>\n    </segment>\n  </body>\n</apm>\n")


def _write_entries(file, leaf, entries):
    """Keywords of a block; components that belong together stand in a group of their own."""
    groups = {"Q1": "quaternion", "Z_ANGLE": "rotationAngles", "Z_RATE": "rotationRates"}
    inside, count = None, 0
    for key, value, unit in entries:
        if key in groups and inside is None:
            inside, count = groups[key], 0
            file.write(f"          <{inside}>\n")
        if inside is None:
            leaf(10, key, value, unit)
            continue
        count += 1
        if inside == "quaternion":
            leaf(12, key, value, unit)
        else:
            kind = "angle" if inside == "rotationAngles" else "rate"
            leaf(12, f"rotation{count}", value, unit, f' {kind}="{key}"')
        if count == (4 if inside == "quaternion" else 3):
            file.write(f"          </{inside}>\n")
            inside = None
