"""CCSDS Attitude Ephemeris Messages, versions 1.0 and 2.0, KVN and XML, read and written.

>>> from attitude import Body, FreeRotation, Spin
>>> spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0.1))
>>> motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
>>> import os, tempfile
>>> with tempfile.TemporaryDirectory() as folder:
...     path = os.path.join(folder, "satellite.aem")
...     write(path, motion.at([0.0, 10.0, 20.0]), object_name="SATELLITE")
...     table = read(path)
>>> table.wxyz.shape, table.method, table.degree, table.epoch.utc_iso
((3, 4), 'hermite', 5, '2026-01-01T00:00:00')

Conventions: see `attitude_types`.  What is lost: nothing of the quaternions (written with 17
digits), half a picosecond of the epochs; the motion itself, of which this is a table.
"""

from attitude import quaternion
from attitude.errors import AttitudeError
from attitude.formats import sources
from attitude.formats.aem import kvn as aem_kvn
from attitude.formats.aem import xml as aem_xml
from attitude.formats.aem.message import VERSIONS, Options
from attitude.formats.aem.written import Written
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.rows import TOLERANCE
from attitude.textfiles import kvn
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import opened


def read(path, *, tolerance=TOLERANCE, frame=None, orbit=None):
    """A message as an AttitudeTable.

    Parameters
    ----------
    path : str or path
        KVN or XML, version 1.0 or 2.0; which of them, the file tells.
    tolerance : float
        How far from 1 the length of a quaternion may be; they are made unit.
    frame : str, optional
        Which axes the external frame of the file is, where its name is not known (see `axes`).
    orbit : path, optional
        The path of the body about its center, for attitudes relative to LVLH or RTN.

    Returns
    -------
    AttitudeTable
        Relative to ICRF; `meta` of it and of each of its segments holds keywords and comments.

    Raises
    ------
    AttitudeError
        With file, line and keyword, for anything that is wrong.
    """
    options = Options(tolerance, frame, orbit)
    with opened(path) as lines:
        first = kvn.first(lines)
        if first is not None:
            return aem_kvn.read(lines, first, options)
    return aem_xml.read(path, options)


def write(
    path,
    source,
    *,
    t=None,
    version="2.0",
    xml=False,
    kind=None,
    frame=None,
    time_system=None,
    rates_over="body",
    sequence="ZXZ",
    scalar_first=False,
    object_name=None,
    object_id=None,
    center=None,
    body_frame=None,
    originator="ATTITUDE",
    comments=None,
    method=None,
    degree=None,
    creation_date=None,
    digits=ccsds_epochs.DIGITS,
    orbit=None,
):
    """Write attitudes as an AEM.

    Parameters
    ----------
    path : str or path
        Appears when it is complete, and not at all if something goes wrong.
    source : AttitudeHistory, AttitudeTable, a list of them (segments), or a motion with `t`
        A motion is evaluated piece by piece, so that long histories need no memory.
    version : str
        "2.0", or "1.0" (what GMAT and others read).
    xml : bool
        XML instead of KVN.
    kind : str, optional
        The attitude type, by its name in version 2: "QUATERNION/ANGVEL" by default, "QUATERNION"
        for tables without angular velocities.
    frame : str
        The external axes, "ICRF" by default or what a table came in; see `axes`.
    time_system : str
        "UTC" by default, or TAI, TT, TDB, GPS.
    rates_over : str
        "body" or "frame": the axes of angular velocities.
    sequence : str
        Of Euler angles.
    scalar_first : bool
        Version 1.0: QC before Q1, Q2, Q3.
    method, degree : str, int
        What is recommended for interpolation; by default what a table has, or else Hermite or
        Lagrange of degree 7, less where records are few.
    creation_date : str, optional
        Now, in UTC, by default.
    digits : int
        Decimals of the seconds.
    orbit : path, optional
        For LVLH and RTN.
    """
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; AEM has {' and '.join(VERSIONS)}.")
    parts = sources.segments(source, t)
    given = parts[0].meta
    settings = {
        "version": version,
        "kind": kind,
        "frame": frame,
        "time_system": time_system,
        "rates_over": rates_over,
        "sequence": quaternion.known_sequence(sequence).upper(),
        "scalar_first": scalar_first,
        "digits": digits,
        "orbit": orbit,
        "method": method,
        "degree": degree,
        "names": (object_name, object_id, center, body_frame),
    }
    written = [Written(part, settings) for part in parts]
    header = {
        "CREATION_DATE": creation_date or ccsds_epochs.now(),
        "ORIGINATOR": originator,
    }
    comments = list(given.get("comments", ()) if comments is None else comments)
    for text in (*header.values(), *comments):
        kvn.refuse_line_breaks(text)
    notation = aem_xml if xml else aem_kvn
    with written_whole(path, "the AEM") as file:
        notation.write_message(file, version, header, comments, written)
