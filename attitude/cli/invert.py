"""``attitude invert CURVE.csv``: the spin states that a light curve allows."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from attitude.cli import _options, _output
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.inversion._solution import SpinStates


HELP: str = "find the spin states of a tumbling body from a light curve"
EPILOG: str = """\
examples:
  attitude invert toutatis.csv --max-frequency "0.75 /d" --output solution.toml --figure fit.png
  attitude invert A43.lc.txt --period "5.7 h, 5.8 h" --zero-points free --output ariadne.toml

Prints the verdict with its criterion, and the ranked solutions. The CSV has a line of names: an
epoch (utc, jd_tdb, jd_utc), magnitude or flux, sigma, session, filter, and the geometry (sun_x ..
observer_z in au, or ra, dec, delta); otherwise give --orbit and --site.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="CURVE.csv", help="the light curve")
    parser.add_argument(
        "--max-frequency",
        metavar="F",
        help='largest frequency of rotation, such as "0.75 /d" or "2 mHz"',
    )
    parser.add_argument(
        "--period",
        metavar="P",
        help='of a rotation about one axis, which is searched to 1 %%: "5.762 h"; or between two: '
        '"5.7 h, 5.8 h". --max-frequency may then be left out',
    )
    _options.add_orbit_arguments(parser)
    _options.add_site_argument(parser)
    parser.add_argument("--frame", default="icrf", help="axes of the vectors of the file (icrf)")
    parser.add_argument(
        "--zero-points", default="auto", help='of sessions: auto, shared, free, or "0.05 mag"'
    )
    parser.add_argument(
        "--modes",
        default="LAM,SAM",
        help="LAM, SAM or both (default); PA: rotation about one axis alone, of any length of time",
    )
    parser.add_argument(
        "--moments",
        default="shape",
        help='"shape" (the default), "free", a tolerance, three known moments "3.1, 3.2, 1", or a '
        "spin file with the body",
    )
    parser.add_argument("--budget", default="60 s", help="time of the search (60 s)")
    parser.add_argument("--seed", type=int, default=0, help="of the random starts (0)")
    parser.add_argument("--output", metavar="FILE.toml", help="spin file of the best solution")
    kinds = ", ".join(_output.PICTURES)
    parser.add_argument("--figure", metavar="FILE", help=f"figure, by its ending: {kinds}")


def run(arguments: argparse.Namespace) -> None:
    """Search, print verdict and table, write the spin file and the figure."""
    from attitude._support import validation
    from attitude.inversion import _spin_states
    from attitude.photometry._curve import LightCurve

    if arguments.figure is not None:
        _output.kind_of(arguments.figure, _output.PICTURES, "--figure")
    curve = LightCurve.read(
        arguments.file,
        frame=arguments.frame,
        zero_points=_zero_points(arguments.zero_points),
        **_geometry(arguments),
    )
    moments = _moments(arguments.moments)
    found = _spin_states.spin_states(
        curve,
        arguments.max_frequency,
        period=_period(arguments.period),
        modes=tuple(each.strip() for each in arguments.modes.split(",")),
        moments=moments,
        budget=validation.positive(arguments.budget, "--budget", unit="s"),
        seed=arguments.seed,
    )
    print(curve)
    print(found)
    _write(found, arguments)


def _write(found: SpinStates, arguments: argparse.Namespace) -> None:
    if not (arguments.output or arguments.figure):
        return
    if len(found) == 0:
        raise AttitudeError("nothing was found, so that --output and --figure have no content.")
    if arguments.output:
        found[0].write(arguments.output, name=found[0].curve.name)
        print(arguments.output)
    if arguments.figure:
        found.plot(arguments.figure)
        print(arguments.figure)


def _period(text: str | None) -> Any:
    """The period, or both ends."""
    if text is None or "," not in text:
        return text
    return tuple(each.strip() for each in text.split(","))


def _zero_points(text: str) -> Any:
    from attitude._support import validation

    if text in ("auto", "shared", "free"):
        return text
    return validation.positive(text if " " in text else f"{text} mag", "--zero-points", unit="mag")


def _moments(text: str) -> Any:
    """ "shape", "free", a tolerance, three moments, or the body of a spin file."""
    from attitude._support import validation
    from attitude.formats import spin_file

    if text in ("shape", "free"):
        return text
    if text.endswith(".toml"):
        return spin_file.read(text).body
    if "," in text:
        return validation.real(text, "--moments", shape=(3,))
    try:
        return float(text)
    except ValueError:
        raise AttitudeError(
            f'--moments is {text!r}; give "shape", "free", a number (the tolerance), three moments '
            'such as "3.1, 3.2, 1", or the name of a spin file (.toml).'
        ) from None


def _geometry(arguments: argparse.Namespace) -> dict[str, Any]:
    """The keywords of the geometry from --orbit and --site."""

    path, site = _options.path_of(arguments), _options.site_of(arguments)
    if path is None:
        return {}
    return {"path": path} if site is None else {"path": path, "site": site}
