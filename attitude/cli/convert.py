"""``attitude convert IN OUT``: between any two formats of attitudes and motions."""

from __future__ import annotations

import argparse
import warnings

from attitude.cli import _options
from attitude.errors import AttitudeError, AttitudeWarning
from attitude.formats import detect
from attitude.formats._format import OpenedFile, endings, formats, message_labels
from attitude.formats._sampling import Records
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._table import AttitudeTable

# ---- The options of ``attitude convert``

HELP: str = "convert between any two formats of attitudes and motions"
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
    for option in _options.of_formats():
        parser.add_argument(f"--{option.name}", help=option.help, **option.settings)
    _options.add_orbit_arguments(
        parser,
        "path of the body about the center that it names, where attitudes of IN or OUT are "
        "relative to axes of the orbit (LVLH, RTN): OEM, TLE, OMM, SPK, MPCORB line, elements "
        "(text or TOML), mission file or planet",
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
    listed = [f"  {ending:<10}{entry.title}" for ending, entry in endings().items()]
    parser.epilog = "\n".join([EPILOG, "endings that OUT may have:", *listed])


# Ratio of the rms of two fits from which the principal axes are fitted too.
_BETTER = 0.9


def run(arguments: argparse.Namespace) -> None:
    """Read IN and write OUT."""
    from attitude import catalog

    written = detect.format_to_write(arguments.output)
    # An entry of the catalogue is as a spin file.
    is_catalogued = not _options.is_file(arguments.input) and catalog.has(arguments.input)
    read = formats()["spin"] if is_catalogued else detect.format_of(arguments.input)
    choices = _options.of_reading(arguments, f"{arguments.input} as IN", read, written.writing)
    # The tolerance of a C-kernel, or of a motion that is sampled, is not that of lengths read.
    sampled = written.holds == "span" or (
        (read.holds != "records" or arguments.fit) and arguments.step is None
    )
    path = _options.path_of(arguments)
    if path is not None and "orbit" not in (*written.writing, *read.reading):
        known = [ending for ending, entry in endings().items() if "orbit" in entry.reading]
        raise AttitudeError(
            f"--orbit is for files that end in {', '.join(known)}, whose attitudes may be relative "
            "to axes of the orbit; leave it out."
        )
    if is_catalogued:
        entry = catalog.entry(arguments.input)
        labels = {"name": entry.name, "source": "; ".join(entry.sources), "note": entry.note}
        source = OpenedFile(entry.motion(), labels)
    else:
        tolerance = None if sampled else arguments.tolerance
        source = detect.opened(arguments.input, tolerance=tolerance, orbit=path, **choices)
    for text in source.motion.meta.get("assumed", ()):
        print(f"{arguments.input}: assumed: {text}")
    if left_out := source.said.get("left_out"):
        warnings.warn(
            f"{arguments.input} is converted as a table of attitudes, without its "
            f"{' and '.join(left_out)}; attitude.acm.read has them, and the motion.",
            AttitudeWarning,
            stacklevel=2,
        )
    with source.motion:  # a C-kernel is unloaded at the end
        _convert(arguments, written, source, path)


def _convert(arguments, written, source, path):
    """Write an `OpenedFile` in the format `written`."""
    if not arguments.fit:
        _options.refuse(arguments, ("axes", "rms"), "a conversion without --fit")
    settings = _settings(arguments, written, path)
    motion = _fitted(arguments, source.motion) if arguments.fit else source.motion
    if written.holds == "motion":
        if not arguments.fit:
            _options.refuse(arguments, ("start", "stop", "step"), f"a file like {arguments.output}")
        if not isinstance(motion, FreeRotation):
            raise AttitudeError(
                f"{arguments.output} holds a motion, and {arguments.input} attitudes at epochs; "
                "give --fit to fit a free rotation to them."
            )
        settings |= written.labels(motion, source.said)
        written.write(arguments.output, motion, **settings)
    elif written.holds == "span":
        _write_span(arguments, written, motion, settings)
    elif _by_tolerance(arguments, written, source.motion):
        start, stop = _ends(arguments, motion)
        settings |= {"start": start, "stop": stop, "tolerance": arguments.tolerance}
        settings |= written.labels(motion, source.said)
        print(written.write(arguments.output, motion, **settings))
    else:
        records = _records(arguments, motion)
        if isinstance(motion, FreeRotation):
            records.meta.update(message_labels(motion, source.said))
        written.write(arguments.output, records, **settings)


def _by_tolerance(arguments, written, read):
    """Whether --tolerance is that of the attitudes between records, and not of lengths read."""
    is_given = arguments.tolerance is not None and arguments.step is None and written.is_sampled
    return is_given and (arguments.fit or not isinstance(read, AttitudeTable))


def _fitted(arguments, source):
    """The free rotation fitted to IN; prints the rms of the residuals."""
    from attitude.fitting._attitudes import fit

    if isinstance(source, FreeRotation):
        raise AttitudeError(
            "--fit fits a table of attitudes, but IN is a motion already; leave --fit out."
        )
    table = source if isinstance(source, AttitudeTable) else _sampled(arguments, source)
    used = arguments.axes or "principal"
    with warnings.catch_warnings():
        # Large residuals are refused below.
        warnings.simplefilter("ignore", AttitudeWarning)
        best = fit(table, axes=used)
        if arguments.axes is None and len(table) > 3:
            free = fit(table, axes="free")
            if free.rms < _BETTER * best.rms:
                best, used = free, "free"
    print(f"rms of the residuals: {best.rms:.3g} rad, with {used} axes")
    most = MOST_RMS if arguments.rms is None else arguments.rms
    if not best.rms <= most:
        raise AttitudeError(
            f"the rms of the residuals is {best.rms:.3g} rad, more than {most:g}: the "
            f"attitudes of {arguments.input} are not those of a free rotation, or noisy; "
            "--rms accepts more."
        )
    return best.motion


def _sampled(arguments, source):
    """A table of the attitudes of a C-kernel at the epochs of --start, --stop and --step."""
    records = _records(arguments, source)
    history = source.at(records.seconds, records.low)
    return AttitudeTable.from_history(history, rates=records.has_rates)


def _write_span(arguments, written, source, settings):
    """Write a file of attitudes at any epoch from --start to --stop; prints what was made."""
    is_table, ends = isinstance(source, AttitudeTable), (None, None)
    if not is_table and not isinstance(source, FreeRotation):
        source = _sampled(arguments, source)
        ends = source.span
    else:
        _options.refuse(arguments, ("step",), written.noun)
        asked = (arguments.start, arguments.stop, arguments.tolerance, arguments.method)
        if not is_table or any(choice is not None for choice in asked):
            ends = _ends(arguments, source)
    print(written.write(arguments.output, source, *ends, **settings))


def _records(arguments, source):
    """The records of a table, or `Records` of a motion at --start, --stop and --step."""
    if isinstance(source, AttitudeTable) and arguments.step is None:
        _options.refuse(arguments, ("start", "stop"), "records as they are, without --step")
        return source
    if arguments.step is None:
        free = isinstance(source, FreeRotation)
        needed = "--step and --stop" if free else "--start, --stop and --step"
        raise AttitudeError(
            f"the attitudes of {arguments.input} are sampled at epochs; give {needed}."
        )
    epochs = _epochs(arguments, source, *_texts_of_ends(arguments, source), arguments.step)
    hi, lo = epochs.block(0, epochs.count)
    return Records(source, source.epoch, hi, lo)


def _ends(arguments, source):
    """The Instants of --start and --stop: dates, or times after the epoch of IN."""
    texts = _texts_of_ends(arguments, source)
    return [_epochs(arguments, source, text, text, "1").start for text in texts]


def _texts_of_ends(arguments, source):
    """--start and --stop, by default the span of a table."""
    start, stop = arguments.start, arguments.stop
    if isinstance(source, AttitudeTable):
        epoch = source.epoch
        first, last = (
            repr((end.seconds - epoch.seconds) + (end.low - epoch.low)) for end in source.span
        )
        start, stop = start or first, stop or last
    if stop is None or (start is None and not isinstance(source, FreeRotation)):
        raise AttitudeError(f"{arguments.input} has no span of its own; give --start and --stop.")
    return start or "0", stop


def _epochs(arguments, source, start, stop, step):
    """Epochs in seconds of UTC; of TDB in files in TDB, and within tables, whose span is in TDB."""
    is_tdb = (arguments.time_system or "").strip().upper() in ("TDB", "ET")
    is_tdb = is_tdb or isinstance(source, AttitudeTable)
    return _options.grid(source.epoch, start, stop, step, is_tdb=is_tdb)


def _settings(arguments, written, path):
    """The keyword arguments of the writer; AttitudeError for an option of other formats."""
    noun = written.noun.format(output=arguments.output)
    values = {"tolerance": arguments.tolerance, "orbit": path}
    for option in _options.of_formats():
        value = getattr(arguments, option.attribute)
        if value is option.settings.get("default", False):
            value = None
        values[option.attribute] = value
        if value is None or option.of_reading or option.attribute in written.writing:
            continue
        if option.name not in written.fulfilled:
            refusal = option.refusal.format(noun=noun, output=arguments.output)
            raise AttitudeError(f"--{option.name} {refusal}")
        if value != written.fulfilled[option.name]:
            raise AttitudeError(f"--{option.name} {value} has no meaning for {noun}.")
    used = [name for name in written.writing if values[name] is not None]
    return {written.renamed.get(name, name): values[name] for name in used}
