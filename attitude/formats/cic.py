"""Attitude files of CIC, the dialect of CNES in which VTS and many simulators write AEMs.

A file begins with ``CIC_AEM_VERS = 1.0`` or 2.0 and has the keywords of AEM 1.0.  It differs from
an AEM: the epoch of a record is two columns, the modified Julian date and the seconds of the day,
in the scale of TIME_SYSTEM; records follow META_STOP without DATA_START and DATA_STOP; START_TIME
and STOP_TIME may be missing; the scalar of a quaternion stands first unless QUATERNION_TYPE is
LAST; and VTS interpolates on the great circle between two records.  The direction is that of AEM:
under A2B the numbers of a quaternion are those of the rotation that takes the axes of A to those of
B, as Orekit and PATRIUS print them, and as `AttitudeHistory.wxyz` from B to A.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.cic")
...     write(path, motion, t=[0.0, 10.0, 20.0])
...     table = read(path)
>>> table.wxyz.shape, table.method, table.epoch.utc_iso
((3, 4), 'slerp', '2026-01-01T00:00:00')
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from attitude._textfiles import messages
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.formats import _aem_message, _sampling
from attitude.formats._aem_message import Options, WrittenSegment
from attitude.formats._format import Format, message_labels, refuse_foreign, register, table_reader
from attitude.formats._messages import written_header
from attitude.formats._records import TOLERANCE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude._support.annotations import EpochOrSeconds, Epochs, FilePath
    from attitude.formats._sampling import AttitudeSource, SampledFile
    from attitude.motions._table import AttitudeTable
    from attitude.paths._path import Path


__all__ = ["read", "write"]

_FORM = replace(
    _aem_message.FORM,
    family="CIC",
    meta=_aem_message.FORM.meta_of("1.0"),
    only={},
    needed=tuple(word for word in _aem_message.FORM.needed if not word.endswith("_TIME")),
    marks={"metadata": "META", "data": ""},
    spaced=True,
)
# Keywords of an AEM that written files leave out, as those of VTS and its tools do.
_LEFT_OUT = (
    "START_TIME",
    "STOP_TIME",
    "USEABLE_START_TIME",
    "USEABLE_STOP_TIME",
    "INTERPOLATION_METHOD",
    "INTERPOLATION_DEGREE",
)


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    rates: str | None = None,
    object: str | None = None,
    segment: int | None = None,
    lenient: bool = False,
) -> AttitudeTable:
    """A CIC attitude file as an AttitudeTable relative to ICRF.

    Parameters
    ----------
    path, tolerance, frame, orbit, rates, object, segment
        As in `aem.read`.
    lenient : bool
        Leave out keywords that are not known, and assume those that are missing.

    Raises
    ------
    AttitudeError
        As `aem.read`.
    """
    options = Options(tolerance, frame, orbit, rates, object, segment, lenient)
    return _aem_message.read(path, _FORM, options)


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    start: EpochOrSeconds | None = None,
    stop: EpochOrSeconds | None = None,
    tolerance: float | None = None,
    frame: str = "EME2000",
    time_system: str = "UTC",
    object_name: str | None = None,
    object_id: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    creation_date: str | None = None,
    digits: int = ccsds_epochs.DIGITS,
    orbit: Path | None = None,
) -> SampledFile | None:
    """Write attitudes as a CIC file: quaternions from `frame` to the body, scalar first.

    Parameters
    ----------
    path, source, t, start, stop, tolerance
        As in `aem.write`; one segment.
    frame : str
        The external axes: VTS knows EME2000, which is the default, not that of a table read.
    time_system, object_name, object_id, body_frame, originator, comments, creation_date, digits
        As in `aem.write`.
    orbit : Path, optional
        Path of the body about its center, for axes of an orbit.

    Returns
    -------
    SampledFile or None
        As `aem.write`.

    Raises
    ------
    AttitudeError
        For several segments, and as `aem.write`.
    """
    refuse_foreign(path, "cic")
    meta, _ = _sampling.known_of(source, t)
    settings: dict[str, Any] = {
        **{"version": "1.0", "kind": "QUATERNION", "scalar_first": True, "rates": None},
        **{"rates_over": "body", "sequence": "ZYX", "method": "slerp", "degree": 1, "for_": None},
        "frame": frame or "EME2000",
        "time_system": time_system or "UTC",
        "digits": digits,
        "orbit": orbit,
        "names": (object_name, object_id, None, body_frame),
        "epochs": ccsds_epochs.days_and_seconds,
    }
    header = written_header(meta, creation_date, originator, comments)

    def write_records(target: FilePath, segments: Sequence[Any]) -> None:
        segment = WrittenSegment(segments[0], settings)
        segment.data_comments = ()
        keywords = {key: text for key, text in segment.keywords.items() if key not in _LEFT_OUT}
        written = [(keywords, segment.comments, segment.write)]
        messages.write(target, _FORM, "1.0", header, written)

    writing = _sampling.Writing(
        ("slerp", 1),
        write_records,
        lambda target: read(target, orbit=orbit),
        name="a CIC file",
        holder="a CIC file",
    )
    return _sampling.write(path, source, t, (start, stop), tolerance, writing)


def _labels(motion, said):
    """Names and comments; a CIC file has no center."""
    return {key: text for key, text in message_labels(motion, said).items() if key != "center"}


register(
    Format(
        name="cic",
        module=__name__,
        title="CIC of CNES, for VTS",
        endings=(".cic",),
        marks=(b"CIC_AEM_VERS",),
        read=table_reader(read),
        reading=("tolerance", "frame", "orbit", "rates", "object", "segment", "lenient"),
        write=write,
        writing=("frame", "time_system", "orbit"),
        noun="a CIC file",
        labels=_labels,
    )
)
