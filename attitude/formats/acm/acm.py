"""CCSDS Attitude Comprehensive Messages (504.0-B-2, section 5), KVN and XML, read and written.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.01, 0, 0.1),
...             covariance={"attitude": 0.01, "angular_velocity": 1e-4})
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.acm")
...     write(path, motion, t=[0.0, 10.0, 20.0], object_name="SATELLITE")
...     message = read(path)
>>> message.table.wxyz.shape, message.covariances[0].kind, message.body.moments.round(9)
((3, 4), 'ANGLE_ANGVEL', array([1., 2., 3.]))
>>> message.motion.at(10.0).wxyz.round(6) == motion.at(10.0).wxyz.round(6)
array([ True,  True,  True,  True])

The message holds variances, no correlations: those about the body axes are written.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import pairs
from attitude.axes import axes
from attitude.errors import AttitudeError
from attitude.formats import sources
from attitude.formats.acm import written
from attitude.formats.acm.attitudes import TimeTags
from attitude.formats.acm.blocks import read_kvn, read_xml
from attitude.formats.acm.interpreted import interpreted
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.rows import TOLERANCE, known_tolerance
from attitude.textfiles import kvn
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import opened

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import Epochs, FilePath
    from attitude.formats.acm.message import Comprehensive
    from attitude.formats.sources import AttitudeSource
    from attitude.paths.path import Path


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    products: str | None = None,
) -> Comprehensive:
    """A message as `Comprehensive`.

    Parameters
    ----------
    path : str or path
        KVN or XML, recognized by the content.
    tolerance, frame, orbit
        As of `aem.read`.
    products : str, optional
        As of `apm.read`; by default the entry of the inertia tensor is -IXY.

    Raises
    ------
    AttitudeError
        As `aem.read`.
    """
    known_tolerance(tolerance)
    with opened(path) as lines:
        first = kvn.first(lines)
        message = None if first is None else read_kvn(lines, first)
    if message is None:
        message = read_xml(path)
    return interpreted(message, tolerance, frame, orbit, products)


def write(
    path: FilePath,
    source: AttitudeSource,
    *,
    t: Epochs | None = None,
    xml: bool = False,
    covariance: bool | None = None,
    frame: str | None = None,
    time_system: str | None = None,
    products: str | None = None,
    object_name: str | None = None,
    object_id: str | None = None,
    center: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    creation_date: str | None = None,
    digits: int = ccsds_epochs.DIGITS,
    orbit: Path | None = None,
) -> None:
    """Write attitudes as an ACM, with the body, the impulses and the errors of their motion.

    Each segment becomes a block ATT (quaternions and angular velocities, at seconds since the first
    epoch); the inertia in kg m2 a block PHYS; each impulse of `Arcs` a block MAN without duration,
    with the angular momentum after it; standard deviations a block COV for each segment.

    Parameters
    ----------
    path, source, t, frame, time_system, object_name, object_id, center
        As of `aem.write`.
    body_frame, originator, comments, creation_date, digits, orbit
        As of `aem.write`.
    xml : bool
        XML instead of KVN.
    covariance : bool, optional
        Write variances; by default if the spin of the motion has a covariance (that of a
        `Fit.motion` has).
    products : str, optional
        As of `read`.

    Raises
    ------
    AttitudeError
        As `aem.write`, and for variances of a motion without a covariance.
    """
    parts = sources.segments(source, t)
    motion, meta = parts[0].motion, parts[0].meta
    found = axes.named(frame or meta.get("frame") or "ICRF")
    name = axes.WRITTEN[found.kind] if found.name.islower() else found.name
    body = body_frame or meta.get("body_frame") or "SC_BODY_1"
    if (why := axes.body_name_fault(body)) is not None:
        raise AttitudeError(f"body_frame is {body!r}, which {why}; give another name.")
    scale = ccsds_epochs.writable(time_system or meta.get("time_system") or "UTC")

    begin = parts[0].first_and_last()
    end = parts[-1].first_and_last()
    start, _ = ccsds_epochs.texts(parts[0].epoch, *begin, scale, digits)
    _, stop = ccsds_epochs.texts(parts[-1].epoch, *end, scale, digits)
    tags = TimeTags(scale, ccsds_epochs.instant(start, scale))

    def texts(history: Any) -> list[str]:
        low = 0.0 if history.low is None else history.low
        epoch = history.epoch
        return tags.text(*pairs.add((history.seconds, low), epoch.seconds, epoch.low), digits)

    blocks = [written.attitudes(part, name, found, body, texts, orbit) for part in parts]
    if motion.body is not None and not motion.body.relative:
        blocks.append(written.physics(motion.body, body, products))
    if covariance is None:
        covariance = _has_covariance(parts[0])
    if covariance:
        blocks += [written.covariances(part, body, texts) for part in parts]
    if motion.body is not None and not motion.body.relative:
        blocks += written.maneuvers(
            motion,
            lambda hi, lo: _text_of(tags, motion.epoch.after(hi, lo), digits),
            float(begin[0][0]),
            float(end[0][1]),
            (name, found),
        )
    header = {"CREATION_DATE": creation_date or ccsds_epochs.now(), "ORIGINATOR": originator}
    keywords = {
        "OBJECT_NAME": object_name or meta.get("object_name") or "UNKNOWN",
        "INTERNATIONAL_DESIGNATOR": object_id or meta.get("object_id") or "UNKNOWN",
        **({"CENTER_NAME": center or meta["center"]} if center or meta.get("center") else {}),
        "TIME_SYSTEM": scale.upper(),
        "EPOCH_TZERO": start,
        "ACM_DATA_ELEMENTS": ", ".join(block.name for block in blocks),
        "START_TIME": start,
        "STOP_TIME": stop,
    }
    lines = list(meta.get("comments", ()) if comments is None else comments)
    more = [text for block in blocks for text in block.comments]
    for text in (*header.values(), *keywords.values(), *lines, *more, body):
        kvn.refuse_line_breaks(text)
    with written_whole(path, "the ACM") as file:
        (written.write_xml if xml else written.write_kvn)(file, header, lines, keywords, blocks)


def _has_covariance(part):
    """Whether the motion of a segment knows its errors."""
    try:
        part.motion.covariance_at(part.seconds[:1])
    except AttitudeError:
        return False
    return True


def _text_of(tags, instant, digits):
    """Seconds from EPOCH_TZERO to an Instant, as text."""
    return tags.text(np.array([instant.seconds]), np.array([instant.low]), digits)[0]
