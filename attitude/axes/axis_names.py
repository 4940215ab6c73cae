"""Names of reference axes in files, and what each of them means.

Three sorts: axes that this package computes (`meaning`), axes that standards name but this package
does not compute (`named_elsewhere`), and names that look like one of both but are none
(`looks_like`).  None of the three can be the name of a body's own axes.

Source: SANA registries of celestial body, orbit-relative and spacecraft body reference frames.
"""

from __future__ import annotations

import difflib
import re

FIXED: dict[str, str] = {
    **dict.fromkeys(("ICRF", "ICRF1", "ICRF2", "ICRF3", "GCRF", "BCRF"), "icrf"),
    **dict.fromkeys(("ICRS", "GCRS", "BCRS"), "icrf"),
    **dict.fromkeys(("EME2000", "J2000"), "eme2000"),
    **dict.fromkeys(("ECLIPTIC", "ECLIPTICJ2000", "ECLIPJ2000"), "ecliptic"),
    **dict.fromkeys(("B1950", "EME1950"), "b1950"),
}
TURNING: dict[str, str] = {
    **dict.fromkeys(("TEME", "TEMEOFDATE"), "teme"),
    **dict.fromkeys(("ITRF", "ITRS"), "itrf"),
    **dict.fromkeys(("TOD", "TODEARTH", "TRUEOFDATE"), "tod"),
    **dict.fromkeys(("MOD", "MODEARTH", "MEANOFDATE"), "mod"),
    **dict.fromkeys(("GTOD", "TDR"), "gtod"),
    **{"CIRS": "cirs", "TIRS": "tirs"},
    **dict.fromkeys(("RTN", "RSW", "RIC", "QSW"), "rtn"),
    **dict.fromkeys(("LVLH", "VVLH"), "lvlh"),
    **{"TNW": "tnw", "NTW": "ntw", "VNC": "vnc"},
}
OF_ORBIT: tuple[str, ...] = ("rtn", "lvlh", "tnw", "ntw", "vnc")
# Axes at one epoch that the file gives (STK): name -> kind of the axes of date.
OF_EPOCH: dict[str, str] = {"TRUEOFEPOCH": "tod", "MEANOFEPOCH": "mod", "TEMEOFEPOCH": "teme"}
# Kind -> name in written files.
WRITTEN: dict[str, str] = {
    **{"icrf": "ICRF", "gcrf": "GCRF", "eme2000": "EME2000", "ecliptic": "ECLIPTICJ2000"},
    **{"b1950": "B1950", "itrf": "ITRF", "teme": "TEME", "tod": "TOD", "mod": "MOD"},
    **{"gtod": "GTOD", "cirs": "CIRS", "tirs": "TIRS", "rtn": "RTN", "lvlh": "LVLH"},
    **{"tnw": "TNW", "ntw": "NTW", "vnc": "VNC"},
}
# Axes that the registries name and that are not computed here.
_ELSEWHERE = re.compile(
    r"(NSW|SEZ|PQW|EQW|ENU|NED|LTP|GRC|GRCS|EFG|FIXED|FK4|DTRF(19|20)?\d\d|UVWGO|UVW|ECI|ECEF|ECF|INERTIAL"
    r"|ALIGN(CB|EARTH)|FIXED(CB|EARTH|MOON)?|(MOE|TOE|TEME?OE|TEMEOFEPOCH|TRUEOFEPOCH|MEANOFEPOCH)"
    r"|(MOD|TOD|MOE|TOE)(CB|MOON)|MOON(ME|MEIAUE|PA)\w*|MCI|MEIAU\w*|PALUN\w*|LVLHMOON)"
)
# Names of axes of spacecraft and their parts in the registry, with or without a number.
_OF_BODIES = re.compile(
    r"(ACC|ACTUATOR|AST|CSS|DSS|ESA|GYRO(FRAME)?|IMU(FRAME)?|INSTRUMENT|MTA|RW|SA|SC(BODY)?"
    r"|SENSOR|STARTRACKER|TAM|SCFRAME)\w{0,4}"
)
_ALIKE = 0.86


def normal(name: str) -> str:
    """A name in capital letters without hyphens, underscores and blanks."""
    return re.sub(r"[-_ ]", "", name).upper()


def meaning(name: str) -> tuple[str, bool] | None:
    """Kind of axes that a name means, and whether rates in them are relative to inertial space.

    None for other names.

    >>> meaning("LVLH_ROTATING"), meaning("ITRF-97"), meaning("SC_BODY_1")
    (('lvlh', False), ('itrf', False), None)
    """
    given = normal(name)
    if given in FIXED:
        return FIXED[given], False
    inertial = given.endswith("INERTIAL")
    given = given.removesuffix("INERTIAL").removesuffix("ROTATING")
    if re.fullmatch(r"ITRF(19|20)?\d\d", given):
        given = "ITRF"
    return (TURNING[given], inertial) if given in TURNING else None


def named_elsewhere(name: str) -> bool:
    """Whether a standard gives this name to axes that this package does not compute."""
    given = normal(name)
    stem = given.removesuffix("INERTIAL").removesuffix("ROTATING")
    return any(map(_ELSEWHERE.fullmatch, (given, stem)))


def looks_like(name: str) -> str | None:
    """The name of known axes of which another name is probably a misspelling, or None.

    >>> looks_like("LVLHX"), looks_like("EME200"), looks_like("SC_BODY_1"), looks_like("SPACECRAFT")
    ('LVLH', 'EME2000', None, None)
    """
    given = normal(name).removesuffix("INERTIAL").removesuffix("ROTATING")
    if _OF_BODIES.fullmatch(given):
        return None
    # Names of three letters differ by one letter from many.
    longer = [each for each in (*FIXED, *TURNING) if len(each) > 3]
    near = difflib.get_close_matches(given, longer, n=1, cutoff=_ALIKE)
    if not near:
        known = "|".join(sorted((*TURNING, *FIXED), key=len, reverse=True))
        found = re.fullmatch(rf"({known})(ROTATING|INERTIAL)?[A-Z0-9]?", given)
        near = [found.group(1)] if found and meaning(name) is None else []
    return near[0] if near else None
