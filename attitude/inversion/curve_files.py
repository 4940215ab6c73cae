"""Light curves with geometry, for the inversion, from any file that `photometry.read` reads."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from attitude.errors import AttitudeError
from attitude.photometry import files
from attitude.physical_constants import ASTRONOMICAL_UNIT_M

if TYPE_CHECKING:
    from attitude.annotations import FilePath
    from attitude.photometry.contents import Contents

_PLACES = ("sun", "observer", "frame")


def columns(path: FilePath, given: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Keywords of `LightCurve` from a file, replaced by those given, and the notes of the file.

    Raises
    ------
    AttitudeError
        For a file that cannot be read, one without epochs or brightness, rows that cannot be used
        (it names them), and dates of light at the barycenter or the Sun.
    """
    found = files.opened(path, bad="refuse")
    if found.time_of in ("barycenter", "heliocenter"):
        raise AttitudeError(
            f"{found.name}: its dates are those of light at the {found.time_of}; give dates at the "
            "observer, or photometry.read(file).reduced(path), which converts them."
        )
    keywords = found.keywords()
    keywords.pop("site", None)
    if any(each in given for each in ("scene", "path", "sun", "observer")):
        for key in _PLACES:
            keywords.pop(key, None)
    elif "frame" in keywords:  # of the file, whatever the frame of other files
        given = {key: each for key, each in given.items() if key != "frame"}
    if found.time_of == "emission":
        keywords["light_time"] = False
    if found.unit_distances:
        _dim(keywords, found)
    name = os.path.splitext(os.path.basename(found.name))[0]
    return {"name": name, **keywords, **given}, found.notes


def _dim(keywords: dict[str, Any], found: Contents) -> None:
    """Brightness at unit distances as apparent brightness, which `LightCurve` takes."""
    import numpy as np

    if not {"sun", "observer"} <= keywords.keys():
        raise AttitudeError(
            f"{found.name}: holds brightness at 1 au, and no vectors to Sun and observer; give a "
            "file of apparent brightness."
        )
    size = [np.linalg.norm(keywords[key], axis=1) / ASTRONOMICAL_UNIT_M for key in _PLACES[:2]]
    if found.is_flux:
        keywords["flux"] = keywords["flux"] / (size[0] * size[1]) ** 2
        if "sigma" in keywords:
            keywords["sigma"] = keywords["sigma"] / (size[0] * size[1]) ** 2
    else:
        keywords["magnitude"] = keywords["magnitude"] + 5.0 * np.log10(size[0] * size[1])
