"""``attitude convert IN OUT``: between any two formats of attitudes and motions."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from attitude.cli import _options
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from typing import TypeGuard

    from attitude.cli._options import Grid
    from attitude.epochs._instants import Instant
    from attitude.formats.detect import OpenedFile
    from attitude.motions._free_rotation import FreeRotation
    from attitude.motions._motion import Motion
    from attitude.motions._table import AttitudeTable
    from attitude.paths._path import Path

__all__ = ["EPILOG", "HELP", "add_arguments", "run"]


# ---- The options of ``attitude convert``

HELP: str = "convert between spin files, CCSDS AEM, APM and ACM, STK, SPICE CK and tables"
EPILOG: str = """\
examples:
  attitude convert tumbler.toml tumbler.aem --stop "1 d" --tolerance 1e-7
  attitude convert toutatis.toml toutatis.aem --stop "30 d" --step "1 h"
  attitude convert "4179 Toutatis" toutatis.aem --stop "30 d" --step "1 h"
  attitude convert satellite.xml satellite.ecsv
  attitude convert satellite.aem satellite.toml --fit
  attitude convert tumbler.toml tumbler.bc --stop "2 d" --tolerance 1e-9
  attitude convert relative-to-lvlh.aem inertial.aem --frame ICRF --orbit satellite.oem
  attitude convert satellite.toml satellite.aem --for gmat --stop "1 h" --step "1 s"
  attitude convert tumbler.bc tumbler.csv --start 2026-01-01 --stop 2026-01-02 --step "1 min"

endings that OUT may have:
  .toml  spin file, exact     .aem      CCSDS AEM        .a     STK attitude
  .apm   CCSDS APM            .xml      CCSDS AEM, XML   .bc    SPICE CK with .tf and .tsc
  .acm   CCSDS ACM            .apm.xml  CCSDS APM, XML   .ecsv .fits .csv .parquet  tables
  .spin  DAMIT                .acm.xml  CCSDS ACM, XML   .cic   CIC of CNES, for VTS

The format of IN follows from its contents. A table is written record by record, or interpolated at
--start, --stop and --step; motions and C-kernels are evaluated there. --fit turns a table into a
motion.
"""
# Largest rms, rad, of the residuals of a fit that is accepted without --rms.
MOST_RMS: float = 0.01


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("input", metavar="IN", help="file to read, or a name in the catalogue")
    parser.add_argument("output", metavar="OUT", help="file to write; appears whole or not at all")
    parser.add_argument("--start", metavar="TIME", help="date (UTC), or time after the epoch of IN")
    parser.add_argument("--stop", metavar="TIME", help="last epoch, as --start")
    parser.add_argument("--step", metavar="TIME", help='time between records, such as "10 s"')
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="RAD",
        help="largest error between the records of OUT, from which the step follows (of a C-kernel "
        "1e-9 by default); of a table IN, and with --step, of the length of quaternions read",
    )
    parser.add_argument("--version", metavar="1.0|2.0", help="of CCSDS messages (default 2.0)")
    parser.add_argument("--type", metavar="NAME", help="attitude type of an AEM, section of STK")
    parser.add_argument("--frame", metavar="NAME", help="axes of OUT, such as ICRF or EME2000")
    parser.add_argument(
        "--time-system", metavar="NAME", help="of CCSDS messages: UTC, TAI, TDB, .."
    )
    _add_messages(parser)
    _options.add_orbit_arguments(parser)
    _add_fits_and_kernels(parser)


def _add_messages(parser: argparse.ArgumentParser) -> None:
    """Options of CCSDS messages."""
    parser.add_argument(
        "--for",
        dest="tool",
        metavar="TOOL",
        help="settings of an AEM that a tool accepts: gmat, orekit, stk or brahe",
    )
    parser.add_argument(
        "--rates",
        choices=("body", "euler"),
        help="what the rates of AEM and APM 1.0 are, read or written: angular velocity, or "
        "derivatives of the Euler angles",
    )
    parser.add_argument(
        "--object", metavar="NAME", help="OBJECT_ID or OBJECT_NAME of the segments of IN to read"
    )
    parser.add_argument(
        "--segment", type=int, metavar="N", help="the one segment of IN to read, counted from 0"
    )
    parser.add_argument(
        "--lenient",
        action="store_true",
        help="read an AEM that leaves out parts of the standard; prints what was assumed",
    )


def _add_fits_and_kernels(parser: argparse.ArgumentParser) -> None:
    """Options of fits and of C-kernels."""
    parser.add_argument(
        "--split",
        action="store_true",
        help="STK: a file x-1.a, x-2.a, ... for each stretch between impulses or gaps",
    )
    parser.add_argument("--fit", action="store_true", help="fit a free rotation to the table IN")
    parser.add_argument(
        "--axes",
        choices=("principal", "free"),
        help="with --fit: whether the body axes are principal axes; by default both are tried",
    )
    parser.add_argument(
        "--rms",
        type=float,
        metavar="RAD",
        help=f"with --fit: largest rms of the residuals that is accepted (default {MOST_RMS})",
    )
    parser.add_argument(
        "--method",
        choices=("hermite", "lagrange", "linear"),
        help="interpolation that an AEM states, or of a C-kernel (hermite or linear)",
    )
    parser.add_argument(
        "--rate-tolerance", type=float, metavar="RAD/S", help="largest error of rates of a C-kernel"
    )
    parser.add_argument(
        "--clock",
        nargs="+",
        metavar="FILE",
        help="clock kernel of a mission (and its leap seconds) for a C-kernel",
    )
    parser.add_argument(
        "--frame-kernel", metavar="FILE", help="frame kernel of a mission that defines --body"
    )
    parser.add_argument(
        "--time-scale",
        choices=("tdb", "spice"),
        help="of a C-kernel: exact at TDB, or at the epochs that SPICE makes of dates",
    )
    parser.add_argument(
        "--body", metavar="FRAME", help="frame of a C-kernel: the one to read, or the one to write"
    )
    parser.add_argument(
        "--kernels",
        nargs="+",
        default=(),
        metavar="FILE",
        help="further kernels that the C-kernel IN needs; x.tf and x.tsc beside x.bc are found",
    )


# Ratio of the rms of two fits from which the principal axes are fitted too.
_BETTER = 0.9
# Options of C-kernels.
_OF_KERNELS = ("rate_tolerance", "clock", "frame_kernel", "time_scale")
# Formats whose attitudes may be relative to axes of an orbit.
_WITH_AXES = ("acm", "acm-xml", "aem", "aem-xml", "apm", "apm-xml", "cic", "stk")


def run(arguments: argparse.Namespace) -> None:
    """Read IN and write OUT."""
    from attitude.formats import detect

    kind = detect.to_write(arguments.output)
    # The tolerance of a C-kernel, or of a motion that is sampled, is not that of lengths read.
    read = _kind_read(arguments.input)
    of_motion = read in (*detect.OF_MOTIONS, "ck")
    sampled = kind == "ck" or ((of_motion or arguments.fit) and arguments.step is None)
    tolerance = None if sampled else arguments.tolerance
    path = _options.path_of(arguments)
    if path is not None and {kind, read}.isdisjoint(_WITH_AXES):
        raise AttitudeError(
            "--orbit is for AEM, APM, CIC and STK files, whose attitudes may be relative to axes "
            "of the orbit; leave it out."
        )
    found = _catalogued(arguments.input) or detect.opened(
        arguments.input,
        tolerance=tolerance,
        body=arguments.body,
        kernels=arguments.kernels,
        orbit=path,
        rates=arguments.rates,
        object=arguments.object,
        segment=arguments.segment,
        lenient=arguments.lenient,
    )
    for text in found.motion.meta.get("assumed", ()):
        print(f"{arguments.input}: assumed: {text}")
    with ExitStack() as stack:
        stack.enter_context(found.motion)  # a C-kernel is unloaded at the end
        _convert(arguments, kind, found, path)


def _kind_read(name: str) -> str:
    """The format of IN; an entry of the catalogue is as a spin file."""
    from attitude.formats import detect

    return "spin" if _is_catalogued(name) else detect.of_file(name)


def _is_catalogued(name: str) -> bool:
    from attitude import catalog
    from attitude.cli import _options

    return not _options.is_file(name) and catalog.has(name)


def _catalogued(name: str) -> OpenedFile | None:
    """The motion of an entry of the catalogue with its labels; None for a file."""
    if not _is_catalogued(name):
        return None
    from attitude import catalog
    from attitude.formats.detect import OpenedFile

    entry = catalog.entry(name)
    labels = {"name": entry.name, "source": "; ".join(entry.sources), "note": entry.note}
    return OpenedFile(entry.motion(), labels)


def _convert(
    arguments: argparse.Namespace, kind: str, found: OpenedFile, path: Path | None
) -> None:
    """Write what was read, as the format `kind`."""
    from attitude.formats import detect

    if not arguments.fit:
        _refuse(arguments, ("axes", "rms"), "a conversion without --fit")
    if kind != "ck":
        _refuse(arguments, _OF_KERNELS, f"a file like {arguments.output}")
    if arguments.split and kind != "stk":
        raise AttitudeError(f"--split is for STK files, not {arguments.output}; leave it out.")
    if kind not in ("ck", "aem", "aem-xml"):
        _refuse(arguments, ("method",), f"a file like {arguments.output}")
    motion = _fitted(arguments, found.motion) if arguments.fit else found.motion
    if kind in detect.OF_MOTIONS:
        _write_motion(arguments, kind, motion, found.said)
    elif kind == "ck":
        _write_kernel(arguments, motion)
    else:
        if _by_tolerance(arguments, found.motion):
            _write_sampled(arguments, kind, motion, found.said, path)
            return
        records = _records(arguments, motion)
        if _is_free_rotation(motion):
            records.meta.update(_names(found.said))
        detect.write(arguments.output, records, **_settings(arguments, kind, path))


def _by_tolerance(arguments: argparse.Namespace, read: Motion) -> bool:
    """Whether --tolerance is that of the attitudes between records, and not of lengths read."""
    from attitude.formats import detect

    acm = detect.to_write(arguments.output) in ("acm", "acm-xml")
    given = arguments.tolerance is not None and arguments.step is None and not acm
    return given and (arguments.fit or not _is_table(read))


def _write_sampled(
    arguments: argparse.Namespace,
    kind: str,
    motion: Motion,
    labels: Mapping[str, Any],
    path: Path | None,
) -> None:
    """Write a motion with the step that --tolerance needs; prints the step and the error."""
    from attitude.formats import detect

    start, stop = _ends(arguments, motion)
    settings = _settings(arguments, kind, path)
    if kind in ("aem", "aem-xml", "cic"):
        settings |= _names(labels)
        if kind == "cic":
            settings.pop("center", None)
    made = detect.write(
        arguments.output,
        motion,
        start=_moment(motion, start),
        stop=_moment(motion, stop),
        tolerance=arguments.tolerance,
        **settings,
    )
    assert made is not None
    print(
        f"{made.records} records at most {made.step:.4g} s apart in {made.segments} "
        f"segment{'s' if made.segments > 1 else ''}: error {made.error:.2g} rad"
    )


def _is_free_rotation(source: Motion) -> TypeGuard[FreeRotation]:
    from attitude.motions._free_rotation import FreeRotation

    return isinstance(source, FreeRotation)


def _is_table(source: Motion) -> TypeGuard[AttitudeTable]:
    from attitude.motions._table import AttitudeTable

    return isinstance(source, AttitudeTable)


def _fitted(arguments: argparse.Namespace, source: Motion) -> FreeRotation:
    """The free rotation fitted to IN; prints the rms of the residuals."""
    from attitude.fitting._attitudes import fit

    if _is_free_rotation(source):
        raise AttitudeError(
            "--fit fits a table of attitudes, but IN is a motion already; leave --fit out."
        )
    table = source if _is_table(source) else _sampled(arguments, source)
    found = fit(table, axes=arguments.axes or "principal")
    used = arguments.axes or "principal"
    if arguments.axes is None and len(table) > 3:
        free = fit(table, axes="free")
        if free.rms < _BETTER * found.rms:
            found, used = free, "free"
    print(f"rms of the residuals: {found.rms:.3g} rad, with {used} axes")
    most = MOST_RMS if arguments.rms is None else arguments.rms
    if not found.rms <= most:
        raise AttitudeError(
            f"the rms of the residuals is {found.rms:.3g} rad, more than {most:g}: the attitudes "
            f"of {arguments.input} are not those of a free rotation, or noisy; --rms accepts more."
        )
    return found.motion


def _sampled(arguments: argparse.Namespace, source: Motion) -> AttitudeTable:
    """A table of the attitudes of a C-kernel at the epochs of --start, --stop and --step."""
    from attitude.motions._table import AttitudeTable

    records = _records(arguments, source)
    history = source.at(records.seconds, records.low)
    return AttitudeTable.from_history(history, rates=records.has_rates)


# ---- Writing


def _write_motion(
    arguments: argparse.Namespace, kind: str, motion: Motion, labels: Mapping[str, Any]
) -> None:
    """Write a spin file, an APM or a DAMIT file."""
    from attitude.formats import detect

    sampled = () if arguments.fit else ("start", "stop", "step")
    _refuse(arguments, (*sampled, "type", "tool"), f"a file like {arguments.output}")
    if not _is_free_rotation(motion):
        raise AttitudeError(
            f"{arguments.output} holds a motion, and {arguments.input} attitudes at epochs; give "
            "--fit to fit a free rotation to them."
        )
    settings: dict[str, Any]
    if kind in ("apm", "apm-xml"):
        settings = {"frame": arguments.frame, "version": arguments.version or "2.0"}
        settings["time_system"] = arguments.time_system or "UTC"
        settings["inertia"] = not motion.body.relative
        settings["rates"] = arguments.rates if arguments.version == "1.0" else None
        settings |= _names(labels)
    else:
        _refuse(arguments, ("version", "frame", "time_system"), f"a file like {arguments.output}")
        settings = _spin_labels(labels) if kind == "spin" else {}
    detect.write_motion(arguments.output, motion, **settings)


def _names(labels: Mapping[str, Any]) -> dict[str, Any]:
    """The names and comments of messages and tables, from those of IN."""
    names = {key: labels[key] for key in ("object_name", "object_id", "center") if labels.get(key)}
    if labels.get("name"):
        names["object_name"] = labels["name"]
    lines = [line for key in ("source", "note") for line in (labels.get(key) or "").splitlines()]
    lines = [" ".join(line.split()) for line in lines if line.strip()]
    comments = [*labels.get("comments", ()), *lines]
    return names | ({"comments": tuple(comments)} if comments else {})


def _spin_labels(labels: Mapping[str, Any]) -> dict[str, str]:
    """The labels of a spin file, from the names and comments of IN."""
    name = labels.get("name") or labels.get("object_name")
    note = labels.get("note") or " ".join(labels.get("comments", ()))
    found = {"name": name if name != "UNKNOWN" else None, "source": labels.get("source")}
    return {key: text for key, text in (found | {"note": note}).items() if text}


def _write_kernel(arguments: argparse.Namespace, source: Motion) -> None:
    """Write a C-kernel; prints its files and its error."""
    from attitude.formats import ck

    others = ("version", "type", "frame", "time_system", "tool")
    settings: dict[str, Any] = {"time_scale": arguments.time_scale or "tdb"}
    settings["kind"] = 3 if arguments.method == "linear" else 5
    ends: Any = None, None
    if not _is_free_rotation(source) and not _is_table(source):
        source = _sampled(arguments, source)
        _refuse(arguments, others, "a C-kernel")
        ends = source.span
    else:
        _refuse(arguments, ("step", *others), "a C-kernel")
        asked = (arguments.start, arguments.stop, arguments.tolerance, arguments.method)
        if not _is_table(source) or any(each is not None for each in asked):
            start, stop = _ends(arguments, source)
            ends = _moment(source, start), _moment(source, stop)
    if arguments.clock is not None:
        settings["clock"] = arguments.clock
    made = ck.write(
        arguments.output,
        source,
        *ends,
        tolerance=1e-9 if arguments.tolerance is None else arguments.tolerance,
        rate_tolerance=arguments.rate_tolerance,
        name=arguments.body or "TUMBLER",
        frame_kernel=arguments.frame_kernel,
        **settings,
    )
    print(
        f"{', '.join(os.path.basename(name) for name in made.kernels)}: error {made.error:.2g} rad"
    )


def _records(arguments: argparse.Namespace, source: Motion) -> Any:
    """The records of a table, or `Records` of a motion at --start, --stop and --step."""
    from attitude.formats._sampling import Records

    if _is_table(source) and arguments.step is None:
        _refuse(arguments, ("start", "stop"), "records as they are, without --step")
        return source
    if arguments.step is None:
        free = _is_free_rotation(source)
        options = "--step and --stop" if free else "--start, --stop and --step"
        raise AttitudeError(f"{arguments.output} holds attitudes at epochs; give {options}.")
    start, stop = _ends(arguments, source)
    epochs = _epochs(source, start, stop, arguments.step)
    hi, lo = epochs.block(0, epochs.count)
    return Records(source, source.epoch, hi, lo)


def _ends(arguments: argparse.Namespace, source: Motion) -> tuple[str, str]:
    """--start and --stop as texts, by default the span of a table."""
    start, stop = arguments.start, arguments.stop
    if _is_table(source):
        epoch = source.epoch
        seconds = [
            repr((end.seconds - epoch.seconds) + (end.low - epoch.low)) for end in source.span
        ]
        start, stop = start or seconds[0], stop or seconds[1]
    if stop is None or (start is None and not _is_free_rotation(source)):
        raise AttitudeError(f"{arguments.input} has no span of its own; give --start and --stop.")
    return start or "0", stop


def _epochs(source: Motion, start: str, stop: str, step: str) -> Grid:
    from attitude.cli._options import grid

    return grid(source.epoch, start, stop, step)


def _moment(source: Motion, text: str) -> Instant:
    """The Instant of a date, or of a time after the epoch of IN."""
    return _epochs(source, text, text, "1").start


def _settings(arguments: argparse.Namespace, kind: str, path: Path | None) -> dict[str, Any]:
    """The keyword arguments of the writer."""
    settings: dict[str, Any] = {}
    if kind in ("aem", "aem-xml"):
        settings = {"version": arguments.version, "kind": arguments.type}
        settings |= {"for_": arguments.tool, "rates": arguments.rates}
        settings["method"] = arguments.method
        settings |= {"frame": arguments.frame, "time_system": arguments.time_system}
        settings["orbit"] = path
    elif kind in ("acm", "acm-xml"):
        _refuse(arguments, ("version", "type", "tool"), "an ACM")
        settings = {"frame": arguments.frame, "time_system": arguments.time_system, "orbit": path}
    elif kind == "cic":
        _refuse(arguments, ("version", "type", "tool"), "a CIC file")
        settings = {"frame": arguments.frame or "EME2000", "orbit": path}
        settings["time_system"] = arguments.time_system or "UTC"
    elif kind == "stk":
        _refuse(arguments, ("version", "time_system"), "an STK file")
        if arguments.tool not in (None, "stk"):
            raise AttitudeError(f"--for {arguments.tool} has no meaning for an STK file.")
        settings = {"section": arguments.type, "frame": arguments.frame or "ICRF", "orbit": path}
        settings["split"] = arguments.split
    else:
        _refuse(arguments, ("version", "time_system", "frame", "type", "tool"), "a table")
    return settings


def _refuse(arguments: argparse.Namespace, names: Iterable[str], what: str) -> None:
    """Raise the AttitudeError for the first given option of these, which `what` does not have."""
    for name in names:
        if getattr(arguments, name) is not None:
            option = "for" if name == "tool" else name.replace("_", "-")
            raise AttitudeError(f"--{option} has no meaning for {what}; leave it out.")
