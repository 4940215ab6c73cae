"""What the blocks of CCSDS attitude messages share: units, epochs, axes, sequences and inertia.

The sign of the products of inertia is that of the book of each version, unless it is given:
"tensor"    IXY (I12) is the entry of the inertia tensor, -integral of x y dm.  Version 1: "the
            inertia cross products used for this message assume a negative double integral", CCSDS
            504.0-B-1, 3.2.5.2.5.  Orekit reads both versions with this sign.
"integral"  IXY is the integral of x y dm, and the entry of the tensor is -IXY: the matrix of
            version 2, CCSDS 504.0-B-2, annex F6.  brahe reads version 2 with this sign.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import validation
from attitude._textfiles.lines import cut
from attitude._textfiles.messages import comparable, refuse_line_breaks
from attitude.epochs import _ccsds as ccsds_epochs
from attitude.errors import AttitudeError
from attitude.formats._records import ANGLES, ANGLES_DOT, ANGVEL, Q_DOT, Q
from attitude.frames import quaternion
from attitude.motions import _axes
from attitude.motions._body import Body

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from attitude._support.annotations import FloatArray
    from attitude._textfiles.messages import Block, Message
    from attitude.epochs._instants import Instant
    from attitude.motions._axes import Axes


# Versions of attitude data messages (CCSDS 504.0) and keywords of their header.
VERSIONS: tuple[str, ...] = ("1.0", "2.0")
HEADER: tuple[str, ...] = ("CREATION_DATE", "ORIGINATOR", "MESSAGE_ID", "CLASSIFICATION")
INERTIA: tuple[str, ...] = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
OLD_INERTIA: tuple[str, ...] = ("I11", "I22", "I33", "I12", "I13", "I23")
OLD_ANGLES: tuple[str, ...] = ("X_ANGLE", "Y_ANGLE", "Z_ANGLE")
OLD_RATES: tuple[str, ...] = ("X_RATE", "Y_RATE", "Z_RATE")
# Keyword -> the element of XML that groups it with others.
GROUPS: dict[str, str | None] = {
    **dict.fromkeys(Q, "quaternion"),
    **dict.fromkeys(Q_DOT, "quaternionRate"),
    **dict.fromkeys(OLD_ANGLES, "rotationAngles"),
    **dict.fromkeys(OLD_RATES, "rotationRates"),
}
# Keyword or column -> units that may stand with it; without one, a number is in the first.
UNITS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys((*ANGLES, *OLD_ANGLES), ("deg",)),
    **dict.fromkeys(("SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SENSOR_NOISE_STDDEV"), ("deg",)),
    **dict.fromkeys(("NUTATION", "NUTATION_PHASE", "MOMENTUM_ALPHA", "MOMENTUM_DELTA"), ("deg",)),
    **dict.fromkeys((*ANGLES_DOT, *ANGVEL, *OLD_RATES), ("deg/s",)),
    **dict.fromkeys(("SPIN_ANGLE_VEL", "NUTATION_VEL"), ("deg/s",)),
    **dict.fromkeys(Q_DOT, ("1/s",)),
    **dict.fromkeys((*INERTIA, *OLD_INERTIA), ("kg*m**2", "kg*m^2", "kg.m**2")),
    **dict.fromkeys(("WET_MASS", "DRY_MASS"), ("kg",)),
    **dict.fromkeys(("MAN_BEGIN_TIME", "MAN_END_TIME", "MAN_DURATION", "NUTATION_PER"), ("s",)),
    **dict.fromkeys(("TAIMUTC_AT_TZERO", "NEXT_LEAP_TAIMUTC"), ("s",)),
    "CP": ("m",),
    "TARGET_MOMENTUM": ("N*m*s", "N.m.s"),
    "TARGET_SPINRATE": ("deg/s", "°/s"),
    "SENSOR_FREQUENCY": ("Hz",),
    "SIGMA_U": ("deg/s**1.5", "deg/s^1.5", "°/s**1.5"),
    "SIGMA_V": ("deg/s**0.5", "deg/s^0.5", "°/s**0.5"),
    "RATE_PROCESS_NOISE_STDDEV": ("deg/s**1.5", "deg/s^1.5", "°/s**1.5"),
}

_SIGNS = {"tensor": 1.0, "integral": -1.0}
_OF_VERSION = {"1.0": "tensor", "2.0": "integral"}
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def scale_of(meta: Block) -> str:
    """The time scale, in lower case, of TIME_SYSTEM."""
    with meta.located("TIME_SYSTEM"):
        return ccsds_epochs.known(meta.needed("TIME_SYSTEM"))


def epoch_of(block: Block, keyword: str, scale: str) -> Instant:
    """The Instant of a keyword."""
    with epochs_named(block, keyword):
        return ccsds_epochs.instant(block.needed(keyword), scale)


@contextmanager
def epochs_named(block: Block, keyword: str) -> Iterator[None]:
    """A BadEpoch inside becomes the AttitudeError for a keyword."""
    try:
        yield
    except ccsds_epochs.BadEpoch as err:
        raise block.fault(
            f"{keyword} is {cut(block[keyword])}, no epoch: {err.reason}.", keyword
        ) from err


def refuse_reversed(
    block: Block, start: Instant | None, stop: Instant | None, of: str = ""
) -> None:
    """AttitudeError if STOP_TIME is before START_TIME; `of` stands before these keywords."""
    if start is not None and stop is not None and stop.since(start) < 0.0:
        raise block.fault(f"{of}STOP_TIME is before {of}START_TIME.", f"{of}STOP_TIME")


def axes_of(block: Block, frame: str | None) -> tuple[Axes, str, bool]:
    """The external axes, the name of the body's axes, and whether the body is A."""
    names = block.needed("REF_FRAME_A"), block.needed("REF_FRAME_B")
    with block.located("REF_FRAME_B"):
        return _axes.of_pair(*names, frame)


def sequence_of(block: Block) -> str:
    """The axes of EULER_ROT_SEQ, such as "ZXZ"."""
    if not block.get("EULER_ROT_SEQ"):
        raise block.fault("Euler angles and their rates need EULER_ROT_SEQ, like 321 or ZYX.")
    with block.located("EULER_ROT_SEQ", "EULER_ROT_SEQ: "):
        return quaternion.known_sequence(block["EULER_ROT_SEQ"].upper())


def known_products(products: str | None, version: str) -> str:
    """The convention of the products of inertia, by default that of the version's book."""
    if products is None:
        return _OF_VERSION[version]
    return validation.one_of(products, "products", tuple(_SIGNS))


def body_of(block: Block, products: str) -> Body:
    """The Body of IXX, ..., IYZ in kg m2.

    For (10, 20, 26, 0.5, 0, 0) the first row of the tensor is 10, 0.5, 0 with "tensor", and
    10, -0.5, 0 with "integral".
    """
    tensor = np.zeros((3, 3))
    for (i, j), keyword in zip(_PLACES, INERTIA, strict=True):
        value = block.number(keyword)
        tensor[i, j] = tensor[j, i] = value if i == j else _signed(value, products)
    with block.located(what="the inertia: "):
        return Body(tensor=tensor)


def refuse_other_axes(inertia: str | None, body: str | None) -> None:
    """AttitudeError if an inertia is over other axes than those whose attitude is given."""
    if inertia is not None and body is not None and comparable(inertia) != comparable(body):
        raise AttitudeError(
            f"the inertia is over the axes {cut(inertia, '')}, but the attitude is that of "
            f"{cut(body, '')}; give a Body over the axes of the attitude: FreeRotation(body, spin)."
        )


def inertia_values(tensor: FloatArray, products: str | None, version: str) -> list[float]:
    """IXX, IYY, IZZ, IXY, IXZ, IYZ in kg m2 from an inertia tensor (3, 3) in kg m2."""
    products = known_products(products, version)
    entries = [(i == j, float(tensor[i, j])) for i, j in _PLACES]
    return [value if diagonal else _signed(value, products) for diagonal, value in entries]


def _signed(value, products):
    return _SIGNS[products] * value + 0.0  # -0.0 becomes 0.0


def said_by(message: Message, meta: Block, title: str, identifier: str) -> dict[str, Any]:
    """Format, keywords, comments and names of a message, for `meta` of what is read."""
    return {
        "format": title,
        "header": dict(message.header),
        "comments": tuple(message.header.comments),
        "keywords": dict(meta),
        "object_name": meta["OBJECT_NAME"],
        "object_id": meta.get(identifier),
        "center": meta.get("CENTER_NAME"),
    }


# ---- Writing


def written_header(
    meta: Mapping[str, Any],
    creation_date: str | None,
    originator: str,
    comments: Sequence[str] | None,
) -> tuple[dict[str, str], Sequence[str]]:
    """The header, by default with the present date, and comments, by default those of `meta`."""
    keywords = {"CREATION_DATE": creation_date or ccsds_epochs.now(), "ORIGINATOR": originator}
    return keywords, list(meta.get("comments", ()) if comments is None else comments)


def written_body(body_frame: str | None, meta: Mapping[str, Any]) -> str:
    """The name of the body's axes: as given, or that of the file that was read."""
    name = body_frame or meta.get("body_frame") or "SC_BODY_1"
    if (why := _axes.body_name_fault(name)) is not None:
        raise AttitudeError(f"body_frame is {name!r}, which {why}; give another name.")
    refuse_line_breaks(name)
    return name


def written_names(
    meta: Mapping[str, Any],
    object_name: str | None,
    object_id: str | None,
    center: str | None,
    identifier: str = "OBJECT_ID",
) -> dict[str, str]:
    """The keywords that name object and center: as given, or those of the file that was read."""
    center = center or meta.get("center")
    return {
        "OBJECT_NAME": object_name or meta.get("object_name") or "UNKNOWN",
        identifier: object_id or meta.get("object_id") or "UNKNOWN",
        **({"CENTER_NAME": center} if center else {}),
    }
