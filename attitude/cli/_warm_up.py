"""Small examples of every feature that compiles, to compile ahead of use."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from attitude._compilation.choice import compiling
from attitude._solver.warm_up import compile_ahead, compile_loops, compile_stages
from attitude.events._channels import illuminated
from attitude.events._search import find_discrete
from attitude.light_curve._brightness import brightness
from attitude.light_curve._visibility import Visibility
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._spin import Spin
from attitude.paths import _two_body
from attitude.scattering._materials import Material, Materials
from attitude.scene._scene import Scene
from attitude.shape._ellipsoid import Ellipsoid
from attitude.shape._mesh import Mesh
from attitude.shape._solids import box
from attitude.torques._arcs import Arcs, Impulse
from attitude.torques._torque import ConstantTorque, GravityGradient, LinearDamping
from attitude.torques._torqued import TorquedRotation
from attitude.torques._triggers import AxisCrossesDirection

if TYPE_CHECKING:
    from attitude.scattering._law import Law


_BODY = Body(tensor=[[3.0, 0.1, 0.2], [0.1, 4.0, -0.3], [0.2, -0.3, 4.5]])
# Short- and long-axis mode, rest, and near the separatrix: the three forms of the solution.
_RATES = (0.1, 0.2, 0.9), (0.9, 0.2, 0.1), (0.0, 0.0, 0.0), (1.0, 15.0, 1.0)
_SPINS = [Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=rates) for rates in _RATES]
_STATES = [
    *((_BODY, first_spin) for first_spin in _SPINS[:3]),
    (Body(moments=(10, 20, 26)), _SPINS[3]),
]
_ORBIT = _two_body.kepler(
    epoch="2026-01-01",
    center="earth",
    semi_major_axis=7e6,
    eccentricity=0.1,
    inclination=0.5,
    node=0.2,
    pericenter_argument=0.1,
    mean_anomaly=0.3,
)


def features(everything: bool) -> Iterator[Callable[[], None]]:
    """Functions that compile one feature each: propagation alone, or `everything`."""
    chosen = [propagation]
    if everything:
        chosen += [derivatives, impulses, torques, scenes_and_events, light_curves]
    for feature in chosen:
        yield compiling()(feature)


def propagation() -> None:
    """Attitudes, angular velocities and regimes of every form of the solution."""
    compile_ahead()
    compile_stages()
    compile_loops()
    for body, spin in _STATES:
        motion = FreeRotation(body, spin)
        motion.at([0.0, 1.0]).angular_velocity  # noqa: B018  computed when it is read
        str(motion)


def derivatives() -> None:
    """Sensitivities and covariances."""
    for body, spin in _STATES:
        motion = FreeRotation(body, spin.with_covariance({"attitude": 0.1}))
        motion.sensitivity_at([0.0, 1.0, 1e4], angular_velocity=True)
        motion.covariance_at([0.0, 1.0, 1e4])


def impulses() -> None:
    """A chain of arcs, with a change at an event."""
    when = AxisCrossesDirection((1, 0, 0), (0, 0, 1))
    changes = [Impulse(at=5.0, angular_momentum=(0.1, 0.2, 0.3)), Impulse(when, (0.3, 0, 0))]
    Arcs(_BODY, _SPINS[0], changes).at(np.linspace(-5.0, 50.0, 23))


def torques() -> None:
    """Fixed and adaptive steps, and torques of the package."""
    both = [ConstantTorque((0.01, 0, 0)), LinearDamping(0.01), GravityGradient(_ORBIT, "earth")]
    fixed = TorquedRotation(_BODY, _SPINS[0], both, step=0.1)
    for motion in (fixed, TorquedRotation(_BODY, _SPINS[0], both, tolerance=1e-6)):
        motion.at(np.linspace(-2.0, 3.0, 7)).angular_acceleration  # noqa: B018


def scenes_and_events() -> None:
    """Views of a scene, and an event."""
    motion = FreeRotation(_BODY, _SPINS[0])
    scene = Scene(motion, center=_ORBIT, observer="earth")
    view = scene.since(_SPINS[0].epoch, np.linspace(0.0, 6000.0, 5))
    for quantity in (view.phase_angle, view.sun_direction, view.observer_direction):
        np.asarray(quantity)
    find_discrete(0.0, 100.0, illuminated(motion, (0, 0, 1), sun=(1, 0, 1)))


def light_curves() -> None:
    """Ellipsoids, and meshes with and without shadows under every law."""
    directions = np.eye(3)[[0, 1, 2]], np.eye(3)[[1, 2, 0]]
    ellipsoid = Ellipsoid((3, 2, 1))
    brightness(ellipsoid, "lommel-seeliger", *directions)
    mesh = ellipsoid.facets(80)
    laws: list[str | Law] = ["lambert", "lommel-seeliger", "hapke"]
    laws += [
        Materials({"surface": Material(0.3, 0.5, lobe)}) for lobe in ("phong", "cook-torrance")
    ]
    vertices = np.array(mesh.vertices)
    dent = 1.0 + 0.25 * np.sin(3.0 * vertices[:, 0]) * np.cos(2.0 * vertices[:, 1])
    concave = Mesh(vertices * dent[:, None], mesh.facets)
    table = Visibility.of(concave, resolution=8, keep=False)
    for law in laws:
        brightness(mesh, law, *directions)
        brightness(concave, law, *directions, shadows=table)
        brightness(box((3, 2, 1)), law, *directions)
