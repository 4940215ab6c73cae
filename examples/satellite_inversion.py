"""The rates and the attitude of a satellite from the brightness of one pass.

Envisat as a box with a wing (data/mission/envisat-glints.toml: dimensions approximate, materials
and state assumed) is observed from Skibotn for one pass: 200 magnitudes of 0.1 mag, glints among
them.  The inversion knows shape, materials, moments and geometry, and searches rates up to 0.012
turns a second.  Its shape has 24 facets, that of the mission 384 with finer shadows.  45 s.

    python examples/satellite_inversion.py
"""

from pathlib import Path

import numpy as np

from attitude import epochs, inversion
from attitude.formats import mission
from attitude.scene import Scene
from attitude.shape import Mesh, box_wing

MISSION = Path(__file__).resolve().parent.parent / "data" / "mission" / "envisat-glints.toml"
# From the end of the shadow to the end of the pass.
START, LENGTH = "2013-10-23T19:19:30", 385.0
PICTURE = "satellite_inversion.png"


def main() -> None:
    found = mission.read(MISSION)
    scene = found.scene
    # The file describes facets, a motion and magnitudes.
    assert isinstance(scene, Scene) and isinstance(scene.shape, Mesh)
    assert scene.motion is not None and scene.motion.body is not None
    assert found.magnitude is not None
    start = epochs.instant(START)
    generator = np.random.default_rng(3)
    seconds = np.sort(generator.uniform(0.0, LENGTH, 200))
    magnitude = found.magnitude.of(scene.since(start, seconds))
    seen = np.isfinite(magnitude)
    magnitude = magnitude[seen] + 0.1 * generator.normal(size=np.count_nonzero(seen))
    times = epochs.times(start, seconds[seen], np.zeros(np.count_nonzero(seen)))
    curve = inversion.LightCurve(times, magnitude, 0.1, scene=scene, name="Envisat")
    print(curve)
    shape = box_wing(
        (10.0, 4.0, 4.0), (14.0, 5.0), gap=2.0, wings=1, wing_axis="x", wing_angle=np.radians(45.0)
    )
    result = inversion.spin_states(
        curve, "0.012 Hz", shape=shape, law=scene.law, moments=scene.motion.body, budget=120.0
    )
    print(result, end="\n\n")
    best = result[0].motion
    for name, motion in (("found", best), ("truth", scene.motion)):
        here = motion.at([start])
        rate = np.degrees(here.matrix[0] @ here.angular_velocity[0])
        print(f"{name}: rates {rate.round(3)} deg/s over ICRF axes at {START}")
    result.plot(PICTURE)
    print(f"Picture: {PICTURE}")


if __name__ == "__main__":
    main()
