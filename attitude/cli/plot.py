"""``attitude plot NAME|FILE.toml``: a motion as a picture of four panels."""

import os

from attitude.cli import output, target
from attitude.errors import AttitudeError

HELP = "draw a motion: polhode, body axes on the sky, rates and angles against time"
EPILOG = """\
example:
  attitude plot toutatis --output toutatis.png
  attitude plot "99942 Apophis (2014)" --phi0 "0 deg" --psi0 "0 deg" --epoch 2012-12-23
"""


def add_arguments(parser):
    target.add_arguments(parser)
    parser.add_argument(
        "--span", metavar="TIME", help='time to show, such as "20 d" (default: three slow turns)'
    )
    parser.add_argument(
        "--sky", default="ecliptic", metavar="FRAME", help="coordinates of the sky (ecliptic)"
    )
    kinds = ", ".join(output.PICTURES)
    parser.add_argument(
        "--output",
        metavar="FILE",
        help=f"picture, its kind by its ending: {kinds} (default: the name, .png)",
    )


def run(arguments):
    from attitude import plots
    from attitude.textfiles import quantities

    found = target.opened(arguments)
    name = arguments.output or _file_name(found.name, arguments.target)
    output.kind_of(name, output.PICTURES)
    span = None
    if arguments.span is not None:
        span = quantities.in_unit(arguments.span, "--span", "s")
    figure = plots.overview(found.motion, span=span, frame=arguments.sky, title=found.name)
    try:
        figure.savefig(name, dpi=150)
    except OSError as err:
        raise AttitudeError(
            f"{name}: cannot be written ({err.strerror or err}); give another --output."
        ) from err
    print(name)


def _file_name(name, given):
    """A picture in the working directory, called like the entry of the catalogue or the file."""
    if target.is_file(given):
        name = os.path.basename(given).removesuffix(".toml")
    words = "".join(each if each.isalnum() else " " for each in name.lower()).split()
    return "-".join(words) + ".png"
