"""``attitude check``: the self-test on the user's own machine."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import attitude
from attitude.cli import _options
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.motions._free_rotation import FreeRotation

HELP: str = "compare this installation with reference solutions, and measure its speed"
# rad, the default of --tolerance: records with seven decimals are within it.
_TOLERANCE = 1e-6


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "--families", action="store_true", help="print the worst error of each family of states"
    )
    parser.add_argument(
        "--full",
        action="store_true",
        help="also --families, 20,000 random states, torques and brightness against closed forms "
        "(half a minute, or two where nothing is compiled yet)",
    )
    parser.add_argument(
        "--prove",
        nargs="?",
        const="",
        metavar="FILE",
        help="prove bounds of the errors (extra proof); of a file of attitudes: its distances from "
        "the free rotation of --spin",
    )
    parser.add_argument(
        "--spin", metavar="FILE", help="with --prove FILE: the motion, or a name in the catalogue"
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        metavar="RAD",
        help="with --prove FILE: largest accepted distance of a record; the exit code is 1 beyond "
        f"it ({_TOLERANCE:g} by default)",
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the self-test, or certify a file, and print the result."""
    from attitude.cli import _selftest

    for option in ("spin", "tolerance"):
        if getattr(arguments, option) is not None and not arguments.prove:
            raise AttitudeError(
                f"--{option} is for --prove FILE, as in --prove t.aem --spin t.toml."
            )
    if arguments.prove:
        _prove_file(arguments.prove, arguments.spin, arguments.tolerance)
        return
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
    if arguments.families or arguments.full:
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
    passed = result.passed
    if arguments.full:
        for what, error, accepted in _selftest.more():
            passed = passed and error <= accepted
            print(f"{what}: {error:.1e}, at most {accepted:.0e} is accepted.")
    if arguments.prove is not None:
        certificates = _selftest.certificates()
        worst = max(float(certificate.error.max()) for certificate in certificates)
        print(
            f"Proved: none of {sum(one.error.size for one in certificates)} attitudes errs by "
            f"more than {worst:.3g} rad. Assumed: {'; '.join(certificates[0].assumed)}."
        )
    verdict = "passed" if passed else "FAILED"
    print(
        f"{verdict}: {_selftest.LARGEST_ERROR:.0e} is the accepted error. {result.seconds:.1f} s."
    )
    if not passed:
        raise SystemExit(1)


def _prove_file(file: str, spin: str | None, tolerance: float | None) -> None:
    """Print the largest proved distance of the records of a file from a free rotation."""
    from attitude._support import pairs, validation
    from attitude.formats import detect
    from attitude.motions._free_rotation import certify
    from attitude.motions._table import AttitudeTable

    if spin is None:
        raise AttitudeError("--prove FILE needs --spin FILE, the motion that its records have.")
    limit = _TOLERANCE if tolerance is None else validation.positive(tolerance, "--tolerance")
    motion = _motion(spin)
    with detect.opened(file).motion as table:
        if not isinstance(table, AttitudeTable):
            raise AttitudeError(f"{file} holds no records of attitudes, which could be certified.")
        start, epoch = table.epoch, motion.spin.epoch
        shift = pairs.add((start.seconds, start.low), -epoch.seconds, -epoch.low)
        seconds, low = pairs.add((table.seconds, table.low), *shift)
        certificate = certify(motion.body, motion.spin, seconds, table.wxyz, low=low)
    k = int(certificate.error.argmax())
    when = epoch.after(seconds[k], low[k]).utc_iso
    print(
        f"Proved: none of {certificate.error.size} records of {file} is more than "
        f"{certificate.error[k]:.3g} rad from the free rotation of {spin} (the farthest at {when} "
        f"UTC). Assumed: {'; '.join(certificate.assumed)}; the seconds from the epoch of the spin."
    )
    beyond = int((certificate.error > limit).sum())
    if beyond:
        print(
            f"FAILED: {beyond} of the records {'is' if beyond == 1 else 'are'} farther than "
            f"{limit:g} rad, the accepted distance (--tolerance RAD)."
        )
        raise SystemExit(1)


def _motion(name: str) -> FreeRotation:
    """The free rotation of a file or of an entry of the catalogue."""
    from attitude import catalog
    from attitude.formats import detect
    from attitude.motions._free_rotation import FreeRotation

    if not _options.is_file(name) and catalog.has(name):
        return catalog.entry(name).motion()
    motion = detect.opened(name).motion
    if not isinstance(motion, FreeRotation):
        raise AttitudeError(
            f"{name} holds no free rotation; give a spin file, or a message with inertia and "
            "angular velocity."
        )
    return motion
