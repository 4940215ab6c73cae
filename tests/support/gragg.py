"""A second witness for motion under torques: extrapolated midpoint steps in many digits.

Gragg, Bulirsch & Stoer (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I,
section II.9): nothing in common with a splitting scheme.
"""

from mpmath import mp, mpf


def integrate(f, t, y, end, steps, stages=12):
    """y at `end`, from y at t, by equal steps of order 2 stages; all mpf lists."""
    big = (end - t) / steps
    for _ in range(steps):
        y = _extrapolated(f, t, y, big, stages)
        t += big
    return y


def _extrapolated(f, t, y, big, stages):
    rows = []
    for j in range(1, stages + 1):
        row = [_midpoint(f, t, y, big, 2 * j)]
        for k in range(1, j):
            ratio = (mpf(j) / (j - k)) ** 2 - 1
            row.append(
                [a + (a - b) / ratio for a, b in zip(row[k - 1], rows[-1][k - 1], strict=True)]
            )
        rows.append(row)
    return rows[-1][-1]


def _midpoint(f, t, y, big, count):
    h = big / count
    before, now = y, [a + h * b for a, b in zip(y, f(t, y), strict=True)]
    for j in range(1, count):
        slope = f(t + j * h, now)
        before, now = now, [a + 2 * h * b for a, b in zip(before, slope, strict=True)]
    slope = f(t + big, now)
    return [(a + b + h * c) / 2 for a, b, c in zip(before, now, slope, strict=True)]


class EccentricOrbit:
    """Gravity gradient on a Kepler orbit in the x-y plane: units in which GM = a = n = 1."""

    def __init__(self, moments, eccentricity):
        self.moments = [mpf(x) for x in moments]
        self.e = mpf(eccentricity)

    def position(self, t):
        anomaly = t + self.e * mp.sin(t)
        for _ in range(60):
            step = (t - anomaly + self.e * mp.sin(anomaly)) / (1 - self.e * mp.cos(anomaly))
            anomaly += step
            if abs(step) < mp.eps * 8:
                break
        return mp.cos(anomaly) - self.e, mp.sqrt(1 - self.e**2) * mp.sin(anomaly)

    def slope(self, t, y):
        """Quaternion body to inertial and body rates: their rates of change."""
        w, x, yy, z, a, b, c = y
        p, q = self.position(t)
        r2 = p * p + q * q
        size = w * w + x * x + yy * yy + z * z
        # q* (p, q, 0) q
        u1 = ((w * w + x * x - yy * yy - z * z) * p + 2 * (x * yy + w * z) * q) / size
        u2 = (2 * (x * yy - w * z) * p + (w * w - x * x + yy * yy - z * z) * q) / size
        u3 = (2 * (x * z + w * yy) * p + 2 * (yy * z - w * x) * q) / size
        i1, i2, i3 = self.moments
        strength = 3 / (r2 * r2 * mp.sqrt(r2))
        return [
            (-x * a - yy * b - z * c) / 2,
            (w * a + yy * c - z * b) / 2,
            (w * b + z * a - x * c) / 2,
            (w * c + x * b - yy * a) / 2,
            (i2 - i3) / i1 * (b * c - strength * u2 * u3),
            (i3 - i1) / i2 * (c * a - strength * u3 * u1),
            (i1 - i2) / i3 * (a * b - strength * u1 * u2),
        ]
