"""``attitude warm-up``: compile ahead of use."""

from __future__ import annotations

import argparse
import time

HELP: str = "compile ahead of use, as a step of an installation or of a container image"
EPILOG: str = """\
Machine code is kept in the folder of NUMBA_CACHE_DIR, else beside the package, else in the user's
cache folder. It serves all users who may read that folder, on the same kind of processor.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--all",
        action="store_true",
        help="events, impulses, torques, derivatives, scenes and light curves too (a minute)",
    )


def run(arguments: argparse.Namespace) -> None:
    """Compile, and print what was compiled and where it is kept."""
    from attitude._compilation.status import compilation_status
    from attitude.cli import _warm_up

    begin = time.perf_counter()
    for feature in _warm_up.features(everything=arguments.all):
        start = time.perf_counter()
        feature()
        print(f"{feature.__name__.replace('_', ' '):<24} {time.perf_counter() - start:6.1f} s")
    status = compilation_status()
    print(
        f"{len(status.compiled)} entry points in {time.perf_counter() - begin:.1f} s; "
        f"kept in {status.cache}."
    )
