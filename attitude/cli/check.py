"""``attitude check``: the self-test on the user's own machine."""

from attitude.errors import AttitudeError

HELP = "test this installation against exact answers, and its speed"


def add_arguments(parser):
    parser.add_argument(
        "--families", action="store_true", help="print the worst error of each family of states"
    )


def run(arguments):
    from attitude import selftest

    try:
        result = selftest.check()
    except (OSError, KeyError, ValueError) as err:
        if isinstance(err, AttitudeError):
            raise
        raise AttitudeError(
            f"the reference states of the installation cannot be read ({err}); install it anew."
        ) from err
    print(*selftest.versions(), sep="\n")
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
    print(f"{verdict}: {selftest.LARGEST_ERROR:.0e} is promised. {result.seconds:.1f} s.")
    if not result.passed:
        raise SystemExit(1)
