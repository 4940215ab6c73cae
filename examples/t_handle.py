"""A T-handle that flips: rotation about the middle axis, as filmed in orbit.

A handle of two rods spins about its middle axis of inertia, tilted by a hundredth of a degree.  The
exact motion gives the times of its flips over any span; the time between flips grows with the
logarithm of the inverse tilt.

    python examples/t_handle.py
"""

import numpy as np
from numpy.typing import NDArray

from attitude import Body, FreeRotation, Spin

Array = NDArray[np.float64]

PICTURE = "t_handle.png"
RATE = 2.0 * np.pi  # one turn a second


def handle() -> Body:
    """A T of two brass rods, as points: a bar of 8 cm along x, a stem of 4 cm along y."""
    bar = np.column_stack([np.linspace(-0.04, 0.04, 161), np.zeros((161, 2))])
    stem = np.column_stack([np.zeros(81), np.linspace(0.0, 0.04, 81), np.zeros(81)])
    points = np.concatenate([bar, stem])
    return Body.from_points(np.full(len(points), 0.4 / len(points)), points)


def spun_off_by(body: Body, degrees: float) -> tuple[FreeRotation, Array]:
    """Rotation about the middle axis, tilted towards the axis of least inertia; that axis."""
    order = np.argsort(body.moments)
    middle, least = body.principal_axes[:, order[1]], body.principal_axes[:, order[0]]
    tilt = np.radians(degrees)
    rate = RATE * (np.cos(tilt) * middle + np.sin(tilt) * least)
    motion = FreeRotation(body, Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=rate))
    return motion, middle


def main() -> None:
    body = handle()
    print("principal moments:", ", ".join(f"{1e6 * x:.2f}" for x in body.moments), "kg mm2")
    print(f"\n{'tilt, deg':>12}{'mode':>14}{'seconds between flips':>24}")
    for degrees in (10.0, 1.0, 1e-2, 1e-4, 1e-8):
        motion, _ = spun_off_by(body, degrees)
        print(f"{degrees:12g}{motion.mode.name:>14}{0.5 * motion.period_psi:24.4f}")

    motion, middle = spun_off_by(body, 1e-2)
    t = np.linspace(0.0, 2.0 * motion.period_psi, 4001)
    momentum = motion.momentum / np.sqrt(motion.momentum @ motion.momentum)
    cosine = motion.at(t).body_to_inertial(middle) @ momentum
    flips = t[1:][np.diff(np.sign(cosine)) != 0.0]
    print("\ntilted by 0.01 deg, it turns over at", ", ".join(f"{x:.2f}" for x in flips), "s")
    century = motion.at(100.0 * 365.25 * 86400.0)
    print("and after a century its middle axis is", century.body_to_inertial(middle).round(6))
    draw(t, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def draw(t: Array, angle: Array) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9, 4), layout="constrained")
    axes.plot(t, angle)
    axes.set(
        xlabel="seconds",
        ylabel="middle axis from the momentum (deg)",
        title="A T-handle spun about its middle axis, 0.01 deg off",
        yticks=(0, 45, 90, 135, 180),
    )
    axes.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
