"""The self-test: the accuracy and speed of this installation on this machine.

States of every regime are propagated and compared with attitudes and rates of 30 digits, computed
by an independent method (the mpmath oracle of the project's tests; benchmarks/make_reference.py
writes the file).
"""

from __future__ import annotations

import platform
import sys
import time
import timeit
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from importlib.metadata import PackageNotFoundError, distributions, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._solver.warm_up import compile_ahead
from attitude._support.arrays import units
from attitude._textfiles import toml
from attitude._textfiles.lines import packaged
from attitude.motions._propagation import propagate

if TYPE_CHECKING:
    from attitude._support.annotations import FloatArray
    from attitude.proof._certificate import Certificate


# Accepted errors: rad, and of the angular velocity relative to its largest component.
LARGEST_ERROR: float = 4e-15
# The folder of this package, and a file in it of the other project of its name, Attitude 0.5.0.
_FOLDER = Path(__file__).resolve().parent.parent
_OTHERS = Path("orientation", "pca.py")
_PACKAGES = ("numpy", "scipy", "astropy", "skyfield", "numba", "llvmlite")


@dataclass(frozen=True)
class CheckResult:
    """Errors and cost found by the self-test."""

    # families of states as in the file: largest errors, rad, relative rate
    worst: list[tuple[str, float, float]]
    states: int
    epochs: int
    ratio: float  # cost of an epoch with its rates over that of numpy.sin
    nanoseconds: float
    seconds: float

    @property
    def error(self) -> float:
        """The largest attitude error in rad; NaN if any answer is NaN."""
        return float(np.max([row[1] for row in self.worst]))

    @property
    def rate_error(self) -> float:
        """The largest error of an angular velocity, relative to its largest component."""
        return float(np.max([row[2] for row in self.worst]))

    @property
    def passed(self) -> bool:
        """Whether both errors are at most `LARGEST_ERROR`."""
        return self.error <= LARGEST_ERROR and self.rate_error <= LARGEST_ERROR


def check() -> CheckResult:
    """Run the self-test.

    About 1 s; with a cold disk cache 4 to 7 s on two cores and 8 to 10 on one, nearly all of it
    compilation.
    """
    start = time.perf_counter()
    compile_ahead()
    worst: dict[str, FloatArray] = {}
    epochs = 0
    states = reference_states()
    for state in states:
        error, rate_error = errors_of(state)
        old = worst.get(state["family"], np.zeros(2))
        worst[state["family"]] = np.maximum(old, (error, rate_error))
        epochs += len(state["t"])
    ratio, nanoseconds = _speed()
    rows = [(family, float(pair[0]), float(pair[1])) for family, pair in worst.items()]
    elapsed = time.perf_counter() - start
    return CheckResult(rows, len(states), epochs, ratio, nanoseconds, elapsed)


# States of `more`.
_RANDOM = 20_000
# Largest turn, rad, after which they start again.
_TURN = 20.0
# Accepted error, rad: a state in doubles is off by 1e-16 of its rate, which that turn enlarges,
# most near the separatrix.
_RESTART_ERROR = 1e-12
# Accepted error, rad, of an integration to 1e-10 rad.
_TORQUE_ERROR = 1e-10
# Facets that stand for an ellipsoid, and the accepted error of their brightness.
_FACETS = 20_000
_FACETS_ERROR = 1e-4


def more() -> Iterator[tuple[str, float, float]]:
    """Further checks: what was compared, the largest difference, and what is accepted."""
    name = f"restarts of {_RANDOM} random states, rad"
    yield name, _restarts(np.random.default_rng(7)), _RESTART_ERROR
    yield "a constant torque about a principal axis, rad", _spin_up(), _TORQUE_ERROR
    yield (
        f"brightness of {_FACETS} facets and of their ellipsoid, relative",
        _facets(np.random.default_rng(8)),
        _FACETS_ERROR,
    )


def _restarts(random: np.random.Generator) -> float:
    """Largest angle, rad, between attitudes, and those of a state that starts again on the way."""
    from attitude.frames import quaternion

    masses = random.uniform(0.05, 1.0, (_RANDOM, 3))
    moments = masses.sum(axis=1, keepdims=True) - masses
    wxyz0 = random.normal(size=(_RANDOM, 4))
    wxyz0 /= np.linalg.norm(wxyz0, axis=1)[:, None]
    omega0 = random.normal(size=(_RANDOM, 3))
    rate = np.linalg.norm(omega0, axis=1)[:, None]
    t = np.sort(random.uniform(0.0, _TURN, (_RANDOM, 2)), axis=1) / rate
    wxyz, omega = propagate(moments, wxyz0, omega0, t, angular_velocity=True)
    later = propagate(moments, wxyz[:, 0], omega[:, 0], t[:, 1:] - t[:, :1])[:, 0]
    off = quaternion.multiply(quaternion.conjugate(wxyz[:, 1]), later)
    return float(2.0 * np.linalg.norm(off[:, 1:], axis=1).max())


def _spin_up() -> float:
    """Largest angle, rad, by which a torque about a principal axis turns a body too far."""
    from attitude.motions._body import Body
    from attitude.motions._spin import Spin
    from attitude.torques._torque import ConstantTorque
    from attitude.torques._torqued import TorquedRotation

    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0.0, 0.0, 0.1))
    torque = ConstantTorque((0.0, 0.0, 0.26))
    motion = TorquedRotation(Body(moments=(10, 20, 26)), spin, torque, tolerance=1e-10)
    t = np.linspace(0.0, 60.0, 200)
    wxyz, half = motion.at(t).wxyz, 0.5 * (0.1 * t + 0.005 * t**2)
    off = wxyz[:, 3] * np.cos(half) - wxyz[:, 0] * np.sin(half)
    return float(2.0 * np.max(np.sqrt(off**2 + wxyz[:, 1] ** 2 + wxyz[:, 2] ** 2)))


def _facets(random: np.random.Generator) -> float:
    """Largest relative difference of the brightness of facets and of an ellipsoid."""
    from attitude.light_curve import brightness
    from attitude.shape._ellipsoid import Ellipsoid

    solid = Ellipsoid((3.0, 2.0, 1.0))
    sun = units(random.normal(size=(200, 3)))
    # Phase angles below 45 degrees: thin crescents lose more to the edges of facets.
    observer = units(sun + 0.7 * units(random.normal(size=(200, 3))))
    exact = brightness(solid, "lommel-seeliger", sun, observer)
    computed = brightness(solid.facets(_FACETS), "lommel-seeliger", sun, observer)
    return float(np.max(np.abs(computed / exact - 1.0)))


def reference_states() -> list[dict[str, Any]]:
    """The stored states."""
    name = "reference/states.json"
    return toml.of_json(packaged(name), name)["states"]


def errors_of(state: Mapping[str, Any]) -> tuple[float, float]:
    """The largest attitude error (rad) and relative rate error of one stored state."""
    moments, wxyz0, omega0, t = _numbers_of(state)
    wxyz, omega = propagate(moments, wxyz0, omega0, t, angular_velocity=True)
    exact, off = _difference(wxyz, state["wxyz"])
    # The part of the difference normal to the exact quaternion is half the angle between them.
    along = np.sum(off * exact, axis=-1, keepdims=True)
    error = 2.0 * np.sqrt(np.sum((off - along * exact) ** 2, axis=-1))
    error = np.where(np.abs(along[..., 0]) < 1e-6, error, 2.0 * np.pi)
    exact, off = _difference(omega, state["omega"])
    largest = np.max(np.abs(exact), axis=-1)
    rate_error = np.max(np.abs(off), axis=-1) / np.where(largest > 0.0, largest, 1.0)
    return float(np.max(error)), float(np.max(rate_error))


def certificates() -> list[Certificate]:
    """Proved error bounds of stored states at their epochs; AttitudeError without python-flint."""
    from attitude.proof._chain import Chain

    bounds = []
    for state in reference_states():
        moments, wxyz0, omega0, t = _numbers_of(state)
        start = np.stack([wxyz0, np.zeros(4)], axis=1)
        wxyz = propagate(moments, wxyz0, omega0, t)
        bounds.append(Chain(moments, start, omega0).certificate(t, None, wxyz))
    return bounds


def _numbers_of(state: Mapping[str, Any]) -> list[FloatArray]:
    """Moments, attitude, angular velocity and epochs of a stored state."""
    keys = ("moments", "wxyz0", "omega0", "t")
    return [np.array([float.fromhex(x) for x in state[key]]) for key in keys]


def _difference(
    values: FloatArray, texts: Sequence[Sequence[str]]
) -> tuple[FloatArray, FloatArray]:
    """The exact values rounded, and the values minus the exact ones, to 1e-30."""
    exact = [[Decimal(x) for x in row] for row in texts]
    high = np.array([[float(x) for x in row] for row in exact])
    low = np.array([[float(x - Decimal(float(x))) for x in row] for row in exact])
    return high, (values - high) - low


def _speed() -> tuple[float, float]:
    """Cost of an epoch over that of numpy.sin, and in ns."""
    t = np.linspace(0.0, 1e4, 10**5)
    state = (10.0, 20.0, 26.0), (1.0, 0.0, 0.0, 0.0), (1.0, 15.0, 1.0)
    sine = _least(lambda: np.sin(t))
    # With rates, as in errors_of: attitudes alone would be compiled for this line only.
    ours = _least(lambda: propagate(*state, t, angular_velocity=True))
    return ours / sine, ours / t.size * 1e9


def _least(call: Callable[[], object]) -> float:
    """The least wall time of 15 calls, s."""
    return min(timeit.repeat(call, number=1, repeat=15))


def other_project() -> str | None:
    """A sentence if PyPI's `Attitude`, another project, lies in the same folder; None otherwise."""
    same = [
        distribution.version
        for distribution in distributions(name="attitude")
        if Path(str(distribution.locate_file("attitude"))).resolve() == _FOLDER
    ]
    if not same and not (_FOLDER / _OTHERS).is_file():
        return None
    return (
        f"files of another project, PyPI's Attitude{' ' + same[0] if same else ''}, lie in "
        f"{_FOLDER} too, and each of both replaces files of the other; install "
        "attitude-propagation in an environment without it."
    )


def versions() -> list[str]:
    """Versions of this package, Python and its dependencies, as lines of text."""
    from attitude import __version__

    lines = [f"attitude {__version__}, Python {platform.python_version()} on {sys.platform}"]
    packages = []
    for name in _PACKAGES:
        try:
            packages.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            packages.append(f"{name} missing")
    return [*lines, ", ".join(packages)]
