"""The encounter of Apophis with the Earth on 13 April 2029: how tides change its rotation.

The path is integrated from JPL's solution; body and periods are those of Pravec et al. (2014).  The
phases of the rotation in 2029 are unknown, so a grid of phases is assumed: the change of the
periods depends on the attitude of the body at closest approach.

    python examples/apophis_2029_torque.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import AttitudeHistory, Body, FreeRotation, Spin, catalog, paths
from attitude.splitting import TorquedRotation
from attitude.torques import GravityGradient

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "apophis_2029_torque.png"
NAME, EPOCH = "99942 Apophis (2014)", "2029-04-07"
HOUR, DAY = 3600.0, 86400.0
END = 13.5 * DAY
PHASES = np.radians(np.arange(0.0, 360.0, 60.0))


def passing(path: paths.Path, phi0: float, psi0: float) -> tuple[FreeRotation, TorquedRotation]:
    """The free rotation before the encounter, and the motion under the Earth's gravity gradient."""
    before = catalog.entry(NAME).motion(phi0=phi0, psi0=psi0, epoch=EPOCH)
    tides = GravityGradient(path, "earth")
    # Tolerance of each step; the step size adapts to the encounter.
    through = TorquedRotation(
        before.body, before.spin, tides, step_tolerance=1e-11, scheme="blanes-moan"
    )
    return before, through


def afterwards(motion: TorquedRotation, body: Body, seconds: float = END) -> FreeRotation:
    """The free rotation that continues a motion, once the Earth is far away."""
    last = motion.at(seconds)
    spin = Spin(
        epoch=last.epoch.after(seconds),
        wxyz=last.wxyz,
        angular_velocity=last.angular_velocity,
    )
    return FreeRotation(body, spin)


def turned(one: Array, two: Array) -> float:
    """The angle between two momenta, deg."""
    sine = np.cross(one, two)
    return float(np.degrees(np.arctan2(np.sqrt(sine @ sine), one @ two)))


def main() -> None:
    path = paths.oem(DATA / "paths" / "apophis-2029-encounter.oem")
    print("Apophis before and after 13 April 2029, for assumed phases on 7 April:")
    print(
        f"{'phi0':>6}{'psi0':>6}{'mode':>12}{'P_phi h':>10}{'P_psi h':>10}{'L changes':>11}"
        f"{'pole':>8}"
    )
    before, _ = passing(path, 0.0, 0.0)
    periods = before.period_phi / HOUR, before.period_psi / HOUR
    print(f"{'before':>12}{before.mode.name:>12}{periods[0]:10.3f}{periods[1]:10.2f}")
    rows = []
    for phi0 in PHASES[::2]:
        for psi0 in PHASES[::2]:
            before, through = passing(path, phi0, psi0)
            after = afterwards(through, before.body)
            sizes = [np.sqrt(m.momentum @ m.momentum) for m in (before, after)]
            rows.append((after.period_phi / HOUR, after.period_psi / HOUR))
            print(
                f"{np.degrees(phi0):6.0f}{np.degrees(psi0):6.0f}{after.mode.name:>12}"
                f"{rows[-1][0]:10.3f}{rows[-1][1]:10.2f}"
                f"{100.0 * (sizes[1] / sizes[0] - 1.0):+10.2f}%"
                f"{turned(before.momentum, after.momentum):7.2f}°"
            )
    found = np.array(rows)
    print(
        f"\nP_phi from {periods[0]:.2f} h to {found[:, 0].min():.2f} .. {found[:, 0].max():.2f} h, "
        f"P_psi from {periods[1]:.1f} h to {found[:, 1].min():.0f} .. {found[:, 1].max():.0f} h."
    )

    before, through = passing(path, 0.0, 0.0)
    t = np.linspace(0.0, END, 4001)
    free, tidal = before.at(t), through.at(t)
    check = TorquedRotation(
        before.body, before.spin, through.torques, step=60.0, scheme="blanes-moan"
    ).at(END)
    apart = 2.0 * np.max(np.abs(check.wxyz - tidal.wxyz[-1]))
    print(f"Fixed steps of 60 s end within {apart:.1e} rad of the adaptive ones.")
    distance = np.sqrt(np.sum(path.position(before.spin.epoch, t) ** 2, axis=-1))
    draw(t / DAY, distance, free, tidal, before.body)


def draw(
    days: Array, distance: Array, free: AttitudeHistory, tidal: AttitudeHistory, body: Body
) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    momentum = tidal.body_to_inertial(tidal.angular_velocity @ body.tensor)
    change = momentum / np.sqrt(np.sum(momentum[0] ** 2))
    size = np.sqrt(np.sum(change**2, axis=-1))
    product = np.abs(np.sum(free.wxyz * tidal.wxyz, axis=-1))
    off = np.degrees(2.0 * np.arccos(np.minimum(product, 1.0)))
    figure, axes = plt.subplots(3, 1, figsize=(9, 8), sharex=True, layout="constrained")
    axes[0].semilogy(days, distance / 1e3)
    axes[0].set(ylabel="distance (km)", title="Apophis past the Earth, 13 April 2029")
    axes[1].plot(days, 100.0 * (size - 1.0))
    axes[1].set(ylabel="change of |L| (%)")
    axes[2].plot(days, off)
    axes[2].set(ylabel="attitude from free rotation (deg)", xlabel="days since 7 April 2029 UTC")
    for panel in axes:
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
