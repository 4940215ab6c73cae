"""Which format a file has, by what is in it or by its ending; reading and writing any of them."""

import os
from typing import NamedTuple

from attitude.errors import AttitudeError
from attitude.textfiles.lines import beginning

# Ending -> format, for writing, and for reading where the content does not tell.
ENDINGS = {
    ".aem": "aem",
    ".xml": "aem-xml",
    ".apm": "apm",
    ".apm.xml": "apm-xml",
    ".a": "stk",
    ".toml": "spin",
    ".spin": "damit",
    ".bc": "ck",
    ".ecsv": "table",
    ".fits": "table",
    ".fit": "table",
    ".csv": "table",
    ".parquet": "table",
}
# Formats that hold a motion, and not attitudes at epochs.
OF_MOTIONS = ("apm", "apm-xml", "spin", "damit")


def of_file(path):
    """The format of a file that is there: one of the values of ENDINGS.

    Raises
    ------
    AttitudeError
        Where neither content nor ending tells.
    """
    text = beginning(path)
    for mark, found in (
        (b"CCSDS_AEM_VERS", "aem"),
        (b"CCSDS_APM_VERS", "apm"),
        (b"stk.v.", "stk"),
        (b"DAF/CK", "ck"),
    ):
        if text.startswith(mark):
            return found
    if text.startswith(b"<"):
        return "apm-xml" if b"<apm" in text else "aem-xml"
    if _ending(path) in ENDINGS:
        return ENDINGS[_ending(path)]
    if len(text.split(b"\n")[0].split()) == 3:
        return "damit"
    raise AttitudeError(
        f"{os.fspath(path)!r} is in no format that is known: neither its content nor its ending "
        f"tells. Known endings are {', '.join(ENDINGS)}."
    )


def to_write(path):
    """The format that the ending of a file asks for."""
    ending = _ending(path)
    if ending not in ENDINGS:
        raise AttitudeError(
            f"{os.fspath(path)!r} ends in {ending!r}, which tells no format; endings are "
            f"{', '.join(ENDINGS)}."
        )
    return ENDINGS[ending]


def _ending(path):
    name = os.path.basename(os.fspath(path)).lower()
    return ".apm.xml" if name.endswith(".apm.xml") else os.path.splitext(name)[1]


class Source(NamedTuple):
    """What was read, with ``.at(t)``, and what else its file says: names, comments, notes."""

    motion: object
    said: dict


def read(path, **how):
    """A file in any format, as something with ``.at(t)``; see `opened` for the arguments.

    Returns
    -------
    AttitudeTable, FreeRotation or KernelAttitude
        The last of these is to be closed.
    """
    return opened(path, **how).motion


def opened(path, *, tolerance=None, frame=None, orbit=None, body=None, kernels=()):
    """A file in any format, as a `Source`.

    Parameters
    ----------
    tolerance, frame, orbit
        As of `aem.read`.
    body : str
        The frame to be read out of a C-kernel.
    kernels : paths
        Others that a C-kernel needs; x.tf and x.tsc beside it are found.
    """
    kind = of_file(path)
    lengths = {} if tolerance is None else {"tolerance": tolerance}
    ways = {"frame": frame, "orbit": orbit, **lengths}
    if kind in ("aem", "aem-xml"):
        from attitude.formats import aem

        return _table(aem.read(path, **ways))
    if kind in ("apm", "apm-xml"):
        from attitude.formats import apm

        found = apm.read(path, **ways)
        names = ("object_name", "object_id", "center", "comments")
        return Source(found.motion, {name: found.meta[name] for name in names})
    if kind == "stk":
        from attitude.formats import stk

        return _table(stk.read(path, **ways))
    if kind == "spin":
        from attitude.formats import spin_file

        found = spin_file.read(path)
        return Source(
            found.motion, {name: getattr(found, name) for name in ("name", "source", "note")}
        )
    if kind == "damit":
        from attitude.formats import damit

        found = damit.read(path)
        return Source(found.motion(), {"scattering": found.scattering})
    if kind == "ck":
        return Source(_kernel(path, body, kernels), {})
    from attitude.formats import tables

    return _table(tables.read(path, **lengths))


def _table(table):
    names = ("object_name", "object_id", "center", "comments")
    return Source(table, {name: table.meta[name] for name in names if table.meta.get(name)})


def _kernel(path, body, kernels):
    from attitude.formats import ck

    stem = os.path.splitext(os.fspath(path))[0]
    beside = [stem + ending for ending in (".tf", ".tsc") if os.path.exists(stem + ending)]
    if body is None:
        body = "TUMBLER"
    return ck.KernelAttitude([path, *beside, *kernels], body)


def write(path, source, *, t=None, **settings):
    """Write attitudes at epochs in the format of the ending; settings go to its writer."""
    kind = to_write(path)
    if kind in ("aem", "aem-xml"):
        from attitude.formats import aem

        aem.write(path, source, t=t, xml=kind == "aem-xml", **settings)
    elif kind == "stk":
        from attitude.formats import stk

        stk.write(path, source, t=t, **settings)
    elif kind == "table":
        from attitude.formats import tables

        tables.write(path, source, t=t, **settings)
    else:
        raise AttitudeError(
            f"{os.fspath(path)!r} holds a motion and no attitudes at epochs; see write_motion."
        )


def write_motion(path, motion, **settings):
    """Write a FreeRotation: as a spin file (.toml, exact), an APM (.apm), a DAMIT file (.spin)."""
    kind = to_write(path)
    if kind == "spin":
        from attitude.formats import spin_file

        spin_file.write(path, motion, **settings)
    elif kind in ("apm", "apm-xml"):
        from attitude.formats import apm

        apm.write(path, motion, xml=kind == "apm-xml", **settings)
    elif kind == "damit":
        from attitude.formats import damit

        damit.write(path, motion, **settings)
    else:
        raise AttitudeError(
            f"{os.fspath(path)!r} holds attitudes at epochs and no motion; see write."
        )
