"""Self-shadowing by casting rays: slow and exact, the witness of `visibility`."""

import numpy as np

from attitude.errors import AttitudeError
from attitude.light_curve.directions import components, paired
from attitude.light_curve.visibility import points_of, require_mesh
from attitude.scattering import law as known_law


def brightness_by_rays(mesh, law, sun, observer, *, points=None):
    """Brightness with shadows from rays, embree's where it is installed.

    Parameters
    ----------
    mesh : Mesh
    law : str or Law
        One of those that are a phase function times mu0 mu [a / (mu0 + mu) + b].
    sun, observer : (N, 3) array_like
        Unit vectors in body axes.
    points : (P, 3) array_like, optional
        Barycentric weights of the points of each facet from which rays are cast; the eight of
        `Visibility` unless given; ``[[1/3, 1/3, 1/3]]`` casts from the centroids.

    Returns
    -------
    (N,) array
        m2/sr.

    Notes
    -----
    Two rays a facet, point and epoch that is lit and turned to the observer: some 1e6 a second.
    A share of the facet counts when its point sees both Sun and observer.
    """
    from attitude.solution.vectors import separation

    require_mesh(mesh)
    law = known_law(law)
    if law.weights is None:
        raise AttitudeError(
            f"law is {law!r}; rays are cast only under laws that are a phase function times "
            "mu0 mu [a / (mu0 + mu) + b], such as Lambert and LommelSeeliger."
        )
    sun, observer, shape = paired(sun, observer)
    if points is None:
        places = points_of(mesh.corners)
    else:
        places = np.einsum("pk,fki->fpi", np.asarray(points, dtype=float), mesh.corners)
    blocked = _caster(mesh)
    a, b = law.weights
    phase = law.phase(separation(*components(sun, observer, 0, len(sun))))
    out = np.zeros(len(sun))
    # Away from the facet itself by far less than any facet, and more than embree's floats resolve.
    lift = 1e-4 * np.sqrt(np.min(mesh.areas)) * mesh.normals
    for t in range(len(sun)):
        mu0, mu = mesh.normals @ sun[t], mesh.normals @ observer[t]
        on = np.flatnonzero((mu0 > 0.0) & (mu > 0.0))
        if len(on) == 0:
            continue
        start = places[on] + lift[on, None]
        free = ~blocked(start.reshape(-1, 3), sun[t])
        free[free] = ~blocked(start.reshape(-1, 3)[free], observer[t])
        share = np.mean(free.reshape(len(on), -1), axis=1)
        p, q = mu0[on], mu[on]
        out[t] = phase[t] * np.sum(mesh.areas[on] * share * p * q * (a / (p + q) + b))
    return out.reshape(shape)


def _caster(mesh):
    try:
        import trimesh
    except ImportError as err:
        raise AttitudeError(
            "casting rays needs trimesh, and embreex to be fast: "
            'pip install "attitude-propagation[mesh]".'
        ) from err
    solid = trimesh.Trimesh(mesh.vertices, mesh.facets, process=False)

    def blocked(origins, direction):
        if len(origins) == 0:
            return np.zeros(0, dtype=bool)
        return solid.ray.intersects_any(origins, np.broadcast_to(direction, origins.shape))

    return blocked
