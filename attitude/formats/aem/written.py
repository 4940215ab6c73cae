"""A segment of an Attitude Ephemeris Message to be written: its keywords and its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.attitude_table import interpolation
from attitude.axes import axes
from attitude.errors import AttitudeError
from attitude.formats import recipes
from attitude.formats.aem.message import META
from attitude.formats.ccsds import attitude_types
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.rows import columns_of
from attitude.textfiles import kvn

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from attitude.annotations import FloatArray
    from attitude.formats.sources import Records


def written_kind(settings: Mapping[str, Any], has_rates: bool) -> str:
    """The attitude type that settings of `aem.write` mean, under its name in version 2."""
    usual = "QUATERNION/DERIVATIVE" if settings["version"] == "1.0" else "QUATERNION/ANGVEL"
    kind = settings["kind"] or (usual if has_rates else "QUATERNION")
    return attitude_types.known(kind, "2.0")


class WrittenSegment:
    """A segment to be written: its keywords, and its rows piece by piece.

    Parameters
    ----------
    part : Records
    settings : mapping
        Arguments of `aem.write`, by name; `names` are object_name, object_id, center, body_frame;
        `epochs`, if given, the function that writes epochs, as `ccsds.epochs.texts`.

    Attributes
    ----------
    kind : str
        Attitude type, under its name in version 2.
    scalar_first, sequence, rates_of_angles : bool, str, bool
        As of `Convention`.
    keywords : dict of str
        Keyword of the meta data -> value, in their order.
    comments, data_comments : sequence of str
        Comments of the meta data and of the data.

    Raises
    ------
    AttitudeError
        For names of types, axes or time systems that are not known or not in this version.
    """

    def __init__(self, part: Records, settings: Mapping[str, Any]):
        self._part, self._settings = part, settings
        version = settings["version"]
        self.kind: str = written_kind(settings, part.has_rates)
        if version == "1.0" and self.kind not in attitude_types.IN_VERSION_1:
            raise AttitudeError(
                f"{self.kind} is no attitude type of AEM 1.0; write version 2.0, or one of "
                f"{', '.join(attitude_types.IN_VERSION_1)}."
            )
        old = version == "1.0" and self.kind.endswith("/ANGVEL")
        if old and settings["rates"] is None:
            raise AttitudeError(
                f"{attitude_types.IN_VERSION_1[self.kind]} of AEM 1.0 is read in two ways; give "
                'rates="body" (components of the angular velocity) or rates="euler" (derivatives '
                "of the angles), or kind QUATERNION/DERIVATIVE, which all readers understand."
            )
        name = settings["frame"] or part.meta.get("frame") or "ICRF"
        self._axes = axes.named(name)
        self._scale = ccsds_epochs.writable(
            settings["time_system"] or part.meta.get("time_system") or "UTC"
        )
        if settings["rates_over"] not in ("body", "frame"):
            raise AttitudeError(f"rates_over is {settings['rates_over']!r}; give body or frame.")
        self._how = attitude_types.Convention(
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
        for text in (*self.keywords.values(), *self.comments, *self.data_comments):
            kvn.refuse_line_breaks(text)

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
        body = body or "SC_BODY_1"
        if (why := axes.body_name_fault(body)) is not None:
            raise AttitudeError(f"body_frame is {body!r}, which {why}; give another name.")
        frame = axes.WRITTEN.get(self._axes.kind) if self._axes.name.islower() else self._axes.name
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
            "ATTITUDE_TYPE": attitude_types.IN_VERSION_1[self.kind]
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
        has_rates = attitude_types.has_rates(self.kind)
        count = len(self._part)
        method, degree = interpolation.settled(method, degree, count, has_rates)
        degree = recipes.degree_of(self._settings["for_"], degree, count)
        return "LINEAR" if method == "slerp" else method.upper(), degree

    def _usable(self, table):
        ends = list(zip(*self._part.first_and_last(), strict=True))
        limits = max(table._limits[0], ends[0]), min(table._limits[1], ends[1])
        if limits == tuple(ends):
            return {}
        hi, lo = np.array(limits).T
        names = ("USEABLE_START_TIME", "USEABLE_STOP_TIME")
        return dict(zip(names, self._texts(table.epoch, hi, lo), strict=True))
