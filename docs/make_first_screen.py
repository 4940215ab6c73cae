"""The pictures of the first screen of README, into docs/figures/first_screen/.

    python docs/make_first_screen.py

needs matplotlib and Pillow.  The body of the animation is two ellipsoids in contact, of the size of
Toutatis; Sun and observer stand in fixed directions, 60 degrees apart.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from PIL import Image

from attitude import Scene, catalog, plots, shape
from attitude.viewer import animate

FIGURES = Path(__file__).resolve().parent / "figures"
FOLDER = FIGURES / "first_screen"
# Thumbnails, and the figures of which they are made.
THUMBNAILS = {
    "asteroids": "apophis_light_curve.png",
    "debris": "envisat_glints.png",
    "missions": "despin.png",
    "mechanics": "t_handle.png",
}
WIDTH, HEIGHT = 210, 150


def lit():
    """Toutatis, lit and seen."""
    motion = catalog.entry("toutatis").motion()
    large = shape.Ellipsoid((950.0, 1150.0, 1350.0)).facets(1000).moved((0.0, 0.0, -750.0))
    small = shape.Ellipsoid((750.0, 800.0, 1000.0)).facets(700).moved((0.0, 0.0, 1450.0))
    body = large.joined(small)
    return Scene(motion, None, observer=(1, 0, 0.1), sun=(0.5, 0.87, 0.2), shape=body)


def main():
    """Write all pictures."""
    FOLDER.mkdir(exist_ok=True)
    animate(
        lit(), FOLDER / "toutatis.webp", stop=22 * 86400.0, frames=150, rate=18.0,
        size=(520, 400), title="(4179) Toutatis, 22 days",
    )  # fmt: skip
    motion = catalog.entry("toutatis").motion()
    plots.overview(motion, title="4179 Toutatis").savefig(FOLDER / "overview.png", dpi=60)
    for name, source in THUMBNAILS.items():
        with Image.open(FIGURES / source) as picture:
            small = picture.convert("RGB")
            small.thumbnail((WIDTH, HEIGHT), Image.Resampling.LANCZOS)
            small.save(FOLDER / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
