"""The iteration of least squares, against scipy's, for many states at a time."""

import numpy as np
import pytest
from scipy import optimize

from attitude._support import least_squares
from attitude._support.least_squares import Near, Problem, Rule

RULE = Rule(start=1e-3, least=1e-12, stuck=1e8, larger=5.0, gain=1e-15, settled=3)
T = np.linspace(0.0, 4.0, 30)
# A decaying wave with errors: its cost has many minima by the frequency.
TRUTH = np.array([1.3, 0.4, 2.1, 0.7])
Y = TRUTH[0] * np.exp(-TRUTH[1] * T) * np.cos(TRUTH[2] * T + TRUTH[3])
Y += np.random.default_rng(8).normal(0.0, 0.05, T.size)


def residual(x):
    return Y - x[0] * np.exp(-x[1] * T) * np.cos(x[2] * T + x[3])


def jacobian(x):
    """(N, 4), of the model."""
    decay = np.exp(-x[1] * T)
    cosine, sine = decay * np.cos(x[2] * T + x[3]), decay * np.sin(x[2] * T + x[3])
    return np.stack([cosine, -x[0] * T * cosine, -x[0] * T * sine, -x[0] * sine], axis=-1)


def linearised(states, stays=()):
    r = np.array([residual(x) for x in states]).reshape(-1, T.size)
    j = np.array([jacobian(x) for x in states]).reshape(-1, T.size, 4)
    normal, gradient = j.swapaxes(1, 2) @ j, (r[:, None] @ j)[:, 0]
    for k in stays:
        normal[:, k] = normal[:, :, k] = gradient[:, k] = 0.0
        normal[:, k, k] = 1.0
    return Near(states, np.sum(r**2, axis=1), normal, gradient)


def moved(states, steps):
    """After steps of at most a half, from which no decay overflows."""
    return states + np.clip(steps, -0.5, 0.5), np.ones(len(states), bool)


def starts(count):
    return TRUTH + np.random.default_rng(3).normal(0.0, 0.5, (count, 4))


def test_minima_are_those_of_scipy():
    best = least_squares.minimum(Problem(linearised, moved), starts(60), RULE, 400)
    compared = 0
    for x, cost, gradient in zip(best.states, best.cost, best.gradient, strict=True):
        again = optimize.least_squares(
            residual, x, lambda x: -jacobian(x), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15
        )
        # a minimum: scipy goes on from it and wins nothing
        assert cost <= 2.0 * again.cost * (1.0 + 1e-9), x
        assert cost == pytest.approx(np.sum(residual(x) ** 2), rel=1e-15)
        compared += bool(np.allclose(again.x, x, rtol=0.0, atol=1e-5))
        assert np.abs(gradient).max() < 1e-4
    assert compared >= 55
    assert np.count_nonzero(best.cost < 0.1) > 40
    assert np.sum((best.states[np.argmin(best.cost)] - TRUTH) ** 2) < 0.1


def test_costs_alone_are_computed_of_steps_that_fail_and_of_last_ones():
    """The same states, with derivatives of those alone from which a step was taken."""
    counts = {"near": 0, "costs": 0}

    def near(states):
        counts["near"] += len(states)
        return linearised(states)

    def costs(states):
        counts["costs"] += len(states)
        return linearised(states).cost

    def reached(problem):
        return least_squares.minimum(problem, starts(20), RULE, 12).states

    first = reached(Problem(near, moved))
    evaluations = counts["near"]
    counts["near"] = 0
    np.testing.assert_array_equal(reached(Problem(near, moved, costs, is_cost_first=True)), first)
    assert counts["costs"] == evaluations - 20
    assert counts["near"] < 0.9 * evaluations


def test_each_of_many_is_as_if_alone():
    problem = Problem(linearised, moved)
    many = least_squares.minimum(problem, starts(20), RULE, 12)
    for k, start in enumerate(starts(20)):
        alone = least_squares.minimum(problem, start[None], RULE, 12)
        assert np.array_equal(alone.states[0], many.states[k])
        assert alone.cost[0] == many.cost[k]


def test_starts_stay_as_they_are_and_parameters_that_are_held():
    given = starts(5)
    problem = Problem(lambda states: linearised(states, stays=(1,)), moved)
    best = least_squares.minimum(problem, given, RULE, 60)
    assert np.array_equal(given, starts(5))
    assert np.array_equal(best.states[:, 1], given[:, 1])
    assert np.all(best.cost < linearised(given).cost)


def test_costs_never_rise_and_the_last_may_be_costs_alone():
    evaluated = []

    def costs(states):
        evaluated.append(len(states))
        return linearised(states).cost

    before = linearised(starts(30)).cost
    for evaluations in range(2, 9):
        whole = least_squares.minimum(Problem(linearised, moved), starts(30), RULE, evaluations)
        problem = Problem(linearised, moved, costs)
        short = least_squares.minimum(problem, starts(30), RULE, evaluations)
        assert np.array_equal(whole.states, short.states) and np.all(whole.cost <= before)
        before = whole.cost
    assert len(evaluated) == 7


@pytest.mark.parametrize(("bounds_count", "evaluations"), [(True, 1), (False, 6)])
def test_steps_outside_of_the_bounds_are_damped(bounds_count, evaluations):
    """The frequency may rise by 0.01 a step: most first steps are longer."""
    start = TRUTH - np.array([0.0, 0.0, 0.2, 0.0])
    seen = []

    def near(states):
        seen.extend(states[:, 2])
        return linearised(states)

    def bounded(states, steps):
        return states + steps, np.abs(steps[:, 2]) < 0.01

    rule = RULE._replace(bounds_count=bounds_count)
    best = least_squares.minimum(Problem(near, bounded), start[None], rule, 6)
    assert len(seen) == evaluations or (bounds_count and len(seen) < 6)
    assert np.all(np.abs(np.diff(seen)) < 0.01) and best.cost[0] <= linearised(start[None]).cost[0]


def test_a_state_without_a_cost_ends_and_the_others_go_on():
    def near(states):
        computed = linearised(states)
        computed.cost[states[:, 0] < 0.0] = np.inf
        return computed

    given = starts(8)
    given[3, 0] = -1.0
    best = least_squares.minimum(Problem(near, moved), given, RULE, 30)
    assert np.isinf(best.cost[3]) and np.array_equal(best.states[3], given[3])
    assert np.all(np.isfinite(np.delete(best.cost, 3)))


def test_parameters_that_nothing_depends_on_stay():
    def near(states):
        computed = linearised(states)
        for column in (computed.normal[:, 0], computed.normal[:, :, 0], computed.gradient[:, 0]):
            column[...] = 0.0
        return computed

    best = least_squares.minimum(Problem(near, moved), starts(4), RULE, 20)
    assert np.array_equal(best.states[:, 0], starts(4)[:, 0])


def test_it_ends_when_it_is_over():
    rounds = []

    def is_over():
        rounds.append(1)
        return len(rounds) == 3

    least_squares.minimum(Problem(linearised, moved), starts(9), RULE, 100, is_over)
    assert len(rounds) == 3
