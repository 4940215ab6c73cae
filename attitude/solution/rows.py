"""Attitudes at rows of epochs, each of one of many bodies: runs of rows of the same body.

Rows in which the members stand in any order are brought into runs by a counting sort.
"""

from attitude.compilation.decorators import sized_entry_point
from attitude.solution.chain import evaluate_part


@sized_entry_point
def evaluate_runs(constants, starts, t, t_low, wxyz, rates):
    """Attitudes, and angular velocities unless rates is None, of B runs of rows.

    Given
        constants  (B,) records (solution.record), one of each run
        starts     (B + 1,) the rows of run b are starts[b] to starts[b + 1]
        t, t_low   (1, R) seconds since the epoch of the state; t_low may be None
    Filled
        wxyz       (1, 4, R) body to inertial
        rates      (1, 3, R) rad/s over the given body axes, or None
    Returned
        -1, or the first run with an epoch beyond its reach; it and those after it are not filled
    """
    for b in range(len(constants)):
        first, end = starts[b], starts[b + 1]
        if evaluate_part(constants[b : b + 1], t, t_low, wxyz, rates, first, end, first):
            return b
    return -1


@sized_entry_point
def surveyed(member):
    """The least and the greatest of N >= 1 whole numbers, how many runs of equals, of descents."""
    least = greatest = before = member[0]
    runs, descents = 1, 0
    for k in range(1, len(member)):
        here = member[k]
        least, greatest = min(least, here), max(greatest, here)
        runs += here != before
        descents += here < before
        before = here
    return least, greatest, runs, descents


@sized_entry_point
def runs_of(member, first, end, who, starts):
    """Fill the member and the first row of each run of the rows first to end, and the end.

    Returned
        the number of runs
    """
    count = 0
    for k in range(first, end):
        if k == first or member[k] != member[k - 1]:
            who[count], starts[count] = member[k], k
            count += 1
    starts[count] = end
    return count


@sized_entry_point
def counted(member, counts):
    """Add the number of rows of each member to counts."""
    for k in range(len(member)):
        counts[member[k]] += 1


@sized_entry_point
def placed(member, first, places, order):
    """Fill the order in which rows stand by member, each member's as given.

    Given
        member     (K,) of the rows from `first` on
        places     the next place of each member; advanced
    """
    for k in range(len(member)):
        place = places[member[k]]
        order[place] = first + k
        places[member[k]] = place + 1
