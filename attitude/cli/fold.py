"""``attitude fold FILE --period P``: a light curve folded with one period or two."""

from __future__ import annotations

import argparse
import warnings

from attitude.cli import _options, _output, periods
from attitude.errors import AttitudeWarning

HELP: str = "fold photometry with one period or two: points, series and residuals"
EPILOG: str = """\
examples:
  attitude fold curve.csv --period "5.37 h" --figure folded.png
  attitude fold curve.csv --period "5.37, 7.4 d" --order 2 --refine --output folded.csv

FILE and the reduction are those of "attitude periods".
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    periods.add_data(parser)
    parser.add_argument(
        "--period", metavar="P", required=True, help='period, or two: "5.37 h", "5.37, 7.4 d"'
    )
    parser.add_argument("--order", type=int, help="harmonics of the series (4; of two periods 2)")
    parser.add_argument("--epoch", metavar="DATE", help="of phase zero (the first point)")
    parser.add_argument(
        "--refine", action="store_true", help="take the periods of least squares near these"
    )
    parser.add_argument("--output", metavar="FILE", help="points as x.csv or x.ecsv")
    _output.add_figure(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the periods, amplitude and rms; write table and figure."""
    import numpy as np

    from attitude._support import quantity_text, validation
    from attitude.photometry import _folding

    _output.picture_of(arguments)
    times = _options.periods(arguments.period, "--period")
    order = 4 if len(times) == 1 else 2
    if arguments.order is not None:
        order = validation.count(arguments.order, "--order")
    kind = _output.kind_of(arguments.output)
    data = periods.data_of(arguments)
    folded = _folding.fold(
        data,
        times,
        order=order,
        epoch=arguments.epoch,
        refine=arguments.refine,
        zero_points=arguments.zero_points,
    )
    print(repr(data)[1:-1])
    phase = np.linspace(0.0, 1.0, 1000)
    for k, period in enumerate(folded.periods):
        if period > folded.samples.span:
            warnings.warn(
                f"the light curve spans {folded.samples.span / period:.2g} turns of a period of "
                f"{quantity_text.of_time(period)}: the curve at other phases is not known.",
                AttitudeWarning,
                stacklevel=1,
            )
        error = folded.series.errors[k] * period**2
        size = float(np.ptp(folded.curve(phase, k)))
        scale, unit = quantity_text.time_unit(period)
        print(f"period {period / scale:.8g} +- {error / scale:.2g} {unit}, peak to peak {size:.3g}")
    print(f"rms of the residuals {folded.rms:.4g}, order {order}")
    if arguments.output is not None:
        _output.write_table(folded.table(), arguments.output, kind)
        print(arguments.output)
    _output.draw(arguments.figure, folded.plot)
