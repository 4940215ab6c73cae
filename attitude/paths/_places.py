"""`place`: where a body or an observer is, in any form that Python, TOML and commands take.

One grammar: a path, the name of a body, a file, an orbit line, elements, a place on the ground.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from attitude._support import quantity_text, validation
from attitude._support.quantity_text import quoted
from attitude._textfiles import toml
from attitude._textfiles.lines import beginning, whole
from attitude._textfiles.toml import refuse_unknown, way_of
from attitude.errors import AttitudeError
from attitude.paths import (
    _ground,
    _mpc_line,
    _oem_file,
    _path,
    _satellite,
    _solar_system,
    _two_body,
)
from attitude.paths._composed import NamedBody
from attitude.paths._foreign import place_of
from attitude.paths._path import Place, body_name, naif_index

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath
    from attitude.paths._path import EphemerisLike, Path


class Kind(NamedTuple):
    """A kind of table: what makes its place, its other keys, and how a file of the kind begins."""

    make: Callable[..., Place]
    keys: tuple[str, ...] = ()
    mark: bytes = b""


KINDS: dict[str, Kind] = {
    "tle": Kind(_satellite.tle, ("name", "any_epoch"), rb"([^\n]*\n)?1 [^\n]*\n2 "),
    "omm": Kind(
        _satellite.omm,
        ("name", "any_epoch"),
        rb"CCSDS_OMM_VERS|[<{]|\[\s*\{|.*\bMEAN_MOTION\b",
    ),
    "oem": Kind(_oem_file.oem, ("degree", "center"), rb"CCSDS_OEM_VERS|<.*<oem\b|<oem\b"),
    "spk": Kind(_solar_system.spk, ("target", "center"), rb"DAF/SPK|NAIF/DAF"),
    "mpc_orbit": Kind(_mpc_line.mpc_orbit),
    "kepler": Kind(_two_body.kepler),
    "site": Kind(_ground.site, ("height", "name", "long_term")),
    "observatory": Kind(_ground.observatory, ("long_term",)),
    "direction": Kind(_path.direction, ("frame", "name")),
}
_BODIES = "the name of a planet, the Sun or the Moon"
_MOVING = (
    f"{_BODIES}, a file (OEM, TLE, OMM, SPK, MPCORB line, elements, mission file), a line "
    'of MPCORB.DAT, or elements such as "a = 2.53 au, e = 0.63, i = 0.45 deg, node = 124 deg, '
    'peri = 279 deg, M = 12 deg, epoch = 2026-01-01 TT"'
)
_ON_GROUND = (
    f'{_BODIES}, the code of an observatory ("568"), its name, or longitude and latitude '
    '("-70.7, -30.2 deg, 2700 m")'
)
# Short names of elements -> keyword of `kepler`.
_ELEMENTS = {
    **dict.fromkeys(("a", "sma", "semi_major_axis"), "semi_major_axis"),
    **dict.fromkeys(("q", "pericenter_distance", "perihelion_distance"), "pericenter_distance"),
    **dict.fromkeys(("e", "ecc", "eccentricity"), "eccentricity"),
    **dict.fromkeys(("i", "inc", "incl", "inclination"), "inclination"),
    **dict.fromkeys(("node", "Omega", "om", "raan", "longitude_of_node"), "node"),
    **dict.fromkeys(
        ("peri", "omega", "w", "argp", "pericenter_argument", "argument_of_perihelion"),
        "pericenter_argument",
    ),
    **dict.fromkeys(("M", "ma", "M0", "mean_anomaly"), "mean_anomaly"),
    **dict.fromkeys(("epoch", "t", "Tp", "tp"), "epoch"),
    **{key: key for key in ("center", "gm", "frame", "name", "source")},
}
_ANGLES = ("inclination", "node", "pericenter_argument", "mean_anomaly")
_LENGTHS = ("semi_major_axis", "pericenter_distance")
# Plain numbers up to one turn may be radians or degrees.
_TURN = 6.2832
# The same of an angle up to a right angle.
_RIGHT_ANGLE = 1.5708


def place(
    given: Any,
    name: str = "place",
    *,
    of: str | int | None = None,
    is_observer: bool = False,
    ephemeris: EphemerisLike = None,
    folder: FilePath = "",
) -> Place:
    """The path or direction of a body or an observer that is given in any form.

    Parameters
    ----------
    given : Path, Direction, object of astropy or skyfield, int, str, path or mapping
        A NAIF number; the name of a planet, of the Sun or the Moon; a file: OEM, TLE, OMM, SPK, a
        line of MPCORB.DAT or the whole file, elements (text, or TOML with its names or the keywords
        of `kepler`), a mission file (its ``center``); a line of MPCORB.DAT or CometEls.txt; text,
        ``"a = 2.53 au, e = 0.63, i = 0.45 deg, node = ..., peri = ..., M = ..., epoch = ..."``.
        Of an observer also the code or the name of an observatory, and ``"longitude, latitude[,
        height]"`` with units or, plain, in degrees and m.  A mapping is a table of mission files,
        such as ``{"site": "15.49, 47.07 deg", "height": "495 m"}``.
    name : str
        Of the argument, for messages.
    of : str or int, optional
        The target of an SPK, or one body of several in a TLE, OMM or MPCORB.DAT.
    is_observer : bool
        Whether three characters are the code of an observatory rather than a NAIF number.
    ephemeris : path of a kernel, name, Ephemeris, None, or a list of these
        Of bodies given by name, as for `body`, and of files with several centers.
    folder : path
        Where relative names of files begin.

    Returns
    -------
    Path or Direction

    Raises
    ------
    AttitudeError
        For anything else, plain numbers that may be degrees or radians, names of several
        observatories, and as the reader of the file.

    >>> place("568", is_observer=True).name
    '568 Maunakea'
    >>> place("a = 1 au, e = 0, i = 0 deg, node = 0 deg, peri = 0 deg, epoch = 2026-01-01").center
    'sun'
    """
    if isinstance(given, Place):
        return given
    if isinstance(given, Mapping):
        return _of_table(dict(given), name, os.fspath(folder), ephemeris)
    if isinstance(given, os.PathLike):
        return _of_file(os.path.join(folder, given), name, of, ephemeris)
    if isinstance(given, str):
        return _of_text(given, name, of, is_observer, ephemeris, os.fspath(folder))
    if naif_index(given) is not None:
        return NamedBody(body_name(given, name), ephemeris)
    foreign = None if isinstance(given, (list, tuple)) else place_of(given, name)
    if foreign is not None:
        return foreign
    raise AttitudeError(
        f"{name} is {validation.shown(given)}; give a path of attitude.paths, a direction, "
        f"{_ON_GROUND if is_observer else _MOVING}."
    )


def is_body(text: str) -> bool:
    """Whether a text is the name or the NAIF number of a body."""
    try:
        body_name(text)
    except AttitudeError:
        return False
    return True


def is_code(text: str) -> bool:
    """Whether a text has the form of the code of an observatory."""
    return re.fullmatch(r"[0-9A-Za-z][0-9]{2}", text.strip()) is not None


# ---- Text


def _of_text(text, name, of, is_observer, ephemeris, folder):
    path = os.path.join(folder, os.path.expanduser(text)) if len(text) < 1000 else ""
    stripped = text.strip()
    if is_observer and is_code(stripped):
        return _of_code(stripped, name)
    if path and os.path.isfile(path):
        return _of_file(path, name, of, ephemeris)
    if of is not None:
        raise AttitudeError(
            f"{name} is {quoted(text)}, which is not a file; give a file with several bodies, or "
            f"leave out {of!r}."
        )
    if is_observer and re.fullmatch("[0-9]{4}", stripped):
        raise AttitudeError(
            f"{name} is {text!r}, neither the code of an observatory of the Minor Planet Center, "
            f"of three characters, nor the NAIF number of a body; give {_ON_GROUND}."
        )
    if is_body(stripped):
        return NamedBody(body_name(stripped, name), ephemeris)
    if _mpc_line.is_line(text):
        return _mpc_line.mpc_orbit(text)
    if "=" in text:
        return _of_elements(text, name)
    if re.fullmatch(r"\s*[-+]?[0-9.].*,.*[0-9].*", text):
        return _of_coordinates(text, name)
    if re.search(r"\.[A-Za-z]\w*$|[/\\]", stripped):
        raise AttitudeError(f"{name} is {quoted(text)}, which is not a file; give the name of one.")
    if is_observer and (site := _ground.named(stripped)) is not None:
        return site
    raise AttitudeError(
        f"{name} is {quoted(text)}, which is not the name of a body of the solar system's "
        f"ephemeris; give {_ON_GROUND if is_observer else _MOVING}."
        + (
            ""
            if is_observer
            else " In Python: paths.mpc_orbit(line), paths.kepler(...), paths.oem(file) or "
            "paths.spk(file, target). The catalogue of spin states holds no orbits."
        )
    )


def _of_code(code: str, name: str) -> Place:
    """The observatory of a code; AttitudeError for one that is the NAIF number of a body too."""
    if code.isdigit() and not body_name(code).isdigit():
        body = body_name(code)
        raise AttitudeError(
            f"{name} is {code!r}, the NAIF number of {body!r} and the code of an observatory; give "
            f'{body!r}, or {{"observatory": {code!r}}} (in TOML {{ observatory = "{code}" }}).'
        )
    return _ground.observatory(code)


def _of_coordinates(text: str, name: str) -> Place:
    """The place of "-70.7, -30.2", "-70.7, -30.2 deg, 2700 m" or "-70.7 deg, -30.2 deg, 2.7 km"."""
    parts = [word.strip() for word in text.split(",")]
    example = '"-70.7, -30.2 deg, 2700 m"'
    if len(parts) not in (2, 3):
        raise AttitudeError(
            f"{name} is {quoted(text)}; give longitude, latitude and, if known, the height, as in "
            f"{example}."
        )
    if len(parts) == 3 and not quantity_text.is_quantity(parts[1]) and " " in parts[2]:
        trailing = parts[2].split(None, 1)[1]
        if quantity_text.common_factor(trailing, "m") is None:
            raise AttitudeError(
                f"{name} is {quoted(text)}, whose height is in {trailing}; write each unit behind "
                f"its number, as in {example}."
            )
    angles = parts[:2]
    if any(re.search(r"[NSEW]$|\d *[:d°] *\d", word) for word in angles):
        raise AttitudeError(
            f"{name} is {quoted(text)}; give longitude and latitude in decimal degrees, positive "
            f"to the east and north, as in {example}."
        )
    if not any(map(quantity_text.is_quantity, angles)):
        numbers = [validation.number(_number(word, name), name) for word in angles]
        if abs(numbers[0]) <= _TURN and abs(numbers[1]) <= _RIGHT_ANGLE and any(numbers):
            raise AttitudeError(
                f"{name} is {quoted(text)}, which may be degrees or radians; give the unit, as in "
                f"{example}."
            )
        angles = [f"{word} deg" for word in angles]
    elif not quantity_text.is_quantity(angles[1]):
        raise AttitudeError(
            f"{name} is {quoted(text)}, whose latitude has no unit; write it behind the latitude, "
            f"as in {example}."
        )
    elif not quantity_text.is_quantity(angles[0]):  # the unit stands behind the latitude
        unit = quantity_text.numbers_and_unit(angles[1], name)[1]
        angles = [f"{angles[0]} {unit}", angles[1]]
    return _ground.site(*angles, *parts[2:], name=text.strip())


def _number(text: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise AttitudeError(
            f'{name} has {quoted(text)}; give a number, as in "-70.7, -30.2 deg, 2700 m".'
        ) from None


def _of_elements(text: str, name: str) -> Path:
    """The path of elements "a = 2.5 au, e = 0.6, ...", separated by commas, semicolons or lines."""
    elements: dict[str, Any] = {}
    for entry in re.split(r"[,;\n]", text):
        key, mark, value = (word.strip() for word in entry.partition("="))
        if not entry.strip():
            continue
        if not mark or key not in _ELEMENTS:
            raise AttitudeError(
                f"{name} has {quoted(entry.strip())}, which is no element; give a (or q), e, i, "
                'node, peri, M and epoch, as in "a = 2.53 au, e = 0.63, ...".'
            )
        if "=" in value:
            raise AttitudeError(
                f"{name} has {quoted(entry.strip())}; put a comma between elements, as in "
                '"a = 2.53 au, e = 0.63, ...".'
            )
        if _ELEMENTS[key] in elements:
            raise AttitudeError(f"{name} has {key} twice; give it once.")
        elements[_ELEMENTS[key]] = value
    for key in (*_ANGLES, *_LENGTHS):
        if key in elements and not quantity_text.is_quantity(elements[key]):
            unit = "deg" if key in _ANGLES else "au"
            raise AttitudeError(
                f"{name} has {key} = {elements[key]!r} without a unit; write it like "
                f'"{elements[key]} {unit}".'
            )
    return _of_keywords(elements, name)


def _of_keywords(value: Any, name: str) -> Path:
    """The path of the keywords of `kepler`."""
    if not isinstance(value, dict):
        raise AttitudeError(f"{name} kepler is {quoted(value)}; give a table of elements.")
    return _two_body.kepler(**value)


# ---- Tables of mission files


def _of_table(table: dict[str, Any], name: str, folder: str, ephemeris: EphemerisLike) -> Place:
    kind = way_of(table, KINDS, name)
    make, keys, mark = KINDS[kind]
    refuse_unknown(table, (kind, *keys), name)
    settings = {key: table[key] for key in keys if key in table}
    value = table[kind]
    if "center" in settings:
        center = settings["center"]
        settings["center"] = place(center, f"{name} center", folder=folder, ephemeris=ephemeris)
    if kind == "spk" and "target" not in settings:
        raise AttitudeError(f"{name} spk needs a target, such as target = 20099942.")
    if "center" in keys:  # a file may have several centers
        settings["ephemeris"] = ephemeris
    if mark:
        value = file_of(value, folder, f"{name} {kind}")
    if kind == "kepler":
        return _of_keywords(value, name)
    if kind == "site":
        angles = validation.real(value, f"{name} site", unit="rad")
        if angles.shape != (2,):
            raise AttitudeError(
                f"{name} site is {quoted(value)}; give longitude and latitude, as in "
                '"15.49, 47.07 deg".'
            )
        return make(*angles.tolist(), **settings)
    return make(value, **settings)


def file_of(value: Any, folder: str, name: str) -> str:
    """The path of an existing file; a relative one starts from the folder."""
    if not isinstance(value, str):
        raise AttitudeError(f"{name} is {quoted(value)}; give the name of a file, in quotes.")
    path = os.path.join(folder, os.path.expanduser(value))
    if not os.path.isfile(path):
        where = f" ({path})" if len(value) <= 120 else ""
        raise AttitudeError(
            f"{name} is {quoted(value)}, which is not a file{where}; give the name of a file."
        )
    return path


# ---- Files


def _of_file(path: str, name: str, of: str | int | None, ephemeris: EphemerisLike) -> Place:
    """The path in a file, whose format follows from its beginning."""
    kind = _kind(path, name)
    if kind == "oem":
        if of is not None:
            raise AttitudeError(
                f"{name} {path!r} is an OEM, which holds one body; leave out {of!r}."
            )
        return _oem_file.oem(path, ephemeris=ephemeris)
    if kind == "spk":
        if of is None:
            raise AttitudeError(
                f"{name} {path!r} is an SPK, which may hold many bodies; name one by its name or "
                "NAIF number: --orbit-of on the command line, target = in a table."
            )
        target = of.strip() if isinstance(of, str) else of
        is_number = isinstance(target, str) and re.fullmatch(r"-?[0-9]+", target)
        return _solar_system.spk(path, int(target) if is_number else target, ephemeris=ephemeris)
    if kind == "mpc":
        return _of_orbit_lines(path, name, of)
    if kind == "toml":
        if of is not None:
            raise AttitudeError(f"{name} {path!r} holds one body; leave out {of!r}.")
        return _of_toml(path, name, ephemeris)
    if kind == "elements":
        return _of_elements(whole(path, "give a file of elements"), path)
    return KINDS[kind].make(path, name=of)


def _kind(path: str, name: str) -> str:
    start = beginning(path)
    is_toml = path.lower().endswith(".toml")  # which may name the keywords of an OMM
    for kind in ("spk", "oem") if is_toml else ("spk", "oem", "omm", "tle"):
        if re.match(KINDS[kind].mark, start, re.DOTALL):
            return kind
    if is_toml:
        return "toml"
    lines = start.decode("utf-8", "replace").splitlines()
    # A line cut at the end of what was read may lack its last columns, never its first ones.
    is_catalog = start.startswith(b"MINOR PLANET CENTER ORBIT DATABASE")
    if is_catalog or any(map(_mpc_line.is_line, lines)):
        return "mpc"
    if lines and lines[0].partition("=")[0].strip() in _ELEMENTS:
        return "elements"
    raise AttitudeError(
        f"{name} {path!r} is in no known format; give an OEM, two-line elements, an OMM, an "
        "SPK, lines of MPCORB.DAT, elements, or a mission file in TOML."
    )


def _of_orbit_lines(path: str, name: str, of: str | int | None) -> Path:
    """The path of the one orbit line of a file, or of that with a name or number."""
    text = whole(path, "give a file of orbit lines")
    rows = [row for row in text.splitlines() if _mpc_line.is_line(row)]
    if of is not None:
        wanted = str(of).strip().lower()
        rows = [row for row in rows if wanted in _mpc_line.names(row)]
    if len(rows) != 1:
        raise AttitudeError(
            f"{name} {path!r} has {len(rows)} orbit lines"
            + (f" of {of!r}" if of is not None else "")
            + "; name one body by its number, name or designation: --orbit-of on the command line."
        )
    return _mpc_line.mpc_orbit(rows[0])


def _of_toml(path: str, name: str, ephemeris: EphemerisLike) -> Place:
    """The center of a mission file, or the place of a file of elements or of a table."""
    content = toml.parsed(toml.read(path, "file of elements or mission file"), path)
    folder = os.path.dirname(path)
    if "center" in content and set(content) - set(_ELEMENTS):
        return place(content["center"], f"{path}: center", folder=folder, ephemeris=ephemeris)
    if any(key in KINDS for key in content):
        return _of_table(content, path, folder, ephemeris)
    if "eccentricity" in content:
        return _of_keywords(content, path)
    if "e" in content:
        return _of_elements("\n".join(f"{key} = {value}" for key, value in content.items()), path)
    raise AttitudeError(
        f"{name} {path!r} has neither a center, as a mission file, nor elements; give a, e, i, "
        "node, peri, M and epoch, or the keywords of paths.kepler, or mpc_orbit = LINE."
    )
