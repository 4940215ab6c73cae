"""Envisat over one night: the flashes of its flat sides, found between the samples.

A box with one wing (data/mission/envisat-glints.toml: dimensions approximate, materials, wing angle
and state of rotation assumed) is observed from Skibotn in northern Norway on the night of 23
October 2013.  Each side is diffuse with a specular lobe about the mirror direction.  A side glints
while the Sun, mirrored in it, is so near to the observer that the lobe exceeds a tenth of its peak:
for some seconds, as the body turns at 2.7 deg/s.  The search for these times uses the exact motion,
not samples.  In the shadow of the Earth a glint is dark.

    python examples/envisat_glints.py
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from attitude import epochs, events
from attitude.formats import mission
from attitude.formats.mission import MagnitudeScale
from attitude.scattering import Material, Materials
from attitude.scene import Scene
from attitude.shape import Mesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

MISSION = Path(__file__).resolve().parent.parent / "data" / "mission" / "envisat-glints.toml"
PICTURE = "envisat_glints.png"
START, NIGHT = "2013-10-23T15:30:00", 8 * 3600.0
LOWEST = np.radians(5.0)


class Glint(NamedTuple):
    """A glint: the number of the pass, the side, and the seconds of the motion of begin and end."""

    number: int
    side: str
    begin: float
    end: float


def sides(mesh: Mesh) -> dict[str, tuple[Array, str]]:
    """Name, outward normal and material of each flat side of the box and of the wing."""
    found = {}
    for normal, material in zip(mesh.normals.round(9) + 0.0, mesh.materials, strict=True):
        if material == "panel edge":
            continue
        name = material
        if material == "body":
            axis = int(np.argmax(np.abs(normal)))
            name = f"box {'-+'[int(normal[axis] > 0.0)]}{'xyz'[axis]}"
        found[name] = normal, material
    return found


def reach(material: Material) -> float:
    """The angle at which Phong's lobe cos^n has fallen to a tenth, plus the Sun's radius, rad."""
    return float(np.arccos(0.1 ** (1.0 / material.exponent))) + events.SUN_RADIUS


def passes(scene: Scene, start: epochs.Instant) -> list[tuple[float, float]]:
    """(begin, end) in seconds of the motion of each interval above the lowest elevation."""
    view = scene.since(start, np.arange(0.0, NIGHT, 10.0))
    up = np.flatnonzero(np.diff(np.r_[False, view.elevation > LOWEST, False]))
    return [(view.seconds[a], view.seconds[b - 1]) for a, b in up.reshape(-1, 2)]


def glints(scene: Scene, spans: list[tuple[float, float]]) -> tuple[list[Glint], int]:
    """The glints in order, and how many a perfect plane mirror on each side would give."""
    # The file describes facets and their materials.
    assert isinstance(scene.shape, Mesh) and isinstance(scene.law, Materials)
    known = sides(scene.shape)
    conditions, flat = [], []
    for normal, material in known.values():
        conditions.append(events.glint(scene, normal, sun_radius=reach(scene.law[material])))
        flat.append(events.glint(scene, normal))
    found: list[Glint] = []
    mirrors = 0
    for number, (begin, end) in enumerate(spans):
        seen = events.find_discrete(begin, end, conditions)
        for k, name in enumerate(known):
            found += [Glint(number, name, a, b) for a, b in seen[seen.which == k].spans()]
        mirrors += len(events.find_discrete(begin, end, flat)) // 2
    return sorted(found, key=lambda each: each.begin), mirrors


def main() -> None:
    found = mission.read(MISSION)
    scene, epoch, scale = found.scene, found.scene.epoch, found.magnitude
    assert epoch is not None and scale is not None  # the file has a spin and a shape
    start = epochs.instant(START)
    spans = passes(scene, start)
    print(found.name)
    print((found.note or "").strip(), end="\n\n")

    def date(seconds: float, digits: int = 1) -> str:
        text = epoch.after(float(seconds)).utc_iso
        return f"{text[11:19]}{f'{float(text[19:] or 0):.{digits}f}'[1:]}"

    print(f"{'pass':<22}{'highest':>8}{'phase deg':>11}{'magnitude':>14}   enters or leaves shadow")
    for begin, end in spans:
        view = scene.at(np.arange(begin, end, 1.0))
        seen = scale.of(view)
        seen = seen[np.isfinite(seen)]
        edges = events.find_discrete(begin, end, events.shadow_state(scene), step=5.0)
        crossings = ", ".join(
            f"{('light', 'penumbra', 'umbra')[state]} {date(t)}"
            for t, state in zip(*edges, strict=True)
        )
        magnitudes = f"{np.min(seen):.1f} to {np.max(seen):.1f}" if len(seen) else "dark"
        phase = np.degrees([np.min(view.phase_angle), np.max(view.phase_angle)])
        print(
            f"{date(begin, 0)} - {date(end, 0):<11}{np.degrees(np.max(view.elevation)):8.1f}"
            f"{phase[0]:6.0f} -{phase[1]:3.0f}{magnitudes:>14}   {crossings}"
        )

    flashes, mirrors = glints(scene, spans)
    print(f"\n{'UTC':<12}{'side':<13}{'lasts s':>8}{'elev.':>7}{'phase':>7}{'lit':>6}", end="")
    print(f"{'mag':>7}{'before':>8}")
    for _, name, begin, end in flashes:
        t = np.linspace(begin, end, 201)
        magnitude = scale.of(scene.at(t))
        top = int(np.argmin(magnitude)) if np.any(np.isfinite(magnitude)) else 100
        view = scene.at([t[top], begin - (end - begin)])
        print(
            f"{date(t[top]):<12}{name:<13}{end - begin:8.3f}{np.degrees(view.elevation[0]):7.1f}"
            f"{np.degrees(view.phase_angle[0]):7.1f}{view.lit_fraction[0]:6.2f}{magnitude[top]:7.2f}"
            f"{scale.of(view)[1]:8.2f}"
        )
    print(
        f"\n{len(flashes)} glints; perfect plane mirrors would give {mirrors}. "
        "(inf: no lit part is visible.)"
    )
    draw(scene, scale, spans, flashes, date)


def draw(
    scene: Scene,
    scale: MagnitudeScale,
    spans: list[tuple[float, float]],
    flashes: list[Glint],
    date: Callable[[float, int], str],
) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    middles = [scale.of(scene.at([0.5 * (each.begin + each.end)]))[0] for each in flashes]
    visible = [pair for pair in zip(middles, flashes, strict=True) if np.isfinite(pair[0])]
    bright = [glint for _, glint in sorted(visible)[:2]]
    shown = sorted({each.number for each in bright})
    figure, panels = plt.subplots(
        len(shown) + 1, 1, figsize=(9, 3.6 * (len(shown) + 1)), layout="constrained"
    )
    for panel, number in zip(panels, shown, strict=False):
        curve(panel, scene, scale, spans[number])
        for each, name, begin, end in flashes:
            if each == number:
                middle = (0.5 * (begin + end) - spans[number][0]) / 60.0
                panel.axvline(middle, color="#d55e00", lw=0.8, ls="--")
                panel.text(
                    middle,
                    0.97,
                    f"{name} ",
                    transform=panel.get_xaxis_transform(),
                    rotation=90,
                    ha="right",
                    va="top",
                    color="#d55e00",
                    fontsize=9,
                )
        panel.set_xlabel(f"minutes since {date(spans[number][0], 0)} UTC")
    if bright:
        _, name, begin, end = bright[0]
        middle = 0.5 * (begin + end)
        t = np.linspace(middle - 8.0, middle + 8.0, 3201)
        panels[-1].plot(t - middle, scale.of(scene.at(t)), color="#0072b2", lw=1.2)
        panels[-1].axvspan(begin - middle, end - middle, color="#d55e00", alpha=0.2)
        panels[-1].invert_yaxis()
        panels[-1].set(
            xlabel=f"seconds from {date(middle, 1)} UTC: the glint of the {name} (shaded)",
            ylabel="apparent magnitude",
            xlim=(-8, 8),
        )
    panels[0].set_title("Envisat as a box with a wing, over Skibotn on 23 October 2013")
    for panel in panels:
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


def curve(panel: "Axes", scene: Scene, scale: MagnitudeScale, span: tuple[float, float]) -> None:
    t = np.arange(*span, 0.25)
    view = scene.at(t)
    magnitude = scale.of(view)
    minutes = (t - span[0]) / 60.0
    panel.plot(
        minutes, np.where(np.isfinite(magnitude), magnitude, np.nan), color="#0072b2", lw=0.9
    )
    dark = np.flatnonzero(view.lit_fraction == 0.0)
    if dark.size:
        panel.axvspan(minutes[dark[0]], minutes[dark[-1]], color="0.88", zorder=0)
        panel.text(minutes[dark].mean(), 0.5, "in the Earth's umbra", rotation=90, ha="center",
                   va="center", transform=panel.get_xaxis_transform(), color="0.4")  # fmt: skip
    panel.invert_yaxis()
    panel.set(ylabel="apparent magnitude", xlim=(0, minutes[-1]))
    right = panel.twinx()
    right.plot(minutes, np.degrees(view.elevation), color="#009e73", ls=":", lw=1.2)
    right.set_ylabel("elevation (deg)", color="#009e73")
    right.set_ylim(0, 90)


if __name__ == "__main__":
    main()
