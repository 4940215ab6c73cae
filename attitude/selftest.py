"""The self-test: is this installation exact and fast on this machine?

States of every regime, with answers to 30 digits that were computed by an independent method (the
mpmath oracle of the project's tests; benchmarks/make_reference.py wrote the file), are propagated
and compared.
"""

import platform
import sys
import time
from dataclasses import dataclass
from decimal import Decimal
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from attitude.propagation import propagate
from attitude.solution.warm_up import compile_ahead
from attitude.textfiles import records
from attitude.textfiles.lines import packaged

# What is promised: rad, and angular velocity relative to its largest component.
LARGEST_ERROR = 4e-15
_PACKAGES = ("numpy", "scipy", "astropy", "skyfield", "numba", "llvmlite")


@dataclass(frozen=True)
class CheckResult:
    """What the self-test found.

    worst : list of (family, rad, relative rate error), by family in the order of the file
    ratio : cost of an epoch, angular velocity included, over that of numpy.sin, in one run
    nanoseconds : that cost
    seconds : how long all of it took
    """

    worst: list
    states: int
    epochs: int
    ratio: float
    nanoseconds: float
    seconds: float

    @property
    def error(self):
        """The largest attitude error in rad; NaN if any answer is NaN."""
        return float(np.max([row[1] for row in self.worst]))

    @property
    def rate_error(self):
        """The largest error of an angular velocity, relative to its largest component."""
        return float(np.max([row[2] for row in self.worst]))

    @property
    def passed(self):
        return self.error <= LARGEST_ERROR and self.rate_error <= LARGEST_ERROR


def check():
    """Run the self-test.

    Returns
    -------
    CheckResult

    Notes
    -----
    About 1 s; with a cold disk cache 4 to 7 s on two cores and 8 to 10 on one, nearly all of it
    compilation.
    """
    start = time.perf_counter()
    compile_ahead()
    worst, epochs = {}, 0
    states = reference_states()
    for state in states:
        error, rate_error = errors_of(state)
        old = worst.get(state["family"], (0.0, 0.0))
        worst[state["family"]] = np.maximum(old, (error, rate_error))
        epochs += len(state["t"])
    ratio, nanoseconds = _speed()
    rows = [(family, float(pair[0]), float(pair[1])) for family, pair in worst.items()]
    elapsed = time.perf_counter() - start
    return CheckResult(rows, len(states), epochs, ratio, nanoseconds, elapsed)


def reference_states():
    """The stored states: family, moments, wxyz0, omega0, t, and exact wxyz, omega as text."""
    name = "reference/states.json"
    return records.of_json(packaged(name), name)["states"]


def errors_of(state):
    """The largest attitude error (rad) and relative rate error of one stored state."""
    moments, wxyz0, omega0, t = (
        np.array([float.fromhex(x) for x in state[key]])
        for key in ("moments", "wxyz0", "omega0", "t")
    )
    wxyz, omega = propagate(moments, wxyz0, omega0, t, angular_velocity=True)
    exact, off = _less(wxyz, state["wxyz"])
    # What is left of the difference across the exact quaternion is half the angle between them.
    along = np.sum(off * exact, axis=-1, keepdims=True)
    error = 2.0 * np.sqrt(np.sum((off - along * exact) ** 2, axis=-1))
    error = np.where(np.abs(along[..., 0]) < 1e-6, error, 2.0 * np.pi)
    exact, off = _less(omega, state["omega"])
    largest = np.max(np.abs(exact), axis=-1)
    rate_error = np.max(np.abs(off), axis=-1) / np.where(largest > 0.0, largest, 1.0)
    return float(np.max(error)), float(np.max(rate_error))


def _less(found, texts):
    """The exact values rounded, and what was found less the exact values, to 1e-30."""
    exact = [[Decimal(x) for x in row] for row in texts]
    high = np.array([[float(x) for x in row] for row in exact])
    low = np.array(
        [[float(x - Decimal(float(x))) for x in row] for row in exact],
    )
    return high, (found - high) - low


def _speed():
    t = np.linspace(0.0, 1e4, 10**5)
    state = (10.0, 20.0, 26.0), (1.0, 0.0, 0.0, 0.0), (1.0, 15.0, 1.0)
    sine = _least(lambda: np.sin(t))
    # With rates, as above: attitudes alone would be compiled for this line only.
    ours = _least(lambda: propagate(*state, t, angular_velocity=True))
    return ours / sine, ours / t.size * 1e9


def _least(call):
    times = []
    for _ in range(15):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def versions():
    """Versions of this package, Python and what it stands on, as lines of text."""
    from attitude import __version__

    lines = [f"attitude {__version__}, Python {platform.python_version()} on {sys.platform}"]
    found = []
    for name in _PACKAGES:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} missing")
    return [*lines, ", ".join(found)]
