"""The cases of data/torque-free-cases.json, and the code that docs/brick.md shows for each tool."""

import json

import numpy as np
import pytest
from mpmath import mp

from attitude import Body, FreeRotation, Spin
from benchmarks import brick
from tests.support import oracle, taylor

CASES = json.loads(brick.CASES.read_text())["cases"]
BY_NAME = {case["name"]: case for case in CASES}
# Largest error up to ten turns of the case "brick", rad, where docs/brick.md says what integrators
# reach up to 100; SPICE interpolates, with (turn / 200)^2 / 8.
LARGEST = {
    "attitude": 4e-15,
    "scipy": 1e-8,
    "heyoka": 1e-12,
    "Orekit": 1e-12,
    "Basilisk": 2e-6,
    "42": 2e-6,
    "42, its formulas": 2e-6,
    "Tudat": 2e-6,
    "SPICE": 1e-3,
}


def test_the_file_is_what_its_script_writes():
    """State by state; the answers of one case once more."""
    assert list(BY_NAME) == list(brick.STATES)
    for name, (_, moments, wxyz, rates) in brick.STATES.items():
        case = BY_NAME[name]
        assert (case["moments"], case["wxyz"]) == (list(moments), list(wxyz))
        assert case["angular_velocity"] == list(rates)
        assert len(case["epochs"]) == len(case["answers"]) == len(case["conditioning"])
    case = BY_NAME["separatrix"]
    state = case["moments"], case["wxyz"], case["angular_velocity"]
    exact = oracle.Oracle(*state, digits=40)
    for t, answer in zip(case["epochs"], case["answers"], strict=True):
        wxyz, omega = exact.at(t)
        assert answer == {"wxyz": brick._texts(wxyz), "angular_velocity": brick._texts(omega)}


@pytest.mark.parametrize("case", CASES, ids=BY_NAME)
def test_the_package_agrees_with_the_file(case):
    body = Body(moments=case["moments"])
    spin = Spin(epoch="2026-01-01", wxyz=case["wxyz"], angular_velocity=case["angular_velocity"])
    history = FreeRotation(body, spin).at(np.array(case["epochs"]))
    assert np.nanmax(brick.errors(history.wxyz, case)) < 4e-15
    exact = np.array([answer["angular_velocity"] for answer in case["answers"]], dtype=float)
    size = np.abs(exact).max()
    np.testing.assert_allclose(history.angular_velocity, exact, rtol=0, atol=4e-15 * size)


def test_an_integration_in_forty_digits_agrees_with_the_file():
    case = BY_NAME["brick"]
    with mp.workdps(50):
        start = [mp.mpf(x) for x in case["wxyz"]]
        for k in (2, 3, 4):  # 1, 3 and 10 turns
            found = taylor.state(case["moments"], case["angular_velocity"], case["epochs"][k])
            values = [mp.mpf(x.numerator) / x.denominator for x in found]
            values[:4] = oracle.multiply(start, values[:4])
            answer = case["answers"][k]
            exact = [mp.mpf(text) for text in answer["wxyz"] + answer["angular_velocity"]]
            assert max(abs(x - y) for x, y in zip(values, exact, strict=True)) < 1e-24


TOOLS, MISSING = brick.tools()


def test_the_page_has_eight_tools():
    names = {name.partition(",")[0] for name, _ in [*TOOLS, *MISSING]}
    assert names == {name.partition(",")[0] for name in LARGEST}


@pytest.mark.parametrize(("name", "solve"), TOOLS, ids=[name for name, _ in TOOLS])
def test_the_code_of_the_page_follows_the_brick(name, solve):
    case = BY_NAME["brick"]
    epochs = np.array(case["epochs"][:5])  # up to ten turns
    wxyz = solve(case["moments"], case["wxyz"], case["angular_velocity"], epochs, case["turn"])
    found = brick.errors(wxyz, case)
    assert len(found) == 5 and found.max() < LARGEST[name]
    assert found[1:].max() > 0.0
