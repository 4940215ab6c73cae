"""Relaxation of a tumbling asteroid: from long-axis mode through the separatrix to short-axis spin.

The moments and rates are those of Toutatis; the friction is some 1e11 times that of rock, so that
days replace 1e11 years.  The angular momentum is constant to rounding; the energy decreases to the
least value for this momentum.

    python examples/relaxation.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import FreeRotation, Mode, Spin, plots
from attitude.formats import spin_file
from attitude.splitting import TorquedRotation
from attitude.torques import InternalDissipation

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parent.parent / "data"
PICTURE = "relaxation.png"
DAY = 86400.0
STRENGTH, SPAN, STEP = 0.02, 600.0 * DAY, 1800.0


def main() -> None:
    free = spin_file.read(DATA / "spin" / "toutatis.toml").motion
    body = free.body
    motion = TorquedRotation(body, free.spin, InternalDissipation(STRENGTH), step=STEP)
    t = np.linspace(0.0, SPAN, 6001)
    history = motion.at(t)
    w = history.angular_velocity
    in_body = w @ body.tensor
    size = np.sqrt(np.sum(in_body**2, axis=-1))
    energy = 0.5 * np.sum(w * in_body, axis=-1)
    least = size[0] ** 2 / (2.0 * body.moments.max())
    momentum = history.body_to_inertial(in_body)
    drift = np.max(np.abs(momentum - momentum[0])) / size[0]

    print(f"momentum vector in ICRF moves by {drift:.1e} of its size in {SPAN / STEP:.0f} steps")
    print(
        f"{'day':>6}{'mode':>12}{'E / least':>12}{'long axis from L':>18}{'short axis from L':>19}"
    )
    order = np.argsort(body.moments)
    angles = {}
    for name, k in (("long", order[0]), ("short", order[2])):
        along = np.abs(in_body @ body.principal_axes[:, k]) / size
        angles[name] = np.degrees(np.arccos(np.minimum(along, 1.0)))
    for k in range(0, len(t), 500):
        spin = Spin(
            epoch=history.epoch.after(float(t[k])), wxyz=history.wxyz[k], angular_velocity=w[k]
        )
        mode = FreeRotation(body, spin).mode
        print(
            f"{t[k] / DAY:6.0f}{mode.name:>12}{energy[k] / least:12.6f}"
            f"{angles['long'][k]:17.2f}°{angles['short'][k]:18.2f}°"
        )
    assert mode in (Mode.SHORT_AXIS, Mode.PRINCIPAL_AXIS)
    middle = size[0] ** 2 / (2.0 * np.median(body.moments))
    crossed = t[np.argmax(energy < middle)]
    print(f"\nThe separatrix is crossed on day {crossed / DAY:.1f}.")
    draw(t / DAY, energy / least, middle / least, angles)


def draw(days: Array, energy: Array, separatrix: float, angles: dict[str, Array]) -> None:
    figure, (above, below) = plots.stacked((9, 7), 2)
    above.plot(days, energy)
    above.axhline(separatrix, color="0.5", ls="--", lw=1, label="separatrix")
    above.set(
        ylabel="energy over the least",
        title=f"(4179) Toutatis with friction of {STRENGTH:g}: from long-axis to short-axis mode",
    )
    above.legend()
    below.plot(days, angles["long"], label="long axis", lw=0.8)
    below.plot(days, angles["short"], label="short axis", lw=0.8)
    below.set(xlabel="days", ylabel="angle to the momentum (deg)", ylim=(0, 90))
    below.legend()
    figure.savefig(PICTURE, dpi=150)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
