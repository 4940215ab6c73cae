"""A synthetic light curve of Apophis, and what its inversion finds.

The curve is computed from the published rotation and moments (Pravec et al. 2014), the path of JPL
and the homogeneous ellipsoid with these moments (data/mission/apophis-2012.toml): 400 magnitudes of
0.02 mag in 40 nights of the winter of 2012-13.  The inversion gets epochs, magnitudes and the
geometry, and returns the mode, both periods and the pole.  Some 20 seconds.

    python examples/apophis_inversion.py
"""

from pathlib import Path

import numpy as np

from attitude import FreeRotation, epochs, inversion
from attitude.formats import mission

MISSION = Path(__file__).resolve().parent.parent / "data" / "mission" / "apophis-2012.toml"
PICTURE = "apophis_inversion.png"
DAY = 86400.0


def curve() -> tuple[inversion.LightCurve, FreeRotation]:
    """The light curve, and the truth."""
    found = mission.read(MISSION)
    scene, motion = found.scene, found.scene.motion
    # The file describes a free rotation.
    assert isinstance(motion, FreeRotation)
    start = epochs.instant(found.times["start"])
    generator = np.random.default_rng(20130109)
    night = np.sort(generator.choice(90, 40, replace=False))
    seconds = np.sort((night[:, None] + generator.uniform(0.0, 0.3, (40, 10))).ravel()) * DAY
    # A LightCurve takes apparent magnitudes; the file asks for reduced ones.
    magnitude = scene.since(start, seconds).magnitude + 0.02 * generator.normal(size=len(seconds))
    times = epochs.times(start, seconds, np.zeros_like(seconds))
    return inversion.LightCurve(times, magnitude, 0.02, scene=scene, name="Apophis"), motion


def main() -> None:
    given, motion = curve()
    print(given)
    found = inversion.spin_states(given, "1.4 /d")
    print(found, end="\n\n")
    print("Found:", found[0].published("L"))
    print("Truth:", motion.published("L", frame="ecliptic"))
    found.plot(PICTURE)
    print(f"Picture: {PICTURE}")


if __name__ == "__main__":
    main()
