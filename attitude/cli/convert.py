"""``attitude convert IN OUT``: between any two formats of attitudes and motions."""

import os

from attitude.errors import AttitudeError

HELP = "convert between spin files, CCSDS AEM and APM, STK, SPICE CK and tables"
EPILOG = """\
examples:
  attitude convert toutatis.toml toutatis.aem --stop "30 d" --step "1 h"
  attitude convert satellite.xml satellite.ecsv
  attitude convert satellite.aem satellite.toml --fit
  attitude convert tumbler.toml tumbler.bc --stop "2 d" --tolerance 1e-9

endings that OUT may have:
  .toml  spin file, exact     .aem  CCSDS AEM        .a     STK attitude
  .apm   CCSDS APM            .xml  CCSDS AEM, XML   .bc    SPICE CK with .tf and .tsc
  .spin  DAMIT                .ecsv .fits .csv .parquet     tables

The format of IN is told by what is in it. A table goes into a table as it is; with --step it is
interpolated, and a motion is evaluated. A table becomes a motion with --fit.
"""


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
    parser.add_argument("--fit", action="store_true", help="fit a free rotation to the table IN")
    parser.add_argument(
        "--body", metavar="FRAME", help="frame to read out of a C-kernel, or its name to write"
    )


def run(arguments):
    from attitude.formats import which

    wanted = which.to_write(arguments.output)
    # The tolerance of lengths is for files of attitudes; of a C-kernel that is written, not.
    tolerance = None if wanted == "ck" else arguments.tolerance
    source = which.read(arguments.input, tolerance=tolerance, body=arguments.body)
    if arguments.fit:
        source = _fitted(source)
    if wanted in which.OF_MOTIONS:
        _write_motion(arguments, wanted, source)
    elif wanted == "ck":
        _write_kernel(arguments, source)
    else:
        which.write(arguments.output, _records(arguments, source), **_settings(arguments, wanted))


def _fitted(source):
    from attitude.attitude_table import AttitudeTable
    from attitude.fitting import fit

    if not isinstance(source, AttitudeTable):
        raise AttitudeError("--fit wants a table of attitudes; IN is a motion already.")
    found = fit(source)
    print(f"rms of the residuals: {found.rms:.3g} rad")
    return found.motion


def _is_motion(source):
    return hasattr(source, "spin")


def _write_motion(arguments, wanted, source):
    from attitude.formats import which

    _refuse(arguments, ("start", "stop", "step", "type"), f"a file like {arguments.output}")
    if not _is_motion(source):
        raise AttitudeError(
            f"{arguments.output} holds a motion, and {arguments.input} a table of attitudes; give "
            "--fit to find the free rotation that comes closest."
        )
    settings = {}
    if wanted == "apm":
        settings = {"frame": arguments.frame, "version": arguments.version or "2.0"}
        settings["time_system"] = arguments.time_system or "UTC"
        settings["inertia"] = not source.body.relative
    else:
        _refuse(arguments, ("version", "frame", "time_system"), f"a file like {arguments.output}")
    which.write_motion(arguments.output, source, **settings)


def _write_kernel(arguments, source):
    from attitude.formats import ck

    _refuse(arguments, ("step", "version", "type", "frame", "time_system"), "a C-kernel")
    start, stop = _ends(arguments, source)
    epochs = _epochs(source, start, stop, _difference(start, stop))
    hi, lo = epochs.block(0, epochs.count)
    ends = [source_epoch(source).after(float(hi[k]), float(lo[k])) for k in (0, -1)]
    made = ck.write(
        arguments.output,
        source,
        *ends,
        tolerance=arguments.tolerance or 1e-9,
        name=arguments.body or "TUMBLER",
    )
    print(
        f"{', '.join(os.path.basename(name) for name in made.kernels)}: error {made.error:.2g} rad"
    )


def _records(arguments, source):
    """What is written: the records of a table, or some of a motion."""
    from attitude.formats.records import Records

    if not _is_motion(source) and hasattr(source, "segments") and arguments.step is None:
        _refuse(arguments, ("start", "stop"), "records as they are, without --step")
        return source
    if arguments.step is None:
        raise AttitudeError(
            f"{arguments.output} holds attitudes at epochs; give --step and --stop."
        )
    start, stop = _ends(arguments, source)
    epochs = _epochs(source, start, stop, arguments.step)
    hi, lo = epochs.block(0, epochs.count)
    return Records(source, source_epoch(source), hi, lo)


def source_epoch(source):
    """The epoch from which plain seconds of a source count."""
    return source.spin.epoch if _is_motion(source) else source.epoch


def _ends(arguments, source):
    """--start and --stop as texts, by default the span of a table."""
    start, stop = arguments.start, arguments.stop
    if hasattr(source, "segments"):
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

    return grid(source_epoch(source), start, stop, step)


def _difference(start, stop):
    """A step from the first to the last of two ends, where both are times after the epoch."""
    from attitude.cli.grid import duration

    try:
        return repr(float(duration(stop, "--stop") - duration(start, "--start")))
    except AttitudeError as err:
        raise AttitudeError(
            "for a C-kernel give --start and --stop as times after the epoch of IN, such as "
            '"0" and "2 d".'
        ) from err


def _settings(arguments, wanted):
    """What the writer is told."""
    settings = {}
    if wanted in ("aem", "aem-xml"):
        settings = {"version": arguments.version or "2.0", "kind": arguments.type}
        settings |= {"frame": arguments.frame, "time_system": arguments.time_system}
    elif wanted == "stk":
        _refuse(arguments, ("version", "time_system"), "an STK file")
        settings = {"section": arguments.type, "frame": arguments.frame or "ICRF"}
    else:
        _refuse(arguments, ("version", "time_system", "frame", "type"), "a table")
    return settings


def _refuse(arguments, names, what):
    for name in names:
        if getattr(arguments, name) is not None:
            raise AttitudeError(
                f"--{name.replace('_', '-')} has no meaning for {what}; leave it out."
            )
