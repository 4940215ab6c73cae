"""Vectors turned by attitudes, compiled: what a loop over a million epochs needs.

All arrays are component-major, (4, N) for attitudes and (3, N) for vectors, so that the loop
vectorises; a vector (3, 1) is the same for all epochs.  `attitude.quaternion.rotate` is the same
in numpy, at some 60 ns an epoch where this takes 3 to 5.
"""

from attitude.solution.machine import compiled


@compiled
def to_body(wxyz, vectors, out):
    """Components over body axes of inertial vectors: out = q* v q."""
    if vectors.shape[1] == 1:
        a, b, c = vectors[0, 0], vectors[1, 0], vectors[2, 0]
        for k in range(wxyz.shape[1]):
            w, x, y, z = wxyz[0, k], wxyz[1, k], wxyz[2, k], wxyz[3, k]
            # v - 2 w (u x v) + 2 u x (u x v), u being the vector part of q
            d = 2.0 * (y * c - z * b)
            e = 2.0 * (z * a - x * c)
            f = 2.0 * (x * b - y * a)
            out[0, k] = a - w * d + (y * f - z * e)
            out[1, k] = b - w * e + (z * d - x * f)
            out[2, k] = c - w * f + (x * e - y * d)
    else:
        for k in range(wxyz.shape[1]):
            w, x, y, z = wxyz[0, k], wxyz[1, k], wxyz[2, k], wxyz[3, k]
            a, b, c = vectors[0, k], vectors[1, k], vectors[2, k]
            d = 2.0 * (y * c - z * b)
            e = 2.0 * (z * a - x * c)
            f = 2.0 * (x * b - y * a)
            out[0, k] = a - w * d + (y * f - z * e)
            out[1, k] = b - w * e + (z * d - x * f)
            out[2, k] = c - w * f + (x * e - y * d)
