"""Shadows of a mesh by casting rays: slow, and independent of the table of shadows.

`attitude.light_curve.brightness` is compared with it.  Both share the law and the points of the
facets, but not the way in which these are found to be free.
"""

import numpy as np

from attitude._solver.vectors import separation
from attitude.light_curve._brightness import components, paired
from attitude.light_curve._visibility import points_of
from attitude.scattering._law import law as known_law


def brightness_by_rays(mesh, law, sun, observer, *, points=None):
    """Brightness (...) of a mesh, m2/sr, with the shadows found by casting rays.

    By embree if embreex is installed: some 1e6 rays a second, else far fewer.  A facet that is
    turned to both Sun and observer takes two rays for each point and epoch; the fraction of its
    points that see both is the fraction of its area that counts.

    Parameters
    ----------
    mesh : Mesh
    law : str or Law
        A law with ``weights``, such as Lambert and LommelSeeliger.
    sun, observer : (..., 3) array_like
        Unit vectors in body axes.
    points : (P, 3) array_like, optional
        Barycentric weights of the points of each facet from which rays are cast; by default the
        eight of `Visibility`.  ``[[1/3, 1/3, 1/3]]`` casts from the centroids.
    """
    import trimesh

    law = known_law(law)
    a, b = law.weights
    suns, observers, shape = paired(sun, observer)
    if points is None:
        places = points_of(mesh.corners)
    else:
        places = np.einsum("pk,fki->fpi", np.asarray(points, dtype=float), mesh.corners)
    solid = trimesh.Trimesh(mesh.vertices, mesh.facets, process=False)
    phase = law.phase(separation(*components(suns, observers, 0, len(suns))))
    out = np.zeros(len(suns))
    # Rays start above the facet: by far less than any facet's size, by more than the resolution of
    # embree's single precision.
    lift = 1e-4 * np.sqrt(np.min(mesh.areas)) * mesh.normals
    for t in range(len(suns)):
        mu0, mu = mesh.normals @ suns[t], mesh.normals @ observers[t]
        on = np.flatnonzero((mu0 > 0.0) & (mu > 0.0))
        if len(on) == 0:
            continue
        start = (places[on] + lift[on, None]).reshape(-1, 3)
        free = ~_blocked(solid, start, suns[t])
        free[free] = ~_blocked(solid, start[free], observers[t])
        share = np.mean(free.reshape(len(on), -1), axis=1)
        p, q = mu0[on], mu[on]
        out[t] = phase[t] * np.sum(mesh.areas[on] * share * p * q * (a / (p + q) + b))
    return out.reshape(shape)


def _blocked(solid, origins, direction):
    """Whether each ray from origins (N, 3) in a direction (3,) meets a solid of trimesh."""
    if len(origins) == 0:
        return np.zeros(0, dtype=bool)
    return solid.ray.intersects_any(origins, np.broadcast_to(direction, origins.shape))
