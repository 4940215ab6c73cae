"""Shadows of a mesh by casting rays: slow, and independent of the table of `_visibility`.

Users compare `brightness` with it on meshes of their own.  Both share the law and the points of the
facets, but not the way in which these are found to be free.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude._support import validation
from attitude.errors import AttitudeError
from attitude.light_curve._brightness import components, paired
from attitude.light_curve._visibility import points_of, require_mesh
from attitude.scattering._law import law as known_law

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.scattering._law import Law
    from attitude.shape._mesh import Mesh


def brightness_by_rays(
    mesh: Mesh,
    law: str | Law,
    sun: ArrayLike,
    observer: ArrayLike,
    *,
    points: ArrayLike | None = None,
) -> FloatArray:
    """Brightness of a mesh, with the shadows found by casting rays (by embree if installed).

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

    Returns
    -------
    (...) array
        m2/sr.

    Raises
    ------
    AttitudeError
        Without trimesh, for laws without weights, and for vectors that are not unit to 1e-6.

    Notes
    -----
    A facet that is turned to both Sun and observer takes two rays for each point and epoch; some
    1e6 rays a second.  The fraction of its points that see both is the fraction of its area that
    counts.
    """
    from attitude._solver.vectors import separation

    require_mesh(mesh)
    law = known_law(law)
    weights = law.weights
    if weights is None:
        raise AttitudeError(
            f"law is {law!r}; rays are cast only under laws that are a phase function times "
            "mu0 mu [a / (mu0 + mu) + b], such as Lambert and LommelSeeliger."
        )
    suns, observers, shape = paired(sun, observer)
    if points is None:
        places = points_of(mesh.corners)
    else:
        places = np.einsum("pk,fki->fpi", np.asarray(points, dtype=float), mesh.corners)
    blocked = _caster(mesh)
    a, b = weights
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
        start = places[on] + lift[on, None]
        free = ~blocked(start.reshape(-1, 3), suns[t])
        free[free] = ~blocked(start.reshape(-1, 3)[free], observers[t])
        share = np.mean(free.reshape(len(on), -1), axis=1)
        p, q = mu0[on], mu[on]
        out[t] = phase[t] * np.sum(mesh.areas[on] * share * p * q * (a / (p + q) + b))
    return out.reshape(shape)


def _caster(mesh: Mesh) -> Callable[[FloatArray, FloatArray], BoolArray]:
    """A function of origins (N, 3) and a direction (3,): whether each ray meets the mesh, (N,)."""
    try:
        import trimesh
    except ImportError as err:
        raise AttitudeError(
            f"casting rays needs trimesh, and embreex to be fast: {validation.installing('mesh')}."
        ) from err
    solid = trimesh.Trimesh(mesh.vertices, mesh.facets, process=False)

    def blocked(origins, direction):
        if len(origins) == 0:
            return np.zeros(0, dtype=bool)
        return solid.ray.intersects_any(origins, np.broadcast_to(direction, origins.shape))

    return blocked
