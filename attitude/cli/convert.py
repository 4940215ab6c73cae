"""``attitude convert IN OUT``: between any two formats of attitudes and motions."""

import os
from contextlib import ExitStack

from attitude.cli import orbit
from attitude.errors import AttitudeError

HELP = "convert between spin files, CCSDS AEM and APM, STK, SPICE CK and tables"
EPILOG = """\
examples:
  attitude convert toutatis.toml toutatis.aem --stop "30 d" --step "1 h"
  attitude convert satellite.xml satellite.ecsv
  attitude convert satellite.aem satellite.toml --fit
  attitude convert tumbler.toml tumbler.bc --stop "2 d" --tolerance 1e-9
  attitude convert relative-to-lvlh.aem inertial.aem --frame ICRF --orbit satellite.oem
  attitude convert tumbler.bc tumbler.csv --start 2026-01-01 --stop 2026-01-02 --step "1 min"

endings that OUT may have:
  .toml  spin file, exact     .aem      CCSDS AEM        .a     STK attitude
  .apm   CCSDS APM            .xml      CCSDS AEM, XML   .bc    SPICE CK with .tf and .tsc
  .spin  DAMIT                .apm.xml  CCSDS APM, XML   .ecsv .fits .csv .parquet  tables

The format of IN is told by what is in it. A table goes into a table as it is; with --step it is
interpolated, and a motion is evaluated. A table becomes a motion with --fit. A C-kernel is asked
at the epochs of --start, --stop and --step.
"""
# Formats whose attitudes may be relative to axes of an orbit.
_WITH_AXES = ("aem", "aem-xml", "apm", "apm-xml", "stk")


def add_arguments(parser):
    parser.add_argument("input", metavar="IN", help="file to read")
    parser.add_argument("output", metavar="OUT", help="file to write; appears whole or not at all")
    parser.add_argument("--start", metavar="TIME", help="date (UTC), or time after the epoch of IN")
    parser.add_argument("--stop", metavar="TIME", help="likewise; included")
    parser.add_argument("--step", metavar="TIME", help='time between records, such as "10 s"')
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="RAD",
        help="of a C-kernel between its records (default 1e-9); of the length of quaternions read",
    )
    parser.add_argument("--version", metavar="1.0|2.0", help="of CCSDS messages (default 2.0)")
    parser.add_argument("--type", metavar="NAME", help="attitude type of an AEM, section of STK")
    parser.add_argument("--frame", metavar="NAME", help="axes of OUT, such as ICRF or EME2000")
    parser.add_argument(
        "--time-system", metavar="NAME", help="of CCSDS messages: UTC, TAI, TDB, .."
    )
    orbit.add_arguments(parser)
    parser.add_argument("--fit", action="store_true", help="fit a free rotation to the table IN")
    parser.add_argument(
        "--body", metavar="FRAME", help="frame to read out of a C-kernel, or its name to write"
    )
    parser.add_argument(
        "--kernels",
        nargs="+",
        default=(),
        metavar="FILE",
        help="others that the C-kernel IN needs; x.tf and x.tsc beside it are found",
    )


def run(arguments):
    from attitude.formats import detect

    wanted = detect.to_write(arguments.output)
    # The tolerance of lengths is for files of attitudes; of a C-kernel that is written, not.
    tolerance = None if wanted == "ck" else arguments.tolerance
    path = orbit.path_of(arguments)
    if path is not None and {wanted, detect.of_file(arguments.input)}.isdisjoint(_WITH_AXES):
        raise AttitudeError(
            "--orbit is for AEM, APM and STK files, whose attitudes may be relative to axes of the "
            "orbit; leave it out."
        )
    reading = {"body": arguments.body, "kernels": arguments.kernels, "orbit": path}
    found = detect.opened(arguments.input, tolerance=tolerance, **reading)
    with ExitStack() as stack:
        stack.enter_context(found.motion)  # a C-kernel is unloaded at the end
        _convert(arguments, wanted, found, path)


def _convert(arguments, wanted, found, path):
    from attitude.formats import detect

    motion = _fitted(arguments, found.motion) if arguments.fit else found.motion
    if wanted in detect.OF_MOTIONS:
        _write_motion(arguments, wanted, motion, found.said)
    elif wanted == "ck":
        _write_kernel(arguments, motion)
    else:
        records = _records(arguments, motion)
        if _is_motion(motion):
            records.meta.update(_names(found.said))
        detect.write(arguments.output, records, **_settings(arguments, wanted, path))


def _is_motion(source):
    from attitude.free_rotation.free_rotation import FreeRotation

    return isinstance(source, FreeRotation)


def _is_table(source):
    from attitude.attitude_table.table import AttitudeTable

    return isinstance(source, AttitudeTable)


def _fitted(arguments, source):
    from attitude.fitting import fit

    if _is_motion(source):
        raise AttitudeError("--fit wants a table of attitudes; IN is a motion already.")
    found = fit(source if _is_table(source) else _sampled(arguments, source))
    print(f"rms of the residuals: {found.rms:.3g} rad")
    return found.motion


def _sampled(arguments, source):
    """A table of what a C-kernel holds at the epochs that were asked for."""
    from attitude.attitude_table.table import AttitudeTable

    records = _records(arguments, source)
    history = source.at(records.seconds, records.low)
    return AttitudeTable.from_history(history, rates=records.has_rates)


# Writing: what is taken of the options ------------------------------------------------------------


def _write_motion(arguments, wanted, motion, said):
    from attitude.formats import detect

    sampled = () if arguments.fit else ("start", "stop", "step")
    _refuse(arguments, (*sampled, "type"), f"a file like {arguments.output}")
    if not _is_motion(motion):
        raise AttitudeError(
            f"{arguments.output} holds a motion, and {arguments.input} attitudes at epochs; give "
            "--fit to find the free rotation that comes closest."
        )
    if wanted in ("apm", "apm-xml"):
        settings = {"frame": arguments.frame, "version": arguments.version or "2.0"}
        settings["time_system"] = arguments.time_system or "UTC"
        settings["inertia"] = not motion.body.relative
        settings |= _names(said)
    else:
        _refuse(arguments, ("version", "frame", "time_system"), f"a file like {arguments.output}")
        settings = _labels(said) if wanted == "spin" else {}
    detect.write_motion(arguments.output, motion, **settings)


def _names(said):
    """What messages and tables say of the object, of what IN says."""
    names = {key: said[key] for key in ("object_name", "object_id", "center") if said.get(key)}
    if said.get("name"):
        names["object_name"] = said["name"]
    lines = [line for key in ("source", "note") for line in (said.get(key) or "").splitlines()]
    lines = [" ".join(line.split()) for line in lines if line.strip()]
    comments = [*said.get("comments", ()), *lines]
    return names | ({"comments": tuple(comments)} if comments else {})


def _labels(said):
    """The labels of a spin file, of what IN says."""
    name = said.get("name") or said.get("object_name")
    note = said.get("note") or " ".join(said.get("comments", ()))
    labels = {"name": name if name != "UNKNOWN" else None, "source": said.get("source")}
    return {key: text for key, text in (labels | {"note": note}).items() if text}


def _write_kernel(arguments, source):
    from attitude.formats import ck

    if not _is_motion(source) and not _is_table(source):
        source = _sampled(arguments, source)
        _refuse(arguments, ("version", "type", "frame", "time_system"), "a C-kernel")
        ends = source.span
    else:
        _refuse(arguments, ("step", "version", "type", "frame", "time_system"), "a C-kernel")
        ends = [_moment(source, text) for text in _ends(arguments, source)]
    made = ck.write(
        arguments.output,
        source,
        *ends,
        tolerance=1e-9 if arguments.tolerance is None else arguments.tolerance,
        name=arguments.body or "TUMBLER",
    )
    print(
        f"{', '.join(os.path.basename(name) for name in made.kernels)}: error {made.error:.2g} rad"
    )


def _records(arguments, source):
    """What is written: the records of a table, or some of a motion."""
    from attitude.formats.sources import Records

    if _is_table(source) and arguments.step is None:
        _refuse(arguments, ("start", "stop"), "records as they are, without --step")
        return source
    if arguments.step is None:
        options = "--step and --stop" if _is_motion(source) else "--start, --stop and --step"
        raise AttitudeError(f"{arguments.output} is made of attitudes at epochs; give {options}.")
    start, stop = _ends(arguments, source)
    epochs = _epochs(source, start, stop, arguments.step)
    hi, lo = epochs.block(0, epochs.count)
    return Records(source, _epoch_of(source), hi, lo)


def _epoch_of(source):
    """The epoch from which plain seconds of a source count."""
    return source.spin.epoch if _is_motion(source) else source.epoch


def _ends(arguments, source):
    """--start and --stop as texts, by default the span of a table."""
    start, stop = arguments.start, arguments.stop
    if _is_table(source):
        epoch = source.epoch
        seconds = [
            repr((end.seconds - epoch.seconds) + (end.low - epoch.low)) for end in source.span
        ]
        start, stop = start or seconds[0], stop or seconds[1]
    if stop is None or (start is None and not _is_motion(source)):
        raise AttitudeError(f"{arguments.input} has no end of its own; give --start and --stop.")
    return start or "0", stop


def _epochs(source, start, stop, step):
    from attitude.cli.grid import grid

    return grid(_epoch_of(source), start, stop, step)


def _moment(source, text):
    """The Instant of a date, or of a time after the epoch of IN."""
    return _epochs(source, text, text, "1").start


def _settings(arguments, wanted, path):
    """What the writer is told."""
    settings = {}
    if wanted in ("aem", "aem-xml"):
        settings = {"version": arguments.version or "2.0", "kind": arguments.type}
        settings |= {"frame": arguments.frame, "time_system": arguments.time_system}
        settings["orbit"] = path
    elif wanted == "stk":
        _refuse(arguments, ("version", "time_system"), "an STK file")
        settings = {"section": arguments.type, "frame": arguments.frame or "ICRF", "orbit": path}
    else:
        _refuse(arguments, ("version", "time_system", "frame", "type"), "a table")
    return settings


def _refuse(arguments, names, what):
    for name in names:
        if getattr(arguments, name) is not None:
            raise AttitudeError(
                f"--{name.replace('_', '-')} has no meaning for {what}; leave it out."
            )
