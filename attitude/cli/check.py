"""``attitude check``: the self-test on the user's own machine."""

from __future__ import annotations

import argparse

import attitude
from attitude.errors import AttitudeError

HELP: str = "compare this installation with reference solutions, and measure its speed"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--families", action="store_true", help="print the worst error of each family of states"
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the self-test and print its result."""
    from attitude.cli import _selftest

    other = _selftest.other_project()
    if other is not None:
        if not hasattr(attitude, "__version__"):  # its __init__.py is there in place of ours
            raise AttitudeError(other)
        print(f"Warning: {other}")
    try:
        result = _selftest.check()
    except (OSError, KeyError, ValueError) as err:
        if isinstance(err, AttitudeError):
            raise
        raise AttitudeError(
            f"the reference states of the installation cannot be read ({err}); install the package "
            "again."
        ) from err
    print(*_selftest.versions(), sep="\n")
    if arguments.families:
        for family, error, rate_error in result.worst:
            print(f"  {family:<32} {error:8.1e} rad   rates {rate_error:8.1e}")
    print(
        f"{result.states} states of every regime, {result.epochs} epochs up to 1e9 revolutions: "
        f"worst attitude error {result.error:.1e} rad, "
        f"angular velocity {result.rate_error:.1e} (relative)."
    )
    print(
        f"{result.nanoseconds:.1f} ns an epoch in long arrays, angular velocity included: "
        f"{result.ratio:.2f} times numpy.sin on this machine."
    )
    verdict = "passed" if result.passed else "FAILED"
    print(
        f"{verdict}: {_selftest.LARGEST_ERROR:.0e} is the accepted error. {result.seconds:.1f} s."
    )
    if not result.passed:
        raise SystemExit(1)
