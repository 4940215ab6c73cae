"""``attitude convert IN OUT``: between any two formats of attitudes and motions."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from attitude.cli import _options
from attitude.errors import AttitudeError
from attitude.formats._format import Format, OpenedFile, Option, endings, formats, message_labels

if TYPE_CHECKING:
    from typing import TypeGuard

    from attitude.cli._options import Grid
    from attitude.epochs._instants import Instant
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
    for option in options():
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


def options() -> list[Option]:
    """The options that the registered formats add to the command."""
    return [option for entry in formats().values() for option in entry.options]


# Ratio of the rms of two fits from which the principal axes are fitted too.
_BETTER = 0.9


def run(arguments: argparse.Namespace) -> None:
    """Read IN and write OUT."""
    from attitude.formats import detect

    written = detect.format_to_write(arguments.output)
    # An entry of the catalogue is as a spin file.
    is_catalogued = _is_catalogued(arguments.input)
    read = formats()["spin"] if is_catalogued else detect.format_of(arguments.input)
    # The tolerance of a C-kernel, or of a motion that is sampled, is not that of lengths read.
    sampled = written.holds == "span" or (
        (read.holds != "records" or arguments.fit) and arguments.step is None
    )
    path = _options.path_of(arguments)
    if path is not None and "orbit" not in (*written.reading, *read.reading):
        raise AttitudeError(
            "--orbit is for AEM, APM, CIC and STK files, whose attitudes may be relative to axes "
            "of the orbit; leave it out."
        )
    keywords = {
        option.name: getattr(arguments, option.attribute)
        for option in options()
        if option.of_reading
    }
    keywords |= {"tolerance": None if sampled else arguments.tolerance, "orbit": path}
    source = (
        _catalogued(arguments.input)
        if is_catalogued
        else detect.opened(arguments.input, **keywords)
    )
    for text in source.motion.meta.get("assumed", ()):
        print(f"{arguments.input}: assumed: {text}")
    with ExitStack() as stack:
        stack.enter_context(source.motion)  # a C-kernel is unloaded at the end
        _convert(arguments, written, source, path)


def _is_catalogued(name: str) -> bool:
    from attitude import catalog
    from attitude.cli import _options

    return not _options.is_file(name) and catalog.has(name)


def _catalogued(name: str) -> OpenedFile:
    """The motion of an entry of the catalogue with its labels."""
    from attitude import catalog

    entry = catalog.entry(name)
    labels = {"name": entry.name, "source": "; ".join(entry.sources), "note": entry.note}
    return OpenedFile(entry.motion(), labels)


def _convert(
    arguments: argparse.Namespace, written: Format, found: OpenedFile, path: Path | None
) -> None:
    """Write what was read, in the format `written`."""
    from attitude.formats import detect

    if not arguments.fit:
        _refuse(arguments, ("axes", "rms"), "a conversion without --fit")
    settings = _settings(arguments, written, path)
    motion = _fitted(arguments, found.motion) if arguments.fit else found.motion
    if written.holds == "motion":
        _write_motion(arguments, written, motion, settings, found.said)
    elif written.holds == "span":
        _write_span(arguments, written, motion, settings)
    elif _by_tolerance(arguments, written, found.motion):
        start, stop = _ends(arguments, motion)
        ends = (_moment(motion, moment, arguments) for moment in (start, stop))
        settings |= dict(zip(("start", "stop"), ends, strict=True))
        settings |= written.labels(motion, found.said)
        print(detect.write(arguments.output, motion, tolerance=arguments.tolerance, **settings))
    else:
        records = _records(arguments, motion)
        if _is_free_rotation(motion):
            records.meta.update(message_labels(motion, found.said))
        detect.write(arguments.output, records, **settings)


def _by_tolerance(arguments: argparse.Namespace, written: Format, read: Motion) -> bool:
    """Whether --tolerance is that of the attitudes between records, and not of lengths read."""
    is_by_tolerance = (
        arguments.tolerance is not None and arguments.step is None and written.is_sampled
    )
    return is_by_tolerance and (arguments.fit or not _is_table(read))


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
    principal = fit(table, axes=arguments.axes or "principal")
    used = arguments.axes or "principal"
    if arguments.axes is None and len(table) > 3:
        free = fit(table, axes="free")
        if free.rms < _BETTER * principal.rms:
            principal, used = free, "free"
    print(f"rms of the residuals: {principal.rms:.3g} rad, with {used} axes")
    most = MOST_RMS if arguments.rms is None else arguments.rms
    if not principal.rms <= most:
        raise AttitudeError(
            f"the rms of the residuals is {principal.rms:.3g} rad, more than {most:g}: the "
            f"attitudes of {arguments.input} are not those of a free rotation, or noisy; "
            "--rms accepts more."
        )
    return principal.motion


def _sampled(arguments: argparse.Namespace, source: Motion) -> AttitudeTable:
    """A table of the attitudes of a C-kernel at the epochs of --start, --stop and --step."""
    from attitude.motions._table import AttitudeTable

    records = _records(arguments, source)
    history = source.at(records.seconds, records.low)
    return AttitudeTable.from_history(history, rates=records.has_rates)


# ---- Writing


def _write_motion(
    arguments: argparse.Namespace,
    written: Format,
    motion: Motion,
    settings: dict[str, Any],
    said: Mapping[str, Any],
) -> None:
    """Write the file of a free rotation."""
    from attitude.formats import detect

    if not arguments.fit:
        _refuse(arguments, ("start", "stop", "step"), f"a file like {arguments.output}")
    if not _is_free_rotation(motion):
        raise AttitudeError(
            f"{arguments.output} holds a motion, and {arguments.input} attitudes at epochs; give "
            "--fit to fit a free rotation to them."
        )
    detect.write_motion(arguments.output, motion, **settings, **written.labels(motion, said))


def _write_span(
    arguments: argparse.Namespace, written: Format, source: Motion, settings: dict[str, Any]
) -> None:
    """Write a file of attitudes at any epoch from --start to --stop; prints what was made."""
    ends: Any = None, None
    if not _is_free_rotation(source) and not _is_table(source):
        source = _sampled(arguments, source)
        ends = source.span
    else:
        _refuse(arguments, ("step",), written.noun)
        asked = (arguments.start, arguments.stop, arguments.tolerance, arguments.method)
        if not _is_table(source) or any(choice is not None for choice in asked):
            start, stop = _ends(arguments, source)
            ends = tuple(_moment(source, moment, arguments) for moment in (start, stop))
    print(written.write(arguments.output, source, *ends, **settings))


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
    epochs = _epochs(source, start, stop, arguments.step, arguments)
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


def _epochs(
    source: Motion, start: str, stop: str, step: str, arguments: argparse.Namespace
) -> Grid:
    """Epochs in seconds of UTC; of TDB in files in TDB, and within tables, whose span is in TDB."""
    from attitude.cli._options import grid

    is_tdb = _is_table(source) or (arguments.time_system or "").strip().upper() in ("TDB", "ET")
    return grid(source.epoch, start, stop, step, is_tdb=is_tdb)


def _moment(source: Motion, text: str, arguments: argparse.Namespace) -> Instant:
    """The Instant of a date, or of a time after the epoch of IN."""
    return _epochs(source, text, text, "1", arguments).start


def _settings(arguments: argparse.Namespace, written: Format, path: Path | None) -> dict[str, Any]:
    """The keyword arguments of the writer; AttitudeError for an option of other formats."""
    words = {"noun": written.noun.format(output=arguments.output), "output": arguments.output}
    for option in options():
        value = _value(arguments, option)
        if value is None or option.of_reading or option.attribute in written.writing:
            continue
        if option.name not in written.fulfilled:
            raise AttitudeError(f"--{option.name} {option.refusal.format(**words)}")
        if value != written.fulfilled[option.name]:
            raise AttitudeError(f"--{option.name} {value} has no meaning for {words['noun']}.")
    values = {**vars(arguments), "orbit": path}
    values |= {option.attribute: _value(arguments, option) for option in options()}
    used = [name for name in written.writing if values[name] is not None]
    return {written.renamed.get(name, name): values[name] for name in used}


def _value(arguments: argparse.Namespace, option: Option) -> Any:
    """What was given for an option; None if it was left out."""
    value = getattr(arguments, option.attribute)
    return None if value is option.settings.get("default", False) else value


def _refuse(arguments: argparse.Namespace, names: Iterable[str], what: str) -> None:
    """Raise the AttitudeError for the first given option of these, which `what` does not have."""
    for name in names:
        if getattr(arguments, name) is not None:
            raise AttitudeError(f"--{name} has no meaning for {what}; leave it out.")
