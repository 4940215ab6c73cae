"""Blocks of an Attitude Comprehensive Message to be written, in KVN and XML."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, Any, TypeAlias

import numpy as np

from attitude import quaternion
from attitude.formats.acm.keywords import ROWS, UNITS
from attitude.formats.apm import inertia as apm_inertia
from attitude.formats.ccsds.attitude_types import Convention
from attitude.formats.rows import columns_of
from attitude.textfiles.xml import escaped

if TYPE_CHECKING:
    from attitude.axes.axes import Axes
    from attitude.body import Body
    from attitude.formats.sources import Records
    from attitude.history import AttitudeHistory
    from attitude.motion import Motion
    from attitude.paths.path import Path

# Texts of epochs, and columns, of some rows.
RowPieces: TypeAlias = Iterator[tuple[list[str], Any]]


@dataclass
class AcmBlockOut:
    """A block to be written.

    Attributes
    ----------
    name : str
    entries : list of (keyword, text)
    rows : callable or None
        Returns the rows piece by piece.
    comments : tuple of str
    """

    name: str
    entries: list[tuple[str, str]]
    rows: Callable[[], RowPieces] | None = None
    comments: tuple[str, ...] = field(default=())


def attitudes(
    part: Records,
    frame: str,
    found: Axes,
    body: str,
    texts: Callable[[AttitudeHistory], list[str]],
    orbit: Path | None,
) -> AcmBlockOut:
    """The block ATT of a segment: quaternions, with angular velocities if it has them.

    Parameters
    ----------
    part : Records
    frame, found : str, Axes
        External axes, and their name in the file.
    body : str
        Name of the body's axes.
    texts : callable
        The epochs of a history as texts.
    orbit : Path or None
        Path of the body about its center, for axes of an orbit.
    """
    kind = "QUATERNION/ANGVEL" if part.has_rates else "QUATERNION"
    entries = [("REF_FRAME_A", frame), ("REF_FRAME_B", body)]
    entries += [("NUMBER_STATES", "7" if part.has_rates else "4"), ("ATT_TYPE", "QUATERNION")]
    if part.has_rates:
        entries.append(("RATE_TYPE", "ANGVEL"))

    def rows() -> RowPieces:
        for history in part.pieces():
            yield texts(history), columns_of(history, kind, Convention(), found, orbit)

    return AcmBlockOut("ATT", entries, rows, tuple(part.meta.get("data_comments", ())))


def covariances(
    part: Records, body: str, texts: Callable[[AttitudeHistory], list[str]]
) -> AcmBlockOut:
    """The block COV of a segment: variances about the body axes, and of angular velocities."""
    entries = [("COV_BASIS", "PREDICTED"), ("COV_REF_FRAME", body), ("COV_TYPE", "ANGLE_ANGVEL")]

    def rows() -> RowPieces:
        for history in part.pieces():
            given = np.asarray(history.covariance)
            turn = np.swapaxes(history.matrix, -1, -2)
            angles = turn @ given[:, :3, :3] @ np.swapaxes(turn, -1, -2)
            both = [np.diagonal(m, axis1=1, axis2=2) for m in (angles, given[:, 3:, 3:])]
            yield texts(history), np.concatenate(both, axis=1) * np.degrees(1.0) ** 2

    return AcmBlockOut("COV", entries, rows)


def physics(body: Body, frame: str, products: str | None) -> AcmBlockOut:
    """The block PHYS of a body in kg m2; `products` as of `acm.read`."""
    names = ("IXX", "IYY", "IZZ", "IXY", "IXZ", "IYZ")
    values = apm_inertia.values(body.tensor, apm_inertia.known_products(products, "2.0"))
    entries = [("INERTIA_REF_FRAME", frame)]
    if body.mass is not None:
        entries.insert(0, ("WET_MASS", repr(float(body.mass))))
    entries += [(name, repr(value)) for name, value in zip(names, values, strict=True)]
    return AcmBlockOut("PHYS", entries)


def maneuvers(
    motion: Motion,
    seconds: Callable[[float, float], str],
    first: float,
    last: float,
    axes_of: tuple[str, Axes],
) -> list[AcmBlockOut]:
    """A block MAN for each impulse of a motion, with the angular momentum after it.

    Parameters
    ----------
    motion : Motion
    seconds : callable
        Text of an epoch given as TDB seconds, hi and lo, since that of the motion.
    first, last : float
        The span of the message, s since the epoch of the motion.
    axes_of : (str, Axes)
        The axes of the angular momentum, and their name in the file; ICRF instead of axes that
        turn.
    """
    name, axes = ("ICRF", None) if axes_of[1].turning else axes_of
    inner = None if axes is None else quaternion.conjugate(axes.to_icrf(motion.epoch, 0.0, None))
    found = []
    for hi, lo in motion.breaks():
        if not first <= hi <= last:
            continue
        after = motion.at(np.array([hi]), np.array([lo]))
        before = motion.at(np.array([hi]), np.array([np.nextafter(lo, -np.inf)]))
        was, now = (
            quaternion.rotate(h.wxyz, h.motion.momentum_in_body(h))[0] for h in (before, after)
        )
        if np.linalg.norm(now - was) <= 1e-12 * np.linalg.norm(now):
            continue  # a change of the inertia alone
        now = now if inner is None else quaternion.rotate(inner, now)
        momentum = " ".join(repr(float(x)) for x in now)
        entries = [("MAN_PURPOSE", "ATT_ADJUST"), ("MAN_BEGIN_TIME", seconds(hi, lo))]
        entries += [("MAN_DURATION", "0.0"), ("TARGET_MOMENTUM", momentum)]
        found.append(AcmBlockOut("MAN", [*entries, ("TARGET_MOM_FRAME", name)]))
    return found


def write_kvn(
    file: IO[str],
    header: dict[str, str],
    comments: list[str],
    meta: dict[str, str],
    blocks: list[AcmBlockOut],
) -> None:
    """Write a message in KEYWORD = value notation to an open file."""
    file.write("CCSDS_ACM_VERS = 2.0\n")
    file.writelines(f"COMMENT {text}\n" for text in comments)
    file.writelines(f"{key} = {value}\n" for key, value in header.items())
    file.write("\nMETA_START\n")
    file.writelines(f"{key} = {value}\n" for key, value in meta.items())
    file.write("META_STOP\n")
    for block in blocks:
        file.write(f"\n{block.name}_START\n")
        file.writelines(f"COMMENT {text}\n" for text in block.comments)
        for key, value in block.entries:
            unit = f" [{UNITS[key][0]}]" if key in UNITS else ""
            file.write(f"{key} = {value}{unit}\n")
        for text in _rows(block):
            file.write(text + "\n")
        file.write(f"{block.name}_STOP\n")


def write_xml(
    file: IO[str],
    header: dict[str, str],
    comments: list[str],
    meta: dict[str, str],
    blocks: list[AcmBlockOut],
) -> None:
    """Write a message in XML to an open file."""
    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<acm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        '     xsi:noNamespaceSchemaLocation="https://sanaregistry.org/r/ndmxml_unqualified/'
        'ndmxml-4.0.0-master-4.0.xsd"\n     id="CCSDS_ACM_VERS" version="2.0">\n  <header>\n'
    )

    def leaf(indent: int, key: str, value: str) -> None:
        unit = f' units="{UNITS[key][0]}"' if key in UNITS else ""
        file.write(f"{' ' * indent}<{key}{unit}>{escaped(value)}</{key}>\n")

    for text in comments:
        leaf(4, "COMMENT", text)
    for key, value in header.items():
        leaf(4, key, value)
    file.write("  </header>\n  <body>\n    <segment>\n      <metadata>\n")
    for key, value in meta.items():
        leaf(8, key, value)
    file.write("      </metadata>\n      <data>\n")
    for block in blocks:
        file.write(f"        <{block.name.lower()}>\n")
        for text in block.comments:
            leaf(10, "COMMENT", text)
        for key, value in block.entries:
            leaf(10, key, value)
        for text in _rows(block):
            leaf(10, ROWS[block.name], text)
        file.write(f"        </{block.name.lower()}>\n")
    file.write("      </data>\n    </segment>\n  </body>\n</acm>\n")


def _rows(block):
    """The rows of a block as texts."""
    if block.rows is None:
        return
    for epochs, columns in block.rows():
        row = "%s" + " %r" * columns.shape[1]
        for each in zip(epochs, *columns.T.tolist(), strict=True):
            yield row % each
