"""The normal form of a free rotation: its elements, and the motion that has given ones."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from attitude import validation
from attitude.body import Body
from attitude.free_rotation.differentiable import Differentiable
from attitude.free_rotation.sensitivity import Sensitivity
from attitude.sensitivities.elements import Elements, elements_of, state_of
from attitude.spin import Spin

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import Epoch, Real, Reals


class NormalForm(Differentiable):
    """A free rotation with its elements; a class of this kind is made from a Body and a Spin."""

    _has_closed_form = True

    if TYPE_CHECKING:
        _constants: Any

        def __init__(self, body: Body, spin: Spin) -> None: ...

    @cached_property
    def _sensitivity(self) -> Sensitivity:
        return Sensitivity(self._constants, self.body, self.spin)

    def _with(self, body: Body, spin: Spin) -> Self:
        return type(self)(body, spin)

    @cached_property
    def elements(self) -> Elements:
        """The normal form: rates, phase, amplitude and ellipticity of the motion.

        Raises
        ------
        AttitudeError
            Where no nutation is defined: at rest, spheres, the middle axis, and the equator of a
            symmetric body.
        """
        return elements_of(self._constants[0])

    @classmethod
    def from_elements(
        cls,
        elements: Elements | Sequence[float],
        *,
        epoch: Epoch,
        wxyz: Reals,
        frame: str = "icrf",
        largest_moment: Real | None = None,
    ) -> Self:
        """The motion with given elements.

        Parameters
        ----------
        elements : Elements or five numbers
            precession_rate, nutation_rate (rad/s), phase (rad), rho, X; see
            `attitude.sensitivities.elements`.
        epoch, wxyz, frame
            As for `Spin`: attitude at the epoch of the principal axes in the order of the solution
            (the momentum circulates about the third, the second is the middle one).
        largest_moment : float or Quantity, optional
            kg m2.  Without it the moments are relative, the largest being 1.

        Raises
        ------
        AttitudeError
            For elements outside their range, and elements that no body has.
        """
        numbers = validation.real(elements, "elements", shape=(5,), finite=False)
        given = Elements(*numbers.tolist())
        moments, omega = state_of(given)
        if largest_moment is not None:
            moments *= validation.positive(largest_moment, "largest_moment", unit="kg m2")
        body = Body(moments=moments, relative=largest_moment is None)
        return cls(body, Spin(epoch, wxyz, omega, frame))
