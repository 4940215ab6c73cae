"""Named axes by their definitions, in as many digits as mpmath is set to."""

import mpmath


def turned(axis, angle):
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = mpmath.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[j, i], matrix[i, j] = s, -s
    return matrix


def definition(frame):
    """The rotation to ICRF with the constants as printed, in the digits of the context."""
    arcsec = mpmath.pi / 648000
    obliquity = mpmath.mpf("84381.448") * arcsec
    if frame == "ecliptic":
        return turned(0, obliquity)
    if frame == "eme2000":
        xi = mpmath.mpf("-0.041775") * arcsec * mpmath.sin(obliquity)
        eta = mpmath.mpf("-0.0068192") * arcsec
        alpha = mpmath.mpf("-0.0146") * arcsec
        return turned(2, alpha) * turned(1, xi) * turned(0, -eta)
    return mpmath.eye(3)
