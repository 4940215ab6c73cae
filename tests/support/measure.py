"""What the package answers for a state, and how far that is from the exact answer."""

from typing import NamedTuple

import numpy as np

from attitude import Body, FreeRotation, Spin, certify, propagate
from tests.support.oracle import Oracle, rate_error, rotation_error
from tests.support.states import State

DIGITS = 25  # of the oracle: nine more than doubles have


class Error(NamedTuple):
    """One epoch of one state: where, and how wrong."""

    attitude: float  # rad, signed: the wrong overall sign is 2 pi
    rate: float  # relative to the largest component
    seconds: float
    state: State


def by_propagate(state, seconds):
    """(wxyz, omega) of the array floor."""
    return propagate(state.moments, state.wxyz0, state.omega0, seconds, angular_velocity=True)


def by_motion(state, seconds):
    """(wxyz, omega) of the objects."""
    history = motion_of(state).at(np.asarray(seconds))
    return history.wxyz, history.angular_velocity


def motion_of(state):
    spin = Spin(epoch="2026-01-01", wxyz=state.wxyz0, angular_velocity=state.omega0)
    return FreeRotation(Body(moments=state.moments), spin)


def errors(state, seconds, evaluate=by_propagate):
    """An Error for each of some epochs, against the oracle."""
    exact = Oracle(state.moments, state.wxyz0, state.omega0, digits=DIGITS)
    wxyz, omega = evaluate(state, seconds)
    return [
        Error(error_of(q, right[0]), rate_error(w, right[1]), t, state)
        for q, w, t, right in zip(wxyz, omega, seconds, map(exact.at, seconds), strict=True)
    ]


def certified(state, seconds):
    """As `errors`, for many states: by certificates (attitude.proof), which contain the error and
    exceed it by 1e-18 at most.
    """
    motion = motion_of(state)
    wxyz, omega = by_propagate(state, seconds)
    low = np.zeros(len(seconds))  # seconds, not what looks like a Julian date
    found = certify(motion.body, motion.spin, seconds, wxyz, low=low, angular_velocity=omega)
    turned = np.where(found.same_sign, found.error, 2.0 * np.pi - found.error)
    size = np.maximum(np.abs(omega).max(axis=1), 1e-300)
    return [
        Error(float(angle), float(rate), t, state)
        for angle, rate, t in zip(turned, found.rate_error / size, seconds, strict=True)
    ]


def error_of(wxyz, exact):
    """Radians between two attitudes, their signs compared too."""
    return rotation_error(wxyz, exact, signed=True)


def worst(errors):
    """The Error with the largest attitude error, and the largest rate error of all."""
    return max(errors), max(error.rate for error in errors)
