"""Attitudes at the widest steps between which great circles stay within an angle of the motion."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.viewer.subject import Subject

# Largest angle between the motion and what is drawn, rad: a tenth of a degree.
TOLERANCE: float = float(np.radians(0.1))
# Of it, what the great circles may take; rounding to 16 bits takes 0.007 degree at most.
_SHARE = 0.85
# Most attitudes of one page: 8 MB of text.
MOST: int = 400_000
# Largest turn between two attitudes, rad: beyond pi a great circle goes the other way.
_TURN = 2.0
# Places between two attitudes at which the error is measured, in steps; no two have a common
# divisor, so that whole turns between two attitudes are noticed.
_BETWEEN = (0.5, 0.236, 0.691)
# Steps of a piece that are measured, at most, at each trial.
_MEASURED = 4000
# Of a step, by which the last attitude of a piece lies before a jump.
_BEFORE = 1e-9


@dataclass(frozen=True)
class PosePiece:
    """Equally spaced attitudes between two jumps of the angular velocity.

    Attributes
    ----------
    start, step : float
        s from the start of the span, and between attitudes.
    wxyz, angular_velocity : (N, 4), (N, 3) arrays
        Body to ICRF; rad/s over the body axes.
    """

    start: float
    step: float
    wxyz: FloatArray
    angular_velocity: FloatArray


def pieces(subject: Subject, tolerance: float = TOLERANCE) -> list[PosePiece]:
    """The attitudes of a subject, each piece with the widest step that keeps the tolerance.

    Raises
    ------
    AttitudeError
        If the span needs more than `MOST` attitudes.
    """
    bounds = np.concatenate([[0.0], subject.breaks(), [subject.duration]])
    found: list[PosePiece] = []
    for begin, end in pairwise(bounds):
        left = MOST - sum(len(each.wxyz) for each in found)
        found.append(_piece(subject, float(begin), float(end), tolerance, left))
    return found


def _piece(subject: Subject, begin: float, end: float, tolerance: float, most: int) -> PosePiece:
    length = end - begin
    count = _first_count(subject, begin, length)
    while True:
        if count + 1 > most:
            raise _too_many(subject, length, count, most)
        error = _error(subject, begin, length, count)
        if error <= _SHARE * tolerance:
            break
        # The error falls with the square of the step at least.
        factor = np.sqrt(error / (_SHARE * tolerance))
        count = int(np.ceil(count * min(max(1.1 * factor, 1.2), 4.0)))
    times = begin + length * np.arange(count + 1) / count
    times[-1] -= _BEFORE * length / count if end < subject.duration else 0.0
    history = subject.at(times)
    rates = np.asarray(history.angular_velocity)
    return PosePiece(begin, length / count, np.asarray(history.wxyz), rates)


def _first_count(subject: Subject, begin: float, length: float) -> int:
    """Steps over which the body turns by at most `_TURN`, by its rate at some epochs."""
    inner = begin + length * np.linspace(0.5 / 64.0, 63.5 / 64.0, 64)
    rates = np.linalg.norm(subject.at(inner).angular_velocity, axis=-1)
    fastest = float(np.max(rates))
    return max(1, int(np.ceil(fastest * length / _TURN)))


def _error(subject: Subject, begin: float, length: float, count: int) -> float:
    """Largest measured angle between the motion and great circles, rad."""
    chosen = np.unique(np.floor(np.linspace(0.0, count - 1.0, min(count, _MEASURED))))
    step = length / count
    inside = 1.0 - _BEFORE
    first, last = (subject.at(begin + step * (chosen + k * inside)).wxyz for k in (0, 1))
    turn = forms.to_rotation_vector(quaternion.multiply(quaternion.conjugate(first), last))
    worst = 0.0
    for part in _BETWEEN:
        motion = subject.at(begin + step * (chosen + part)).wxyz
        between = quaternion.multiply(first, forms.from_rotation_vector(turn * part))
        off = quaternion.multiply(quaternion.conjugate(motion), between)
        angles = np.linalg.norm(forms.to_rotation_vector(off), axis=-1)
        worst = max(worst, float(np.max(angles)))
    return worst


def _too_many(subject: Subject, length: float, count: int, most: int) -> AttitudeError:
    longest = 0.9 * length * most / count
    return AttitudeError(
        f"a span of {length:.6g} s needs {count:.2g} attitudes, so that what is drawn stays within "
        f"0.1 degree of the motion; {MOST} can be shown. Give a stop at most {longest:.4g} s after "
        "the start."
    )
