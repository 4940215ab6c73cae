"""The blocks of Attitude Parameter Messages under one set of names, in both notations and versions.

Version 1 has other names for the keywords of version 2, and no marks around its blocks in KVN.
"""

from attitude.textfiles import kvn
from attitude.textfiles.xml import MESSAGES, OUTSIDE, ElementReader

VERSIONS = ("1.0", "2.0")
HEADER = ("CREATION_DATE", "ORIGINATOR", "MESSAGE_ID", "CLASSIFICATION")
META = ("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "TIME_SYSTEM")
_Q = ("Q1", "Q2", "Q3", "QC")
_SPIN = ("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL")
_NUTATION = ("NUTATION", "NUTATION_PER", "NUTATION_PHASE")
_FRAMES = ("REF_FRAME_A", "REF_FRAME_B")
# Keywords of the blocks of version 2, by the name in their _START and _STOP.
BLOCKS = {
    "QUAT": (*_FRAMES, *_Q, *(f"{name}_DOT" for name in _Q)),
    "EULER": (
        *(*_FRAMES, "EULER_ROT_SEQ", "ANGLE_1", "ANGLE_2", "ANGLE_3"),
        *("ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"),
    ),
    "ANGVEL": (*_FRAMES, "ANGVEL_FRAME", "ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"),
    "SPIN": (*_FRAMES, *_SPIN, *_NUTATION, "MOMENTUM_ALPHA", "MOMENTUM_DELTA", "NUTATION_VEL"),
    "INERTIA": ("INERTIA_REF_FRAME", "IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ"),
    "MAN": (
        *("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME", "MAN_TOR_X", "MAN_TOR_Y"),
        *("MAN_TOR_Z", "MAN_DELTA_MASS"),
    ),
}
# Version 1: keyword -> block and the name in version 2 (or its own, where there is none).
OLD = {
    **{name: ("QUAT", name) for name in BLOCKS["QUAT"][2:]},
    **{"Q_FRAME_A": ("QUAT", "REF_FRAME_A"), "Q_FRAME_B": ("QUAT", "REF_FRAME_B")},
    "Q_DIR": ("QUAT", "DIR"),
    **{"EULER_FRAME_A": ("EULER", "REF_FRAME_A"), "EULER_FRAME_B": ("EULER", "REF_FRAME_B")},
    **{"EULER_DIR": ("EULER", "DIR"), "EULER_ROT_SEQ": ("EULER", "EULER_ROT_SEQ")},
    "RATE_FRAME": ("EULER", "RATE_FRAME"),
    **{f"{axis}_ANGLE": ("EULER", f"{axis}_ANGLE") for axis in "XYZ"},
    **{f"{axis}_RATE": ("EULER", f"{axis}_RATE") for axis in "XYZ"},
    **{"SPIN_FRAME_A": ("SPIN", "REF_FRAME_A"), "SPIN_FRAME_B": ("SPIN", "REF_FRAME_B")},
    "SPIN_DIR": ("SPIN", "DIR"),
    **{name: ("SPIN", name) for name in (*_SPIN, *_NUTATION)},
    "INERTIA_REF_FRAME": ("INERTIA", "INERTIA_REF_FRAME"),
    **{
        f"I{i}{j}": ("INERTIA", f"I{'XYZ'[i - 1]}{'XYZ'[j - 1]}")
        for i in (1, 2, 3)
        for j in (1, 2, 3)
        if i <= j
    },
    **{name: ("MAN", name) for name in ("MAN_EPOCH_START", "MAN_DURATION", "MAN_REF_FRAME")},
    **{f"MAN_TOR_{k}": ("MAN", f"MAN_TOR_{'XYZ'[k - 1]}") for k in (1, 2, 3)},
}
_REPEATED = ("X_ANGLE", "Y_ANGLE", "Z_ANGLE", "X_RATE", "Y_RATE", "Z_RATE")
# Units that may stand behind the numbers of a keyword; none is always taken for the first.
_UNITS = {
    "ANGLE": ("deg",),
    "RATE": ("deg/s",),
    "DOT": ("1/s",),
    "INERTIA": ("kg*m**2", "kg*m^2", "kg.m**2"),
    "PERIOD": ("s",),
}


class Block(dict):
    """Keywords and values of a block, the lines they stand in, and all of them in their order."""

    def __init__(self, name, line):
        super().__init__()
        self.name, self.line = name, line
        self.lines, self.order, self.comments = {}, [], []


class Collected:
    """A message while it is read: header, meta data, blocks."""

    def __init__(self, version, fault):
        self.version, self.fault = version, fault
        self.header, self.meta, self.comments, self.blocks = {}, {}, [], []
        self.lines = {}

    def put_common(self, keyword, value, line):
        """A keyword of header or meta data, or EPOCH; False for others."""
        if keyword not in (*HEADER, *META, "EPOCH"):
            return False
        into = self.header if keyword in HEADER else self.meta
        if keyword in into:
            raise self.fault(f"{keyword} is given twice.", line)
        into[keyword], self.lines[keyword] = value, line
        return True

    def put(self, block, keyword, value, line):
        """A keyword of a block, under its name in version 2."""
        if keyword in block and keyword not in _REPEATED:
            raise self.fault(
                f"{keyword} is given twice, first in line {block.lines[keyword]}.", line
            )
        block.order.append((keyword, value, line))
        block[keyword], block.lines[keyword] = value, line

    def unknown(self, keyword, line):
        return self.fault(
            f"{keyword} is not known in an APM of version {self.version}, or not in this place.",
            line,
        )


def read_kvn(lines, first):
    """The Collected message of an APM in KVN, of whose lines the first is read."""
    version = kvn.version(lines, first, "APM", VERSIONS)
    message = Collected(version, lines.fault)
    current = None
    for line in lines:
        if line.strip() in (b"", b"META_START", b"META_STOP"):
            continue
        mark = line.strip().decode("ascii", "replace")
        if version != "1.0" and mark.endswith(("_START", "_STOP")) and "=" not in mark:
            current = _marked(message, mark, current, lines.number)
            continue
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            (message.comments if current is None else current.comments).append(value)
        elif current is None and message.put_common(keyword, value, lines.number):
            pass
        elif version == "1.0" and keyword in OLD:
            name, new = OLD[keyword]
            block = _open_block(message, name, keyword, lines.number)
            message.put(block, new, value, lines.number)
        elif current is not None and keyword in BLOCKS[current.name]:
            message.put(current, keyword, value, lines.number)
        else:
            raise message.unknown(keyword, lines.number)
    if current is not None:
        raise lines.fault(f"the file ends before {current.name}_STOP; is it cut off?")
    return message


def _marked(message, mark, current, line):
    name, _, end = mark.rpartition("_")
    if name not in BLOCKS:
        raise message.fault(
            f"{mark} is not known; blocks are {', '.join(BLOCKS)}, each with _START and _STOP.",
            line,
        )
    if end == "START":
        if current is not None:
            raise message.fault(f"{mark} stands before {current.name}_STOP.", line)
        message.blocks.append(Block(name, line))
        return message.blocks[-1]
    if current is None or current.name != name:
        raise message.fault(f"{mark} stands without {name}_START.", line)
    return None


def _open_block(message, name, keyword, line):
    """The block of version 1 that a keyword belongs to; a second maneuver begins a new one."""
    found = [block for block in message.blocks if block.name == name]
    if not found or (name == "MAN" and keyword == "MAN_EPOCH_START"):
        message.blocks.append(Block(name, line))
        return message.blocks[-1]
    return found[-1]


_XML_BLOCKS = {
    **{"quaternionState": "QUAT", "eulerAngleState": "EULER", "eulerElementsThree": "EULER"},
    **{"angularVelocity": "ANGVEL", "spin": "SPIN", "eulerElementsSpin": "SPIN"},
    **{"inertia": "INERTIA", "spacecraftParameters": "INERTIA", "maneuverParameters": "MAN"},
}
XML_NAMES = {
    "2.0": {
        **{"QUAT": "quaternionState", "EULER": "eulerAngleState", "ANGVEL": "angularVelocity"},
        **{"SPIN": "spin", "INERTIA": "inertia"},
    },
    "1.0": {
        **{"QUAT": "quaternionState", "EULER": "eulerElementsThree", "SPIN": "eulerElementsSpin"},
        "INERTIA": "spacecraftParameters",
    },
}
_GROUPS = ("quaternion", "quaternionDot", "quaternionRate", "rotationAngles", "rotationRates")
_OUTER = ("apm", "ndm", "header", "body", "segment", "metadata", "data")


def read_xml(path):
    """The Collected message of an APM in XML."""
    reader = _XmlReader(path)
    reader.run()
    if reader.message is None:
        raise reader.fault("there is no <apm> message in it.")
    return reader.message


class _XmlReader(ElementReader):
    """Collects the message of an APM in XML."""

    def __init__(self, path):
        super().__init__(path)
        self._block, self._place, self._attributes = None, [], {}
        self._outside = []

    def begin(self, tag, attributes):
        if tag in MESSAGES or (self.message is None and tag not in OUTSIDE):
            self.message = Collected(self.version(tag, attributes, "apm", VERSIONS), self.fault)
            self.message.comments.extend(self._outside)
        elif self._place[-1:] == ["data"] and tag in _XML_BLOCKS:
            self._block = Block(_XML_BLOCKS[tag], self.line)
            self.message.blocks.append(self._block)
        self._place.append(tag)
        self._attributes = attributes

    def end(self, tag, text):
        self._place.pop()
        if self.message is None:
            self._outside += [text] if tag == "COMMENT" else []
            return
        if tag in _OUTER or tag in _GROUPS:
            return
        if self._place[-1:] == ["data"] and tag in _XML_BLOCKS:
            self._block = None
        elif tag == "COMMENT":
            (self.message.comments if self._block is None else self._block.comments).append(text)
        elif self._block is None or (tag == "EPOCH" and "EPOCH" not in self.message.meta):
            if not self.message.put_common(tag, text, self.line):
                raise self.message.unknown(tag, self.line)
        else:
            self._put(tag, text)

    def _put(self, tag, text):
        unit = self._attributes.get("units")
        value = text if unit is None else f"{text} [{unit}]"
        label = self._attributes.get("angle") or self._attributes.get("rate")
        if tag in ("rotation1", "rotation2", "rotation3") and label in _REPEATED:
            tag = label
        if self.message.version == "1.0" and tag in OLD:
            name, tag = OLD[tag]
            if name != self._block.name:
                raise self.message.unknown(tag, self.line)
        elif tag not in BLOCKS[self._block.name]:
            raise self.message.unknown(tag, self.line)
        self.message.put(self._block, tag, value, self.line)


def number(message, block, keyword, kind=None):
    """The value of a keyword as a finite float, its unit checked; kinds are those of _UNITS."""
    from attitude.textfiles.lines import is_number

    line = block.lines.get(keyword)
    if keyword not in block:
        raise message.fault(f"the block {block.name} lacks {keyword}.", block.line)
    value, unit = kvn.without_unit(block[keyword])
    return checked_number(message, keyword, value, unit, kind, line, is_number)


def checked_number(message, keyword, value, unit, kind, line, is_number):
    allowed = _UNITS.get(kind, ())
    if unit and unit.replace(" ", "") not in allowed:
        known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
        raise message.fault(f"{keyword} is in {unit!r}{known}.", line)
    if not is_number(value.encode("ascii", "replace")) or abs(float(value)) == float("inf"):
        raise message.fault(f"{keyword} is {value[:40]!r}, which is no finite number.", line)
    result = float(value)
    if result != result:
        raise message.fault(f"{keyword} is {value[:40]!r}, which is no finite number.", line)
    return result


def needs(message, keyword):
    """A keyword of the meta data that must be there."""
    if not message.meta.get(keyword):
        raise message.fault(f"the message lacks {keyword}.", None)
    return message.meta[keyword]


def one_of(message, block, keyword, choices):
    """What a keyword stands for, of some choices."""
    value = block.get(keyword)
    if value is None or value.upper() not in choices:
        given = "is not given" if value is None else f"is {value!r}"
        raise message.fault(
            f"{keyword} of the block {block.name} {given}; it must be one of {', '.join(choices)}.",
            block.lines.get(keyword, block.line),
        )
    return choices[value.upper()]
