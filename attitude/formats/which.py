"""Which format a file has, by what is in it or by its ending; reading and writing any of them."""

import os

from attitude.errors import AttitudeError
from attitude.formats.lines import unreadable

# Ending -> format, for writing, and for reading where the content does not tell.
ENDINGS = {
    ".aem": "aem",
    ".xml": "aem-xml",
    ".apm": "apm",
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
OF_MOTIONS = ("apm", "spin", "damit")
_SNIFFED = 4096


def of_file(path):
    """The format of a file that is there: one of the values of ENDINGS, or "apm-xml".

    Raises
    ------
    AttitudeError
        Where neither content nor ending tells.
    """
    try:
        with open(path, "rb") as file:
            start = file.read(_SNIFFED)
    except OSError as err:
        raise unreadable(path, err) from err
    text = start.lstrip(b"\xef\xbb\xbf \t\r\n")
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
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending in ENDINGS:
        return ENDINGS[ending]
    if len(text.split(b"\n")[0].split()) == 3:
        return "damit"
    raise AttitudeError(
        f"{os.fspath(path)!r} is in no format that is known: neither its content nor its ending "
        f"tells. Known endings are {', '.join(ENDINGS)}."
    )


def to_write(path):
    """The format that the ending of a file asks for."""
    ending = os.path.splitext(os.fspath(path))[1].lower()
    if ending not in ENDINGS:
        raise AttitudeError(
            f"{os.fspath(path)!r} ends in {ending!r}, which tells no format; endings are "
            f"{', '.join(ENDINGS)}."
        )
    return ENDINGS[ending]


def read(path, *, tolerance=None, frame=None, orbit=None, body=None, kernels=()):
    """A file in any format, as something with ``.at(t)``.

    Parameters
    ----------
    tolerance, frame, orbit
        As of `aem.read`.
    body : str
        The frame to be read out of a C-kernel.
    kernels : paths
        Others that a C-kernel needs; x.tf and x.tsc beside it are found.

    Returns
    -------
    AttitudeTable, FreeRotation or KernelAttitude
    """
    kind = of_file(path)
    ways = {"frame": frame, "orbit": orbit}
    if tolerance is not None:
        ways["tolerance"] = tolerance
    if kind in ("aem", "aem-xml"):
        from attitude.formats import aem

        return aem.read(path, **ways)
    if kind in ("apm", "apm-xml"):
        from attitude.formats import apm

        return apm.read(path, **ways).motion
    if kind == "stk":
        from attitude.formats import stk

        return stk.read(path, **ways)
    if kind == "spin":
        from attitude.formats import spin_file

        return spin_file.read(path).motion
    if kind == "damit":
        from attitude.formats import damit

        return damit.read(path).motion()
    if kind == "ck":
        return _kernel(path, body, kernels)
    from attitude.formats import tables

    return tables.read(path)


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
    elif kind == "apm":
        from attitude.formats import apm

        apm.write(path, motion, **settings)
    elif kind == "damit":
        from attitude.formats import damit

        damit.write(path, motion, **settings)
    else:
        raise AttitudeError(
            f"{os.fspath(path)!r} holds attitudes at epochs and no motion; see write."
        )
