"""Magnitudes of a known shape under a known law, with their derivative by a turn of the body."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError
from attitude.inversion.convex import BodyLight
from attitude.light_curve.brightness import BLOCK, kernel_of, with_phase
from attitude.light_curve.directions import components, paired
from attitude.scattering import LommelSeeligerLambert
from attitude.scattering import law as known_law
from attitude.shape import Mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude.annotations import FloatArray
    from attitude.scattering import Law

# rad: of the differences.  Lobes of glints are wider by far.
_TURN = 1e-4
# Flux, over the mean, below which a magnitude is that of this flux: the body is unlit.
_DARK = 1e-4
_MAGNITUDE = -2.5 / math.log(10.0)
_NOTHING = np.zeros(0)


@dataclass(frozen=True, eq=False)
class KnownShape:
    """A mesh with its law.

    Attributes
    ----------
    mesh : Mesh
        Over the axes of the body, whose attitude is sought.
    law : Law
    """

    mesh: Mesh
    law: Law

    def __getstate__(self) -> dict[str, object]:
        # `_sums` is made anew: compiled loops are not pickled
        return {"mesh": self.mesh, "law": self.law}

    def over(self, axes: FloatArray) -> KnownShape:
        """The same over other axes, the columns (3, 3)."""
        if np.array_equal(axes, np.eye(3)):
            return self
        return KnownShape(self.mesh.turned(axes.T), self.law)

    def flux(self, sun: FloatArray, observer: FloatArray) -> FloatArray:
        """Brightness (...) seen from unit vectors (..., 3) over the axes of the body, m2/sr."""
        suns, observers, shape = paired(sun, observer)
        found = np.empty(shape)
        flat = found.reshape(-1)
        for begin in range(0, flat.size, BLOCK):
            end = begin + BLOCK
            self._sums(components(suns, observers, begin, end), flat[begin:end])
        return found

    @cached_property
    def _sums(self) -> Callable[[Sequence[FloatArray], FloatArray], None]:
        """The sum over the facets: made once, since a search evaluates it thousands of times."""
        return with_phase(kernel_of(self.mesh, self.law, True, 1), self.law)

    def magnitudes(self, sun: FloatArray, observer: FloatArray, least: float) -> FloatArray:
        """Magnitudes (...) of the flux, or of `least` where it is smaller."""
        found: FloatArray = _MAGNITUDE * np.log(np.maximum(self.flux(sun, observer), least))
        return found

    def floor(self, sun: FloatArray, observer: FloatArray) -> float:
        """The least flux that counts, from directions (..., 3) over any axes."""
        return max(_DARK * float(np.mean(self.flux(sun, observer))), 1e-300)

    def lit(self, sun: FloatArray, observer: FloatArray, least: float) -> BodyLight:
        """Magnitudes (N,) and their slopes (N, 3) by a turn of the body about its own axes."""
        across = np.empty((*sun.shape[:-1], 3))
        for k in range(3):
            ends = [
                self.magnitudes(_turned(sun, k, side), _turned(observer, k, side), least)
                for side in (_TURN, -_TURN)
            ]
            across[..., k] = (ends[0] - ends[1]) / (2.0 * _TURN)
        nothing = np.zeros((0, sun.shape[0]))
        here = self.magnitudes(sun, observer, least)
        return BodyLight(here, across, nothing, _NOTHING, np.zeros((0, 0)))


def known(mesh: Mesh, law: str | Law | None) -> KnownShape:
    """The mesh with a law, or with its name; by default Lommel-Seeliger's and a tenth of Lambert's.

    Raises
    ------
    AttitudeError
        For facets of materials that the law lacks.
    """
    chosen = LommelSeeligerLambert(c=0.1, a=0.0, k=0.0) if law is None else known_law(law)
    if not isinstance(mesh, Mesh):
        raise AttitudeError(f"shape is {mesh!r}; give a Mesh.")
    found = KnownShape(mesh, chosen)
    found.flux(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    return found


def _turned(vectors: FloatArray, axis: int, angle: float) -> FloatArray:
    """Vectors (..., 3) fixed in space, over the axes of a body that is turned about an own axis."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = vectors.copy()
    out[..., i] = c * vectors[..., i] + s * vectors[..., j]
    out[..., j] = c * vectors[..., j] - s * vectors[..., i]
    return out
