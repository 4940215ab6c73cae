"""Attitude Ephemeris Messages in XML: CCSDS 505.0-B-1 for version 1.0, 505.0-B-3 for 2.0."""

from xml.sax.saxutils import escape

import numpy as np

from attitude.formats import attitude_types
from attitude.formats.aem_message import HEADER, VERSIONS, Message, Segment
from attitude.formats.xml_events import Events

_BATCH = 4096
_SCHEMA = {
    "1.0": "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-2.0.0-master-2.0.xsd",
    "2.0": "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd",
}
_UNITS = ("deg", "deg/s", "s", "1/s")
# The elements that hold a record, by version and type.
_ELEMENTS = {
    "2.0": {
        "QUATERNION": "quaternionEphemeris",
        "QUATERNION/DERIVATIVE": "quaternionDerivative",
        "QUATERNION/ANGVEL": "quaternionAngVel",
        "EULER_ANGLE": "eulerAngle",
        "EULER_ANGLE/DERIVATIVE": "eulerAngleDerivative",
        "EULER_ANGLE/ANGVEL": "eulerAngleAngVel",
        "SPIN": "spin",
        "SPIN/NUTATION": "spinNutation",
        "SPIN/NUTATION_MOM": "spinNutationMom",
    },
    "1.0": {
        "QUATERNION": "quaternionState",
        "QUATERNION/DERIVATIVE": "quaternionDerivative",
        "QUATERNION/ANGVEL": "quaternionEulerRate",
        "EULER_ANGLE": "eulerAngle",
        "EULER_ANGLE/ANGVEL": "eulerAngleRate",
        "SPIN": "spin",
        "SPIN/NUTATION": "spinNutation",
    },
}
_RECORDS = {element for names in _ELEMENTS.values() for element in names.values()}


def read(path, options):
    """The AttitudeTable of an AEM in XML; see `aem.read`."""
    reader = _Reader(path, options)
    reader.run()
    if not reader.done:
        raise reader.fault("there is no <aem> message in it.")
    return reader.message.table()


class _Reader(Events):
    def __init__(self, path, options):
        super().__init__(path)
        self._options = options
        self.message = self._segment = self._record = None
        self._place = []
        self._attributes = {}
        self.done = False

    def begin(self, tag, attributes):
        if self._record is not None:
            pass
        elif self.message is None and tag != "ndm":
            self._open(tag, attributes)
        elif tag == "segment":
            self._segment = Segment(self.message, self.fault)
            self._rows, self._tokens, self._lines = [], [], []
        elif tag == "data":
            if self._segment is None or self._segment.rows is None:
                raise self.fault("<data> stands before the end of <metadata>.")
        elif tag == "attitudeState":
            if self._segment is None or self._segment.rows is None:
                raise self.fault("<attitudeState> stands outside of <data>.")
            self._record, self._epoch = {}, None
            self._columns = attitude_types.COLUMNS[self._segment.kind]
        self._attributes = attributes
        self._place.append(tag)

    def end(self, tag, text):
        self._place.pop()
        above = self._place[-1] if self._place else None
        if self._record is not None:
            self._in_record(tag, text, above)
        elif above == "header":
            self._in_header(tag, text)
        elif above == "metadata":
            self._in_metadata(tag, text)
        elif tag == "metadata" and self._segment is not None:
            self._segment.begin(self.line)
        elif above == "data":
            self._in_data(tag, text)
        elif tag == "segment" and self._segment is not None:
            if self._segment.rows is None:
                raise self.fault("the segment has no <metadata>.")
            self._take()
            self._segment.finish(self.line)
            self._segment = None
        elif tag == "aem":
            if not self.message.tables:
                raise self.fault("the message has no <segment>.")
            self.done = True

    def _open(self, tag, attributes):
        version = attributes.get("version")
        if tag != "aem" or version not in VERSIONS:
            raise self.fault(
                f"its outermost element is <{tag[:40]}> of version {version!r}; an AEM is <aem "
                f'id="CCSDS_AEM_VERS" version="{" or ".join(VERSIONS)}">.'
            )
        self.message = Message(self.path, version, self._options)

    def _in_header(self, tag, text):
        if tag == "COMMENT":
            self.message.comments.append(text)
        elif tag in HEADER and tag not in self.message.header:
            self.message.header[tag] = text
        else:
            raise self.fault(f"<{tag}> does not belong into the header, or not twice.")

    def _in_metadata(self, tag, text):
        if self._segment is None:
            raise self.fault("<metadata> stands outside of a <segment>.")
        if tag == "COMMENT":
            self._segment.comments.append(text)
        else:
            self._segment.add(tag, text, self.line)

    def _in_data(self, tag, text):
        if tag != "COMMENT":
            raise self.fault(f"<{tag}> does not belong into <data>; an AEM has <attitudeState>.")
        self._segment.data_comments.append(text)

    def _in_record(self, tag, text, above):
        if tag in self._columns:
            self._put(tag, text)
        elif tag == "attitudeState":
            self._finish_record()
        elif tag == "EPOCH":
            self._epoch = text.encode("ascii", "replace")
        elif text:
            self._put(self._name(tag, above), text)
        elif tag not in _RECORDS and not self._known_group(tag):
            raise self.fault(f"<{tag}> is empty or not known among the records.")

    def _known_group(self, tag):
        return tag in (
            *("quaternion", "quaternionDot", "quaternionRate", "angVel"),
            *("rotationAngles", "rotationRates"),
        )

    def _name(self, tag, above):
        """The name of the column that an element holds."""
        if tag in ("rotation1", "rotation2", "rotation3"):
            if above == "rotationAngles":
                return f"ANGLE_{tag[-1]}"
            label = self._attributes.get("rate", "XYZ"[int(tag[-1]) - 1])
            return f"ANGVEL_{label[:1].upper()}"
        return tag

    def _put(self, name, text):
        unit = self._attributes.get("units", "deg")
        if unit not in _UNITS:
            raise self.fault(f"{name} is given in {unit!r}; units are {', '.join(_UNITS)}.")
        if name not in self._columns or name in self._record:
            raise self.fault(
                f"{name} does not belong into a record of "
                f"{self._segment.values['ATTITUDE_TYPE']}, or not twice."
            )
        try:
            self._record[name] = float(text)
        except ValueError as err:
            raise self._no_number(name, text) from err
        if "_" in text:  # which Python takes for a separator of digits
            raise self._no_number(name, text)

    def _no_number(self, name, text):
        return self.fault(f"{name} is {text[:40]!r}, which is no number.")

    def _finish_record(self):
        names = self._columns
        if self._epoch is None or len(self._record) < len(names):
            lacking = [name for name in names if name not in self._record]
            if self._epoch is None:
                lacking.insert(0, "EPOCH")
            raise self.fault(f"the record lacks {', '.join(lacking)}.")
        if self._segment.how.scalar_first:
            names = _scalar_first(names)
        self._rows.append([self._record[name] for name in names])
        self._tokens.append(self._epoch)
        self._lines.append(self.line)
        self._record = None
        if len(self._rows) == _BATCH:
            self._take()

    def _take(self):
        if self._rows:
            self._segment.rows.add(self._tokens, np.array(self._rows), self._lines, self.fault)
            self._rows, self._tokens, self._lines = [], [], []


def _scalar_first(columns):
    """The columns as version 1 has them in KVN with QUATERNION_TYPE = FIRST."""
    groups = [columns[k : k + 4] for k in range(0, len(columns), 4)]
    return [n for g in groups for n in (g[3:] + g[:3] if g[3:4] and g[3].startswith("QC") else g)]


# Writing ------------------------------------------------------------------------------------------


def write_message(file, version, header, comments, segments):
    """A message in XML, to an open file; see `aem.write`."""
    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<aem xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        f'     xsi:noNamespaceSchemaLocation="{_SCHEMA[version]}"\n'
        f'     id="CCSDS_AEM_VERS" version="{version}">\n  <header>\n'
    )
    _leaves(file, 4, [("COMMENT", text) for text in comments])
    _leaves(file, 4, header.items())
    file.write("  </header>\n  <body>\n")
    for segment in segments:
        file.write("    <segment>\n      <metadata>\n")
        _leaves(file, 8, [("COMMENT", text) for text in segment.comments])
        _leaves(file, 8, segment.keywords.items())
        file.write("      </metadata>\n      <data>\n")
        _leaves(file, 8, [("COMMENT", text) for text in segment.data_comments])
        row = _template(segment, version)
        order = _as_in_template(segment)
        for epochs, columns in segment.rows():
            lists = [epochs, *columns[:, order].T.tolist()]
            file.write("".join([row % each for each in zip(*lists, strict=True)]))
        file.write("      </data>\n    </segment>\n")
    file.write("  </body>\n</aem>\n")


def _leaves(file, indent, pairs):
    for tag, text in pairs:
        file.write(f"{' ' * indent}<{tag}>{escape(text)}</{tag}>\n")


def _as_in_template(segment):
    """Which of the segment's columns follow each other in the elements."""
    columns = attitude_types.COLUMNS[segment.kind]
    given = _scalar_first(columns) if segment.scalar_first else list(columns)
    return [given.index(name) for name in columns]


def _template(segment, version):
    """One record as text, with %s for the epoch and %r for each column."""
    kind, columns = segment.kind, attitude_types.COLUMNS[segment.kind]
    lines = ["<EPOCH>%s</EPOCH>"]
    for group, names in _groups(kind, columns, version):
        inner = [_leaf(name, version, k + 1, segment.sequence) for k, name in enumerate(names)]
        lines += [f"<{group}>", *inner, f"</{group}>"] if group else inner
    element = _ELEMENTS[version][kind]
    lines = [f"<{element}>", *lines, f"</{element}>"]
    return (
        "".join(["        <attitudeState>\n", *(f"          {line}\n" for line in lines)])
        + "        </attitudeState>\n"
    )


def _groups(kind, columns, version):
    if kind.startswith("SPIN"):
        return [(None, columns)]
    first = 4 if kind.startswith("QUATERNION") else 3
    given, rates = columns[:first], columns[first:]
    old = version == "1.0"
    if kind.startswith("QUATERNION"):
        groups = [("quaternion", given)]
        names = {
            "/DERIVATIVE": ("quaternionDot", "quaternionRate"),
            "/ANGVEL": ("angVel", "rotationRates"),
        }
    else:
        groups = [("rotationAngles" if old else None, given)]
        names = {"/DERIVATIVE": (None, None), "/ANGVEL": (None, "rotationRates")}
    if rates:
        groups.append((names["/" + kind.split("/")[1]][old], rates))
    return groups


def _leaf(name, version, number, sequence):
    if version == "1.0" and name.startswith("ANGLE"):
        label = f"{sequence[number - 1]}_ANGLE"
        return f'<rotation{number} angle="{label}" units="deg">%r</rotation{number}>'
    if version == "1.0" and name.startswith("ANGVEL"):
        return f'<rotation{number} rate="{name[-1]}_RATE" units="deg/s">%r</rotation{number}>'
    unit = _unit(name)
    return f'<{name} units="{unit}">%r</{name}>' if unit else f"<{name}>%r</{name}>"


def _unit(name):
    if name.startswith("Q"):
        return "1/s" if name.endswith("_DOT") else None
    if name == "NUTATION_PER":
        return "s"
    return "deg/s" if name.endswith(("_DOT", "_VEL")) or name.startswith("ANGVEL") else "deg"
