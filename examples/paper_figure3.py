"""The example of van Zon & Schofield (2006), section 5 and figure 3.

A body with moments (10, 20, 26) starts, with its axes along those of the laboratory, at the angular
velocity (1, 15, 1): nearly about its middle axis, so that it turns over repeatedly.  The exact
angular velocity in the body and the attitude matrix A (laboratory to body) are drawn against time
as lines, a numerical integration of Euler's equations as dots, and the difference below: it is the
error of the integration, because that of the exact solution is too small to be visible.

    python examples/paper_figure3.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import AttitudeHistory, FreeRotation
from attitude.formats import spin_file

Array = NDArray[np.float64]

SPIN_FILE = Path(__file__).resolve().parent.parent / "data" / "spin" / "paper.toml"
PICTURE = "paper_figure3.png"
DURATION = 5.0
TOLERANCES = (1e-6, 1e-9, 1e-12)


def integrated(motion: FreeRotation, t: Array, tolerance: float) -> tuple[Array, Array]:
    """Angular velocity (N, 3) and attitude matrix A (N, 3, 3) by scipy's DOP853."""
    from scipy.integrate import solve_ivp

    moments = motion.body.moments

    def slope(_: float, state: Array) -> Array:
        w, a = state[:3], state[3:].reshape(3, 3)
        # Euler's equations, and dA/dt = -W A (the paper's 2.13): the columns of A rotate by -w.
        return np.concatenate(
            [np.cross(moments * w, w) / moments, -np.cross(w, a, axisb=0, axisc=0).ravel()]
        )

    start = np.concatenate([motion.spin.angular_velocity, np.eye(3).ravel()])
    found = solve_ivp(
        slope, (t[0], t[-1]), start, "DOP853", t_eval=t, rtol=tolerance, atol=tolerance
    )
    return found.y[:3].T, found.y[3:].T.reshape(-1, 3, 3)


def main() -> None:
    motion = spin_file.read(SPIN_FILE).motion
    print(motion, end="\n\n")
    t = np.linspace(0.0, DURATION, 1001)
    history = motion.at(t)
    found = {tolerance: integrated(motion, t, tolerance) for tolerance in TOLERANCES}

    print(f"{'t':>6}{'w1':>12}{'w2':>12}{'w3':>12}{'A11':>12}{'A22':>12}{'A33':>12}")
    for k in range(0, len(t), 100):
        row = [*history.angular_velocity[k], *np.diag(history.dcm[k])]
        print(f"{t[k]:6.2f}" + "".join(f"{value:12.7f}" for value in row))
    print("\nlargest difference of an integration (DOP853) from the exact attitude matrix")
    for tolerance, (_, a) in found.items():
        print(f"  tolerance {tolerance:.0e}: {np.max(np.abs(a - history.dcm)):.1e}")
    draw(t, history, found)


def draw(t: Array, history: AttitudeHistory, found: dict[float, tuple[Array, Array]]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(3, 1, figsize=(9, 10), sharex=True, layout="constrained")
    rates, attitude, error = panels
    dots = slice(None, None, 20)
    w, a = found[TOLERANCES[-1]]
    for k in range(3):
        rates.plot(t, history.angular_velocity[:, k], color=f"C{k}", label=rf"$\omega_{k + 1}$")
        rates.plot(t[dots], w[dots, k], ".", color=f"C{k}")
        attitude.plot(t, history.dcm[:, k, k], color=f"C{k}", label=f"$A_{{{k + 1}{k + 1}}}$")
        attitude.plot(t[dots], a[dots, k, k], ".", color=f"C{k}")
    for tolerance, (_, a) in found.items():
        distance = np.max(np.abs(a - history.dcm), axis=(1, 2))
        error.semilogy(t[1:], distance[1:], label=f"tolerance {tolerance:.0e}")
    rates.set(
        title="I = (10, 20, 26), $\\omega$ = (1, 15, 1): exact (lines), integrated (dots)",
        ylabel="angular velocity in the body (rad/s)",
        ylim=(-17.0, 22.0),
    )
    attitude.set(ylabel="attitude matrix, laboratory to body", ylim=(-1.15, 1.5))
    error.set(ylabel="largest error of A by DOP853", xlabel="time (s)", ylim=(1e-14, 1e-3))
    for panel in panels:
        panel.legend(ncols=3, loc="upper right")
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
