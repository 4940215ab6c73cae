"""Header and segments of an Attitude Ephemeris Message, in either notation and version.

The readers of KVN and XML collect keywords and rows; this module checks them and makes them an
AttitudeTable.  For the conventions see `attitude_types`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from attitude import quaternion
from attitude.attitude_table import interpolation
from attitude.attitude_table.table import AttitudeTable
from attitude.axes import axes
from attitude.epochs import Instant
from attitude.errors import AttitudeError
from attitude.formats.aem import lenient, one_object
from attitude.formats.ccsds import attitude_types, old_rates
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.rows import TOLERANCE, Rows, known_tolerance
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from attitude.axes.axes import Axes
    from attitude.formats.ccsds.attitude_types import Convention
    from attitude.paths.path import Path
    from attitude.textfiles.lines import Fault

# Version -> keywords of a segment, in the order in which they are written.
META: dict[str, tuple[str, ...]] = {
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
    """Arguments of `aem.read` that supplement the file.

    Attributes
    ----------
    tolerance : float
        Largest deviation from 1 of the length of a quaternion.
    frame : str or None
        The external axes, if their name in the file is not known.
    orbit : Path or None
        Path of the body about its center, for axes of an orbit.
    rates : str or None
        What the rates of version 1 are: "body", "euler", or None: "body" with a warning.
    object : str or None
        OBJECT_ID or OBJECT_NAME of the segments that are read.
    segment : int or None
        The place of the one segment that is read, counted from 0.
    lenient : bool
        Whether missing parts of a message in KVN are assumed.
    cic : bool
        Whether the file is in the dialect of CNES; see `formats.cic`.
    """

    tolerance: float = TOLERANCE
    frame: str | None = None
    orbit: Path | None = None
    rates: str | None = None
    object: str | None = None
    segment: int | None = None
    lenient: bool = False
    cic: bool = False

    def __post_init__(self) -> None:
        known_tolerance(self.tolerance)
        old_rates.known(self.rates)


@dataclass
class Message:
    """The header of a message, and its finished segments.

    Attributes
    ----------
    path, version : str
    options : Options
    header : dict of str
        Keyword -> value.
    comments : list of str
    tables : list of AttitudeTable
        One for each finished segment.
    warned : bool
        Whether a warning of the rates of version 1 was given.
    assumed : list of str
        What a lenient reading has assumed.
    title : str
        Format and version in `AttitudeTable.meta`, by default those of an AEM.
    """

    path: str
    version: str
    options: Options
    header: dict[str, str] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    tables: list[AttitudeTable] = field(default_factory=list)
    warned: bool = False
    assumed: list[str] = field(default_factory=list)
    title: str = ""

    def table(self) -> AttitudeTable:
        """The segments of one object as one AttitudeTable; see `one_object.chosen`."""
        options = self.options
        return one_object.chosen(
            self.tables, self.path, options.object, options.segment, options.tolerance
        )


class MessageSegment:
    """One segment of a message while it is read.

    Parameters
    ----------
    message : Message
    fault : callable
        Makes the error for a sentence and the number of a line.

    Attributes
    ----------
    message, fault
        As given.
    values, lines : dict
        Keyword of the meta data -> value, and -> number of its line.
    comments, data_comments : list of str
        Comments of the meta data and of the data.

    The following are set by `begin`.

    kind : str
        Attitude type, under its name in version 2.
    scale : str
        Time scale in lower case.
    axes, body : Axes, str
        The external axes, and the name of the body's.
    how : Convention
    usable : list of two Instants, or None for each
    method, degree : str, int, or None
        Interpolation.
    rows : Rows or None
        The records; None before `begin`.
    """

    kind: str
    scale: str
    axes: Axes
    body: str
    how: Convention
    usable: list[Instant | None]
    method: str | None
    degree: int | None

    def __init__(self, message: Message, fault: Fault):
        self.message: Message = message
        self.fault: Fault = fault
        self.values: dict[str, str] = {}
        self.lines: dict[str, int] = {}
        self.comments: list[str] = []
        self.data_comments: list[str] = []
        self.rows: Rows | None = None

    def add(self, keyword: str, value: str, line: int) -> None:
        """Add a keyword of the meta data; AttitudeError if it is unknown or repeated."""
        allowed = META[self.message.version]
        if keyword not in allowed and self.message.options.lenient:
            self.assume(f"{cut(keyword, '')} is not known: left out")
            return
        if keyword not in allowed:
            others = [v for v in META if keyword in META[v]]
            hint = f" (it belongs to version {others[0]})" if others else ""
            raise self.fault(
                f"{cut(keyword, '')} is not known among the meta data of version "
                f"{self.message.version}{hint}; known are {', '.join(allowed)}.",
                line,
            )
        if keyword in self.values:
            raise self.fault(
                f"{keyword} was given before, in line {self.lines[keyword]}; give it once.", line
            )
        self.values[keyword], self.lines[keyword] = value, line

    def begin(self, line: int) -> None:
        """Check the complete meta data and prepare for the rows.

        Raises
        ------
        AttitudeError
            For missing keywords and values that are not known.
        """
        version, values = self.message.version, self.values
        if self.message.options.lenient:
            lenient.fill(self)
        for keyword in _NEEDED:
            loose = self.message.options.lenient or self.message.options.cic
            known = loose and keyword in ("START_TIME", "STOP_TIME")
            if not values.get(keyword) and not known:
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
            rates_of_angles=self._old_rates() == "euler",
        )
        self.usable = [self._epoch(f"USEABLE_{end}_TIME") for end in ("START", "STOP")]
        self._limits = self._epoch("START_TIME"), self._epoch("STOP_TIME")
        if None not in self._limits and self._limits[1].since(self._limits[0]) < 0.0:
            raise self.fault("STOP_TIME is before START_TIME.", self.lines["STOP_TIME"])
        self.method, self.degree = self._interpolation()
        self.rows = Rows(self.scale, len(attitude_types.COLUMNS[self.kind]))

    def assume(self, what: str) -> None:
        """Note what is assumed of the segment, once."""
        if what not in self.message.assumed:
            self.message.assumed.append(what)

    def take_columns_of_mms(self) -> None:
        """Read the rows as those of MMS: quaternions, scalar last, and rates over body axes."""
        self.assume("21 columns are those of MMS: Q1, Q2, Q3, QC and rates in deg/s over the body")
        self.kind = "QUATERNION/ANGVEL"
        self.how = replace(self.how, rates_over_body=True, scalar_first=False)
        self.rows = Rows(self.scale, len(attitude_types.COLUMNS[self.kind]))

    def finish(self, line: int) -> None:
        """Append the AttitudeTable of the complete rows to `message.tables`.

        Raises
        ------
        AttitudeError
            If there are no rows, and as `Rows.table`.
        """
        if self.rows is None or not self.rows.count:
            raise self.fault("the segment has no attitudes.", line)
        self.warn_of_rates()
        self.rows.refuse_outside(*self._limits, self.fault)
        values, options = self.values, self.message.options
        meta: dict[str, Any] = {
            "format": self.message.title or f"AEM {self.message.version}",
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
            **({"assumed": tuple(self.message.assumed)} if options.lenient else {}),
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
        """The external axes, the name of the body's axes, and whether the body is A."""
        a, b = self.values["REF_FRAME_A"], self.values["REF_FRAME_B"]
        try:
            return axes.of_pair(a, b, self.message.options.frame)
        except AttitudeError as err:
            raise self.fault(str(err), self.lines["REF_FRAME_B"]) from err

    def _to_body(self, body_is_a):
        if self.message.version != "1.0":
            return not body_is_a
        direction = self._one_of("ATTITUDE_DIR", {"A2B": "A2B", "B2A": "B2A"}, needed=True)
        return (direction == "A2B") != body_is_a

    def _scalar_first(self):
        if self.message.version != "1.0":
            return False
        needed = self.kind.startswith("QUATERNION")
        if self.message.options.cic and "QUATERNION_TYPE" not in self.values:
            return needed
        return self._one_of("QUATERNION_TYPE", {"FIRST": True, "LAST": False}, needed=needed)

    def _rates_over_body(self, body_is_a):
        if not self.kind.endswith("/ANGVEL"):
            return True
        keyword = "RATE_FRAME" if self.message.version == "1.0" else "ANGVEL_FRAME"
        a, b = self.values["REF_FRAME_A"].upper(), self.values["REF_FRAME_B"].upper()
        choices = {"REF_FRAME_A": body_is_a, "REF_FRAME_B": not body_is_a}
        choices |= {a: body_is_a, b: not body_is_a}
        return self._one_of(keyword, choices, needed=True)

    def _old_rates(self):
        """What the rates of version 1 are: "euler" or "body"; None without them."""
        if self.message.version != "1.0" or not self.kind.endswith("/ANGVEL"):
            return None
        return self.message.options.rates or "body"

    def take_derivatives(self) -> None:
        """Read the rates of version 1 as derivatives of the Euler angles."""
        if not self.how.rates_of_angles:
            self.how = replace(self.how, sequence=self._sequence(True), rates_of_angles=True)

    def warn_of_rates(self) -> None:
        """Warn, once for a message, where the file does not say what its rates of version 1 are."""
        stated = self.values["ATTITUDE_TYPE"].upper().endswith("/RATE")
        guessed = stated and self._old_rates() is not None and self.message.options.rates is None
        if guessed and not self.how.rates_of_angles and not self.message.warned:
            self.message.warned = True
            old_rates.warn(self.message.path, f"ATTITUDE_TYPE {self.values['ATTITUDE_TYPE']}")

    def _sequence(self, needed=False):
        needed = needed or self._old_rates() == "euler"
        if not self.kind.startswith("EULER") and not needed:
            return None
        if "EULER_ROT_SEQ" not in self.values:
            raise self.fault(
                "Euler angles and their rates need EULER_ROT_SEQ, like 321 or ZYX.", None
            )
        return self._checked("EULER_ROT_SEQ", lambda text: quaternion.known_sequence(text.upper()))

    def _one_of(self, keyword, choices, *, needed):
        value = self.values.get(keyword)
        if value is None:
            if needed:
                raise self.fault(
                    f"the meta data lack {keyword}, which {self.values['ATTITUDE_TYPE']} needs; it "
                    f"must be one of {', '.join(cut(each, '') for each in choices)}.",
                    None,
                )
            return False
        if value.upper() not in choices:
            raise self.fault(
                f"{keyword} is {cut(value)}; it must be one of "
                f"{', '.join(cut(each, '') for each in choices)}.",
                self.lines[keyword],
            )
        return choices[value.upper()]

    def _epoch(self, keyword):
        value = self.values.get(keyword)
        if value is None:
            return None
        days = value.encode("ascii", "replace").split() if self.message.options.cic else []
        try:
            if len(days) == 2:
                hi, lo = ccsds_epochs.parsed_days(days[:1], days[1:], self.scale)
                return Instant(float(hi[0]), float(lo[0]))
            return ccsds_epochs.instant(value, self.scale)
        except ccsds_epochs.BadEpoch as err:
            raise self.fault(
                f"{keyword} is {cut(value)}, no epoch: {err.reason}.", self.lines[keyword]
            ) from err

    def _interpolation(self):
        method, degree = (self.values.get(f"INTERPOLATION_{k}") for k in ("METHOD", "DEGREE"))
        try:
            degree = None if degree is None else int(degree)
            if method is None and self.message.options.cic:
                method, degree = "slerp", 1  # as VTS interpolates
            interpolation.settled(method, degree, 2, True)
        except (ValueError, AttitudeError) as err:
            keyword = "INTERPOLATION_" + ("DEGREE" if isinstance(degree, str) else "METHOD")
            reason = str(err) if isinstance(err, AttitudeError) else "give a whole number."
            raise self.fault(
                f"{keyword} is {cut(self.values.get(keyword))}: {reason}",
                self.lines.get(keyword),
            ) from err
        return method, degree
