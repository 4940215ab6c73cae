"""Constants of rotations about a fixed axis: spheres, principal axes, rest."""

import math

from attitude.compilation.decorators import sized_entry_point, subroutine
from attitude.solution import codes
from attitude.solution.given_axes import any_of, at_start, plus, product, turned_by
from attitude.solution.series import four
from attitude.solution.twofloat import TWO_PI, add, div, less, pair, sqrt, square, sub


@sized_entry_point
def uniform_all(wxyz, wxyz_low, principal, constants):
    """Fill the constants of those of B motions whose angular velocity is constant.

    q(t) = q(0) (cos + sin of half the angle times the unit axis): two rows of `frame`.

    Given
        wxyz       (B, 4) body to inertial at the epoch, of any length
        wxyz_low   (1 or B, 4) second doubles of wxyz, then of unit length; or zeros
        principal  (1 or B, 4) principal axes to given body axes
    """
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.UNIFORM:
            low = four(wxyz_low[b if len(wxyz_low) > 1 else 0])
            _turn(four(wxyz[b]), low, four(principal[b if len(principal) > 1 else 0]), c)
            _periods(c)


@subroutine
def _turn(wxyz, low, principal, c):
    """Fill attitude, axis and rate of the turn."""
    x, y, z = pair(c.omega[0]), pair(c.omega[1]), pair(c.omega[2])
    speed = sqrt(add(add(square(x), square(y)), square(z)))
    turns = div(speed, TWO_PI)
    c.precession[0] = math.ldexp(0.5 * turns[0], c.tempo)
    c.precession[1] = math.ldexp(0.5 * turns[1], c.tempo)
    axis = turned_by(principal, (x[0], y[0], z[0]))
    over = 0.0 if speed[0] == 0.0 else 1.0 / speed[0]
    start = at_start(wxyz, low)
    axis_turn = 0.0, axis[0] * over, axis[1] * over, axis[2] * over
    turn = product(start, axis_turn)
    if any_of(low):
        turn = plus(turn, product(low, axis_turn))
    for k in range(4):
        c.frame[0, k] = start[k]
        c.frame[1, k] = turn[k]
    for k in range(3):
        c.rates[0, k] = math.ldexp(axis[k], c.tempo)


@subroutine
def _periods(c):
    """Fill the rates of psi and phi of a vanishing wobble about the axis."""
    c.circulates = -1
    turns = 2.0 * c.precession[0]
    psi, phi = 0.0, turns
    for k in range(3):
        if c.omega[k, 0] != 0.0:
            here = pair(c.moments[k])
            one, two = pair(c.moments[(k + 1) % 3]), pair(c.moments[(k + 2) % 3])
            positive = sub(here, one)[0] * sub(here, two)[0]
            if positive > 0.0:
                root = math.sqrt(positive / (one[0] * two[0]))
                c.circulates = k
                if less(here, one):
                    # phi' = turns (1 - root), without the cancellation of a needle's
                    rest = here[0] / one[0] * (sub(add(one, two), here)[0] / two[0])
                    psi, phi = turns * root, turns * rest / (1.0 + root)
                else:
                    psi, phi = -turns * root, turns * (1.0 + root)
    c.psi_rate = psi
    c.phi_rate = phi
