"""The content of an AEM or CIC file: header and segments, read and to be written.

`aem.read(lenient=True)` fills what files of operators leave out.  Definitive attitude of the MMS
mission (GSFC) has the header of an AEM, and 21 columns: the epoch, elapsed seconds, the quaternion
(scalar last) from J2000 to the body, its rates in deg/s over the body axes, phases, poles and a
flag of quality.  The quaternion and the rates are read.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._textfiles.lines import cut
from attitude._textfiles.messages import refuse_line_breaks
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.formats import _attitude_types, _recipes
from attitude.formats import _ccsds_epochs as ccsds_epochs
from attitude.formats._messages import written_body
from attitude.formats._records import TOLERANCE, Rows, columns_of, known_tolerance
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _axes, _table
from attitude.motions._table import AttitudeTable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from attitude._support.annotations import FloatArray
    from attitude._textfiles.lines import Fault
    from attitude.formats._attitude_types import Convention
    from attitude.formats._sampling import Records
    from attitude.motions._axes import Axes
    from attitude.paths._path import Path


# Columns of MMS, and those of them that are read: epoch, Q1, Q2, Q3, QC, rates X, Y, Z.
MMS: int = 21
_READ = (0, 2, 3, 4, 5, 6, 7, 8)
# Keyword -> what stands for it if it is missing; version 1 only, or both.
_MISSING = {
    **{"OBJECT_NAME": "UNKNOWN", "OBJECT_ID": "UNKNOWN", "TIME_SYSTEM": "UTC"},
    "ATTITUDE_TYPE": "QUATERNION",
}
_MISSING_1 = {"ATTITUDE_DIR": "A2B", "QUATERNION_TYPE": "LAST"}
_RATES = {"1.0": "RATE_FRAME", "2.0": "ANGVEL_FRAME"}


def fill(segment: MessageSegment) -> None:
    """Give a segment the keywords that it lacks, and note each; START_TIME, STOP_TIME follow from
    records.
    """
    version, values = segment.message.version, segment.values
    missing = {**_MISSING, **(_MISSING_1 if version == "1.0" else {})}
    if segment.message.options.cic:  # whose scalar stands first by default
        missing.pop("QUATERNION_TYPE")
    kind = values.get("ATTITUDE_TYPE", "")
    if kind.upper().endswith(("/RATE", "/ANGVEL")):
        missing[_RATES[version]] = values.get("REF_FRAME_B", "")
    if not kind.upper().startswith("QUATERNION") and kind:
        missing.pop("QUATERNION_TYPE", None)
    for keyword, value in missing.items():
        if not values.get(keyword):
            segment.values[keyword] = value
            segment.lines[keyword] = 1
            segment.assume(f"{keyword} is missing: {cut(value, '')}")
    for keyword in ("START_TIME", "STOP_TIME"):
        if not values.get(keyword) and not segment.message.options.cic:
            segment.assume(f"{keyword} is missing: that of the records")


def of_mms(tokens: Sequence[bytes]) -> list[bytes]:
    """The entries of a row of MMS that are read."""
    return [tokens[k] for k in _READ]


# ---- The segments of a message that belong to one object, as one table

# Attitudes of two segments at one epoch contradict each other beyond this many times the tolerance
# of the length of quaternions: interpolation and few digits explain less.
_CONTRADICTING = 10.0
# Epochs at which two overlapping segments are compared.
_COMPARED = 1000


def chosen(
    tables: Sequence[AttitudeTable],
    path: str,
    name: str | None,
    segment: int | None,
    tolerance: float,
) -> AttitudeTable:
    """The segments of one object as one AttitudeTable."""
    if segment is not None:
        whole = isinstance(segment, int) and not isinstance(segment, bool)
        if not whole or not 0 <= segment < len(tables):
            raise AttitudeError(
                f"{path}: segment is {segment!r}; the file has the segments 0 to "
                f"{len(tables) - 1}, give one."
            )
        tables = tables[segment : segment + 1]
    if name is not None:
        names = [(each.meta["object_id"], each.meta["object_name"]) for each in tables]
        found = [t for t, known in zip(tables, names, strict=True) if name in known]
        if not found:
            raise AttitudeError(
                f"{path}: object is {cut(name)}; the segments are those of {_listed(names)}."
            )
        tables = found
    for what, keys, advice in (
        ("objects", ("object_id", "object_name"), "choose one with object= or segment="),
        ("body frames", ("body_frame",), "choose one segment with segment="),
    ):
        # The identifier decides; names may be written differently.
        values = [tuple(each.meta[key] for key in keys) for each in tables]
        if len({value[0].upper() for value in values}) > 1:
            raise AttitudeError(
                f"{path}: its segments are those of several {what}: {_listed(values)}; {advice} "
                "(on the command line --object, --segment)."
            )
    _refuse_contradictions(tables, path, _CONTRADICTING * tolerance)
    return AttitudeTable.joined(tables)


def _listed(names):
    different = list(dict.fromkeys(names))
    texts = [" ".join(dict.fromkeys(cut(part, "") for part in name)) for name in different]
    return ", ".join(texts[:6]) + (", ..." if len(texts) > 6 else "")


def _refuse_contradictions(tables, path, most):
    """AttitudeError for two segments whose attitudes differ where both are usable."""
    # By first epochs, each segment is compared with the one before: enough to find an overlap.
    order = sorted(range(len(tables)), key=lambda k: tables[k].span[0].seconds)
    for first, second in pairwise(order):
        one, two = tables[first], tables[second]
        end = min(one.span[1], two.span[1], key=lambda each: each.seconds)
        start = two.span[0]
        if end.since(start) <= 0.0:
            continue
        # At records of the second, which the first interpolates.
        shift = two.epoch.since(one.epoch)
        t = two.seconds[(two.seconds + shift >= start.since(one.epoch))]
        t = t[t + shift <= end.since(one.epoch)]
        t = t[:: max(1, len(t) // _COMPARED)]
        try:
            a, b = one.at(t + shift).wxyz, two.at(t).wxyz
        except AttitudeError:
            continue  # records too far apart to be interpolated
        angle = forms.to_axis_angle(quaternion.multiply(quaternion.conjugate(a), b))[1]
        if np.any(angle > most):
            k = int(np.argmax(angle > most))
            raise AttitudeError(
                f"{path}: the segments {first} and {second} overlap, and at "
                f"{two.epoch.after(float(t[k])).utc_iso} UTC their attitudes are {angle[k]:.3g} "
                "rad apart; choose one with segment= (on the command line --segment)."
            )


# ---- Header and segments of an Attitude Ephemeris Message, in either notation and version
# The readers of KVN and XML collect keywords and rows; `Message` checks them and makes them an
# AttitudeTable.  For the conventions see `_attitude_types`.

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

    tolerance: largest deviation from 1 of the length of a quaternion.
    frame: the external axes, if their name in the file is not known.
    orbit: path of the body about its center, for axes of an orbit.
    rates: what the rates of version 1 are: "body", "euler", or None: "body" with a warning.
    object: OBJECT_ID or OBJECT_NAME of the segments that are read.
    segment: the place of the one segment that is read, counted from 0.
    lenient: whether missing parts of a message in KVN are assumed.
    cic: whether the file is in the dialect of CNES; see `formats.cic`.
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
        _attitude_types.known_rates(self.rates)


@dataclass
class Message:
    """The header of a message, and its finished segments.

    header: keyword -> value.
    tables: one for each finished segment.
    warned: whether a warning of the rates of version 1 was given.
    assumed: what a lenient reading has assumed.
    title: format and version in `AttitudeTable.meta`, by default those of an AEM.
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
        """The segments of one object as one AttitudeTable; see `chosen`."""
        options = self.options
        return chosen(self.tables, self.path, options.object, options.segment, options.tolerance)


class MessageSegment:
    """One segment of a message while it is read.

    fault: makes the error for a sentence and the number of a line.

    values, lines: keyword of the meta data -> value, and -> number of its line.
    comments, data_comments: comments of the meta data and of the data.
    The following are set by `begin`.
    kind: attitude type, under its name in version 2.
    scale: time scale in lower case.
    axes, body: the external axes, and the name of the body's.
    method, degree: interpolation.
    rows: the records; None before `begin`.
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
        """Check the complete meta data and prepare for the rows."""
        version, values = self.message.version, self.values
        if self.message.options.lenient:
            fill(self)
        for keyword in _NEEDED:
            loose = self.message.options.lenient or self.message.options.cic
            known = loose and keyword in ("START_TIME", "STOP_TIME")
            if not values.get(keyword) and not known:
                raise self.fault(
                    f"the meta data end without {keyword}, which they must have.", line
                )
        self.kind = self._checked("ATTITUDE_TYPE", _attitude_types.known_type, version)
        self.scale = self._checked("TIME_SYSTEM", ccsds_epochs.known)
        self.axes, self.body, body_is_a = self._frames()
        self.how = _attitude_types.Convention(
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
        self.rows = Rows(self.scale, len(_attitude_types.COLUMNS[self.kind]))

    def assume(self, what: str) -> None:
        """Note what is assumed of the segment, once."""
        if what not in self.message.assumed:
            self.message.assumed.append(what)

    def take_columns_of_mms(self) -> None:
        """Read the rows as those of MMS: quaternions, scalar last, and rates over body axes."""
        self.assume("21 columns are those of MMS: Q1, Q2, Q3, QC and rates in deg/s over the body")
        self.kind = "QUATERNION/ANGVEL"
        self.how = replace(self.how, rates_over_body=True, scalar_first=False)
        self.rows = Rows(self.scale, len(_attitude_types.COLUMNS[self.kind]))

    def finish(self, line: int) -> None:
        """Append the AttitudeTable of the complete rows to `message.tables`."""
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
            return _axes.of_pair(a, b, self.message.options.frame)
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
            _attitude_types.warn(self.message.path, f"ATTITUDE_TYPE {self.values['ATTITUDE_TYPE']}")

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
            _table.settled(method, degree, 2, True)
        except (ValueError, AttitudeError) as err:
            keyword = "INTERPOLATION_" + ("DEGREE" if isinstance(degree, str) else "METHOD")
            reason = str(err) if isinstance(err, AttitudeError) else "give a whole number."
            raise self.fault(
                f"{keyword} is {cut(self.values.get(keyword))}: {reason}",
                self.lines.get(keyword),
            ) from err
        return method, degree


# ---- A segment of an Attitude Ephemeris Message to be written: its keywords and its rows


def written_kind(settings: Mapping[str, Any], has_rates: bool) -> str:
    """The attitude type that settings of `aem.write` mean, under its name in version 2."""
    usual = "QUATERNION/DERIVATIVE" if settings["version"] == "1.0" else "QUATERNION/ANGVEL"
    kind = settings["kind"] or (usual if has_rates else "QUATERNION")
    return _attitude_types.known_type(kind, "2.0")


class WrittenSegment:
    """A segment to be written: its keywords, and its rows piece by piece.

    settings: arguments of `aem.write`, by name; `names` are object_name, object_id, center,
        body_frame; `epochs`, if given, the function that writes epochs, as `_ccsds_epochs.texts`.

    kind: attitude type, under its name in version 2.
    scalar_first, sequence, rates_of_angles: as in `Convention`.
    keywords: keyword of the meta data -> value, in their order.
    comments, data_comments: comments of the meta data and of the data.
    AttitudeError for names of types, axes or time systems that are not known or not in this
        version.
    """

    def __init__(self, part: Records, settings: Mapping[str, Any]):
        self._part, self._settings = part, settings
        version = settings["version"]
        self.kind: str = written_kind(settings, part.has_rates)
        if version == "1.0" and self.kind not in _attitude_types.IN_VERSION_1:
            raise AttitudeError(
                f"{self.kind} is no attitude type of AEM 1.0; write version 2.0, or one of "
                f"{', '.join(_attitude_types.IN_VERSION_1)}."
            )
        old = version == "1.0" and self.kind.endswith("/ANGVEL")
        if old and settings["rates"] is None:
            raise AttitudeError(
                f"{_attitude_types.IN_VERSION_1[self.kind]} of AEM 1.0 is read in two ways; give "
                'rates="body" (components of the angular velocity) or rates="euler" (derivatives '
                "of the angles), or kind QUATERNION/DERIVATIVE, which all readers understand."
            )
        name = settings["frame"] or part.meta.get("frame") or "ICRF"
        self._axes = _axes.named(name)
        self._scale = ccsds_epochs.writable(
            settings["time_system"] or part.meta.get("time_system") or "UTC"
        )
        if settings["rates_over"] not in ("body", "frame"):
            raise AttitudeError(f"rates_over is {settings['rates_over']!r}; give body or frame.")
        self._how = _attitude_types.Convention(
            rates_over_body=settings["rates_over"] == "body",
            rates_follow=version != "1.0",
            scalar_first=settings["scalar_first"] and version == "1.0",
            sequence=settings["sequence"],
            rates_of_angles=old and settings["rates"] == "euler",
        )
        self.scalar_first: bool = self._how.scalar_first
        self.rates_of_angles: bool = self._how.rates_of_angles
        self.sequence: str = settings["sequence"]
        self.comments: Sequence[str] = part.meta.get("meta_comments", ())
        self.data_comments: Sequence[str] = part.meta.get("data_comments", ())
        self.keywords: dict[str, str] = self._keywords(version)
        refuse_line_breaks(*self.keywords.values(), *self.comments, *self.data_comments)

    def rows(self) -> Iterator[tuple[list[str], FloatArray]]:
        """The rows piece by piece: epochs as texts, and columns (N, columns) in deg, deg/s, s."""
        settings = self._settings
        for history in self._part.pieces():
            epochs = self._texts(history.epoch, history.seconds, history.low)
            columns = columns_of(history, self.kind, self._how, self._axes, settings["orbit"])
            yield epochs, columns

    def _texts(self, epoch, seconds, low):
        written = self._settings.get("epochs", ccsds_epochs.texts)
        found: list[str] = written(epoch, seconds, low, self._scale, self._settings["digits"])
        return found

    def _keywords(self, version):
        part, settings, meta = self._part, self._settings, self._part.meta
        given = zip(
            settings["names"], ("object_name", "object_id", "center", "body_frame"), strict=True
        )
        name, number, center, body = (value or meta.get(key) for value, key in given)
        body = written_body(body, {})
        frame = _axes.WRITTEN.get(self._axes.kind) if self._axes.name.islower() else self._axes.name
        start, stop = self._texts(part.epoch, *part.first_and_last())
        method, degree = self._interpolation()
        rate_frame = "REF_FRAME_B" if version == "1.0" else body
        if not self._how.rates_over_body:
            rate_frame = "REF_FRAME_A" if version == "1.0" else frame
        digits, rated = str.maketrans("XYZ", "123"), self.kind.endswith("/ANGVEL")
        known = {
            "OBJECT_NAME": name or "UNKNOWN",
            "OBJECT_ID": number or "UNKNOWN",
            "CENTER_NAME": center,
            "REF_FRAME_A": frame,
            "REF_FRAME_B": body,
            "ATTITUDE_DIR": "A2B",
            "TIME_SYSTEM": self._scale.upper(),
            "START_TIME": start,
            "USEABLE_START_TIME": None,
            "USEABLE_STOP_TIME": None,
            "STOP_TIME": stop,
            "ATTITUDE_TYPE": _attitude_types.IN_VERSION_1[self.kind]
            if version == "1.0"
            else self.kind,
            "QUATERNION_TYPE": ("FIRST" if self._how.scalar_first else "LAST")
            if self.kind.startswith("QUATERNION")
            else None,
            "EULER_ROT_SEQ": (
                self._how.sequence.translate(digits) if version == "1.0" else self._how.sequence
            )
            if self.kind.startswith("EULER") or (version == "1.0" and rated)
            else None,
            "RATE_FRAME": rate_frame if rated else None,
            "ANGVEL_FRAME": rate_frame if rated else None,
            "INTERPOLATION_METHOD": method,
            "INTERPOLATION_DEGREE": str(degree),
        }
        if part.table is not None:
            known.update(self._usable(part.table))
        return {key: known[key] for key in META[version] if known[key] is not None}

    def _interpolation(self):
        """Recommended interpolation: that of a table, of a degree for which there are records."""
        method, degree, table = self._settings["method"], self._settings["degree"], self._part.table
        if method is None and table is not None:
            method, degree = table.method, degree or table.degree
        has_rates = _attitude_types.has_rates(self.kind)
        count = len(self._part)
        method, degree = _table.settled(method, degree, count, has_rates)
        degree = _recipes.degree_of(self._settings["for_"], degree, count)
        return "LINEAR" if method == "slerp" else method.upper(), degree

    def _usable(self, table):
        ends = list(zip(*self._part.first_and_last(), strict=True))
        limits = max(table._limits[0], ends[0]), min(table._limits[1], ends[1])
        if limits == tuple(ends):
            return {}
        hi, lo = np.array(limits).T
        names = ("USEABLE_START_TIME", "USEABLE_STOP_TIME")
        return dict(zip(names, self._texts(table.epoch, hi, lo), strict=True))
