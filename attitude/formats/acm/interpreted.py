"""The meaning of the blocks of an Attitude Comprehensive Message."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import representations as forms
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.formats.acm import attitudes
from attitude.formats.acm.keywords import NEEDED, UNITS
from attitude.formats.acm.maneuvers import Maneuver
from attitude.formats.acm.message import Comprehensive
from attitude.formats.apm.inertia import known_products, tensor
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.textfiles import kvn
from attitude.textfiles.lines import cut, is_number

if TYPE_CHECKING:
    from attitude.epochs import Instant
    from attitude.formats.acm.blocks import AcmBlock, CollectedAcm
    from attitude.paths.path import Path

_INERTIA = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
_DATES = ("START_TIME", "STOP_TIME", "NEXT_LEAP_EPOCH")


def interpreted(
    message: CollectedAcm,
    tolerance: float,
    frame: str | None,
    orbit: Path | None,
    products: str | None,
) -> Comprehensive:
    """The content of a message; see `acm.read` for the parameters.

    Raises
    ------
    AttitudeError
        For missing keywords, and values that are not known.
    """
    products = known_products(products, "2.0")
    tags = _tags(message)
    blocks = message.blocks
    meta: dict[str, Any] = {
        "format": "ACM 2.0",
        "header": dict(message.header),
        "comments": tuple(message.comments),
        "keywords": dict(message.meta),
        "meta_comments": tuple(message.meta_comments),
        "object_name": message.meta["OBJECT_NAME"],
        "object_id": message.meta.get("INTERNATIONAL_DESIGNATOR"),
        "center": message.meta.get("CENTER_NAME"),
        "inertia_frame": None,
        "blocks": tuple(
            (b.name, dict(b.values), tuple(b.comments), tuple(dict(s.values) for s in b.inner))
            for b in blocks
        ),
    }
    body = None
    for block in blocks:
        if block.name == "PHYS":
            body = _body(message, block, products)
            meta["inertia_frame"] = block.values.get("INERTIA_REF_FRAME")
            _check_physics(message, block)
        elif block.name == "AD":
            _check_sensors(message, block)
    return Comprehensive(
        tags.zero,
        tuple(
            attitudes.table(message, block, tags, tolerance, frame, orbit)
            for block in blocks
            if block.name == "ATT"
        ),
        tuple(attitudes.covariance(message, b, tags) for b in blocks if b.name == "COV"),
        body,
        tuple(_maneuver(message, b, tags) for b in blocks if b.name == "MAN"),
        meta,
    )


def _tags(message):
    for keyword in NEEDED:
        if not message.meta.get(keyword):
            raise message.fault(f"the meta data lack {keyword}.", None)
    try:
        scale = ccsds_epochs.known(message.meta["TIME_SYSTEM"])
    except AttitudeError as err:
        raise message.fault(str(err), message.lines["TIME_SYSTEM"]) from err
    for keyword in _DATES:
        if keyword in message.meta and not is_number(message.meta[keyword].encode()):
            _instant(message, keyword, scale)
    zero = _instant(message, "EPOCH_TZERO", scale)
    return attitudes.TimeTags(scale, zero)


def _instant(message: CollectedAcm, keyword: str, scale: str) -> Instant:
    try:
        return ccsds_epochs.instant(message.meta[keyword], scale)
    except ccsds_epochs.BadEpoch as err:
        raise message.fault(
            f"{keyword} is {cut(message.meta[keyword])}, no epoch: {err.reason}.",
            message.lines[keyword],
        ) from err


def _numbers(message: CollectedAcm, block: AcmBlock, keyword: str, count: int) -> Any:
    """The finite numbers of a keyword, (count,); a unit other than the standard's is refused."""
    value, unit = kvn.without_unit(block.values[keyword])
    line, allowed = block.lines[keyword], UNITS.get(keyword, ())
    if unit and unit.replace(" ", "") not in allowed:
        known = f"; it must be in {allowed[0]}" if allowed else ", but it has no unit"
        raise message.fault(f"{keyword} is in {cut(unit)}{known}.", line)
    words = value.split()
    good = all(is_number(w.encode("ascii", "replace")) and math.isfinite(float(w)) for w in words)
    if len(words) != count or not good:
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise message.fault(f"{keyword} is {cut(value)}; give {what}.", line)
    return np.array([float(word) for word in words])


def _body(message, block, products):
    given = [name for name in _INERTIA if name in block.values]
    if not given:
        return None
    lacking = [name for name in _INERTIA if name not in block.values]
    if lacking:
        raise message.fault(
            f"the block PHYS has {', '.join(given)}, but lacks {', '.join(lacking)}.", block.line
        )
    values = [float(_numbers(message, block, name, 1)[0]) for name in _INERTIA]
    try:
        return Body(tensor=tensor(values, products))
    except AttitudeError as err:
        raise message.fault(f"the inertia: {err}", block.line) from err


def _check_physics(message, block):
    if "CP_REF_FRAME" in block.values and "CP" not in block.values:
        raise message.fault("CP_REF_FRAME is given without CP.", block.lines["CP_REF_FRAME"])
    for keyword, count in (("CP", 3), ("WET_MASS", 1), ("DRY_MASS", 1), ("DRAG_COEFF", 1)):
        if keyword in block.values:
            _numbers(message, block, keyword, count)


def _check_sensors(message, block):
    """Sensors are counted from 1, each once, and have as many deviations as they state."""
    found: dict[int, int] = {}
    for sensor in block.inner:
        text = sensor.values.get("SENSOR_NUMBER", "")
        number = int(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0
        line = sensor.lines.get("SENSOR_NUMBER", sensor.line)
        if not number:
            raise message.fault(f"SENSOR_NUMBER is {cut(text)}; count from 1.", line)
        if number in found:
            raise message.fault(
                f"SENSOR_NUMBER {number} was used before, in line {found[number]}.", line
            )
        found[number] = line
        count, values = "NUMBER_SENSOR_NOISE_COVARIANCE", "SENSOR_NOISE_STDDEV"
        if (count in sensor.values) != (values in sensor.values):
            raise message.fault(f"{count} and {values} belong together.", sensor.line)
        if count in sensor.values:
            text = sensor.values[count]
            states = int(text) if text.isascii() and text.isdigit() and len(text) < 6 else 0
            if not states:
                raise message.fault(
                    f"{count} is {cut(text)}; give a whole number.", sensor.lines[count]
                )
            _numbers(message, sensor, values, states)
    lacking = sorted(set(range(1, len(found) + 1)) - set(found))
    if lacking:
        raise message.fault(
            f"the block AD has {len(found)} sensors, but none of SENSOR_NUMBER {lacking[0]}.",
            block.line,
        )


def _maneuver(message, block, tags):
    values = block.values
    for keyword in ("MAN_PURPOSE", "MAN_BEGIN_TIME"):
        if not values.get(keyword):
            raise message.fault(f"the block MAN lacks {keyword}.", block.line)
    if "MAN_END_TIME" in values and "MAN_DURATION" in values:
        raise message.fault(
            "MAN_END_TIME and MAN_DURATION are given; give one of both.",
            block.lines["MAN_DURATION"],
        )
    if "TARGET_MOM_FRAME" in values and "TARGET_MOMENTUM" not in values:
        raise message.fault(
            "TARGET_MOM_FRAME is given without TARGET_MOMENTUM.", block.lines["TARGET_MOM_FRAME"]
        )

    def number(keyword):
        return float(_numbers(message, block, keyword, 1)[0]) if keyword in values else None

    first, last = number("MAN_BEGIN_TIME"), number("MAN_END_TIME")
    assert first is not None
    if last is None:
        last = first + (number("MAN_DURATION") or 0.0)
    if last < first or max(abs(first), abs(last)) > 1e15:
        raise message.fault("the maneuver ends before it begins.", block.line)
    begin, end = (_after(tags, seconds) for seconds in (first, last))
    target = attitude = None
    if "TARGET_MOMENTUM" in values:
        target = _numbers(message, block, "TARGET_MOMENTUM", 3)
    if "TARGET_ATTITUDE" in values:
        numbers = _numbers(message, block, "TARGET_ATTITUDE", 4)
        if not abs(float(np.linalg.norm(numbers)) - 1.0) < 1e-3:
            raise message.fault(
                "TARGET_ATTITUDE is no quaternion of unit length.", block.lines["TARGET_ATTITUDE"]
            )
        attitude = forms.unit(np.roll(numbers, 1))
    rate = number("TARGET_SPINRATE")
    return Maneuver(
        begin,
        end,
        values["MAN_PURPOSE"],
        target,
        values.get("TARGET_MOM_FRAME"),
        attitude,
        None if rate is None else math.radians(rate),
        dict(values),
        tuple(block.comments),
    )


def _after(tags, seconds):
    from attitude.epochs.instants import Instant

    hi, lo = tags.after(np.array([seconds]))
    return Instant(float(hi[0]), float(lo[0]))
