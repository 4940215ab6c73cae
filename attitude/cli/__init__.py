"""The command ``attitude``: one module a command, imported when it is used.

A command module defines ``HELP`` (one line), ``EPILOG`` (optional text below the help),
``add_arguments(parser)`` and ``run(arguments)``, which returns None and raises an AttitudeError for
wrong input.  A module of several commands, named in `_MODULES`, has dicts ``HELP`` and ``EPILOG``
by command, and its functions take the command as the second argument.

propagate, describe, geometry, lightcurve, passes, invert, periods, fold, plot, view, convert,
check, installation   the commands
_options    the motion of a file or of an entry of the catalogue; equally spaced epochs; ``--orbit``
_output     ``--output`` and other files that are written; rows of CSV and ECSV
_selftest   what ``check`` measures
_warm_up    what ``warm-up`` compiles
"""

from __future__ import annotations

import argparse
import difflib
import io
import os
import re
import sys
import warnings
from collections.abc import Callable, Sequence
from contextlib import nullcontext, redirect_stdout, suppress
from functools import partial
from importlib import import_module
from typing import Any, NamedTuple, NoReturn

from attitude.errors import AttitudeError, AttitudeWarning

# The commands, and the module of each.
_MODULES = {
    "propagate": "propagate",
    "evolve": "propagate",
    "describe": "describe",
    "catalog": "describe",
    "geometry": "geometry",
    "lightcurve": "lightcurve",
    "passes": "passes",
    "glints": "passes",
    "invert": "invert",
    "periods": "periods",
    "fold": "fold",
    "plot": "plot",
    "view": "view",
    "convert": "convert",
    "check": "check",
    "warm-up": "installation",
    "completion": "installation",
}
COMMANDS: tuple[str, ...] = tuple(_MODULES)

_DESCRIPTION = "Exact attitude of freely tumbling spacecraft and asteroids at any epoch."
_EPILOG = """\
example:
  attitude propagate toutatis.toml --stop "30 d" --step "6 h" --output attitudes.csv

A spin file holds a body and its state of rotation at an epoch. For the options of a command, see
"attitude COMMAND --help".
"""
# Exit codes: wrong input,
_WRONG = 2
# output closed by its reader (128 + SIGPIPE),
_PIPE = 141
# and Ctrl-C (128 + SIGINT).
_INTERRUPTED = 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    if isinstance(sys.stdout, io.TextIOWrapper):  # letters it cannot encode are written as \u014c
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        arguments = _parsed(sys.argv[1:] if argv is None else list(argv))
        with warnings.catch_warnings():
            warnings.simplefilter("always", AttitudeWarning)
            warnings.showwarning = partial(_said, warnings.showwarning)
            _run(arguments)
        _flush()
    except SystemExit as end:  # argparse: help, version
        return int(end.code or 0)
    except AttitudeError as err:
        return _failed(str(err))
    except BrokenPipeError:
        _abandon_stdout()
        return _PIPE
    except OSError as err:
        return _failed(f"{err.filename or 'output'}: {err.strerror or err}.")
    except (KeyboardInterrupt, Exception) as err:
        if not _is_interrupt(err):
            raise
        _abandon_stdout()
        return _INTERRUPTED
    return 0


def _run(arguments: argparse.Namespace) -> None:
    """Run a command whose files can be written; where it writes any, its text follows them.

    A reader that closes the output, as "| head -1" does, would end it before.
    """
    from attitude.cli import _output

    _output.require_usable(arguments)
    text = io.StringIO()
    is_held = sys.stdout is not None and _output.writes(arguments)
    try:
        with redirect_stdout(text) if is_held else nullcontext():
            arguments.run(arguments)
    finally:
        if is_held:
            print(text.getvalue(), end="", flush=True)


def _is_interrupt(error: BaseException | None) -> bool:
    """Whether an error is Ctrl-C, or caused by it: Python wraps what stops a class statement."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__
    return error is not None


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are AttitudeErrors of one sentence, without the usage."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(
            formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False, **settings
        )
        # A minus before a digit is that of a number, also in "-1e-3" and "-3deg".
        self._negative_number_matcher = re.compile(r"-\.?[0-9]")

    def error(self, message: str) -> NoReturn:
        """Raise the AttitudeError for what argparse refuses."""
        unknown = re.fullmatch(r"unrecognized arguments: (.*)", message)
        if unknown:
            known = [option for action in self._actions for option in action.option_strings]
            words = unknown.group(1).split() or ["an empty argument"]
            alike = difflib.get_close_matches(words[0], known, n=1)
            guess = f" (did you mean {alike[0]}?)" if alike else ""
            message = f"{' '.join(words)} is not known{guess}"
        raise AttitudeError(f'{message}; see "{self.prog} --help".')


def _parsed(argv: list[str]) -> argparse.Namespace:
    parser = _Parser(prog="attitude", description=_DESCRIPTION, epilog=_EPILOG)
    version = "attitude"
    if "--version" in argv or "-V" in argv:
        from attitude import __version__  # not there where another project has replaced the file

        version = f"attitude {__version__}"
    parser.add_argument("-V", "--version", action="version", version=version)
    first = argv[0] if argv else None
    if first is None:
        raise AttitudeError(f'give a command: {", ".join(COMMANDS)}; see "attitude --help".')
    if not first.startswith("-") and first not in COMMANDS:
        alike = difflib.get_close_matches(first, COMMANDS, n=1)
        raise AttitudeError(
            f"there is no command {first!r}"
            + (f"; did you mean {alike[0]}?" if alike else f"; give one of {', '.join(COMMANDS)}.")
        )
    if first in COMMANDS:
        # Parsed by the command's own parser, so that its errors name it.
        command_module = command_of(first)
        command = _Parser(
            prog=f"attitude {first}", description=command_module.help, epilog=command_module.epilog
        )
        command_module.add_arguments(command)
        command.set_defaults(run=command_module.run)
        return command.parse_args(argv[1:])
    commands = parser.add_subparsers(metavar="COMMAND", title="commands", required=True)
    for name in COMMANDS:
        commands.add_parser(name, help=command_of(name).help)
    return parser.parse_args(argv)


class Command(NamedTuple):
    """What a command says of itself, its options and what it does."""

    help: str
    epilog: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], None]


def command_of(name: str) -> Command:
    """The Command of one of `COMMANDS`."""
    module = import_module(f"attitude.cli.{_MODULES[name]}")
    epilog: Any = getattr(module, "EPILOG", "")
    if isinstance(module.HELP, str):
        return Command(module.HELP, epilog, module.add_arguments, module.run)
    functions = (partial(function, command=name) for function in (module.add_arguments, module.run))
    return Command(module.HELP[name], epilog.get(name, ""), *functions)


def _said(other, message, category, *place, **options):
    """Print warnings of the package, and one of numpy, as a sentence; `other` prints all others."""
    if issubclass(category, AttitudeWarning):
        print(f"attitude: warning: {message}", file=sys.stderr)
    elif issubclass(category, RuntimeWarning):
        warnings.simplefilter("ignore", RuntimeWarning)
        print(
            f"attitude: warning: numbers leave the range of doubles ({message}); correct those of "
            "the input.",
            file=sys.stderr,
        )
    else:
        other(message, category, *place, **options)


def _failed(sentence: str) -> int:
    """Print a sentence on stderr; the exit code."""
    with suppress(OSError):
        _flush()
    print(f"attitude: {sentence}", file=sys.stderr)
    return _WRONG


def _flush() -> None:
    """Write what is printed; standard output is None where it was closed before the start."""
    if sys.stdout is not None:
        sys.stdout.flush()


def _abandon_stdout() -> None:
    """Turn stdout to the null device: Python flushes it at exit, an error on a closed pipe."""
    with suppress(OSError, ValueError, AttributeError):
        stdout = sys.stdout.fileno()
        os.dup2(os.open(os.devnull, os.O_WRONLY), stdout)
