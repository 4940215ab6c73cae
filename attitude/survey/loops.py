"""The compiled loops over the rows of a survey: epochs, and brightness over its mean."""

import math

from attitude.compilation.decorators import entry_point, sized_entry_point
from attitude.light_curve.closed_form import intensity


@entry_point
def over_mean(areas, factor, sun, observer, brightness):
    """Divide brightness (R,), m2/sr, by its mean over all orientations, for Lommel-Seeliger's law.

    Given
        areas           (R,) surface areas of the bodies over that of a sphere of radius 1
        factor          weight of the law
        sun, observer   (3, R) vectors of any length
    """
    scale = 0.25 * math.pi * factor
    for n in range(brightness.size):
        sx, sy, sz = sun[0, n], sun[1, n], sun[2, n]
        ox, oy, oz = observer[0, n], observer[1, n], observer[2, n]
        s = 1.0 / math.sqrt(sx * sx + sy * sy + sz * sz)
        o = 1.0 / math.sqrt(ox * ox + oy * oy + oz * oz)
        sphere = intensity(1.0, 1.0, 1.0, scale, sx * s, sy * s, sz * s, ox * o, oy * o, oz * o)
        brightness[n] /= sphere * areas[n]


@sized_entry_point
def interpolated(x, first, table, out):
    """Fill linear interpolations at x (R,) in a table of values at first, first + 1/2, ..."""
    for n in range(x.size):
        place = 2.0 * (x[n] - first)
        k = int(place)
        out[n] = table[k] + (place - k) * (table[k + 1] - table[k])
