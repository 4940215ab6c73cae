"""States of B bodies and their attitudes at epochs: in blocks, by one thread or several."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude._solver import evaluation, sensitivities
from attitude._solver.principal_axes import ASYMMETRY, PrincipalAxes
from attitude._support import validation
from attitude._support.blocks import ProgressBar, in_rectangles
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from attitude._support.annotations import FloatArray


# The constants of so many bodies are computed together: they stay in the second-level cache.
_BLOCK = 256
_IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])


class _Prepared(NamedTuple):
    """Constants of some bodies, and the arrays from which they were computed."""

    constants: NDArray[Any]
    moments: FloatArray
    wxyz: FloatArray
    principal: FloatArray


class Batch(NamedTuple):
    """The states of B bodies.

    inertia: (B, 3) or (B, 3, 3), principal moments about the body axes, or tensors in body axes,
        whose doubles are exact.
    wxyz: (B, 4), attitudes at t = 0, body to inertial, of any length.
    omega: (B, 3), rad/s over the body axes.
    """

    inertia: FloatArray
    wxyz: FloatArray
    omega: FloatArray

    def propagated(
        self,
        t: FloatArray,
        t_low: FloatArray | None,
        wxyz: FloatArray,
        rates: FloatArray | None,
        sensitivity: Sequence[FloatArray],
        threads: int,
        *,
        near: bool = True,
    ) -> None:
        """Fill wxyz (B, 4, T), and rates (B, 3, T), sensitivity (B, 3, 9, T) if given; t (1 or B,
        T).  `near` is that of `sensitivities.evaluate`.
        """
        count, length = len(self.wxyz), t.shape[1]
        if not count:
            return
        if threads != 1:
            threads = validation.count(threads, "threads")
        if count * max(length, 1) <= evaluation.EPOCHS and count <= _BLOCK:
            # nothing to divide: one body at one epoch takes half the time without slices
            whole = 0, length
            self._fill(t, t_low, wxyz, rates, sensitivity, whole, first=0, count=count, near=near)
            return

        def work(part: slice, epochs: tuple[int, int]) -> None:
            rows = part if len(t) > 1 else slice(None)
            Batch(self.inertia[part], self.wxyz[part], self.omega[part])._fill(
                t[rows],
                None if t_low is None else t_low[rows],
                wxyz[part],
                None if rates is None else rates[part],
                [columns[part] for columns in sensitivity],
                epochs,
                first=part.start,
                count=count,
                near=near,
            )

        # A piece of work is some milliseconds long, and writes to few pages of memory.
        span = length if sensitivity else evaluation.EPOCHS
        bar = ProgressBar("attitudes")
        in_rectangles(work, count, length, _BLOCK, max(span, 1), evaluation.EPOCHS, threads, bar)

    def _fill(
        self,
        t: FloatArray,
        t_low: FloatArray | None,
        wxyz: FloatArray,
        rates: FloatArray | None,
        sensitivity: Sequence[FloatArray],
        span: tuple[int, int],
        *,
        first: int,
        count: int,
        near: bool,
    ) -> None:
        """As `propagated` for a span of the epochs; errors say that its first body is `first` of
        `count`.
        """
        prepared = self._prepared(rates is not None, first, count)
        body = evaluation.evaluate_all(prepared.constants, t, t_low, wxyz, rates, *span)
        if body >= 0:
            few = body if len(t) > 1 else 0, slice(*span)
            low = None if t_low is None else t_low[few]
            evaluation.refuse_epoch(prepared.constants[body], t[few], low)
        if sensitivity:
            tangents = sensitivities.tangents_of(
                prepared.moments, prepared.wxyz, prepared.principal, prepared.constants
            )
            sensitivities.evaluate(prepared.constants, tangents, t, t_low, *sensitivity, near=near)

    def _prepared(self, rates: bool, first: int, count: int) -> _Prepared:
        """The constants of the bodies, of which the first one has the number `first` of `count`."""
        wxyz, omega = self.wxyz, self.omega
        differences = None
        if self.inertia.ndim == 2:
            moments, turning = np.zeros((len(wxyz), 3, 2)), np.zeros((len(wxyz), 3, 2))
            moments[:, :, 0], turning[:, :, 0] = self.inertia, omega
            principal = _IDENTITY
        else:
            axes = PrincipalAxes.of(symmetric_tensors(self.inertia, first, count))
            turning, differences = axes.over_axes(evaluation.writable(omega))
            moments, principal = axes.moments, axes.wxyz
        constants = evaluation.constants_of(
            moments,
            wxyz,
            turning,
            principal,
            differences=differences,
            rates=rates,
            first=first,
            count=count,
        )
        return _Prepared(constants, moments, wxyz, principal)


def symmetric_tensors(
    tensors: FloatArray, first: int = 0, count: int = 1, *, raises: bool = True
) -> FloatArray:
    """Tensors (B, 3, 3) without the rounding of their asymmetry."""
    across = np.swapaxes(tensors, 1, 2)
    with np.errstate(invalid="ignore", over="ignore"):
        off, largest = (np.abs(array).max(axis=(1, 2)) for array in (tensors - across, tensors))
        mean = 0.5 * (tensors + across)
    # one that is not finite, or of which sums overflow
    bad = ~(off <= ASYMMETRY * largest) | ~np.isfinite(mean).all(axis=(1, 2))
    if bad.any() and not raises:
        mean[bad] = np.diag([np.nan] * 3)
        np.copyto(mean, 0.0, where=bad[:, None, None] & ~np.eye(3, dtype=bool))
    elif bad.any():
        k = int(np.flatnonzero(bad)[0])
        where = f"Tensor {first + k} of {count}" if count > 1 else "The tensor"
        raise AttitudeError(
            f"{where} is {tensors[k].tolist()}; give symmetric matrices of finite numbers "
            "(products of inertia with a minus sign), up to 8e307."
        )
    return np.ascontiguousarray(mean)
