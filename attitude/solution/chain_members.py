"""Chains of free arcs of many members, which change at the same epochs."""

from attitude.compilation.decorators import entry_point
from attitude.solution.chain import evaluate_arcs
from attitude.solution.flow import flow
from attitude.solution.joints import change_axes, exchange, strike


@entry_point
def join_members(records, moments, axes, principal, length, q, w, in_body, in_space):
    """Carry the states of members over one arc, and add angular momentum at its end.

    Given
        records    (N,) constants of the arc (solution.record)
        moments    (1 or N, 3, 2) principal moments, pairs
        axes       (1 or N, 3, 3, 2) columns: the principal axes in body axes, pairs
        principal  (1 or N, 4) their quaternions, rounded
        length     (2,) seconds, a pair
        in_body    (3,) momentum over the body axes
        in_space   (3, 2) momentum over the inertial axes, pairs
    Changed
        q          (N, 4, 2) body axes to inertial, pairs
        w          (N, 3, 2) rad/s over the principal axes, pairs
    """
    t = length[0], length[1]
    for b in range(len(records)):
        i, j = b if len(moments) > 1 else 0, b if len(axes) > 1 else 0
        near = principal[b if len(principal) > 1 else 0]
        change_axes(q[b], axes[j], near, 1.0)
        flow(records[b], moments[i], t, q[b], w[b])
        change_axes(q[b], axes[j], near, -1.0)
        strike(moments[i], axes[j], q[b], w[b], in_body, in_space)


@entry_point
def exchange_members(moments, axes, new_moments, new_axes, w):
    """Give all members one other body at the same angular momentum.

    Given
        moments, axes          (1 or N, ...) as in `join_members`
        new_moments, new_axes  (3, 2), (3, 3, 2) of the body afterwards
    Changed
        w    (N, 3, 2) rad/s over the principal axes
    """
    for b in range(len(w)):
        i, j = b if len(moments) > 1 else 0, b if len(axes) > 1 else 0
        exchange(moments[i], axes[j], new_moments, new_axes, w[b])


@entry_point
def evaluate_members(constants, starts, t, t_low, wxyz, rates, column):
    """As `solution.chain.evaluate_arcs` for each of N members.

    Given
        constants  (N, K) records of the arcs of each member
        starts     (K, 2) starts of the arcs, the same for all members
    Filled
        wxyz       (N, 4, T), from the column on
        rates      (N, 3, T)
    Returned
        -1, or the first member with an epoch beyond its reach
    """
    for b in range(len(constants)):
        to = wxyz[b : b + 1], rates[b : b + 1]
        if evaluate_arcs(constants[b], starts, t, t_low, to[0], to[1], column) >= 0:
            return b
    return -1
