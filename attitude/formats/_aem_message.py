"""Segments of an AEM or CIC file: the table of keywords, the meaning of records, written records.

`aem.read(lenient=True)` fills what files of operators leave out.  Definitive attitude of the MMS
mission (GSFC) has the header of an AEM, and 21 columns: the epoch, elapsed seconds, the quaternion
(scalar last) from J2000 to the body, its rates in deg/s over the body axes, phases, poles and a
flag of quality.  The quaternion and the rates are read.

Keywords and elements of XML are those of CCSDS 504.0-B-1 with 505.0-B-1 and 505.0-B-2 (section
4.8) for version 1.0, and of CCSDS 504.0-B-2 (section 7) with 505.0-B-3 for version 2.0.  For the
conventions see `_records`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._textfiles import messages
from attitude._textfiles.lines import cut, prefixed
from attitude._textfiles.messages import (
    Form,
    Generator,
    XmlGenerator,
    comparable,
    refuse_line_breaks,
)
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.formats import _messages, _recipes, _records
from attitude.formats._messages import GROUPS, HEADER, VERSIONS, written_body, written_names
from attitude.formats._records import (
    ANGLES,
    ANGVEL,
    Q_DOT,
    TOLERANCE,
    Rows,
    columns_of,
    known_tolerance,
)
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _axes, _table
from attitude.motions._table import AttitudeTable

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from attitude._support.annotations import FilePath
    from attitude.formats._sampling import Records
    from attitude.paths._path import Path


# ---- The table of keywords, in the order in which they are written

# Version -> attitude type -> element of a record.
_NEW = {
    "QUATERNION": "quaternionEphemeris",
    "QUATERNION/DERIVATIVE": "quaternionDerivative",
    "QUATERNION/ANGVEL": "quaternionAngVel",
    "EULER_ANGLE": "eulerAngle",
    "EULER_ANGLE/DERIVATIVE": "eulerAngleDerivative",
    "EULER_ANGLE/ANGVEL": "eulerAngleAngVel",
    "SPIN": "spin",
    "SPIN/NUTATION": "spinNutation",
    "SPIN/NUTATION_MOM": "spinNutationMom",
}
_OLD = {
    **{"QUATERNION": "quaternionState", "QUATERNION/ANGVEL": "quaternionEulerRate"},
    "EULER_ANGLE/ANGVEL": "eulerAngleRate",
}
_ELEMENTS = {"2.0": _NEW, "1.0": {**{k: _NEW[k] for k in _records.IN_VERSION_1}, **_OLD}}
_RECORDS = {element for names in _ELEMENTS.values() for element in names.values()}

FORM = Form(
    "AEM",
    VERSIONS,
    HEADER,
    meta=(
        "OBJECT_NAME",
        "OBJECT_ID",
        "CENTER_NAME",
        "REF_FRAME_A",
        "REF_FRAME_B",
        "ATTITUDE_DIR",
        "TIME_SYSTEM",
        "START_TIME",
        "USEABLE_START_TIME",
        "USEABLE_STOP_TIME",
        "STOP_TIME",
        "ATTITUDE_TYPE",
        "QUATERNION_TYPE",
        "EULER_ROT_SEQ",
        "RATE_FRAME",
        "ANGVEL_FRAME",
        "INTERPOLATION_METHOD",
        "INTERPOLATION_DEGREE",
    ),
    only={
        **dict.fromkeys(("ATTITUDE_DIR", "QUATERNION_TYPE", "RATE_FRAME"), "1.0"),
        "ANGVEL_FRAME": "2.0",
    },
    needed=(
        "OBJECT_NAME",
        "OBJECT_ID",
        "REF_FRAME_A",
        "REF_FRAME_B",
        "TIME_SYSTEM",
        "START_TIME",
        "STOP_TIME",
        "ATTITUDE_TYPE",
    ),
    blocks={"DATA": ()},
    units=_messages.UNITS,
    elements={"data": "DATA"},
    rows={"DATA": "attitudeState"},
    once=("DATA",),
    groups=(
        "quaternion",
        "quaternionDot",
        "quaternionRate",
        "angVel",
        "rotationAngles",
        "rotationRates",
        *sorted(_RECORDS),
    ),
    marks={"metadata": "META", "data": "DATA"},
)


@dataclass
class Options:
    """Arguments of `aem.read` that supplement the file."""

    tolerance: float = TOLERANCE
    frame: str | None = None
    orbit: Path | None = None
    rates: str | None = None
    object: str | None = None
    segment: int | None = None
    lenient: bool = False

    def __post_init__(self) -> None:
        known_tolerance(self.tolerance)
        _records.known_rates(self.rates)


def read(path: FilePath, form: Form, options: Options) -> AttitudeTable:
    """The segments of one object of an AEM, or of a CIC file, as one AttitudeTable."""
    if options.lenient:
        form = replace(form, lenient=True, needed=("REF_FRAME_A", "REF_FRAME_B"))
    segments: list[_Segment] = []

    def begin_rows(block, count):
        segments.append(_Segment(block, options, count))
        return segments[-1]

    message = messages.read(path, form, begin_rows)
    for block in message.blocks:
        if block.rows is None:
            raise block.fault("the segment has no attitudes.")
    if not segments:
        raise message.fault("the message has no segment.", None)
    for guessed in [segment for segment in segments if segment.has_guessed_rates()][:1]:
        name = f"ATTITUDE_TYPE {guessed.block.meta['ATTITUDE_TYPE']}"
        _records.warn(message.path, name)
    tables = [segment.finished() for segment in segments]
    return _chosen(tables, message.path, options)


# ---- The records of a segment, and what its meta data say of them

# Columns of MMS, and those of them that are read: epoch, Q1, Q2, Q3, QC, rates X, Y, Z.
_MMS = 21
_READ = (0, 2, 3, 4, 5, 6, 7, 8)
# Keyword -> what stands for it if it is missing.
_MISSING = {
    **{"OBJECT_NAME": "UNKNOWN", "OBJECT_ID": "UNKNOWN", "TIME_SYSTEM": "UTC"},
    "ATTITUDE_TYPE": "QUATERNION",
}


class _Segment(Rows):
    """The records of a segment while they are read, by the conventions of its meta data."""

    def __init__(self, block, options, count):
        meta, form = block.meta, block.message.form
        self.block, self._options = block, options
        self._is_cic = form.family == "CIC"  # whose versions have the keywords of AEM 1.0
        self._is_old = self._is_cic or block.message.version == "1.0"
        is_mms = options.lenient and not self._is_cic and count == _MMS
        if is_mms:
            meta["ATTITUDE_TYPE"] = "QUATERNION"  # in place of QUATERNION/RATE/SPIN/NUTATION
        if options.lenient:
            self._fill()
        with meta.located("ATTITUDE_TYPE"):
            version = "1.0" if self._is_old else "2.0"
            self._kind = _records.known_type(meta["ATTITUDE_TYPE"], version)
        scale = _messages.scale_of(meta)
        self._axes, self._body, body_is_a = _messages.axes_of(meta, options.frame)
        self._convention = self._convention_of(body_is_a)
        self._usable = [self._epoch(f"USEABLE_{end}_TIME", scale) for end in ("START", "STOP")]
        self._limits = self._epoch("START_TIME", scale), self._epoch("STOP_TIME", scale)
        _messages.refuse_reversed(meta, *self._limits)
        _messages.refuse_reversed(meta, *self._usable, "USEABLE_")
        self._interpolation = self._recommended()
        if is_mms:
            block.message.assume(
                "21 columns are those of MMS: Q1, Q2, Q3, QC and rates in deg/s over the body; the "
                "flag of quality (QF) is not read"
            )
            self._kind, self.others = "QUATERNION/ANGVEL", {_MMS: _READ}
            self._convention = replace(self._convention, rates_over_body=True, scalar_first=False)
        columns = _records.COLUMNS[self._kind]
        names = _scalar_first(columns) if self._convention.scalar_first else columns
        lead, epoch = (2, "an MJD and its seconds") if self._is_cic else (1, "an epoch")
        super().__init__(scale, block.message.fault, names, lead)
        self.holds = (
            f"{cut(meta['ATTITUDE_TYPE'], '')} has {epoch} and {len(columns)} numbers: "
            f"{', '.join(columns)}"
        )

    def _fill(self):
        """Assume the keywords that are missing; START_TIME, STOP_TIME follow from records."""
        meta, assume = self.block.meta, self.block.message.assume
        missing, kind = dict(_MISSING), meta.get("ATTITUDE_TYPE", "").upper()
        if self._is_old:
            missing["ATTITUDE_DIR"] = "A2B"
            # The scalar of CIC stands first by default.
            if not self._is_cic and (not kind or kind.startswith("QUATERNION")):
                missing["QUATERNION_TYPE"] = "LAST"
        if kind.endswith(("/RATE", "/ANGVEL")):
            missing["RATE_FRAME" if self._is_old else "ANGVEL_FRAME"] = meta["REF_FRAME_B"]
        for keyword, value in missing.items():
            if not meta.get(keyword):
                meta[keyword] = value
                assume(f"{keyword} is missing: {cut(value, '')}")
        for keyword in ("START_TIME", "STOP_TIME"):
            if not meta.get(keyword) and not self._is_cic:
                assume(f"{keyword} is missing: that of the records")

    def _convention_of(self, body_is_a):
        """Directions and axes of the columns."""
        meta, is_old, kind = self.block.meta, self._is_old, self._kind
        to_body, scalar_first, over_body, sequence = not body_is_a, False, True, None
        is_rated = kind.endswith("/ANGVEL")
        of_angles = is_old and is_rated and self._options.rates == "euler"
        if is_old:
            to_body = (meta.one_of("ATTITUDE_DIR", ("A2B", "B2A")) == "A2B") != body_is_a
            is_needed = kind.startswith("QUATERNION")
            if "QUATERNION_TYPE" in meta or (is_needed and not self._is_cic):
                scalar_first = meta.one_of("QUATERNION_TYPE", ("FIRST", "LAST")) == "FIRST"
            else:
                scalar_first = is_needed
        if is_rated:
            choices = {"REF_FRAME_A": body_is_a, "REF_FRAME_B": not body_is_a}
            choices |= {meta["REF_FRAME_A"]: body_is_a, meta["REF_FRAME_B"]: not body_is_a}
            over_body = choices[meta.one_of("RATE_FRAME" if is_old else "ANGVEL_FRAME", choices)]
        if kind.startswith("EULER") or of_angles:
            sequence = _messages.sequence_of(meta)
        return _records.Convention(
            to_body=to_body,
            rates_over_body=over_body,
            rates_follow=not is_old,
            scalar_first=scalar_first,
            sequence=sequence,
            rates_of_angles=of_angles,
        )

    def _epoch(self, keyword, scale):
        """The Instant of a keyword, of which CIC has days and seconds too; None without it."""
        value = self.block.meta.get(keyword)
        if value is None:
            return None
        words = value.encode("ascii", "replace").split()
        if not self._is_cic or len(words) != 2:
            return _messages.epoch_of(self.block.meta, keyword, scale)
        with _messages.epochs_named(self.block.meta, keyword):
            hi, lo = ccsds_epochs.parsed_days(words[:1], words[1:], scale)
        return Instant(hi[0], lo[0])

    def _recommended(self):
        """Method and degree of interpolation, None if they are not stated."""
        meta = self.block.meta
        method, degree = (meta.get(f"INTERPOLATION_{k}") for k in ("METHOD", "DEGREE"))
        try:
            degree = None if degree is None else int(degree)
            if method is None and self._is_cic:
                method, degree = "slerp", 1  # as VTS interpolates
            _table.settled(method, degree, 2, True)
        except (ValueError, AttitudeError) as err:
            keyword = "INTERPOLATION_" + ("DEGREE" if isinstance(degree, str) else "METHOD")
            reason = str(err) if isinstance(err, AttitudeError) else "give a whole number."
            raise meta.fault(f"{keyword} is {cut(meta.get(keyword))}: {reason}", keyword) from err
        return method, degree

    def named(self, leaves):
        """Names of the numbers of a record in XML; those of version 1 are numbered."""
        names, angles, rates = [], {}, {}
        for tag, above, attributes in leaves:
            place = _ROTATIONS.get(tag)
            if place is None:
                names.append(tag)
            elif above == "rotationAngles":
                angles[place] = attributes.get("angle", "")[:1].upper()
                names.append(ANGLES[place])
            else:
                rates[place] = attributes.get("rate", "")[:1].upper()
                names.append(ANGVEL[place])
        by_axis = {}
        if any(angles.values()):
            sequence = _messages.sequence_of(self.block.meta)
            by_axis |= self._by_axis(ANGLES, angles, sequence, "angles")
        if rates:
            by_axis |= self._by_axis(ANGVEL, rates, self._axes_of_rates(rates), "rates")
        return [by_axis.get(name, name) for name in names]

    def _axes_of_rates(self, letters):
        """The axes of the columns of rates; an axis named twice means derivatives of angles."""
        letters = [letter for letter in letters.values() if letter]
        if len(letters) == 3 > len(set(letters)) and not self._convention.rates_of_angles:
            sequence = _messages.sequence_of(self.block.meta)
            self._convention = replace(self._convention, sequence=sequence, rates_of_angles=True)
        return self._convention.sequence.upper() if self._convention.rates_of_angles else "XYZ"

    def _by_axis(self, columns, letters, axes, what):
        """Columns by number -> those of the axes that letters, by place, name; all or none are."""
        named = "".join(letters.get(place, "") for place in range(3)) or axes
        places = _records.rates_by_axis(named, axes)
        if places is None:
            raise self.block.message.fault(
                f"the {what} are those of {', '.join(named)}, not of {axes}.", None
            )
        return {name: columns[places.index(k)] for k, name in enumerate(columns)}

    def has_guessed_rates(self):
        """Whether the file does not say what its rates of version 1 are, nor does the caller."""
        stated = self.block.meta["ATTITUDE_TYPE"].upper().endswith("/RATE")
        is_rated = self._is_old and self._kind.endswith("/ANGVEL") and stated
        return is_rated and self._options.rates is None and not self._convention.rates_of_angles

    def finished(self):
        """The AttitudeTable of the complete records."""
        meta, message, options = self.block.meta, self.block.message, self._options
        self.refuse_outside(*self._limits)
        method, degree = self._interpolation
        title = f"{'CIC ' * self._is_cic}AEM {message.version}"
        said = _messages.said_by(message, meta, title, "OBJECT_ID") | {
            "meta_comments": tuple(meta.comments),
            "data_comments": tuple(self.block.comments),
            "frame": self._axes.name,
            "body_frame": self._body,
            "time_system": meta["TIME_SYSTEM"].upper(),
            **({"assumed": tuple(message.assumed)} if options.lenient else {}),
        }
        with self.block.located():
            return self.table(
                self._kind,
                self._convention,
                self._axes,
                tolerance=options.tolerance,
                orbit=options.orbit,
                method=method,
                degree=degree,
                usable=self._usable,
                meta=said,
            )


# Elements of XML of version 1 -> their place.
_ROTATIONS = {"rotation1": 0, "rotation2": 1, "rotation3": 2}


def _scalar_first(columns):
    """Names of columns with QC before Q1, Q2, Q3, as under QUATERNION_TYPE = FIRST of version 1."""
    groups = [columns[k : k + 4] for k in range(0, len(columns), 4)]
    return [n for g in groups for n in ((*g[3:], *g[:3]) if g[3:4] and g[3][:2] == "QC" else g)]


# ---- The segments of a message that belong to one object, as one table

# Attitudes of two segments at one epoch contradict each other beyond this many times the tolerance
# of the length of quaternions: interpolation and few digits explain less.
_CONTRADICTING = 10.0
# Epochs at which two overlapping segments are compared.
_COMPARED = 1000


def _chosen(tables, path, options):
    """The segments of one object as one AttitudeTable."""
    name, segment = options.object, options.segment
    if segment is not None:
        whole = isinstance(segment, int) and not isinstance(segment, bool)
        if not whole or not 0 <= segment < len(tables):
            raise AttitudeError(
                f"{path}: segment is {segment!r}; the file has the segments 0 to "
                f"{len(tables) - 1}, give one."
            )
        tables = tables[segment : segment + 1]
    objects = ("object_id", "object_name")
    if name is not None:
        names = _values(tables, objects)
        tables = [t for t, known in zip(tables, names, strict=True) if name in known]
        if not tables:
            raise AttitudeError(
                f"{path}: object is {cut(name)}; the segments are those of {_listed(names)}."
            )
    for what, keys, advice in (
        ("objects", objects, "choose one with object= or segment="),
        ("body frames", ("body_frame",), "choose one segment with segment="),
    ):
        # The identifier decides; names may be written differently.
        values = _values(tables, keys)
        if len({comparable(value[0]) for value in values}) > 1:
            raise AttitudeError(
                f"{path}: its segments are those of several {what}: {_listed(values)}; {advice} "
                "(on the command line --object, --segment)."
            )
    with prefixed(path):
        refuse_contradictions(tables, options.tolerance)
    return AttitudeTable.joined(tables)


def _values(tables, keys):
    return [tuple(table.meta[key] for key in keys) for table in tables]


def _listed(names):
    different = list(dict.fromkeys(names))
    texts = [" ".join(dict.fromkeys(cut(word, "") for word in name)) for name in different]
    return ", ".join(texts[:6]) + (", ..." if len(texts) > 6 else "")


def refuse_contradictions(tables: Sequence[AttitudeTable], tolerance: float = TOLERANCE) -> None:
    """AttitudeError for two segments whose attitudes differ where both are usable."""
    most = _CONTRADICTING * tolerance
    # By first epochs, each segment is compared with the one before: enough to find an overlap.
    order = sorted(range(len(tables)), key=lambda k: tables[k].span[0].seconds)
    for first, second in pairwise(order):
        one, two = tables[first], tables[second]
        end = min(one.span[1], two.span[1], key=lambda instant: instant.seconds)
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
                f"the segments {first} and {second} overlap, and at "
                f"{two.epoch.after(float(t[k])).utc_iso} UTC their attitudes are {angle[k]:.3g} "
                "rad apart; choose one with segment= (on the command line --segment), of an ACM "
                "also from `tables`."
            )


# ---- A segment of an Attitude Ephemeris Message to be written: its keywords and its rows


def written_kind(settings: Mapping[str, Any], has_rates: bool) -> str:
    """The attitude type that settings of `aem.write` mean, under its name in version 2."""
    usual = "QUATERNION/DERIVATIVE" if settings["version"] == "1.0" else "QUATERNION/ANGVEL"
    kind = settings["kind"] or (usual if has_rates else "QUATERNION")
    return _records.known_type(kind, "2.0")


class WrittenSegment:
    """A segment to be written: its keywords, and its rows piece by piece.

    settings: arguments of `aem.write`, by name; `names` are object_name, object_id, center,
        body_frame; `epochs`, if given, the function that writes epochs, as `ccsds_epochs.texts`.
    """

    def __init__(self, records: Records, settings: Mapping[str, Any]):
        self._records, self._settings = records, settings
        version = settings["version"]
        self._kind = written_kind(settings, records.has_rates)
        if version == "1.0" and self._kind not in _records.IN_VERSION_1:
            raise AttitudeError(
                f"{self._kind} is no attitude type of AEM 1.0; write version 2.0, or one of "
                f"{', '.join(_records.IN_VERSION_1)}."
            )
        old = version == "1.0" and self._kind.endswith("/ANGVEL")
        if old and settings["rates"] is None:
            raise AttitudeError(
                f"{_records.IN_VERSION_1[self._kind]} of AEM 1.0 is read in two ways; give "
                'rates="body" (components of the angular velocity) or rates="euler" (derivatives '
                "of the angles; on the command line --rates), or kind QUATERNION/DERIVATIVE, which "
                "all readers understand."
            )
        self._axes = _axes.named(settings["frame"] or records.meta.get("frame") or "ICRF")
        self._scale = ccsds_epochs.writable(
            settings["time_system"] or records.meta.get("time_system") or "UTC"
        )
        validation.one_of(settings["rates_over"], "rates_over", ("body", "frame"))
        self._convention = _records.Convention(
            rates_over_body=settings["rates_over"] == "body",
            rates_follow=version != "1.0",
            scalar_first=settings["scalar_first"] and version == "1.0",
            sequence=settings["sequence"],
            rates_of_angles=old and settings["rates"] == "euler",
        )
        self.comments: Sequence[str] = records.meta.get("meta_comments", ())
        self.data_comments: Sequence[str] = records.meta.get("data_comments", ())
        self.keywords: dict[str, str] = self._keywords(version)
        refuse_line_breaks(*self.data_comments)

    @property
    def parts(self) -> messages.Segment:
        """Keywords, comments and the function that writes the data."""
        return self.keywords, self.comments, self.write

    def write(self, out: Generator) -> None:
        """Write comments and records."""
        out.comments(self.data_comments)
        columns = _records.COLUMNS[self._kind]
        order = list(range(len(columns)))
        if isinstance(out, XmlGenerator):
            in_file = _scalar_first(columns) if self._convention.scalar_first else list(columns)
            row, order = self._row_in_xml(out), [in_file.index(n) for n in columns]
        else:
            row = out.row("", len(columns))
        pieces, orbit = self._records.pieces(), self._settings["orbit"]
        for history, values in columns_of(pieces, self._kind, self._convention, self._axes, orbit):
            codes = self._texts(history.epoch, history.seconds, history.low)
            out.table(ccsds_epochs.distinct(codes), values[:, order], row)

    def _row_in_xml(self, out):
        """The text of a record, with %s for its epoch and %r for each number."""
        first, *lines, last = out.text_of(self._write_element).splitlines(keepends=True)
        # All lines inside of a record have the same indentation.
        inner = lines[0][: -len(lines[0].lstrip())]
        return "".join([first, *(inner + line.lstrip() for line in lines), last])

    def _write_element(self, out):
        version, kind, groups = self._settings["version"], self._kind, GROUPS
        keys = list(_records.COLUMNS[kind])
        if version == "1.0":
            sequence = self._settings["sequence"]
            rates = sequence if self._convention.rates_of_angles else "XYZ"
            names = {f"ANGLE_{k + 1}": f"{axis}_ANGLE" for k, axis in enumerate(sequence)}
            names |= {ANGVEL[k]: f"{axis}_RATE" for k, axis in enumerate(rates)}
            keys = [names.get(key, key) for key in keys]
        else:
            groups = GROUPS | dict.fromkeys(Q_DOT, "quaternionDot")
            if kind.startswith("QUATERNION"):
                groups |= dict.fromkeys(ANGVEL, "angVel")
        with out.part("attitudeState"), out.part(_ELEMENTS[version][kind]):
            out.entry("EPOCH", "%s")
            out.grouped([(key, "%r") for key in keys], groups)

    def _texts(self, epoch, seconds, low):
        written = self._settings.get("epochs", ccsds_epochs.texts)
        return written(epoch, seconds, low, self._scale, self._settings["digits"])

    def _keywords(self, version):
        records, convention, kind = self._records, self._convention, self._kind
        is_old = version == "1.0"
        *names, body = self._settings["names"]
        body = written_body(body, records.meta)
        frame = _axes.WRITTEN.get(self._axes.kind) if self._axes.name.islower() else self._axes.name
        start, stop = self._texts(records.epoch, *records.first_and_last())
        known = {
            **written_names(records.meta, *names),
            "CENTER_NAME": names[-1] or records.meta.get("center"),  # written even if it is empty
            "REF_FRAME_A": frame,
            "REF_FRAME_B": body,
            "ATTITUDE_DIR": "A2B",
            "TIME_SYSTEM": self._scale.upper(),
            "START_TIME": start,
            "STOP_TIME": stop,
            "ATTITUDE_TYPE": _records.IN_VERSION_1[kind] if is_old else kind,
        }
        if kind.startswith("QUATERNION"):
            known["QUATERNION_TYPE"] = "FIRST" if convention.scalar_first else "LAST"
        is_rated = kind.endswith("/ANGVEL")
        if kind.startswith("EULER") or (is_old and is_rated):
            digits = str.maketrans("XYZ", "123") if is_old else {}
            known["EULER_ROT_SEQ"] = convention.sequence.translate(digits)
        if is_rated and is_old:
            known["RATE_FRAME"] = "REF_FRAME_B" if convention.rates_over_body else "REF_FRAME_A"
        elif is_rated:
            known["ANGVEL_FRAME"] = body if convention.rates_over_body else frame
        known |= self._interpolation() | self._usable()
        return {key: known[key] for key in FORM.meta_of(version) if known.get(key) is not None}

    def _interpolation(self):
        """Recommended interpolation: that of a table, of a degree for which there are records."""
        settings, count, table = self._settings, len(self._records), self._records.table
        method, degree = settings["method"], settings["degree"]
        if method is None and table is not None:
            method, degree = table.method, degree or table.degree
        has_rates = _records.has_rates(self._kind)
        method, degree = _table.settled(method, degree, count, has_rates)
        degree = _recipes.degree_of(settings["for_"], degree, count)
        method = "LINEAR" if method == "slerp" else method.upper()
        return {"INTERPOLATION_METHOD": method, "INTERPOLATION_DEGREE": str(degree)}

    def _usable(self):
        limits = self._records.usable
        if limits is None:
            return {}
        names = ("USEABLE_START_TIME", "USEABLE_STOP_TIME")
        texts = self._texts(self._records.epoch, *np.array(limits).T)
        return dict(zip(names, texts, strict=True))
