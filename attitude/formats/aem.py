"""CCSDS Attitude Ephemeris Messages, versions 1.0 and 2.0, KVN and XML, read and written.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.aem")
...     write(path, motion.at([0.0, 10.0, 20.0]), object_name="SATELLITE")
...     table = read(path)
>>> table.wxyz.shape, table.method, table.degree, table.epoch.utc_iso
((3, 4), 'hermite', 5, '2026-01-01T00:00:00')

Conventions: see `attitude_types`.  What is lost: nothing of the quaternions (written with 17
digits), half a picosecond of the epochs; the motion itself, of which this is a table.
"""

import datetime

import numpy as np

from attitude import quaternion
from attitude.errors import AttitudeError
from attitude.formats import attitude_types, axes, ccsds_epochs, kvn
from attitude.formats import records as sources
from attitude.formats.aem_message import HEADER, META, VERSIONS, Message, Options, Segment
from attitude.formats.aside import written_whole
from attitude.formats.lines import NoNumber, numbers, opened
from attitude.formats.segment import TOLERANCE, columns_of

_BATCH = 16384


def read(path, *, tolerance=TOLERANCE, frame=None, orbit=None):
    """A message as an AttitudeTable.

    Parameters
    ----------
    path : str or path
        KVN or XML, version 1.0 or 2.0; which of them, the file tells.
    tolerance : float
        How far from 1 the length of a quaternion may be; they are made unit.
    frame : str, optional
        Which axes the external frame of the file is, where its name is not known (see `axes`).
    orbit : path, optional
        The path of the body about its center, for attitudes relative to LVLH or RTN.

    Returns
    -------
    AttitudeTable
        Relative to ICRF; `meta` of it and of each of its segments holds keywords and comments.

    Raises
    ------
    AttitudeError
        With file, line and keyword, for anything that is wrong.
    """
    options = Options(tolerance, frame, orbit)
    with opened(path) as lines:
        for line in lines:
            text = line.lstrip(b"\xef\xbb\xbf \t")
            if text.startswith((b"<", b"\xff\xfe", b"\xfe\xff")):
                break
            if text:
                return _read_kvn(lines, line, options)
        else:
            raise lines.fault("the file is empty.")
    from attitude.formats import aem_xml

    return aem_xml.read(path, options)


def _read_kvn(lines, first, options):
    keyword, value = kvn.pair(lines, first)
    if keyword != "CCSDS_AEM_VERS" or value not in VERSIONS:
        raise lines.fault(
            f"it begins with {kvn.shown(lines.text(first))}; an AEM begins with CCSDS_AEM_VERS = "
            f"{' or '.join(VERSIONS)}."
        )
    message = Message(lines.path, value, options)
    _read_header(lines, message)
    while True:
        segment = Segment(message, lines.fault)
        _read_meta(lines, segment)
        _read_data(lines, segment)
        if not _another_segment(lines):
            return message.table()


def _read_header(lines, message):
    for line in lines:
        if not line.strip():
            continue
        if line.strip() == b"META_START":
            return
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            message.comments.append(value)
        elif keyword in HEADER and keyword not in message.header:
            message.header[keyword] = value
        else:
            raise lines.fault(
                f"{keyword} does not belong into the header, or not twice; known are "
                f"{', '.join(HEADER)}, COMMENT, and then META_START."
            )
    raise lines.fault("the file ends before META_START; is it cut off?")


def _read_meta(lines, segment):
    for line in lines:
        if not line.strip():
            continue
        if line.strip() == b"META_STOP":
            segment.begin(lines.number)
            return
        keyword, value = kvn.pair(lines, line)
        if keyword == "COMMENT":
            segment.comments.append(value)
        else:
            segment.add(keyword, value, lines.number)
    raise lines.fault("the file ends before META_STOP; is it cut off?")


def _read_data(lines, segment):
    for line in lines:
        if line.strip() == b"DATA_START":
            break
        if line.strip():
            raise lines.fault(f"{kvn.shown(lines.text(line))} stands where DATA_START must be.")
    batch, width = _Batch(segment), segment.rows.width
    for line in lines:
        tokens = line.split()
        if len(tokens) == width + 1:
            if tokens[0] == b"COMMENT":
                segment.data_comments.append(kvn.comment_of(lines.text(line)))
                continue
            batch.tokens.extend(tokens)
            batch.numbers.append(lines.number)
            if len(batch.numbers) == _BATCH:
                batch.take()
                batch = _Batch(segment)
        elif tokens == [b"DATA_STOP"]:
            batch.take()
            segment.finish(lines.number)
            return
        elif tokens:
            comment = kvn.comment_of(lines.text(line))
            if comment is None:
                raise lines.fault(
                    f"it has {len(tokens)} entries; {segment.values['ATTITUDE_TYPE']} has an epoch "
                    f"and {width} numbers: {', '.join(attitude_types.COLUMNS[segment.kind])}."
                )
            segment.data_comments.append(comment)
    raise lines.fault("the file ends before DATA_STOP; is it cut off?")


class _Batch:
    """Some records as they stand in the file; numbers are made of all of them at once."""

    def __init__(self, segment):
        self._segment = segment
        self.tokens, self.numbers = [], []

    def take(self):
        segment, names = self._segment, attitude_types.COLUMNS[self._segment.kind]
        step = len(names) + 1
        if not self.numbers:
            return
        try:
            values = numbers(self.tokens, step, range(1, step))
        except NoNumber as err:
            raise segment.fault(
                f"{names[err.column]} is {err.shown}, which is no number.", self.numbers[err.line]
            ) from err
        segment.rows.add(self.tokens[::step], values, self.numbers, segment.fault)


def _another_segment(lines):
    for line in lines:
        if line.strip() == b"META_START":
            return True
        if line.strip() and kvn.comment_of(lines.text(line)) is None:
            raise lines.fault(
                f"{kvn.shown(lines.text(line))} stands where META_START or the end must be."
            )
    return False


# Writing ------------------------------------------------------------------------------------------


def write(
    path,
    source,
    *,
    t=None,
    version="2.0",
    xml=False,
    kind=None,
    frame=None,
    time_system=None,
    rates_over="body",
    sequence="ZXZ",
    scalar_first=False,
    object_name=None,
    object_id=None,
    center=None,
    body_frame=None,
    originator="ATTITUDE",
    comments=None,
    method=None,
    degree=None,
    creation_date=None,
    digits=ccsds_epochs.DIGITS,
    orbit=None,
):
    """Write attitudes as an AEM.

    Parameters
    ----------
    path : str or path
        Appears when it is complete, and not at all if something goes wrong.
    source : AttitudeHistory, AttitudeTable, a list of them (segments), or a motion with `t`
        A motion is evaluated piece by piece, so that long histories need no memory.
    version : str
        "2.0", or "1.0" (what GMAT and others read).
    xml : bool
        XML instead of KVN.
    kind : str, optional
        The attitude type, by its name in version 2: "QUATERNION/ANGVEL" by default, "QUATERNION"
        for tables without angular velocities.
    frame : str
        The external axes, "ICRF" by default or what a table came in; see `axes`.
    time_system : str
        "UTC" by default, or TAI, TT, TDB, GPS.
    rates_over : str
        "body" or "frame": the axes of angular velocities.
    sequence : str
        Of Euler angles.
    scalar_first : bool
        Version 1.0: QC before Q1, Q2, Q3.
    method, degree : str, int
        What is recommended for interpolation; by default Hermite or Lagrange of degree 7.
    creation_date : str, optional
        Now, in UTC, by default.
    digits : int
        Decimals of the seconds.
    orbit : path, optional
        For LVLH and RTN.
    """
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; AEM has {' and '.join(VERSIONS)}.")
    parts = sources.segments(source, t)
    given = parts[0].meta
    settings = {
        "version": version,
        "kind": kind,
        "frame": frame,
        "time_system": time_system,
        "rates_over": rates_over,
        "sequence": quaternion.known_sequence(sequence).upper(),
        "scalar_first": scalar_first,
        "digits": digits,
        "orbit": orbit,
        "method": method,
        "degree": degree,
        "names": (object_name, object_id, center, body_frame),
    }
    written = [Written(part, settings) for part in parts]
    header = {
        "CREATION_DATE": creation_date
        or datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%S"),
        "ORIGINATOR": originator,
    }
    comments = list(given.get("comments", ()) if comments is None else comments)
    for text in (*header.values(), *comments):
        refuse_line_breaks(text)
    if xml:
        from attitude.formats import aem_xml as notation
    else:
        from attitude.formats import aem as notation
    with written_whole(path, "the AEM") as file:
        notation.write_message(file, version, header, comments, written)


class Written:
    """A segment to be written: its keywords, and its rows piece by piece."""

    def __init__(self, part, settings):
        self._part, self._settings = part, settings
        version = settings["version"]
        self.kind = settings["kind"] or ("QUATERNION/ANGVEL" if part.has_rates else "QUATERNION")
        self.kind = attitude_types.known(self.kind, "2.0")
        if version == "1.0" and self.kind not in attitude_types.IN_VERSION_1:
            raise AttitudeError(
                f"{self.kind} is no attitude type of AEM 1.0; write version 2.0, or one of "
                f"{', '.join(attitude_types.IN_VERSION_1)}."
            )
        name = settings["frame"] or part.meta.get("frame") or "ICRF"
        self._axes = axes.named(name)
        self._scale = _writable(settings["time_system"] or part.meta.get("time_system") or "UTC")
        if settings["rates_over"] not in ("body", "frame"):
            raise AttitudeError(f"rates_over is {settings['rates_over']!r}; give body or frame.")
        self._how = attitude_types.Convention(
            rates_over_body=settings["rates_over"] == "body",
            rates_follow=version != "1.0",
            scalar_first=settings["scalar_first"] and version == "1.0",
            sequence=settings["sequence"],
        )
        self.scalar_first, self.sequence = self._how.scalar_first, self._how.sequence
        self.comments = part.meta.get("meta_comments", ())
        self.data_comments = part.meta.get("data_comments", ())
        self.keywords = self._keywords(version)
        for text in (*self.keywords.values(), *self.comments, *self.data_comments):
            refuse_line_breaks(text)

    def rows(self):
        """Pieces: a list of epochs as text, and an array of columns."""
        settings = self._settings
        for history in self._part.pieces():
            epochs = self._texts(history.epoch, history.seconds, history.low)
            columns = columns_of(history, self.kind, self._how, self._axes, settings["orbit"])
            yield epochs, columns

    def _texts(self, epoch, seconds, low):
        return ccsds_epochs.texts(epoch, seconds, low, self._scale, self._settings["digits"])

    def _keywords(self, version):
        part, settings, meta = self._part, self._settings, self._part.meta
        given = zip(
            settings["names"], ("object_name", "object_id", "center", "body_frame"), strict=True
        )
        name, number, center, body = (value or meta.get(key) for value, key in given)
        body = body or "SC_BODY_1"
        if axes.known(body) is not None:
            raise AttitudeError(f"body_frame is {body!r}, the name of other axes; give another.")
        frame = axes.WRITTEN.get(self._axes.kind) if self._axes.name.islower() else self._axes.name
        start, stop = self._texts(part.epoch, *part.first_and_last())
        method, degree = settings["method"], settings["degree"]
        if method is None and part.table is not None:
            method, degree = part.table.method, degree or part.table.degree
        method = method or ("hermite" if attitude_types.has_rates(self.kind) else "lagrange")
        rate_frame = "REF_FRAME_B" if version == "1.0" else body
        if not self._how.rates_over_body:
            rate_frame = "REF_FRAME_A" if version == "1.0" else frame
        digits = str.maketrans("XYZ", "123")
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
            "ATTITUDE_TYPE": attitude_types.IN_VERSION_1[self.kind]
            if version == "1.0"
            else self.kind,
            "QUATERNION_TYPE": ("FIRST" if self._how.scalar_first else "LAST")
            if self.kind.startswith("QUATERNION")
            else None,
            "EULER_ROT_SEQ": (
                self._how.sequence.translate(digits) if version == "1.0" else self._how.sequence
            )
            if self.kind.startswith("EULER")
            else None,
            "RATE_FRAME": rate_frame if self.kind.endswith("/ANGVEL") else None,
            "ANGVEL_FRAME": rate_frame if self.kind.endswith("/ANGVEL") else None,
            "INTERPOLATION_METHOD": method.upper(),
            "INTERPOLATION_DEGREE": str(degree or 7),
        }
        if part.table is not None:
            known.update(self._usable(part.table))
        return {key: known[key] for key in META[version] if known[key] is not None}

    def _usable(self, table):
        limits, ends = table._limits, self._part.first_and_last()
        if all((limits[k][0], limits[k][1]) == (ends[0][k], ends[1][k]) for k in (0, 1)):
            return {}
        hi, lo = np.array(limits).T
        names = ("USEABLE_START_TIME", "USEABLE_STOP_TIME")
        return dict(zip(names, self._texts(table.epoch, hi, lo), strict=True))


def write_message(file, version, header, comments, segments):
    """A message in KVN, to an open file."""
    file.write(f"CCSDS_AEM_VERS = {version}\n")
    file.writelines(f"COMMENT {text}\n" for text in comments)
    file.writelines(f"{key} = {value}\n" for key, value in header.items())
    for segment in segments:
        file.write("\nMETA_START\n")
        file.writelines(f"COMMENT {text}\n" for text in segment.comments)
        file.writelines(f"{key} = {value}\n" for key, value in segment.keywords.items())
        file.write("META_STOP\n\nDATA_START\n")
        file.writelines(f"COMMENT {text}\n" for text in segment.data_comments)
        for epochs, columns in segment.rows():
            row = "%s" + " %r" * columns.shape[1] + "\n"
            lists = [epochs, *columns.T.tolist()]
            file.write("".join([row % each for each in zip(*lists, strict=True)]))
        file.write("DATA_STOP\n")


def refuse_line_breaks(text):
    """Names and comments stand in one line each."""
    if not isinstance(text, str) or not text.isprintable() or len(text) > 4000:
        raise AttitudeError(
            f"{str(text)[:60]!r} cannot be a name or a comment in a message; give one line of text."
        )


def _writable(time_system):
    scale = ccsds_epochs.known(time_system)
    if scale.upper() not in ccsds_epochs.WRITTEN:
        raise AttitudeError(
            f"epochs are not written in {time_system}; give one of "
            f"{', '.join(ccsds_epochs.WRITTEN)}."
        )
    return scale
