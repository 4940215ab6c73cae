"""Answers of every compiled part on small input, to be computed with and without compilation.

``python uncompiled_answers.py FILE.npz`` writes them.  The names say how they must agree: "exact"
to the bit, "sum" to the rounding of sums that may be taken in any order.
"""

import sys

import numpy as np

from attitude import Body, FreeRotation, Spin, paths, propagate
from attitude.arcs import Arcs, AxisCrossesDirection, Impulse, InertiaChange
from attitude.events import find_discrete, illuminated
from attitude.light_curve import Visibility, brightness
from attitude.scattering import Material, Materials
from attitude.scene import Scene
from attitude.shape import Ellipsoid, Mesh, box
from attitude.splitting import TorquedRotation
from attitude.torques import (
    ConstantTorque,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    SolarRadiation,
)

# A state of each regime, and of each form of the solution.
STATES = {
    "short_axis": ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    "long_axis": ((10.0, 20.0, 26.0), (15.0, 1.0, 1.0)),
    "separatrix": ((1.0, 2.0, 3.0), (3.0**0.5, 0.3, 1.0)),
    "near_separatrix": ((1.0, 2.0, 3.0), (3.0**0.5 * (1.0 + 1e-9), 0.3, 1.0)),
    "principal_axis": ((10.0, 20.0, 26.0), (0.0, 0.0, 1.0)),
    "middle_axis": ((10.0, 20.0, 26.0), (0.0, 1.0, 0.0)),
    "wobble": ((1.0, 2.0, 3.0), (1e-12, 0.0, 1.0)),
    "sphere": ((2.0, 2.0, 2.0), (1.0, 2.0, 3.0)),
    "at_rest": ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0)),
    "symmetric": ((2.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
    "equatorial": ((2.0, 2.0, 3.0), (1.0, 2.0, 0.0)),
    "rod": ((0.0, 2.0, 2.0), (0.0, 1.0, 1.0)),
    "needle": ((1e-10, 1.0, 1.0), (1.0, 0.1, 0.2)),
    "flat": ((1.0, 2.0, 3.0), (0.2, 0.3, 0.4)),
    "small_units": ((1e-45, 2e-45, 2.5e-45), (1e6, 2e6, 1e5)),
}
EPOCHS = np.array([0.0, 1.3, 60.0, 1e6, -3e8, np.nan])
# So many that Python takes them at once, in arrays.
MANY = np.concatenate([EPOCHS, np.linspace(-20.0, 70.0, 25), 1e5 * np.arange(9.0)])


def answers():
    found = {}
    for name, (moments, rates) in STATES.items():
        wxyz, omega = propagate(moments, (1, 2, 3, 4), rates, EPOCHS, angular_velocity=True)
        found[f"exact {name} wxyz"], found[f"exact {name} omega"] = wxyz, omega
        many = propagate(moments, (1, 2, 3, 4), rates, MANY, angular_velocity=True)
        found[f"exact {name} at once"] = np.hstack(many)
        if moments[0] > 0.0:  # not of a rod
            near = MANY[np.abs(MANY) < 1e3]
            for epochs in (near[:5], near):
                columns = propagate(moments, (1, 2, 3, 4), rates, epochs, sensitivity=True)[1]
                found[f"exact {name} columns of {len(epochs)}"] = columns
        spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=rates)
        motion = FreeRotation(Body(moments=moments), spin)
        regime = motion.regime
        found[f"exact {name} regime"] = np.array(
            [motion.period_psi, motion.period_phi, *regime.nutation("L"), *regime.nutation("S")]
        )
    found |= _beyond_free_motion()
    found |= _light()
    return found


def _beyond_free_motion():
    tensor = [[3.0, 0.1, 0.2], [0.1, 4.0, -0.3], [0.2, -0.3, 4.5]]
    body = Body(tensor=tensor)
    spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0.1, 0.2, 0.3))
    when = AxisCrossesDirection((1, 0, 0), (0, 0, 1))
    changes = [
        Impulse(at=5.0, angular_momentum=(0.1, 0.2, 0.3), frame="ecliptic"),
        InertiaChange(at=9.0, body=Body(moments=(1, 2, 2.5))),
        Impulse(at=when, angular_momentum=(0.3, 0, 0), frame="icrf"),
    ]
    arcs = Arcs(body, spin, changes)
    history = arcs.at(np.linspace(-5.0, 50.0, 23))
    found = {"exact arcs": history.wxyz, "exact arcs omega": history.angular_velocity}
    orbit = paths.kepler(
        epoch="2026-01-01", center="earth", semi_major_axis=7e6, eccentricity=0.1, inclination=0.5,
        node=0.2, pericenter_argument=0.1, mean_anomaly=0.3,
    )  # fmt: skip
    sheet = box((1.0, 2.0, 0.1))
    torques = {
        "kick-rotate-kick": [ConstantTorque((0.01, 0.02, 0.03)), LinearDamping(np.eye(3) * 0.01)],
        "hoa": [InternalDissipation(0.01)],
        "force-gradient": [GravityGradient(orbit, "earth"), ConstantTorque((0.01, 0.0, 0.0))],
        "rotate-kick-rotate": [lambda t, wxyz, omega: (0.01 * np.sin(t), 0.0, -0.1 * omega[2])],
        "blanes-moan": [SolarRadiation(sheet, lambda s: np.full((*np.shape(s), 3), 1e11))],
    }
    for scheme, given in torques.items():
        motion = TorquedRotation(body, spin, given, step=0.1, scheme=scheme)
        history = motion.at(np.linspace(-2.0, 3.0, 7))
        found[f"sum {scheme}"] = np.hstack([history.wxyz, history.angular_velocity])
    motion = TorquedRotation(body, spin, torques["kick-rotate-kick"], tolerance=1e-6)
    found["exact varying steps"] = motion.at([-1.0, 2.0]).wxyz
    free = FreeRotation(body, spin)
    scene = Scene(free, center=orbit, observer="earth")
    seconds = np.linspace(0.0, 6000.0, 5)
    view = scene.since(spin.epoch, seconds)
    found["sum view"] = np.column_stack(
        [view.phase_angle, view.sun_direction, view.observer_direction, view.observer_distance]
    )
    times, values = find_discrete(0.0, 100.0, illuminated(free, (0, 0, 1), sun=(1, 0, 1)))
    found["exact events"] = np.append(times, values)
    return found


def _light():
    found = {}
    rng = np.random.default_rng(3)
    sun, observer = rng.normal(size=(2, 6, 3))
    sun /= np.linalg.norm(sun, axis=1)[:, None]
    observer /= np.linalg.norm(observer, axis=1)[:, None]
    ellipsoid = Ellipsoid((3, 2, 1))
    found["sum closed form"] = brightness(ellipsoid, "lommel-seeliger", sun, observer)
    mesh = ellipsoid.facets(80)
    laws = {law: law for law in ("lambert", "lommel-seeliger", "hapke")}
    for model in ("phong", "cook-torrance"):
        laws[model] = Materials({"surface": Material(0.3, 0.5, model)})
    for name, law in laws.items():
        found[f"sum {name}"] = brightness(mesh, law, sun, observer)
    vertices = np.array(mesh.vertices)
    dent = 1.0 + 0.25 * np.sin(3.0 * vertices[:, 0]) * np.cos(2.0 * vertices[:, 1])
    concave = Mesh(vertices * dent[:, None], mesh.facets)
    table = Visibility.of(concave, resolution=8)
    found["sum shadows"] = brightness(concave, "lambert", sun, observer, shadows=table)
    return found


if __name__ == "__main__":
    np.savez(sys.argv[1], **answers())
