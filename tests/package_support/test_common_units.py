"""Texts in common units are read without astropy, with the bits that astropy gives."""

import subprocess
import sys

import pytest

from attitude._support import quantity_text, validation
from attitude.cli._options import duration
from tests.support.places import ROOT

PAIRS = [(text, target) for target, known in quantity_text._COMMON.items() for text in known]


@pytest.mark.parametrize(("text", "target"), PAIRS)
def test_common_units_have_the_bits_of_astropy(text, target):
    from astropy import units

    own = units.Unit(quantity_text._spelled(text))
    assert quantity_text.common_factor(text, target) == own.to(target)
    for value in (14.51, -33.529, 1e-300, 3.0):
        expected = units.Quantity(value, own).to_value(target)
        assert validation.real(f"{value!r} {text}", "value", unit=target) == expected
    several = validation.real(f"1.7, -98.709 {text}", "value", unit=target)
    assert several.tolist() == units.Quantity([1.7, -98.709], own).to_value(target).tolist()


def test_spellings_and_other_units():
    assert quantity_text.common_factor("revolutions / day", "rad/s") is not None
    assert (
        quantity_text.common_factor("rpm", "rad/s") == quantity_text._COMMON["rad/s"]["cycle/min"]
    )
    assert quantity_text.common_factor("deg", "s") is None
    assert quantity_text.common_factor("s", None) is None
    assert validation.real("7", "value", unit="s").shape == ()
    assert validation.number("2.5", "value") == 2.5
    assert duration("3 d", "--step") == 259200
    assert duration("1 ms", "--step") * 1000 == 1


def test_the_command_of_the_readme_does_not_import_astropy():
    code = (
        "import sys; from attitude.cli import main; "
        "main(['propagate', 'data/spin/toutatis.toml', '--start', '1992-12-02', '--stop', "
        "'1992-12-19', '--step', '1 d']); "
        "print(sorted({'astropy', 'scipy', 'numba', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        env={"ATTITUDE_COMPILE": "automatic", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"
