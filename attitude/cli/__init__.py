"""The command ``attitude``: one module a command, imported when it is used.

A command module has ``HELP`` (one line), ``add_arguments(parser)`` and ``run(arguments)``, which
returns nothing; what is wrong with its input is an AttitudeError.
"""

import argparse
import difflib
import os
import re
import sys
from contextlib import suppress
from importlib import import_module

from attitude import __version__
from attitude.errors import AttitudeError

COMMANDS = ("propagate", "describe", "geometry", "lightcurve", "plot", "convert", "check")

_DESCRIPTION = "Exact attitude of freely tumbling spacecraft and asteroids at any epoch."
_EPILOG = """\
example:
  attitude propagate toutatis.toml --stop "30 d" --step "6 h" --output toutatis.csv

A spin file holds a body and its state of rotation at an epoch; "attitude COMMAND --help" tells
more.
"""
# Exit codes: what was given is wrong; the reader went away (128 + SIGPIPE); Ctrl-C (128 + SIGINT).
_WRONG, _PIPE, _INTERRUPTED = 2, 141, 130


def main(argv=None):
    """Run the command line and return its exit code.

    0, or 2 after one sentence on stderr about what was wrong; 130 after Ctrl-C; 141 when whoever
    read the output has closed it.
    """
    try:
        arguments = _parsed(_joined(sys.argv[1:] if argv is None else list(argv)))
        arguments.run(arguments)
        sys.stdout.flush()
    except SystemExit as end:  # argparse: help, version
        return end.code or 0
    except AttitudeError as err:
        return _said(str(err))
    except BrokenPipeError:
        _abandon_stdout()
        return _PIPE
    except OSError as err:
        return _said(f"{err.filename or 'output'}: {err.strerror or err}.")
    except KeyboardInterrupt:
        _abandon_stdout()
        return _INTERRUPTED
    return 0


class _Parser(argparse.ArgumentParser):
    """What is wrong is told in a sentence, without the usage above it."""

    def __init__(self, **settings):
        super().__init__(
            formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False, **settings
        )

    def error(self, message):
        found = re.fullmatch(r"unrecognized arguments: (.*)", message)
        if found:
            known = [each for action in self._actions for each in action.option_strings]
            near = difflib.get_close_matches(found.group(1).split()[0], known, n=1)
            guess = f" (did you mean {near[0]}?)" if near else ""
            message = f"{found.group(1)} is not known{guess}"
        raise AttitudeError(f'{message}; see "{self.prog} --help".')


def _parsed(argv):
    parser = _Parser(prog="attitude", description=_DESCRIPTION, epilog=_EPILOG)
    parser.add_argument("--version", action="version", version=f"attitude {__version__}")
    first = argv[0] if argv else None
    if first is None:
        raise AttitudeError(f'give a command: {", ".join(COMMANDS)}; see "attitude --help".')
    if not first.startswith("-") and first not in COMMANDS:
        near = difflib.get_close_matches(first, COMMANDS, n=1)
        raise AttitudeError(
            f"there is no command {first!r}"
            + (f"; did you mean {near[0]}?" if near else f"; give one of {', '.join(COMMANDS)}.")
        )
    if first in COMMANDS:
        # Parsed by the command's own parser, so that its errors name it.
        module = import_module(f"attitude.cli.{first}")
        command = _Parser(
            prog=f"attitude {first}", description=module.HELP, epilog=getattr(module, "EPILOG", "")
        )
        module.add_arguments(command)
        command.set_defaults(run=module.run)
        return command.parse_args(argv[1:])
    commands = parser.add_subparsers(metavar="COMMAND", title="commands", required=True)
    for name in COMMANDS:
        commands.add_parser(name, help=import_module(f"attitude.cli.{name}").HELP)
    return parser.parse_args(argv)


def _joined(argv):
    """``--start -3d`` as ``--start=-3d``: argparse takes what begins with a minus for an option."""
    joined = []
    for each in argv:
        after_option = joined and re.fullmatch(r"--[a-z][a-z-]*", joined[-1])
        alone = re.fullmatch(r"-[0-9]+|-[0-9]*\.[0-9]+", each)  # taken for a number
        if after_option and re.match(r"-\.?[0-9]", each) and not alone:
            joined[-1] += "=" + each
        else:
            joined.append(each)
    return joined


def _said(sentence):
    with suppress(OSError):
        sys.stdout.flush()
    print(f"attitude: {sentence}", file=sys.stderr)
    return _WRONG


def _abandon_stdout():
    # Python flushes stdout once more at its end, and would complain about the closed pipe.
    with suppress(OSError, ValueError):
        stdout = sys.stdout.fileno()
        os.dup2(os.open(os.devnull, os.O_WRONLY), stdout)
