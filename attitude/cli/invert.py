"""``attitude invert CURVE.csv``: the spin states that a light curve allows."""

from __future__ import annotations

import argparse
import os
import re
from typing import Any

import numpy as np

from attitude import frames
from attitude._support import validation
from attitude._support.constants import DAY_S
from attitude.cli import _options, _output
from attitude.epochs import _inputs, _instants
from attitude.errors import AttitudeError

HELP: str = "find the spin states of a tumbling body from a light curve"
EPILOG: str = """\
examples:
  attitude invert toutatis.csv --max-frequency "0.75 /d" --output solution.toml --figure fit.png
  attitude invert A43.lc.txt --period "5.7 h, 5.8 h" --output ariadne.toml
  attitude invert curve.csv --max-frequency "3 /d" --orbit body.oem --site 568 \\
      --predict "2026-03-01T18:00 .. 2026-03-02T04:00, 10 min" --prediction night.png
  attitude view solution.toml
  attitude invert pass.csv --max-frequency "0.08 Hz" --shape satellite.obj --law materials.toml \\
      --moments satellite.toml

Prints the verdict with its criterion, and the ranked solutions. The CSV has a line of names: an
epoch (utc, jd_tdb, jd_utc), magnitude or flux, sigma, session, filter, and the geometry (sun_x ..
observer_z in au, or ra, dec, delta); otherwise give --orbit and --site. --output writes state,
errors and shape, which "attitude view", "attitude lightcurve" and mission files draw. With --shape
the shape is known, and rates and attitude are sought. --predict takes dates
("2026-03-01, 2026-03-02"), a span ("START .. STOP, STEP"), a file with a date a line, or a light
curve, whose points the figure of --prediction shows too.
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
        "--zero-points", help='of sessions: auto, shared, free, "0.05 mag" (of the file, else auto)'
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
    parser.add_argument(
        "--exposure", metavar="T", help='exposure time of the points, such as "60 s" (of the file)'
    )
    parser.add_argument(
        "--shape",
        metavar="FILE",
        help="the known shape: OBJ, DAMIT, STL or PLY, or a spin or mission file with [shape]",
    )
    parser.add_argument("--unit", metavar="UNIT", help="of the mesh (default: m)")
    parser.add_argument(
        "--law",
        metavar="NAME|FILE",
        help="with --shape: a scattering law, or a TOML file with [scattering] (default: that of "
        "the file of the shape)",
    )
    words = "both rates of a body that tumbles over several apparitions may change, as by YORP"
    parser.add_argument("--drift", action="store_true", help=words)
    parser.add_argument("--budget", default="60 s", help="work, s of one core (60 s)")
    parser.add_argument("--seed", type=int, default=0, help="of the random starts (0)")
    parser.add_argument("--output", metavar="FILE.toml", help="spin file of the best solution")
    _output.add_figure(parser)
    parser.add_argument(
        "--predict", metavar="DATES|FILE", help="magnitudes of the best solution at other dates"
    )
    parser.add_argument(
        "--prediction",
        metavar="FILE",
        help="of --predict: their table (.csv, .ecsv) or a figure with a panel a night "
        f"({', '.join(_output.PICTURES)})",
    )


def run(arguments: argparse.Namespace) -> None:
    """Search, print verdict and table, write the spin file and the figure."""
    from attitude.inversion import _solution, _spin_states

    _output.picture_of(arguments)
    _output.kind_of(arguments.output, ("toml",))
    of_file = {} if arguments.exposure is None else {"exposure": arguments.exposure}
    if arguments.zero_points is not None:
        of_file["zero_points"] = _zero_points(arguments.zero_points)
    curve = _curve(arguments, arguments.file, **of_file)
    if not curve.has_geometry:
        raise AttitudeError(
            "the photometry has no directions to Sun and observer; give --orbit and --site, or a "
            "file with the columns of the vectors."
        )
    kind, dates = _prediction_of(arguments)
    period: Any = arguments.period
    if period is not None:
        times = _options.periods(period, "--period")
        period = times if len(times) > 1 else times[0]
    states = _spin_states.spin_states(
        curve,
        arguments.max_frequency,
        period=period,
        modes=tuple(mode.strip() for mode in arguments.modes.split(",")),
        moments=_moments(arguments.moments),
        **_surface(arguments),
        drift=arguments.drift,
        budget=validation.positive(arguments.budget, "--budget", unit="s"),
        seed=validation.count(arguments.seed, "--seed", 0),
    )
    print(curve)
    for text in _solution.texts_of(states):
        print(text, flush=True)
    if arguments.output or arguments.figure:
        if len(states) == 0:
            raise AttitudeError("nothing was found, so that --output and --figure have no content.")
        if arguments.output:
            states[0].write(arguments.output, name=states[0].curve.name)
            print(arguments.output)
        _output.draw(arguments.figure, states.plot)
    if arguments.predict is not None:
        _predict(states, dates, kind, arguments.prediction)


def _curve(arguments, file, **settings):
    """The light curve of a file, with the geometry of --orbit and --site."""
    from attitude.photometry._curve import LightCurve

    frames.matrix_to_icrf(arguments.frame)  # also where a file with ra and dec needs none
    path, site = _options.path_of(arguments), _options.site_of(arguments)
    geometry = {
        name: value for name, value in (("path", path), ("site", site)) if value is not None
    }
    return LightCurve.read(file, frame=arguments.frame, **geometry, **settings)


# A span of dates: "START .. STOP, STEP".
_SPAN = re.compile(r"\s*(.+?)\s*\.\.\s*([^,]+?)\s*(?:,\s*(.+?)\s*)?")
# Steps of a span without STEP.
_STEPS = 200
# Epochs of a span at most.
_MOST_EPOCHS = 1_000_000
# Epochs that are printed.
_PRINTED = 40


def _prediction_of(arguments):
    """What --prediction writes, and the epochs of --predict, or a light curve."""
    if arguments.predict is None:
        if arguments.prediction is not None:
            raise AttitudeError("--prediction is the file of --predict; give --predict DATES too.")
        return None, None
    kind = None
    if arguments.prediction is not None:
        kinds = ("csv", "ecsv", *_output.PICTURES)
        kind = _output.kind_of(arguments.prediction, kinds, "--prediction")
    return kind, _dates(arguments.predict, arguments)


def _dates(text, arguments):
    from attitude.photometry import _files

    if os.path.isfile(text):
        lines = [line.strip() for line in _files.text_of(text).splitlines()]
        dates = [line for line in lines if line and not line.startswith("#")]
        if not dates or any("," in line for line in dates):
            return _curve(arguments, text)
    elif span := _SPAN.fullmatch(text):
        return _dates_of_span(text, *span.groups())
    else:
        dates = [date.strip() for date in text.split(",")]
    _inputs.past_j2000(dates, "--predict")
    return dates


def _dates_of_span(text, first, last, step):
    start, stop = _inputs.instant(first), _inputs.instant(last)
    length = stop.seconds - start.seconds
    seconds = length / _STEPS
    if step:
        seconds = validation.positive(step, "the step of --predict", unit="s")
    if not length > 0.0 or length / seconds > _MOST_EPOCHS:
        raise AttitudeError(
            f"--predict is {text!r}: {length / DAY_S:.6g} d in steps of {seconds:.6g} s; give a "
            f"stop after the start, and at most {_MOST_EPOCHS} epochs."
        )
    return _instants.times(start, np.arange(int(length / seconds + 1e-9) + 1) * seconds)


def _predict(states, dates, kind, output):
    """Print the magnitudes of the best solution at dates; write their table or figure."""
    from attitude.photometry._curve import LightCurve

    if len(states) == 0:
        raise AttitudeError("nothing was found, so that nothing is predicted.")
    prediction = states[0].predict(dates)
    print(f"predicted: {repr(prediction)[1:-1]}")
    table = prediction.table()
    print(f"{'UTC':<24}{'mag':>9}{'sigma':>8}{'form':>8}{'level':>8}{'phase deg':>11}")
    for row in table[:_PRINTED]:
        numbers = [getattr(row[key], "value", row[key]) for key in table.colnames[1:]]
        print("{:<24}{:9.3f}{:8.3f}{:8.3f}{:8.3f}{:11.3f}".format(row["time"].isot[:23], *numbers))
    if len(table) > _PRINTED:
        print(f"and {len(table) - _PRINTED} more" + ("" if output else "; give --prediction FILE"))
    if output is None:
        return
    if kind in _output.PICTURES:
        prediction.plot(output, observed=dates if isinstance(dates, LightCurve) else None)
    else:
        table["time"] = table["time"].isot
        table.rename_column("time", "utc")
        _output.write_table(table, output, kind, "--prediction")
    print(output)


def _zero_points(text):
    if text in ("auto", "shared", "free"):
        return text
    try:
        return validation.positive(text if " " in text else f"{text} mag", "", unit="mag")
    except AttitudeError:
        raise AttitudeError(
            f'--zero-points is {text!r}; give auto, shared, free, or a spread like "0.02 mag".'
        ) from None


def _moments(text):
    """ "shape", "free", a tolerance, three moments, or the body of a spin file."""
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


def _surface(arguments):
    """The keywords of a known shape from --shape and --law."""
    if arguments.shape is None:
        _options.refuse(arguments, ("law", "unit"), "a search without --shape")
        return {}
    from attitude.formats import _surface as surface
    from attitude.shape import _files
    from attitude.shape._ellipsoid import Ellipsoid

    law = None
    if arguments.shape.endswith(".toml"):
        _options.refuse(arguments, ("unit",), f"{arguments.shape}, which says its own")
        shape, law = surface.of_file(arguments.shape)
    else:
        shape = _files.read(arguments.shape, unit=arguments.unit or "m")
    if isinstance(shape, Ellipsoid):
        shape = shape.facets()
    if arguments.law is not None and arguments.law.endswith(".toml"):
        law = surface.law_of_file(arguments.law, shape)
    elif arguments.law is not None:
        law = surface.law_of({"law": arguments.law}, shape)
    return {"shape": shape} if law is None else {"shape": shape, "law": law}
