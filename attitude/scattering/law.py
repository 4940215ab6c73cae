"""What a scattering law is, and the laws by their names."""

from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np

from attitude import validation
from attitude.compilation.decorators import Compilable
from attitude.errors import AttitudeError
from attitude.scattering.parameters import geometry
from attitude.scattering.reflectances import reflectances

_by_name = {}


@dataclass(frozen=True, eq=False)
class Law:
    """How a surface element returns sunlight; the base of all laws.

    What a new kind of law defines
    ------------------------------
    A law is a frozen dataclass that derives from `Law`, in a file of its own.  It has

    ``name``
        The word that stands for it in `scattering.law`, in a Scene and in mission files.  Defining
        the class registers the name.  None leaves the law unnamed.
    fields
        Each made by `parameter`, with the range and the unit of a number, or the words that are
        allowed.  Constructor and mission files check and convert by these what is given.

    and one of the following two.

    ``weights``, perhaps with ``phase``
        For r = f(alpha) mu0 [a / (mu0 + mu) + b]: the pair (a, b) in 1/sr as a property, and f as
        ``phase(alpha)``, 1 unless defined.  ``has_ellipsoid_form = True`` says that b is always 0:
        the brightness of an ellipsoid is then a closed form.
    ``of_phase`` and ``element``, perhaps with ``rows``
        For any other r, evaluated facet by facet: two functions under
        `compilation.decorators.reduction_subroutine`.  ``element(row, now, mu0, mu)`` returns
        r / mu0 in 1/sr for positive mu0 and mu.  ``of_phase(row, cos_half, sin_half, now)`` writes
        what depends on the phase angle alone into ``now``, at most `reflectances.TERMS` numbers.
        It gets cosine and sine of half the angle, since a cosine of the whole would lose half of
        its digits near opposition.  ``row`` holds the fields in their order; a law under which
        facets differ defines ``rows``.  The loops over facets are compiled for each pair.

    r / mu0 is symmetric in mu0 and mu (Helmholtz reciprocity).
    """

    name: ClassVar[str | None] = None
    has_ellipsoid_form: ClassVar[bool] = False
    weights = None
    of_phase = None
    element = None

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        compiled = [isinstance(each, Compilable) for each in (cls.of_phase, cls.element)]
        if (cls.weights is None) != all(compiled):
            raise AttitudeError(
                f"the law {cls.__name__} must define either weights, or of_phase and element under "
                "attitude.compilation.decorators.reduction_subroutine; see attitude.scattering.Law."
            )
        if cls.__dict__.get("name") is not None:
            _register(cls)

    def __post_init__(self):
        for name, parameter in self.parameters().items():
            object.__setattr__(self, name, parameter.accepted(getattr(self, name), name))

    @classmethod
    def parameters(cls):
        """What each field takes: a dict of `parameters.Parameter` by name, in order."""
        found = {}
        for each in fields(cls):
            if "parameter" not in each.metadata:
                raise AttitudeError(
                    f"the field {each.name} of the law {cls.__name__} has neither range nor words; "
                    "make it by attitude.scattering.parameter(...)."
                )
            found[each.name] = each.metadata["parameter"]
        return found

    @classmethod
    def required(cls):
        """Names of the fields that have no usual value."""
        return [name for name, each in cls.parameters().items() if each.is_required]

    @property
    def has_phase(self):
        """Whether `phase` is other than 1."""
        return type(self).phase is not Law.phase

    def phase(self, alpha):
        """The factor f(alpha) of a law with weights, for alpha in rad; 1 unless it is defined."""
        return np.ones_like(validation.real(alpha, "alpha", unit="rad"))

    def row(self):
        """The numbers that the compiled functions are given, (W,): the fields in order.

        A word is the number of its place among those allowed.
        """
        found = [each.as_number(getattr(self, name)) for name, each in self.parameters().items()]
        return np.array(found, dtype=np.float64)

    def rows(self, materials):
        """(M, W) rows of numbers, and (F,) which of them each facet has.

        ``materials`` are the names that the facets carry; one row serves all unless a law says
        otherwise.
        """
        return self.row()[None], np.zeros(len(materials), dtype=np.int64)

    def reflectance(self, mu0, mu, alpha):
        """r in 1/sr for cosines of incidence and emission and the phase angle (rad).

        Zero where mu0 or mu is not positive: the element is dark or turned away.
        """
        mu0, mu, alpha = geometry(mu0, mu, alpha)
        if self.weights is None:
            out = np.empty(mu0.shape)
            flat = [np.ascontiguousarray(each).reshape(-1) for each in (mu0, mu, 0.5 * alpha)]
            reflectances(self.of_phase, self.element)(self.row(), *flat, out.reshape(-1))
            return out
        shown = (mu0 > 0.0) & (mu > 0.0)
        together = np.where(shown, mu0 + mu, 1.0)
        a, b = self.weights
        value = self.phase(alpha) * (a * (mu0 / together) + b * mu0)
        return np.where(shown, value, 0.0)


def law(given):
    """The law itself, or the one with usual parameters that a name stands for.

    Examples
    --------
    >>> law("lommel-seeliger")
    LommelSeeliger(albedo=1.0)
    """
    if isinstance(given, Law):
        return given
    if isinstance(given, type) and issubclass(given, Law):
        raise AttitudeError(
            f"law is the class {given.__name__}; give one of its values: {given.__name__}(...)."
        )
    made = _by_name.get(given) if isinstance(given, str) else None
    if made is not None and made.required():
        raise AttitudeError(
            f"law is {given!r}, which has no usual {' and '.join(made.required())}; give "
            f"{made.__module__}.{made.__qualname__}(...)."
        )
    if made is None:
        names = ", ".join(repr(name) for name, each in laws().items() if not each.required())
        raise AttitudeError(
            f"law is {validation.shown(given)}; give one of {names}, or a law with parameters such "
            "as attitude.scattering.Hapke(...) or Materials(...)."
        )
    return made()


def laws():
    """The classes of all laws that have a name: a dict by name, those with weights first."""
    return dict(sorted(_by_name.items(), key=lambda each: (each[1].weights is None, each[0])))


def forget(name):
    """Take a name out of `laws`, as at the end of a test that defines a law."""
    if name not in _by_name:
        raise AttitudeError(f"no law is called {name!r}; known are {', '.join(laws())}.")
    del _by_name[name]


def _register(made):
    """Enter a class; one that is defined anew, as in a notebook, takes the place of its former."""
    other = _by_name.get(made.name, made)
    if (other.__module__, other.__qualname__) != (made.__module__, made.__qualname__):
        raise AttitudeError(
            f"the law {made.__module__}.{made.__qualname__} is called {made.name!r}, as is "
            f"{other.__module__}.{other.__qualname__}; give it another name."
        )
    _by_name[made.name] = made
