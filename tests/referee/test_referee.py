"""The referee: orders that the literature states, laws that each scheme keeps, and bad input."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, Spin
from attitude.referee._referee import compare

BODY = Body(moments=(10, 20, 26))
SPIN = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(2, 1, 5))
STEPS = (0.02, 0.01, 0.005)


@pytest.fixture(scope="module")
def result():
    names = ["dlm", "reich", "celledoni-safstrom", "buss", "rk4", "exact-step"]
    return compare(names, BODY, SPIN, 10.0, steps=STEPS)


@pytest.mark.parametrize(
    ("name", "order"),
    [("dlm", 2), ("reich", 2), ("celledoni-safstrom", 4), ("buss", 2), ("rk4", 4)],
)
def test_order(result, name, order):
    assert result.orders()[name][-1] == pytest.approx(order, abs=0.3)


def test_what_each_scheme_conserves(result):
    worst = {run.name: run for run in result.runs if run.step == max(r.step for r in result.runs)}
    # splittings turn the body under a momentum that is fixed in space
    for name in ("dlm", "reich", "buss", "exact-step"):
        assert worst[name].momentum_drift < 1e-12
    for name in ("celledoni-safstrom", "exact-step"):
        assert worst[name].energy_drift < 1e-13
        assert worst[name].rate_error < 1e-12
    assert worst["exact-step"].attitude_error < 1e-12
    assert worst["rk4"].momentum_drift > 1e-8
    assert worst["dlm"].energy_drift > 1e-6


@pytest.mark.parametrize(
    "moments", [(26, 10, 20), (20, 10, 26), (26, 20, 10), (1e-150, 2e-150, 2.5e-150)]
)
def test_exact_flow_at_steps_of_many_pieces_and_moments_in_any_order(moments):
    """One piece for a long step erred by 0.08 rad; a body may be given in any order and unit."""
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(3, 7, 40))
    result = compare(
        ["exact-step", "celledoni-safstrom"], Body(moments=moments), spin, 5.0, steps=(0.05, 0.5)
    )
    for run in result.runs:
        assert run.rate_error < 1e-12 and run.energy_drift < 1e-13
        assert run.name != "exact-step" or run.attitude_error < 3e-12


def test_a_user_s_scheme_and_scipy():
    def euler(moments, wxyz, omega, h):
        from attitude.frames import quaternion

        rate = -np.cross(omega, moments * omega) / moments
        q = quaternion.multiply(wxyz, np.append(1.0, 0.5 * h * omega))
        return q / np.sqrt(q @ q), omega + h * rate

    result = compare([euler, "DOP853"], BODY, SPIN, 1.0, steps=(1e-3, 5e-4), epochs=10)
    assert result.orders()["euler"][0] == pytest.approx(1.0, abs=0.2)
    solved = result.of("DOP853")[0]
    # 1e-12 a step, some 300 steps' worth of growth
    assert solved.attitude_error < 1e-9 and solved.step == 1e-12
    assert np.isnan(solved.seconds_per_step) and solved.seconds > 0.0
    assert len(result.table()) == 3 and "euler" in repr(result)


def test_axes_that_are_not_principal():
    turned = Body(tensor=[[2.0, 0.3, 0.1], [0.3, 2.5, 0.5], [0.1, 0.5, 2.6]])
    result = compare("exact-step", turned, SPIN, 10.0, steps=(0.02,))
    assert result.runs[0].attitude_error < 1e-12


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: compare("euler", BODY, SPIN, 1.0, steps=STEPS), "integrators holds 'euler'"),
        (lambda: compare("dlm", BODY, SPIN, 1.0), "steps is empty"),
        (lambda: compare("dlm", BODY, SPIN, -1.0, steps=STEPS), "greater than zero"),
        (lambda: compare("dlm", BODY, SPIN, 1.0, steps=(0.0,)), "greater than zero"),
        (lambda: compare("dlm", BODY, SPIN, 1.0, steps=STEPS, epochs=0), "whole number"),
        (lambda: compare("dlm", (1, 2, 3), SPIN, 1.0, steps=STEPS), "compare takes"),
        (lambda: compare("dlm", Body(moments=(0, 1, 1)), SPIN, 1.0, steps=STEPS), "rod"),
        (
            lambda: compare(lambda m, q, w, h: (q, w * np.nan), BODY, SPIN, 1.0, steps=STEPS),
            "is not finite",
        ),
        (
            lambda: compare(lambda m, q, w, h: (q[:3], w), BODY, SPIN, 1.0, steps=STEPS),
            "returned shapes",
        ),
        (lambda: compare(lambda m, q, w, h: None, BODY, SPIN, 1.0, steps=STEPS), "returned None"),
        (
            lambda: compare(lambda m, q, w, h: (0.0 * q, w), BODY, SPIN, 1.0, steps=STEPS),
            "a quaternion is zero",
        ),
        # what is shipped is not spared
        (lambda: compare("rk4", BODY, SPIN, 1e3, steps=(10.0,)), "rk4 is not finite"),
        (lambda: compare("rk4", BODY, SPIN, 1.0, steps=(1e-300,)), "more than 2.53"),
        (lambda: compare("rk4", BODY, SPIN, 1.0, steps=STEPS, epochs=True), "whole number"),
        (lambda: compare("DOP853", BODY, SPIN, 1.0, tolerances=(1e-17,)), "give tolerances of 2"),
        (lambda: compare(None, BODY, SPIN, 1.0), "integrators holds None"),
        (lambda: compare([[1], [2, 3]], BODY, SPIN, 1.0), r"integrators holds \[1\]"),
        (lambda: compare("rk4", BODY, SPIN, 1.0, steps=[[1], [2, 3]]), "steps has shape"),
        (lambda: compare([], BODY, SPIN, 1.0, steps=STEPS), "integrators is empty"),
        (lambda: compare("DOP853", BODY, SPIN, 1.0, tolerances=()), "tolerances is empty"),
        (
            lambda: compare("exact-step", BODY, SPIN, 2e16, steps=(2e16,), epochs=1),
            "turns by up to",
        ),
    ],
)
def test_bad_input_is_a_sentence(call, message):
    with pytest.raises(AttitudeError, match=message):
        call()


def test_one_of_each_needs_no_list():
    one = compare("rk4", BODY, SPIN, 1.0, steps="0.01 s", epochs=np.int64(5)).runs
    assert len(one) == 1 and one[0].step == 0.01
    assert compare("DOP853", BODY, SPIN, 1.0, tolerances=1e-8).runs[0].step == 1e-8


def test_steps_longer_than_the_time_between_epochs_are_kept():
    runs = compare("rk4", BODY, SPIN, 10.0, steps=(0.5, 0.25)).runs
    assert [run.step for run in runs] == [0.5, 0.25]
