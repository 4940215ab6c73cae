"""Attitude Ephemeris Messages in XML, written; for the elements see `xml`."""

from __future__ import annotations

from typing import IO, TYPE_CHECKING

from attitude.formats.aem import elements
from attitude.formats.ccsds import attitude_types
from attitude.textfiles.xml import escaped

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from attitude.formats.aem.written import WrittenSegment

_SCHEMA = {
    "1.0": "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-2.0.0-master-2.0.xsd",
    "2.0": "https://sanaregistry.org/r/ndmxml_unqualified/ndmxml-4.0.0-master-4.0.xsd",
}


def write_message(
    file: IO[str],
    version: str,
    header: Mapping[str, str],
    comments: Sequence[str],
    segments: Iterable[WrittenSegment],
) -> None:
    """Write a message in XML to an open file; see `aem.write`."""
    file.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<aem xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\n'
        f'     xsi:noNamespaceSchemaLocation="{_SCHEMA[version]}"\n'
        f'     id="CCSDS_AEM_VERS" version="{version}">\n  <header>\n'
    )
    _leaves(file, 4, [("COMMENT", text) for text in comments])
    _leaves(file, 4, header.items())
    file.write("  </header>\n  <body>\n")
    for segment in segments:
        file.write("    <segment>\n      <metadata>\n")
        _leaves(file, 8, [("COMMENT", text) for text in segment.comments])
        _leaves(file, 8, segment.keywords.items())
        file.write("      </metadata>\n      <data>\n")
        _leaves(file, 8, [("COMMENT", text) for text in segment.data_comments])
        row = _template(segment, version)
        order = _order(segment)
        for epochs, columns in segment.rows():
            lists = [epochs, *columns[:, order].T.tolist()]
            file.write("".join([row % each for each in zip(*lists, strict=True)]))
        file.write("      </data>\n    </segment>\n")
    file.write("  </body>\n</aem>\n")


def _leaves(file, indent, pairs):
    for tag, text in pairs:
        file.write(f"{' ' * indent}<{tag}>{escaped(text)}</{tag}>\n")


def _order(segment):
    """The places of the segment's columns in the order of the elements."""
    columns = attitude_types.COLUMNS[segment.kind]
    given = elements.scalar_first(columns) if segment.scalar_first else list(columns)
    return [given.index(name) for name in columns]


def _template(segment, version):
    """The text of one record with %s for the epoch and %r for each column."""
    kind, columns = segment.kind, attitude_types.COLUMNS[segment.kind]
    lines = ["<EPOCH>%s</EPOCH>"]
    for group, names in _groups(kind, columns, version):
        rates = segment.sequence if segment.rates_of_angles else "XYZ"
        inner = [_leaf(n, version, k, segment.sequence[k % 3], rates) for k, n in enumerate(names)]
        lines += [f"<{group}>", *inner, f"</{group}>"] if group else inner
    element = elements.ELEMENTS[version][kind]
    lines = [f"<{element}>", *lines, f"</{element}>"]
    return (
        "".join(["        <attitudeState>\n", *(f"          {line}\n" for line in lines)])
        + "        </attitudeState>\n"
    )


def _groups(kind, columns, version):
    """Groups of columns in a record: (element or None, columns)."""
    if kind.startswith("SPIN"):
        return [(None, columns)]
    first = 4 if kind.startswith("QUATERNION") else 3
    given, rates = columns[:first], columns[first:]
    old = version == "1.0"
    if kind.startswith("QUATERNION"):
        groups = [("quaternion", given)]
        names = {
            "/DERIVATIVE": ("quaternionDot", "quaternionRate"),
            "/ANGVEL": ("angVel", "rotationRates"),
        }
    else:
        groups = [("rotationAngles" if old else None, given)]
        names = {"/DERIVATIVE": (None, None), "/ANGVEL": (None, "rotationRates")}
    if rates:
        groups.append((names["/" + kind.split("/")[1]][old], rates))
    return groups


def _leaf(name, version, place, axis, rates):
    """The element of one column; `place` is its place in its group, `axis` that of its angle.

    `rates` are the axes of the rates of version 1.
    """
    tag = f"rotation{place + 1}"
    if version == "1.0" and name.startswith("ANGLE"):
        return f'<{tag} angle="{axis}_ANGLE" units="deg">%r</{tag}>'
    if version == "1.0" and name.startswith("ANGVEL"):
        return f'<{tag} rate="{rates[place]}_RATE" units="deg/s">%r</{tag}>'
    unit = elements.unit(name)
    return f'<{name} units="{unit}">%r</{name}>' if unit else f"<{name}>%r</{name}>"
