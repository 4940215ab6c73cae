"""`Law`, the base class of scattering laws; its parameters, and the registry of laws by name."""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from attitude._compilation.decorators import Compilable, reduction_over
from attitude._compilation.instructions import fence
from attitude._compilation.simd import lanes, largest_lane
from attitude._support import validation
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import ArrayLike

    from attitude._compilation.decorators import EntryPoint
    from attitude._support.annotations import FloatArray, IntArray, Real, Reals
    from attitude.scattering._materials import Material


# ---- Ranges, units and words that the parameters of a law accept


class NumberField:
    """Type annotation of a field of a law: accepts a number, a Quantity or text; holds a float.

    Type checkers apply ``__set__`` to the constructor and ``__get__`` to the attribute.  At run
    time the class does nothing.
    """

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: Any = None) -> float: ...

        def __set__(self, instance: object, value: Real) -> None: ...


@dataclass(frozen=True)
class Parameter:
    """Values that a field of a law accepts: a range of numbers with a unit, or words."""

    low: float
    high: float
    unit: str | None
    words: tuple[str, ...]
    is_required: bool

    def accepted(self, value: Real, name: str) -> float | str:
        """The value as the law holds it: a float in `unit`, or a word."""
        if self.words:
            word: Any = value
            return validation.one_of(word, name, self.words)
        number = validation.number(value, name, unit=self.unit)
        if not self.low <= number <= self.high:
            raise AttitudeError(f"{name} is {number!r}; it must lie {self._range()}.")
        return number

    def __str__(self) -> str:
        if self.words:
            return f"one of {', '.join(map(repr, self.words))}"
        return f"a number {self._range()}"

    def _range(self) -> str:
        return f"from {self.low:g} to {self.high:g}" + (f" {self.unit}" if self.unit else "")


def parameter(
    usual: Any = MISSING,
    *,
    low: float = -np.inf,
    high: float = np.inf,
    unit: str | None = None,
    words: Iterable[str] = (),
) -> Any:
    """A dataclass field of a law: a number with range and unit, or one of several words.

    Parameters
    ----------
    usual : float or str, optional
        The default; without it the field is required.
    low, high, unit, words : as in `Parameter`

    Returns
    -------
    dataclasses.Field
        Typed as Any, since its value is assigned to a field annotated ``float``, ``str`` or
        `NumberField`.
    """
    kept = Parameter(low, high, unit, tuple(words), usual is MISSING)
    return field(default=usual, metadata={"parameter": kept})


def phase_angles(alpha: Reals) -> FloatArray:
    """Phase angles (...) in rad; AttitudeError beyond 0 to pi."""
    angles = validation.real(alpha, "alpha", unit="rad")
    if np.any((angles < 0.0) | (angles > np.pi)):
        raise AttitudeError("alpha must lie from 0 to pi rad.")
    return angles


# ---- Arrays of reflectances of laws that are evaluated facet by facet, compiled for each law

# Upper bound of the number of terms that a law computes from a phase angle.
TERMS = 8
_ONES = (1.0,) * 8


@cache
def reflectances(of_phase: Compilable, element: Compilable, in_lanes: bool = False) -> EntryPoint:
    """The loop over elements with one row of numbers, for the functions of a law; see `Law`.

    Of row (W,), mu0, mu, half the phase angle (rad) and the output, (N,) each.
    """

    @reduction_over(of_phase, element)
    def evaluated(row, mu0, mu, half, out):
        """r in 1/sr, from half the phase angle; 0 where mu0 or mu is not positive."""
        phase_terms = np.empty(TERMS)
        for i in range(out.size):
            out[i] = 0.0
            if mu0[i] > 0.0 and mu[i] > 0.0:
                of_phase(row, math.cos(half[i]), math.sin(half[i]), phase_terms)
                if in_lanes:  # numba compiles one of the branches
                    # Each element has another phase angle: it fills all lanes.
                    p, q = lanes(_ONES) * mu0[i], lanes(_ONES) * mu[i]
                    out[i] = mu0[i] * largest_lane(element(row, phase_terms, p, q))
                else:
                    out[i] = mu0[i] * fence(element(row, phase_terms, mu0[i], mu[i]))

    return evaluated


_by_name: dict[str, type[Law]] = {}


@dataclass(frozen=True, eq=False)
class Law:
    """How a surface element returns sunlight; the base class of all laws.

    What a new law defines
    ----------------------
    A law is a frozen dataclass that derives from `Law`, in a file of its own.  It has

    ``name``
        The name of the law in `scattering.law`, Scene and mission files.  Defining the class
        registers the name.  A law with name None is not registered.
    fields
        Each annotated `NumberField` or ``str`` and defined by `parameter`, with the range and the
        unit of a number, or the words that are allowed.  The constructor and mission files check
        and convert their input by these.

    and one of the following two.

    ``weights``, and ``phase`` if r depends on the phase angle
        For r = f(alpha) mu0 [a / (mu0 + mu) + b]: the pair (a, b) in 1/sr as a property, and f as
        ``phase(alpha)``, 1 by default.  ``has_ellipsoid_form = True`` states that b is always 0:
        the brightness of an ellipsoid then has a closed form.
    ``of_phase`` and ``element``, and ``rows`` if facets differ
        For any other r, evaluated facet by facet: two functions under
        `reduction_subroutine`.  ``element(row, phase_terms, mu0, mu)``
        returns r / mu0 in 1/sr for positive mu0 and mu.  ``of_phase(row, cos_half, sin_half,
        phase_terms)`` writes the terms that depend on the phase angle alone, at most
        `TERMS` numbers.  Its arguments are cosine and sine of half the angle, since
        the cosine of the whole angle loses half of its digits near opposition.  ``row`` holds the
        fields in their order, or is one of several ``rows``.  The loops over facets are compiled
        for each pair.
    ``elements`` in place of ``element``
        The same for SIMD vectors mu0 and mu, under `decorators.reduction_within` and written with
        the operators and functions of `simd` and `elementary`: five to ten
        times as fast.  Cosines may exceed 1 by rounding.

    r / mu0 is symmetric in mu0 and mu (Helmholtz reciprocity).
    """

    name: ClassVar[str | None] = None
    has_ellipsoid_form: ClassVar[bool] = False
    of_phase: ClassVar[Compilable | None] = None
    element: ClassVar[Compilable | None] = None
    elements: ClassVar[Compilable | None] = None

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        forms = [isinstance(function, Compilable) for function in (cls.element, cls.elements)]
        is_compiled = isinstance(cls.of_phase, Compilable) and sum(forms) == 1
        if cls._has_weights() == is_compiled:
            raise AttitudeError(
                f"the law {cls.__name__} must define either weights, or of_phase and element under "
                "attitude._compilation.decorators.reduction_subroutine; see "
                "attitude.scattering.Law."
            )
        if cls.__dict__.get("name") is not None:
            _register(cls)

    def __post_init__(self) -> None:
        for name, parameter in self.parameters().items():
            object.__setattr__(self, name, parameter.accepted(getattr(self, name), name))

    @property
    def by_material(self) -> Mapping[str, Law]:
        """The law of each group of facets, by its name; empty where one law is that of all."""
        return {}

    def values(self) -> dict[str, Any]:
        """The parameters of the law: a dict of numbers and words, by the names of `parameters`."""
        return {name: getattr(self, name) for name in self.parameters()}

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Ranges, units and words of the fields: a dict of `Parameter`, in order.

        Raises
        ------
        AttitudeError
            For a field that `parameter` did not define.
        """
        definitions = {}
        for slot in fields(cls):
            if "parameter" not in slot.metadata:
                raise AttitudeError(
                    f"the field {slot.name} of the law {cls.__name__} has neither range nor words; "
                    "define it by attitude.scattering.parameter(...)."
                )
            definitions[slot.name] = slot.metadata["parameter"]
        return definitions

    @classmethod
    def required(cls) -> list[str]:
        """Names of the fields without a default."""
        return [name for name, parameter in cls.parameters().items() if parameter.is_required]

    @classmethod
    def _has_weights(cls) -> bool:
        return cls.weights is not None and cls.weights is not Law.weights

    @property
    def weights(self) -> tuple[float, float] | None:
        """(a, b) in 1/sr of r = f(alpha) mu0 [a / (mu0 + mu) + b]; None if r has another form."""
        return None

    @property
    def has_phase(self) -> bool:
        """Whether the law defines `phase`."""
        return type(self).phase is not Law.phase

    def phase(self, alpha: ArrayLike) -> FloatArray:
        """The factor f(alpha) of a law with `weights`, for alpha (...) in rad; 1 by default."""
        return np.ones_like(validation.real(alpha, "alpha", unit="rad"))

    def of_material(self, name: str) -> Material | None:
        """The `Material` of facets of a name; None if the law has no lobe."""
        return None

    def row(self) -> FloatArray:
        """The fields in order as the compiled functions read them, (W,).

        A word is represented by its index among the words allowed.
        """
        values = zip(self.parameters().values(), self.values().values(), strict=True)
        row = [param.words.index(value) if param.words else value for param, value in values]
        return np.array(row, dtype=np.float64)

    def rows(self, materials: Sequence[str]) -> tuple[FloatArray, IntArray]:
        """Rows of numbers (M, W), and the index (F,) of the row of each facet.

        ``materials`` are the names of the facets.  All facets share one row unless a law overrides
        this method.
        """
        return self.row()[None], np.zeros(len(materials), dtype=np.int64)

    def reflectance(self, mu0: Reals, mu: Reals, alpha: Reals) -> FloatArray:
        """r in 1/sr, for cosines of incidence and emission and the phase angle (rad).

        Arguments broadcast.  r is 0 where mu0 or mu is not positive: the element is dark or turned
        away.

        Raises
        ------
        AttitudeError
            For cosines beyond -1 to 1, phase angles beyond 0 to pi, or shapes that do not
            broadcast.
        """
        # Each range is checked; whether the three angles belong to one geometry is not.
        cosines = {"mu0": validation.real(mu0, "mu0"), "mu": validation.real(mu, "mu")}
        for name, array in cosines.items():
            if np.any(np.abs(array) > 1.0 + 1e-9):
                largest = np.max(np.abs(array))
                raise AttitudeError(f"{name} holds {largest}; cosines lie from -1 to 1.")
        mu0, mu, alpha = validation.together(**cosines, alpha=phase_angles(alpha))
        weights = self.weights
        if weights is None:
            function = self.element or self.elements
            assert self.of_phase is not None and function is not None
            evaluated = reflectances(self.of_phase, function, self.element is None)
            out = np.empty(mu0.shape)
            flat = [np.ascontiguousarray(array).reshape(-1) for array in (mu0, mu, 0.5 * alpha)]
            evaluated(self.row(), *flat, out.reshape(-1))
            return out
        shown = (mu0 > 0.0) & (mu > 0.0)
        both = np.where(shown, mu0 + mu, 1.0)
        a, b = weights
        value = self.phase(alpha) * (a * (mu0 / both) + b * mu0)
        return np.where(shown, value, 0.0)


def law(given: str | Law) -> Law:
    """The law itself, or the law of a name with its default parameters.

    Raises
    ------
    AttitudeError
        For an unknown name, the name of a law with a field that has no default, or anything else.

    Examples
    --------
    >>> law("lommel-seeliger")
    LommelSeeliger(albedo=1.0)
    """
    if isinstance(given, Law):
        return given
    if isinstance(given, type) and issubclass(given, Law):
        raise AttitudeError(
            f"law is the class {given.__name__}; give an instance: {given.__name__}(...)."
        )
    kind = _by_name.get(given) if isinstance(given, str) else None
    if kind is not None and kind.required():
        raise AttitudeError(
            f"law is {given!r}, which has no default for {' and '.join(kind.required())}; give "
            f"{kind.__module__.partition('._')[0]}.{kind.__qualname__}(...)."
        )
    if kind is None:
        names = ", ".join(repr(name) for name, entry in laws().items() if not entry.required())
        raise AttitudeError(
            f"law is {validation.shown(given)}; give one of {names}, or a law with parameters such "
            "as attitude.scattering.Hapke(...) or Materials(...)."
        )
    return kind()


def laws() -> dict[str, type[Law]]:
    """The classes of all registered laws, a dict by name: first the laws with `weights`."""
    return dict(sorted(_by_name.items(), key=lambda item: (not item[1]._has_weights(), item[0])))


def forget(name: str) -> None:
    """Remove a name from the registry, as at the end of a test that defines a law.

    Raises
    ------
    AttitudeError
        For a name that is not registered.
    """
    if name not in _by_name:
        raise AttitudeError(f"no law is called {name!r}; known are {', '.join(laws())}.")
    del _by_name[name]


def _register(cls: type[Law]) -> None:
    """Register a class; a class defined again, as in a notebook, replaces its former definition."""
    name = str(cls.name)
    other = _by_name.get(name, cls)
    if (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
        raise AttitudeError(
            f"the law {cls.__module__}.{cls.__qualname__} is called {name!r}, as is "
            f"{other.__module__}.{other.__qualname__}; give it another name."
        )
    _by_name[name] = cls
