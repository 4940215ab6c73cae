"""``attitude periods FILE``: one period or two from photometry, ranked, with aliases."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from attitude.cli import _options, _output
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.photometry._curve import LightCurve


HELP: str = "find the periods of a body from photometry: one period, or two of a tumbler"
EPILOG: str = """\
examples:
  attitude periods curve.csv --min "2 h" --max "40 h" --figure periods.png
  attitude periods curve.csv --min "2 h" --max "40 h" --two --figure two.png

FILE is a CSV or ECSV with named columns (jd, utc or bjd; mag or flux; error; filter; site;
session), ALCDEF, ADES (PSV or XML), MPC records of 80 columns or DAMIT light curves. With --orbit,
or vectors in the file, magnitudes are reduced to 1 au and dates to the time at which light left the
body first; --g takes the phase function off too.
"""
# Rows of the tables printed.
_ROWS = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_data(parser)
    parser.add_argument("--min", metavar="P", help='shortest period, such as "2 h"')
    parser.add_argument("--max", metavar="P", help='longest period, such as "40 h" (the span)')
    parser.add_argument("--order", type=int, default=2, help="harmonics of the series (2)")
    parser.add_argument(
        "--method",
        default="fourier",
        help="fourier (series), pdm (phase dispersion) or additive (with --two: a series in each)",
    )
    parser.add_argument(
        "--two", action="store_true", help="two periods: Fourier series in two frequencies"
    )
    parser.add_argument("--count", type=int, default=_ROWS, help=f"rows printed ({_ROWS})")
    parser.add_argument(
        "--bootstrap", type=int, metavar="N", help="errors of the best periods from N draws too"
    )
    _output.add_figure(parser)


def add_data(parser: argparse.ArgumentParser) -> None:
    """Add FILE and the options of its reduction, which `data_of` reads."""
    parser.add_argument("file", metavar="FILE", help="photometry")
    parser.add_argument("--filter", metavar="NAME", help="use the points with this filter")
    parser.add_argument(
        "--zero-points",
        default="auto",
        help="of sessions: free, shared (filters keep their own), or auto (default): free if the "
        "data ask for it",
    )
    _options.add_orbit_arguments(parser)
    _options.add_site_argument(parser)
    parser.add_argument("--g", type=float, help="slope of the phase function (H, G) to take off")


def run(arguments: argparse.Namespace) -> None:
    """Print the periods with their errors and aliases; write the figure."""
    from attitude._support import validation
    from attitude.photometry import _periods

    _output.picture_of(arguments)
    count = validation.count(arguments.count, "--count")
    if arguments.bootstrap is not None:
        validation.count(arguments.bootstrap, "--bootstrap", 2)
    if arguments.method == "additive" and not arguments.two:
        raise AttitudeError("--method additive is the sum of two series; give --two too.")
    if arguments.method == "pdm" and arguments.two:
        raise AttitudeError("--method pdm knows one period; leave out --two, or --method.")
    data = data_of(arguments)
    print(repr(data)[1:-1])
    for note in data.notes:
        print(f"note: {note}")
    periods = _periods.periods(
        data,
        count=2 if arguments.two else 1,
        min_period=arguments.min,
        max_period=arguments.max,
        order=arguments.order,
        method=arguments.method,
        keep=max(count, _ROWS) if arguments.two else count,
        zero_points=arguments.zero_points,
    )
    _print(periods, arguments)
    _output.draw(arguments.figure, periods.plot)


def data_of(arguments: argparse.Namespace) -> LightCurve:
    """The photometry of the options that `add_data` adds, reduced where its geometry is known."""
    from attitude._support import validation
    from attitude.photometry._curve import LightCurve

    data = LightCurve.read(arguments.file)
    if arguments.filter is not None:
        data = data.select(filter=arguments.filter)
    validation.one_of(arguments.zero_points, "--zero-points", ("auto", "free", "shared"))
    path = _options.path_of(arguments)
    site = _options.site_of(arguments)
    if path is not None or data.has_geometry:
        return data.reduced(path, site=site, g=arguments.g)
    if arguments.g is not None:
        raise AttitudeError("--g needs the geometry; give --orbit, or vectors in the file.")
    return data


def _print(periods, arguments):
    """Print a table of the peaks in the unit of the best one, and what it may mean."""
    from attitude._support.quantity_text import time_unit

    size, unit = time_unit(periods.period)
    what = "pairs" if periods.count == 2 else "frequencies"
    print(
        f"{periods.tried} {what}; by chance 1 of 100 light curves leaves "
        f"{periods.false_alarm:.3f} of chi-squared"
    )
    names = ("first", "second") if periods.count == 2 else ("period",)
    head = "".join(f"{f'{name}, {unit}':>14}{'+-':>10}" for name in names)
    print(f"{'':3}{head}{'power':>8}{'left':>8}  relation")
    for rank, peak in enumerate(periods.peaks[: arguments.count], 1):
        both = zip(peak.periods, peak.errors, strict=True)
        numbers = "".join(f"{one / size:14.7g}{error / size:10.2g}" for one, error in both)
        print(f"{rank:3d}{numbers}{peak.power:8.3f}{peak.left:8.3f}  {peak.relation}".rstrip())
    if arguments.bootstrap is not None:
        errors = ", ".join(
            f"{draw / size:.2g} {unit}" for draw in periods.bootstrap(draws=arguments.bootstrap)
        )
        print(f"error of the best by bootstrap: {errors}")
    if periods.count == 2:
        print("candidates for the rotation:")
        for rank, candidate in enumerate(periods.candidates(arguments.count), 1):
            print(f"{rank:3d} {candidate}")
    elif periods.hint:
        print(f"note: {periods.hint}")
