"""Attitude Parameter Messages to be written: their blocks, in either notation and version."""

from __future__ import annotations

from dataclasses import dataclass
from typing import IO, TYPE_CHECKING, TypeAlias

import numpy as np

from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.formats.apm import inertia as apm_inertia
from attitude.formats.apm.keywords import XML_NAMES
from attitude.textfiles.xml import escaped

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.body import Body

# Name of a block, and its entries: keyword, value and unit ("" for none).
WrittenBlock: TypeAlias = tuple[str, list[tuple[str, str | float, str]]]


@dataclass
class WrittenMessage:
    """A message to be written.

    Attributes
    ----------
    version : str
    header, meta : dict of str
        Keyword -> value.
    comments : list of str
    epoch : str
        EPOCH, in the time system of the meta data.
    blocks : list of WrittenBlock
    """

    version: str
    header: dict[str, str]
    comments: list[str]
    meta: dict[str, str]
    epoch: str
    blocks: list[WrittenBlock]


def blocks(
    version: str,
    frame: str,
    body: str,
    wxyz: FloatArray,
    rates: FloatArray,
    meaning: str | None = None,
) -> list[WrittenBlock]:
    """The blocks of attitude and rates.

    Parameters
    ----------
    version : str
    frame, body : str
        Names of the external axes and of the body's.
    wxyz : (4,) array
        Body to the external axes, scalar first.
    rates : (3,) array
        Angular velocity, rad/s over the body axes.
    meaning : str or None
        Version 1: "body" or "euler" adds the block of Euler angles, with rates of this meaning.
    """
    quaternions: list[tuple[str, str | float, str]] = [
        (k, float(q), "") for k, q in zip(("Q1", "Q2", "Q3", "QC"), np.roll(wxyz, -1), strict=True)
    ]
    speeds = [float(rate) for rate in np.degrees(rates)]
    if version == "1.0":
        dots = np.roll(forms.quaternion_rate(wxyz, rates), -1).tolist()
        names = ("Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT")
        first: list[tuple[str, str | float, str]]
        first = [("Q_FRAME_A", frame, ""), ("Q_FRAME_B", body, ""), ("Q_DIR", "A2B", "")]
        turning = [(name, dot, "1/s") for name, dot in zip(names, dots, strict=True)]
        found: list[WrittenBlock] = [("QUAT", [*first, *quaternions, *turning])]
        return found if meaning is None else [*found, _euler(frame, body, wxyz, rates, meaning)]
    frames: list[tuple[str, str | float, str]]
    frames = [("REF_FRAME_A", frame, ""), ("REF_FRAME_B", body, "")]
    components = [(f"ANGVEL_{a}", rate, "deg/s") for a, rate in zip("XYZ", speeds, strict=True)]
    return [
        ("QUAT", [*frames, *quaternions]),
        ("ANGVEL", [*frames, ("ANGVEL_FRAME", body, ""), *components]),
    ]


def _euler(frame, body, wxyz, rates, meaning):
    """The block of Euler angles of version 1."""
    angles = forms.to_euler("ZYX", wxyz)
    speeds = np.degrees(rates)[::-1]
    if meaning == "euler":
        speeds = np.degrees(forms.euler_rates("ZYX", angles, rates))
    return (
        "EULER",
        [
            *(("EULER_FRAME_A", frame, ""), ("EULER_FRAME_B", body, "")),
            *(("EULER_DIR", "A2B", ""), ("EULER_ROT_SEQ", "321", "")),
            ("RATE_FRAME", "EULER_FRAME_B", ""),
            *(
                (f"{a}_ANGLE", float(x), "deg")
                for a, x in zip("ZYX", np.degrees(angles), strict=True)
            ),
            *((f"{a}_RATE", float(x), "deg/s") for a, x in zip("ZYX", speeds, strict=True)),
        ],
    )


def inertia(version: str, body: Body, frame: str, products: str | None) -> WrittenBlock:
    """The block of inertia.

    Parameters
    ----------
    version : str
    body : Body
    frame : str
        Name of the body's axes.
    products : str or None
        Sign of the products of inertia; see `apm.inertia`.

    Raises
    ------
    AttitudeError
        For a body whose moments are relative.
    """
    if body.relative:
        raise AttitudeError(
            "the moments of the body are relative, but an APM has kg m2; give moments in kg m2, or "
            "inertia=False."
        )
    names = ("11", "22", "33", "12", "13", "23")
    if version != "1.0":
        names = ("XX", "YY", "ZZ", "XY", "XZ", "YZ")
    values = apm_inertia.values(body.tensor, apm_inertia.known_products(products, version))
    entries = [(f"I{n}", value, "kg*m**2") for n, value in zip(names, values, strict=True)]
    return "INERTIA", [("INERTIA_REF_FRAME", frame, ""), *entries]


def write_kvn(file: IO[str], message: WrittenMessage) -> None:
    """Write a message in KEYWORD = value notation to an open file."""
    version = message.version
    file.write(f"CCSDS_APM_VERS = {version}\n")
    file.writelines(f"COMMENT {text}\n" for text in message.comments)
    for part in (message.header, message.meta):
        file.writelines(f"{key} = {value}\n" for key, value in part.items())
    file.write(f"EPOCH = {message.epoch}\n")
    for name, entries in message.blocks:
        file.write("\n" if version == "1.0" else f"\n{name}_START\n")
        for key, value, unit in entries:
            shown = value if isinstance(value, str) else repr(value)
            file.write(f"{key} = {shown}{f' [{unit}]' if unit else ''}\n")
        if version != "1.0":
            file.write(f"{name}_STOP\n")


def write_xml(file: IO[str], message: WrittenMessage) -> None:
    """Write a message in XML to an open file."""
    version = message.version
    schema = "2.0.0-master-2.0" if version == "1.0" else "4.0.0-master-4.0"

    def leaf(indent, key, value, unit="", attribute=""):
        shown = escaped(value) if isinstance(value, str) else repr(value)
        units = f' units="{unit}"' if unit else ""
        file.write(f"{' ' * indent}<{key}{attribute}{units}>{shown}</{key}>\n")

    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<apm xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        '     xsi:noNamespaceSchemaLocation="https://sanaregistry.org/r/ndmxml_unqualified/'
        f'ndmxml-{schema}.xsd"\n     id="CCSDS_APM_VERS" version="{version}">\n  <header>\n'
    )
    for text in message.comments:
        leaf(4, "COMMENT", text)
    for key, value in message.header.items():
        leaf(4, key, value)
    file.write("  </header>\n  <body>\n    <segment>\n      <metadata>\n")
    for key, value in message.meta.items():
        leaf(8, key, value)
    file.write("      </metadata>\n      <data>\n")
    if version != "1.0":
        leaf(8, "EPOCH", message.epoch)
    for name, entries in message.blocks:
        element = XML_NAMES[version][name]
        file.write(f"        <{element}>\n")
        if version == "1.0" and name == "QUAT":
            leaf(10, "EPOCH", message.epoch)
        _write_entries(file, leaf, entries)
        file.write(f"        </{element}>\n")
    file.write("      </data>\n    </segment>\n  </body>\n</apm>\n")


def _write_entries(file, leaf, entries):
    """Write the keywords of a block; quaternion, angles and rates each have a group element."""
    groups = {
        "Q1": "quaternion",
        "Q1_DOT": "quaternionRate",
        "Z_ANGLE": "rotationAngles",
        "Z_RATE": "rotationRates",
    }
    inside, count = None, 0
    for key, value, unit in entries:
        if key in groups and inside is None:
            inside, count = groups[key], 0
            file.write(f"          <{inside}>\n")
        if inside is None:
            leaf(10, key, value, unit)
            continue
        count += 1
        if inside.startswith("quaternion"):
            leaf(12, key, value, unit)
        else:
            kind = "angle" if inside == "rotationAngles" else "rate"
            leaf(12, f"rotation{count}", value, unit, f' {kind}="{key}"')
        if count == (4 if inside.startswith("quaternion") else 3):
            file.write(f"          </{inside}>\n")
            inside = None
