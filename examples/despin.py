"""Despin of a tumbling satellite by thruster pulses, and the deployment of a boom.

A satellite with Envisat's inertia tumbles.  When its long axis is first at right angles to the x
axis of ICRF, and each minute after that, a pulse removes a third of the momentum over the body
axes, with the errors of a real thruster; then a boom is deployed.  Between the pulses the motion is
exact.

    python examples/despin.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import AttitudeHistory, Body, Spin
from attitude.arcs import Arcs, AxisCrossesDirection, Impulse, InertiaChange
from attitude.formats import spin_file

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "despin.png"
PULSES, SHARE, ERROR = 12, 1.0 / 3.0, 0.03


def main() -> None:
    body = spin_file.read(DATA / "spin" / "envisat.toml").motion.body
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=np.radians([0.6, 2.6, 0.9]))
    random = np.random.default_rng(1)

    def pulse(before: AttitudeHistory) -> NDArray[np.float64]:
        """Minus a share of the momentum over the body axes, with an error of a few percent."""
        momentum = before.angular_velocity @ body.tensor
        return -SHARE * momentum * (1.0 + ERROR * random.normal(size=3))

    # The attitude of the body triggers the first pulse.
    long = body.principal_axes[:, np.argmin(body.moments)]
    crossing = AxisCrossesDirection(long, direction=(1.0, 0.0, 0.0))
    first = Arcs(body, spin, [Impulse(crossing, pulse)])
    start = float(first.joints[0])

    random = np.random.default_rng(1)
    pulses = [Impulse(crossing, pulse)]
    pulses += [Impulse(start + 60.0 * k, pulse) for k in range(1, PULSES)]
    longer = Body(tensor=body.tensor + np.diag([500.0, 2000.0, 2000.0]))
    boom = InertiaChange(start + 60.0 * PULSES, longer)
    motion = Arcs(body, spin, [*pulses, boom])

    print(f"the long axis is first at right angles to x of ICRF after {start:.6f} s")
    print(f"{'pulse at s':>12}{'rate before':>13}{'after, deg/s':>14}{'momentum, N m s':>17}")
    for at in motion.joints:
        before, after = motion.at(np.nextafter(at, 0.0)), motion.at(at)
        now = motion.body_at(at)
        momentum = after.angular_velocity @ now.tensor
        rates = [np.degrees(np.sqrt(np.sum(h.angular_velocity**2))) for h in (before, after)]
        print(f"{at:12.3f}{rates[0]:13.4f}{rates[1]:14.4f}{np.sqrt(momentum @ momentum):17.3f}")
    draw(motion)


def draw(motion: Arcs) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    t = np.linspace(0.0, motion.joints[-1] + 120.0, 4001)
    rates = np.degrees(motion.at(t).angular_velocity)
    figure, axes = plt.subplots(figsize=(9, 4.5), layout="constrained")
    for k, name in enumerate("xyz"):
        axes.plot(t, rates[:, k], label=rf"$\omega_{name}$", lw=1.2)
    for at in motion.joints:
        axes.axvline(at, color="0.8", lw=0.8, zorder=0)
    axes.set(
        xlabel="seconds",
        ylabel="angular velocity over the body axes (deg/s)",
        title="Despin by pulses, then a boom",
    )
    axes.legend(ncols=3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
