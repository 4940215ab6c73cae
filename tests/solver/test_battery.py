"""The checks of `tests/support/battery.py`, and whether wrong constants and operators fail them."""

import os
import re
import subprocess
import sys

import pytest

from benchmarks import mutation
from tests.support import battery
from tests.support.places import ROOT

pytest.importorskip("flint", reason="python-flint is not installed")

# Checks that compare with exact derivatives, which take two thirds of the time of all truths.
EXACT_DERIVATIVES = ("derivatives", "covariances")


@pytest.fixture(scope="module")
def truths():
    return battery.truths(has_derivatives=False)


@pytest.mark.parametrize("name", [x for x in battery.CHECKS if x not in EXACT_DERIVATIVES])
def test_the_package_passes(name, truths):
    battery.CHECKS[name](truths)


@pytest.mark.slow
def test_derivatives_pass():
    """In the run without soaks `test_sensitivity` and its neighbours compare derivatives."""
    truths = battery.truths()
    for name in EXACT_DERIVATIVES:
        battery.CHECKS[name](truths)


def _mutation(*modules):
    """The report of benchmarks/mutation.py, which ends with 1 if fewer than 98 % of the changes
    that are not equivalent are killed, and for survivors without a reason.
    """
    command = [sys.executable, str(ROOT / "benchmarks" / "mutation.py"), *modules]
    result = subprocess.run(command, capture_output=True, text=True, env=dict(os.environ))
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def test_reasons_are_of_changes_that_exist():
    """A statement that was rewritten takes its reasons with it."""
    modules = {**mutation.MODULES, **mutation.SAMPLED}
    names = {change.name for module in modules for change in mutation.changes_of(module)}
    assert sorted(mutation.equivalent().keys() - names) == []


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="changes are imported in forked processes")
def test_changes_of_the_pairs_are_killed():
    report = _mutation("pairs")
    assert re.search(r"^\d+ of \d+ changes killed, \d+\.\d %", report, re.MULTILINE)


@pytest.mark.slow
def test_changes_of_all_modules_are_killed():
    """4,300 changes in an hour of one processor."""
    _mutation()
