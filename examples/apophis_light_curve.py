"""The light curve of tumbling Apophis over its apparition of 2012-13, and its signal at 30.56 h.

Pravec et al. (2014) found that Apophis tumbles: its light curve has no single period, and the
strongest signal, at 30.56 h, is neither of the two periods of the rotation but P_phi of the long
axis, 1/30.56 h = 1/P_phi - 1/P_psi.  This script computes the curve from the published rotation and
moments and a path from JPL's solution, for the homogeneous ellipsoid with these moments.  A light
curve of an ellipsoid is nearly the same after half a turn, so that its strongest lines have even
numbers: 30.56 h appears as its second harmonic, 15.28 h.

The phases of the rotation are assumed (data/mission/apophis-2012.toml); the lines do not depend on
them.

    python examples/apophis_light_curve.py
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from attitude import FreeRotation, epochs, photometry
from attitude.formats import mission
from attitude.scattering import hg
from attitude.scene import View
from attitude.shape import Ellipsoid

Array = NDArray[np.float64]

MISSION = Path(__file__).resolve().parent.parent / "data" / "mission" / "apophis-2012.toml"
PICTURE = "apophis_light_curve.png"
HOUR, DAY = 3600.0, 86400.0
H, G = 19.09, 0.24


def main() -> None:
    found = mission.read(MISSION)
    scene, motion = found.scene, found.scene.motion
    # The file describes a free rotation, an ellipsoid and its magnitudes.
    assert isinstance(motion, FreeRotation) and isinstance(scene.shape, Ellipsoid)
    assert found.magnitude is not None
    print(found.name)
    print(f"semi-axes of the ellipsoid: {np.round(scene.shape.semi_axes, 1)} m")
    print(f"P_psi {motion.period_psi / HOUR:.2f} h, P_phi {motion.period_phi / HOUR:.2f} h")

    start = epochs.instant(found.times["start"])
    seconds = np.arange(0.0, 137.0 * DAY, 600.0)
    view = scene.since(start, seconds)
    magnitude = found.magnitude.of(view)
    # Without the phase function, the magnitude varies by the rotation alone.
    variation = magnitude - hg(view.phase_angle, H, G)
    left = view.seconds - view.light_time

    print_curve(view, seconds, magnitude)
    fit = photometry.fit_series(left, variation, motion.period_psi, motion.period_phi, order=4)
    print_lines(fit, variation)
    draw(view, seconds / DAY, magnitude, variation, fit)


def print_curve(view: View, seconds: Array, magnitude: Array) -> None:
    print(f"\n{'UTC':<12}{'phase deg':>10}{'aspect deg':>11}{'V(1,1)':>8}   over the next 31 h")
    for k in range(0, len(view), 20 * 144):
        rest = magnitude[k : k + 31 * 6]
        print(
            f"{view.epoch.after(view.seconds[k] + 0.01).utc_iso[:10]:<12}"
            f"{np.degrees(view.phase_angle[k]):10.1f}{np.degrees(view.aspect_angle[k]):11.1f}"
            f"{np.mean(rest):8.2f}   from {np.min(rest):.2f} to {np.max(rest):.2f}"
        )


def print_lines(fit: photometry.SeriesFit, variation: Array) -> None:
    total = np.var(variation)
    print("\nLines |i/P_phi + j/P_psi|, the strongest first; power as a part of the variance:")
    print(f"{'i':>3}{'j':>4}{'period h':>10}{'amplitude mag':>15}{'power':>9}")
    for line, amplitude in fit.strongest(8):
        note = ""
        if (line.i, line.j) == (2, -2):
            note = f"   2nd harmonic of {2.0 * line.period / HOUR:.2f} h"
        elif (line.i, line.j) == (4, -4):
            note = f"   4th harmonic of {4.0 * line.period / HOUR:.2f} h"
        print(
            f"{line.i:3d}{line.j:4d}{line.period / HOUR:10.3f}{amplitude:15.4f}"
            f"{0.5 * amplitude**2 / total:9.4f}{note}"
        )
    print(
        f"\nThe residual of the series is {fit.rms:.3f} mag rms of {np.sqrt(total):.3f}: the "
        "directions of Sun and Earth\nchange, and the amplitudes with them, while a line has one "
        "amplitude."
    )


def periodogram(seconds: Array, variation: Array) -> tuple[Array, Array]:
    """Frequencies in 1/h and amplitudes in mag, from the curve alone.

    Hann's window suppresses the leakage of the strongest line into the weaker ones.
    """
    window = np.hanning(len(variation))
    waves = np.fft.rfft(window * (variation - np.mean(variation)), 8 * len(variation))
    frequency = np.fft.rfftfreq(8 * len(variation), (seconds[1] - seconds[0]) / HOUR)
    return frequency, 2.0 * np.abs(waves) / np.sum(window)


def draw(
    view: View, days: Array, magnitude: Array, variation: Array, fit: photometry.SeriesFit
) -> None:
    frequency, amplitude = periodogram(days * DAY, variation)
    top = frequency[np.argmax(amplitude)]
    print(f"\nThe periodogram of the curve peaks at {1.0 / top:.2f} h, half of {2.0 / top:.2f} h.")
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (whole, part, lines) = plt.subplots(3, 1, figsize=(9, 11), layout="constrained")
    whole.plot(days, magnitude, color="#0072b2", lw=0.7)
    whole.set(
        title="(99942) Apophis, an ellipsoid of the published moments, from the Earth",
        ylabel="reduced magnitude V(1, 1, α)",
        xlabel="days since 2 December 2012 00:00 UTC",
        xlim=(0, days[-1]),
    )
    whole.invert_yaxis()
    right = whole.twinx()
    right.plot(days, np.degrees(view.phase_angle), color="#d55e00", ls="--", lw=1.0)
    right.set_ylabel("phase angle (deg)", color="#d55e00")
    right.set_ylim(0, 120)

    near = (days >= 60.0) & (days <= 72.0)
    hours = (days[near] - 60.0) * 24.0
    part.plot(hours, variation[near], color="#0072b2", lw=1.2)
    for k in range(1, int(hours[-1] / 30.56) + 1):
        part.axvline(k * 30.56, color="0.5", lw=0.8, ls=":")
    part.set(
        ylabel="magnitude over H, G at that phase",
        xlabel="hours since 31 January 2013 00:00 UTC (dotted: every 30.56 h)",
        xlim=(0, hours[-1]),
    )
    part.invert_yaxis()

    lines.plot(frequency, amplitude, color="#0072b2", lw=0.9, label="periodogram of the curve")
    for line, strength in fit.strongest(7):
        lines.plot(line.frequency * HOUR, strength, "o", color="#d55e00", ms=4)
        lines.annotate(
            f"({line.i}, {line.j})  {line.period / HOUR:.2f} h",
            (line.frequency * HOUR, strength),
            textcoords="offset points", xytext=(0, 6), fontsize=9, rotation=90,
            ha="center", va="bottom",
        )  # fmt: skip
    lines.plot([], [], "o", color="#d55e00", ms=4, label="lines (i, j) at |i/P_phi + j/P_psi|")
    lines.set_yscale("log")
    lines.set(ylabel="amplitude (mag)", xlabel="frequency (1/h)", xlim=(0, 0.16), ylim=(1e-3, 20.0))
    lines.legend(loc="upper right")
    for panel in (whole, part, lines):
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)
    print(f"Picture: {PICTURE}")


if __name__ == "__main__":
    main()
