"""What an Attitude Ephemeris Message says of its segments, in either notation and version.

The readers of KVN and XML collect keywords and rows; here they are checked and become an
AttitudeTable.  For the conventions see `attitude_types`.
"""

from dataclasses import dataclass, field

from attitude.attitude_table.table import AttitudeTable
from attitude.errors import AttitudeError
from attitude.formats.ccsds import attitude_types, axes
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.rows import TOLERANCE, Rows, known_tolerance

VERSIONS = ("1.0", "2.0")
HEADER = ("CREATION_DATE", "ORIGINATOR", "MESSAGE_ID", "CLASSIFICATION")
# Keywords of a segment, in the order in which they are written.
META = {
    "1.0": (
        *("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "REF_FRAME_A", "REF_FRAME_B", "ATTITUDE_DIR"),
        *("TIME_SYSTEM", "START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "STOP_TIME"),
        *("ATTITUDE_TYPE", "QUATERNION_TYPE", "EULER_ROT_SEQ", "RATE_FRAME"),
        *("INTERPOLATION_METHOD", "INTERPOLATION_DEGREE"),
    ),
    "2.0": (
        *("OBJECT_NAME", "OBJECT_ID", "CENTER_NAME", "REF_FRAME_A", "REF_FRAME_B"),
        *("TIME_SYSTEM", "START_TIME", "USEABLE_START_TIME", "USEABLE_STOP_TIME", "STOP_TIME"),
        *("ATTITUDE_TYPE", "EULER_ROT_SEQ", "ANGVEL_FRAME"),
        *("INTERPOLATION_METHOD", "INTERPOLATION_DEGREE"),
    ),
}
_NEEDED = (
    *("OBJECT_NAME", "OBJECT_ID", "REF_FRAME_A", "REF_FRAME_B", "TIME_SYSTEM"),
    *("START_TIME", "STOP_TIME", "ATTITUDE_TYPE"),
)


@dataclass
class Options:
    """What a caller of a reader can say about the file."""

    tolerance: float = TOLERANCE
    frame: str | None = None
    orbit: object = None

    def __post_init__(self):
        known_tolerance(self.tolerance)


@dataclass
class Message:
    """The header of a message, and its finished segments."""

    path: str
    version: str
    options: Options
    header: dict = field(default_factory=dict)
    comments: list = field(default_factory=list)
    tables: list = field(default_factory=list)

    def table(self):
        """All segments as one AttitudeTable."""
        return AttitudeTable.joined(self.tables)


class Segment:
    """One segment while it is read.

    `fault(sentence, line)` makes the error for a line of the file.
    """

    def __init__(self, message, fault):
        self.message, self.fault = message, fault
        self.values, self.lines = {}, {}
        self.comments, self.data_comments = [], []
        self.rows = None

    def add(self, keyword, value, line):
        """A keyword of the meta data."""
        allowed = META[self.message.version]
        if keyword not in allowed:
            others = [v for v in VERSIONS if keyword in META[v]]
            hint = f" (it belongs to version {others[0]})" if others else ""
            raise self.fault(
                f"{keyword} is not known among the meta data of version "
                f"{self.message.version}{hint}; known are {', '.join(allowed)}.",
                line,
            )
        if keyword in self.values:
            raise self.fault(
                f"{keyword} was given before, in line {self.lines[keyword]}; give it once.", line
            )
        self.values[keyword], self.lines[keyword] = value, line

    def begin(self, line):
        """The meta data are complete: find out what the rows will mean."""
        version, values = self.message.version, self.values
        for keyword in _NEEDED:
            if not values.get(keyword):
                raise self.fault(
                    f"the meta data end without {keyword}, which they must have.", line
                )
        self.kind = self._checked("ATTITUDE_TYPE", attitude_types.known, version)
        self.scale = self._checked("TIME_SYSTEM", ccsds_epochs.known)
        self.axes, self.body, body_is_a = self._frames()
        self.how = attitude_types.Convention(
            to_body=self._to_body(body_is_a),
            rates_over_body=self._rates_over_body(body_is_a),
            rates_follow=version != "1.0",
            scalar_first=self._scalar_first(),
            sequence=self._sequence(),
        )
        self.usable = [self._epoch(f"USEABLE_{end}_TIME") for end in ("START", "STOP")]
        for keyword in ("START_TIME", "STOP_TIME"):
            self._epoch(keyword)
        self.method, self.degree = self._interpolation()
        self.rows = Rows(self.scale, len(attitude_types.COLUMNS[self.kind]))

    def finish(self, line):
        """The rows are complete: make the table."""
        if not self.rows.count:
            raise self.fault("the segment has no attitudes.", line)
        values, options = self.values, self.message.options
        meta = {
            "format": f"AEM {self.message.version}",
            "header": dict(self.message.header),
            "comments": tuple(self.message.comments),
            "keywords": dict(values),
            "meta_comments": tuple(self.comments),
            "data_comments": tuple(self.data_comments),
            "object_name": values["OBJECT_NAME"],
            "object_id": values["OBJECT_ID"],
            "center": values.get("CENTER_NAME"),
            "frame": self.axes.name,
            "body_frame": self.body,
            "time_system": values["TIME_SYSTEM"].upper(),
        }
        try:
            table = self.rows.table(
                self.kind,
                self.how,
                self.axes,
                self.fault,
                tolerance=options.tolerance,
                orbit=options.orbit,
                method=self.method,
                degree=self.degree,
                usable=self.usable,
                meta=meta,
            )
        except AttitudeError as err:
            if str(err).startswith(self.message.path):
                raise
            raise self.fault(str(err), line) from err
        self.message.tables.append(table)

    def _checked(self, keyword, check, *more):
        try:
            return check(self.values[keyword], *more)
        except AttitudeError as err:
            raise self.fault(str(err), self.lines[keyword]) from err

    def _frames(self):
        """External axes, name of the body's, and whether the body is A."""
        a, b = self.values["REF_FRAME_A"], self.values["REF_FRAME_B"]
        known = [axes.known(name) for name in (a, b)]
        override = self.message.options.frame
        if override is not None:
            body_is_a = known[0] is None and known[1] is not None
            return axes.named(override), a if body_is_a else b, body_is_a
        if known[0] is not None and known[1] is not None:
            raise self.fault(
                f"REF_FRAME_A is {a} and REF_FRAME_B is {b}, both of them axes that are known; one "
                "must be those of the body.",
                self.lines["REF_FRAME_B"],
            )
        if known[0] is None and known[1] is None:
            raise self.fault(
                f"of REF_FRAME_A = {a} and REF_FRAME_B = {b} none is known as ICRF, EME2000, ITRF, "
                "TEME, RTN or LVLH; tell with frame= which axes the other one than the body's is.",
                self.lines["REF_FRAME_A"],
            )
        return (known[0], b, False) if known[0] is not None else (known[1], a, True)

    def _to_body(self, body_is_a):
        if self.message.version != "1.0":
            return not body_is_a
        direction = self._one_of("ATTITUDE_DIR", {"A2B": "A2B", "B2A": "B2A"}, needed=True)
        return (direction == "A2B") != body_is_a

    def _scalar_first(self):
        if self.message.version != "1.0":
            return False
        needed = self.kind.startswith("QUATERNION")
        return self._one_of("QUATERNION_TYPE", {"FIRST": True, "LAST": False}, needed=needed)

    def _rates_over_body(self, body_is_a):
        if not self.kind.endswith("/ANGVEL"):
            return True
        keyword = "RATE_FRAME" if self.message.version == "1.0" else "ANGVEL_FRAME"
        a, b = self.values["REF_FRAME_A"].upper(), self.values["REF_FRAME_B"].upper()
        choices = {"REF_FRAME_A": body_is_a, "REF_FRAME_B": not body_is_a}
        choices |= {a: body_is_a, b: not body_is_a}
        return self._one_of(keyword, choices, needed=True)

    def _sequence(self):
        if not self.kind.startswith("EULER"):
            return None
        from attitude import quaternion

        if "EULER_ROT_SEQ" not in self.values:
            raise self.fault("Euler angles need EULER_ROT_SEQ, like 321 or ZYX.", None)
        return self._checked("EULER_ROT_SEQ", lambda text: quaternion.known_sequence(text.upper()))

    def _one_of(self, keyword, choices, *, needed):
        value = self.values.get(keyword)
        if value is None:
            if needed:
                raise self.fault(
                    f"the meta data lack {keyword}, which {self.values['ATTITUDE_TYPE']} needs; it "
                    f"must be one of {', '.join(choices)}.",
                    None,
                )
            return False
        if value.upper() not in choices:
            raise self.fault(
                f"{keyword} is {value!r}; it must be one of {', '.join(choices)}.",
                self.lines[keyword],
            )
        return choices[value.upper()]

    def _epoch(self, keyword):
        value = self.values.get(keyword)
        if value is None:
            return None
        try:
            return ccsds_epochs.instant(value, self.scale)
        except ccsds_epochs.BadEpoch as err:
            raise self.fault(
                f"{keyword} is {value!r}, no epoch: {err.reason}.", self.lines[keyword]
            ) from err

    def _interpolation(self):
        from attitude.attitude_table import interpolation

        method, degree = (self.values.get(f"INTERPOLATION_{k}") for k in ("METHOD", "DEGREE"))
        try:
            degree = None if degree is None else int(degree)
            interpolation.settled(method, degree, 2, True)
        except (ValueError, AttitudeError) as err:
            keyword = "INTERPOLATION_" + ("DEGREE" if isinstance(degree, str) else "METHOD")
            reason = str(err) if isinstance(err, AttitudeError) else "give a whole number."
            raise self.fault(
                f"{keyword} is {self.values.get(keyword)!r}: {reason}", self.lines.get(keyword)
            ) from err
        return method, degree
