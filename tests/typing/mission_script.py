"""A mission script as a user writes it, for `mypy --strict`: every public class and function.

``tests/house/test_types.py`` checks it, and runs it.
"""

from __future__ import annotations

import datetime
import os
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import attitude
from attitude import (
    Arcs,
    AttitudeError,
    AttitudeHistory,
    AttitudeTable,
    Body,
    FreeRotation,
    Impulse,
    InertiaChange,
    Mode,
    Scene,
    Spin,
    TorquedRotation,
    catalog,
    compare,
    epochs,
    events,
    fit,
    fit_directions,
    fit_rates,
    light_curve,
    paths,
    photometry,
    propagate,
    scattering,
    shape,
)
from attitude.arcs import AxisCrossesDirection
from attitude.formats import aem, spin_file, tables
from attitude.motions._motion import Motion, motion_of
from attitude.torques import ConstantTorque, GravityGradient, LinearDamping


def bodies() -> list[Body]:
    made = [
        Body(moments=(10, 20, 26)),
        Body(moments=np.array([1.0, 2.0, 2.5])),
        Body(tensor=[[3.0, 0.1, 0.0], [0.1, 4.0, 0.0], [0.0, 0.0, 4.5]]),
        Body(moments=(0.3, 0.9, 1.0), relative=True),
        Body.from_ellipsoid((3.0, 2.0, 1.0), mass=100.0),
        Body.from_shape(shape.box((1.0, 2.0, 3.0)), density=2000.0),
        Body.from_points(masses=[1.0, 2.0, 3.0, 4.0], positions=np.eye(4)[:, :3]),
    ]
    moments: NDArray[np.float64] = made[0].moments
    assert moments.shape == (3,)
    return made


def spins(body: Body) -> list[Spin]:
    rate = (1, 15, 1)
    made = [
        Spin(epoch="2026-01-01T00:00:00", wxyz=(1, 0, 0, 0), angular_velocity=rate),
        Spin(
            epoch=datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC),
            wxyz=np.array([1.0, 0.0, 0.0, 0.0]),
            angular_velocity=["1 deg/s", "2 deg/s", "3 deg/s"],
            frame="ecliptic",
        ),
        Spin(epoch=np.datetime64("2026-01-01"), wxyz=[1, 2, 3, 4], angular_velocity=[0, 0, 0.1]),
        Spin.from_matrix(epoch="2026-01-01", matrix=np.eye(3), angular_velocity=rate),
        Spin.from_euler(
            epoch="2026-01-01", sequence="ZXZ", angles=(0.1, 0.2, 0.3), angular_velocity=rate
        ),
        Spin.from_periods(
            body,
            mode="LAM",
            convention="L",
            P_psi="5.37 d",
            P_phi="7.41 d",
            pole=("180 deg", "-52 deg"),
            phi0=0.0,
            psi0="10 deg",
            epoch="1992-12-02",
            frame="ecliptic",
        ),
    ]
    instant: epochs.Instant = made[0].epoch
    assert instant.utc_iso.startswith("2026")
    return made


def free(body: Body, spin: Spin) -> AttitudeHistory:
    motion = FreeRotation(body, spin)
    if motion.mode is Mode.SHORT_AXIS:
        print(motion.period_psi + motion.period_phi, motion.momentum.tolist(), motion.energy)
    regime = motion.regime
    print(regime.mode, motion.published("L").keywords(), motion.separatrix_distance)
    seconds: float = motion.predictable_time(moments_error=1e-3, rates_error=[1e-4] * 3)
    seconds = motion.predictable_time(tolerance="5 deg")
    assert seconds > 0.0
    history = motion.at(np.linspace(0, 60, 1000))
    one = motion.at("2026-01-02T00:00:00")
    assert one.wxyz.shape == (4,)
    x: NDArray[np.float64] = history.body_to_inertial([0, 0, 1])
    y = history.inertial_to_body(x)
    total = float(np.max(np.abs(y))) + float(history.angular_velocity[0, 0])
    print(total, history[10:20].matrix.shape, history.dcm.shape, len(history), history.xyzw[0])
    print(history.angular_acceleration.shape, history.angular_velocity_inertial.shape)
    print(history.as_rotation(), history.euler("ZYX").round(3)[0], history.table().colnames)
    return history


def arrays() -> float:
    wxyz = propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), np.linspace(0.0, 60.0, 10))
    both = propagate((10, 20, 26), (1, 0, 0, 0), (1, 15, 1), [0.0, 1.0], angular_velocity=True)
    quaternions, rates = both
    return float(wxyz[-1, 0] + quaternions[0, 0] + rates[1, 2])


def driven(body: Body, spin: Spin) -> list[Motion]:
    orbit = paths.kepler(
        epoch="2026-01-01",
        center="earth",
        semi_major_axis="7000 km",
        eccentricity=0.01,
        inclination="98 deg",
        node=0.0,
        pericenter_argument=0.0,
        mean_anomaly=0.0,
    )
    changes = [
        Impulse(at=5.0, angular_momentum=(0.1, 0.2, 0.3)),
        Impulse(
            at=AxisCrossesDirection(axis=(1, 0, 0), direction=(0, 0, 1)),
            angular_momentum=lambda before: -0.1 * before.angular_velocity,
            frame="icrf",
        ),
        InertiaChange(at="2026-01-01T00:10:00", body=Body(moments=(30, 40, 26))),
    ]

    def drag(t: float, wxyz: NDArray[np.float64], omega: NDArray[np.float64]) -> list[float]:
        return [-0.01 * float(rate) for rate in omega]

    return [
        Arcs(body, spin, changes),
        TorquedRotation(body, spin, drag, step=0.01),
        TorquedRotation(
            body,
            spin,
            [GravityGradient(orbit, "earth"), ConstantTorque((0, 0, 0.01))],
            step="0.01 s",
            scheme="suzuki",
        ),
        TorquedRotation(body, spin, LinearDamping(np.eye(3) * 0.1), tolerance=1e-9),
        motion_of(FreeRotation(body, spin)),
    ]


def seen(motion: Motion) -> NDArray[np.float64]:
    scene = Scene(
        motion,
        center=None,
        observer=(1, 0, 0),
        sun=paths.direction((0, 1, 0)),
        shape=shape.Ellipsoid((3, 2, 1)),
        law=scattering.LommelSeeliger(albedo=0.2),
    )
    view = scene.at(np.linspace(0.0, 10.0, 5))
    print(view.phase_angle[0], view.sun_direction.shape, view.aspect_angle[-1], view.evaluated)
    return view.brightness


def light() -> float:
    mesh = shape.Ellipsoid((3, 2, 1)).facets(200)
    sun = np.array([[1.0, 0.0, 0.0]])
    curve = light_curve.brightness(mesh, "lambert", sun, sun)
    magnitude = light_curve.reduced_magnitude(curve)
    return float(magnitude[0]) + float(scattering.hg(0.3, 19.0, 0.15))


def found(motion: FreeRotation) -> int:
    lit = events.illuminated(motion, (0, 0, 1), sun=(1, 0, 1))
    times, values = events.find_discrete(0, 10, lit & ~events.visible(motion, (0, 0, 1), (0, 1, 0)))
    peaks = events.find_maxima(0, 10, events.separation(motion, (0, 0, 1), (1, 0, 0)))
    frequencies = photometry.lines(motion, order=2)
    return len(times) + len(values) + len(peaks.seconds) + len(frequencies)


def files(history: AttitudeHistory, folder: Path) -> AttitudeTable:
    aem.write(folder / "a.aem", history, object_name="X", object_id="2026-001A")
    tables.write(os.path.join(folder, "a.ecsv"), history)
    table = aem.read(folder / "a.aem")
    result = fit(table, sigma="0.1 deg", loss="huber", start=None)
    gyros = fit_rates(history.time, history.angular_velocity, sigma="0.01 deg/s")
    stars = np.resize([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], (len(history), 3))
    seen = fit_directions(history.time, history.inertial_to_body(stars), stars, frame="icrf")
    print(gyros.rate_rms, seen.rms, seen.covariance.shape, seen.motion.at(0.0).sigma)
    print(result.rms, result.motion.body.moments.round(3), table.span[0].utc_iso)
    spin_file.write(folder / "x.toml", result.motion, name="X")
    return table


def main() -> None:
    body = bodies()[0]
    spin = spins(Body(moments=(3.0, 3.2, 1.0), relative=True))[0]
    history = free(body, spin)
    print(arrays(), light(), found(FreeRotation(body, spin)))
    for motion in driven(body, spin):
        print(motion, motion.at([0.0, 1.0]).wxyz[-1], seen(motion)[0])
    with tempfile.TemporaryDirectory() as folder:
        files(history[:100], Path(folder))
    toutatis = catalog.load("4179 Toutatis")
    print(FreeRotation(toutatis.body, toutatis.spin), catalog.names()[:3], attitude.__version__)
    comparison = compare(["DOP853"], body, spin, 1.0, tolerances=(1e-9,), epochs=5)
    print(comparison)
    try:
        Body(moments=(1, 1, 5))
    except AttitudeError as err:
        print(err)


if __name__ == "__main__":
    main()
