"""Published spin states of tumbling bodies, each number with its source.

>>> from attitude import FreeRotation, catalog
>>> catalog.names()[:2]
('4179 Toutatis', '99942 Apophis (2014)')
>>> body, spin = catalog.load("4179 Toutatis")
>>> round(FreeRotation(body, spin).period_psi / 86400.0, 4)      # days
5.3685

Values that an entry does not have are given as keywords:

>>> catalog.entry("99942 Apophis (2014)").missing
('phi0', 'psi0', 'epoch')
>>> body, spin = catalog.load("99942 Apophis (2014)", phi0=0.0, psi0=0.0, epoch="2012-12-23")
>>> spin.frame
'ecliptic'
"""

from __future__ import annotations

import difflib
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from attitude._support import markup, validation
from attitude._support.constants import DAY_S
from attitude._support.quantity_text import quoted
from attitude._support.synonyms import Answering, arguments, of_module
from attitude._textfiles import toml
from attitude._textfiles.lines import packaged, path_of_packaged
from attitude.errors import AttitudeError
from attitude.motions import _motion as motions
from attitude.motions._body import Body
from attitude.motions._free_rotation import FreeRotation
from attitude.motions._published import moments_from_ratios
from attitude.motions._spin import Spin

if TYPE_CHECKING:
    from collections.abc import Mapping

    from attitude._support.annotations import Reals
    from attitude.motions._motion import HasAttitudes, Motion

__all__ = ["Entry", "entry", "has", "load", "motion_of", "names"]


# ---- One published number with its unit, error and source

# SI units and radians in the units of the catalogue, as astropy converts them.
_DEGREE = np.pi / 180.0
_SI = {None: 1.0, "s": 1.0, "kg": 1.0, "kg m2": 1.0, "h": 3600.0, "day": DAY_S}
_SI |= {"deg": _DEGREE, "deg/day": _DEGREE / DAY_S}


@dataclass(frozen=True)
class Value:
    """One published number.

    Attributes
    ----------
    name : str
    value : float, list or str
        In `unit`.
    unit : str or None
        As astropy spells it; None for text and pure numbers.
    error : float or list or None
        As printed, in `unit`; [minus, plus] where they differ.
    source : str
        Publication.
    """

    name: str
    value: Any
    unit: str | None
    error: Any
    source: str

    @property
    def si(self) -> Any:
        """The value as a float or array in SI units and radians; text as it is."""
        if isinstance(self.value, str):
            return self.value
        return validation.real(self.value, self.name)[()] * _SI[self.unit]

    def __str__(self) -> str:
        error = f" ({self.spelled_error})" if self.spelled_error else ""
        unit = "" if self.unit is None else f" {self.unit}"
        return f"{self.name}: {self.spelled}{error}{unit} [{self.source}]"

    @property
    def spelled(self) -> str:
        """The value as text."""
        return self.value if isinstance(self.value, str) else _spelled(self.value)

    @property
    def spelled_error(self) -> str:
        """The error as text, "" if there is none."""
        if self.error is None:
            return ""
        both = isinstance(self.error, list)
        return f"-{self.error[0]} +{self.error[1]}" if both else f"+-{self.error}"


def _spelled(value: Any) -> str:
    if isinstance(value, list):
        return "(" + ", ".join(_spelled(component) for component in value) + ")"
    return repr(value)


# ---- Which body a name means: the whole name, its number, or the beginning of a word of it
# A number means a body only as its whole number, and a year none: "41" is not 4179 Toutatis, and
# "2008" not 2008 TC3, so that no body gets the numbers of another.

Item = TypeVar("Item")

# Letters of the beginning of a word by which a body is found.
_BEGUN = 3


def matching(name: str, items: Mapping[str, Item]) -> list[Item]:
    """The items that a name means.

    >>> matching("touta", {"4179 Toutatis": 1, "2008 TC3": 2})
    [1]
    >>> matching("41", {"4179 Toutatis": 1, "2008 TC3": 2})
    []
    """
    key = _words(name)
    exact = [item for label, item in items.items() if _words(label) == key]
    if exact or not key:
        return exact
    return [item for label, item in items.items() if _means(key, _words(label.partition(" (")[0]))]


def _means(key: list[str], words: list[str]) -> bool:
    """Whether words occur in a name, in order, the last of them at least begun."""
    is_designation = len(words) > 1 and re.fullmatch(r"\d{4}", words[0]) and len(words[1]) < 6
    if is_designation and re.fullmatch(r"[a-z]{2}\d*", words[1]) and key == words[:1]:
        return False
    for start in range(len(words) - len(key) + 1):
        run = words[start : start + len(key)]
        begun = len(key[-1]) >= _BEGUN and key[-1].isalpha() and run[-1].startswith(key[-1])
        if run[:-1] == key[:-1] and (run[-1] == key[-1] or begun):
            return True
    return False


def _words(name: str) -> list[str]:
    """The words of a name in lower case, without brackets, apostrophes and slashes."""
    return re.sub(r"[()'/\u2018\u2019]", " ", name.lower()).split()


# The forms of a state, and the values that each requires.
_NEEDED = {
    "angles": ("moments", "angles", "angular_velocity", "epoch"),
    "rates": ("moments", "wxyz", "angular_velocity", "epoch"),
    "periods": ("moments", "mode", "convention", "P_psi", "P_phi", "pole", "phi0", "psi0", "epoch"),
}
_KEYWORDS = (*_NEEDED["periods"], "theta_branch", "wxyz", "angular_velocity", "frame")


class Loaded(NamedTuple):
    """Result of ``load``: ``body, spin = catalog.load(name)``."""

    body: Body
    spin: Spin


@dataclass(frozen=True)
class Entry(Answering):
    """One published spin state.

    Attributes
    ----------
    name : str
        Of the body, with the year of publication if there are several entries.
    year : int
        Of publication.
    frame : str
        Of the pole, angles or attitude: "icrf" or "ecliptic".
    mode, convention : str or None
        "LAM" or "SAM"; "L" or "S"; None if they are not published.
    given : dict of str to Value
        The values from which body and spin are made.
    printed : dict of str to Value
        Further values of the paper, for comparison.
    note : str
    scene : str or None
        A mission file of the package with the Sun, the observer and a shape of a real date.
    """

    name: str
    year: int
    frame: str
    mode: str | None
    convention: str | None
    given: dict[str, Value]
    printed: dict[str, Value]
    note: str
    scene: str | None = None

    @property
    def missing(self) -> tuple[str, ...]:
        """The keywords that `load` requires, in order; () for a complete entry."""
        return tuple(name for name in _NEEDED[self._kind({})] if not self._has(name))

    @property
    def sources(self) -> tuple[str, ...]:
        """The publications of all values, each once."""
        return tuple(dict.fromkeys(quantity.source for quantity in self._values()))

    def body(self, *, moments: Reals | None = None) -> Body:
        """The Body; relative if only ratios of the moments are known; moments (3,)."""
        if moments is not None:
            relative = not hasattr(moments, "unit")
            return Body(moments=moments, relative=relative)
        if "tensor" in self.given:
            return Body(tensor=self.given["tensor"].si, mass=self.given["mass"].si)
        if "moments" in self.given:
            value = self.given["moments"]
            return Body(moments=value.si, relative=value.unit is None)
        if "A_over_C" in self.given:
            ratios = moments_from_ratios(self.given["A_over_C"].si, self.given["B_over_C"].si)
            return Body(moments=ratios, relative=True)
        raise AttitudeError(
            f"the catalogue has no moments of {self.name}; give moments=(3 numbers) about the body "
            "axes, of any unit."
        )

    def load(self, **keywords: Any) -> Loaded:
        """Body and spin; keywords supply values that are missing, or replace published ones.

        An epoch without phi0, psi0 or wxyz is one to which the published state is propagated.
        """
        unknown = [name for name in keywords if name not in _KEYWORDS]
        if unknown:
            are = "is not a keyword" if len(unknown) == 1 else "are not keywords"
            raise AttitudeError(
                f"{', '.join(unknown)} {are} of load; give any of {', '.join(_KEYWORDS)}."
            )
        keywords = {name: value for name, value in keywords.items() if value is not None}
        if self.is_propagated(keywords):
            to = keywords.pop("epoch")
            body, spin = self.load(**keywords)
            return Loaded(body, FreeRotation(body, spin).spin_at(to))
        kind = self._kind(keywords)
        missing = [name for name in _NEEDED[kind] if name not in keywords and not self._has(name)]
        if missing:
            raise AttitudeError(self._request(missing, keywords))
        body = self.body(moments=keywords.get("moments"))
        frame = keywords.get("frame", self.frame)
        if kind == "rates":
            return Loaded(body, self._from_rates(body, keywords, frame))
        state = {name: self._value(name, keywords) for name in _NEEDED[kind] if name != "moments"}
        if kind == "angles":
            state["convention"] = self.convention
            return Loaded(body, Spin.from_angles(body, **state, frame=frame))
        branch = keywords.get("theta_branch")
        return Loaded(body, Spin.from_periods(body, **state, theta_branch=branch, frame=frame))

    def motion(self, **keywords: Any) -> FreeRotation:
        """The ``FreeRotation`` of the body and spin of `load`, with the same keywords."""
        return FreeRotation(*self.load(**keywords))

    def __str__(self) -> str:
        lines = [self.name]
        if self.mode or self.convention:
            lines.append(
                f"  {self.mode or 'mode open'}, convention {self.convention}, {self.frame}"
            )
        lines += [f"  {quantity}" for quantity in self._values()]
        if self.note:
            lines.append(f"  {self.note}")
        if self.missing:
            lines.append(f"  not in the catalogue: {', '.join(self.missing)}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return markup.table(*markup.rows_of(str(self)))

    def _request(self, missing: list[str], keywords: Mapping[str, Any]) -> str:
        """The error text for missing values, or for those that are no part of a whole state."""
        if not self.missing:
            surplus = [name for name in keywords if name not in ("moments", "epoch", "frame")]
            return (
                f"the catalogue has a whole state of {self.name}; leave out {', '.join(surplus)}, "
                f"or give {', '.join(missing)} too."
            )
        them = "it as a keyword" if len(missing) == 1 else "them as keywords"
        open_mode = f" {self.note}" if "mode" in missing and self.note else ""
        return (
            f"the catalogue has no {', '.join(missing)} of {self.name}; give "
            f"{them} of catalog.load, or on the command "
            f"line {' '.join('--' + keyword.replace('_', '-') for keyword in missing)}.{open_mode}"
        )

    def _kind(self, keywords: Mapping[str, Any]) -> str:
        """The form of the state: that of the caller's keywords, else that of the publication."""
        if "wxyz" in keywords or "angular_velocity" in keywords:
            return "rates"
        if set(keywords) & {*_NEEDED["periods"], "theta_branch"} - {"moments", "epoch"}:
            return "periods"
        if "angles" in self.given:
            return "angles"
        return "periods" if "P_phi" in self.given else "rates"

    def is_propagated(self, keywords: Mapping[str, Any]) -> bool:
        """Whether `load` brings the published state to an epoch among keywords, by free rotation.

        Otherwise the epoch is that of a state which the keywords complete or replace.
        """
        has_own = "epoch" in self.given and not {"phi0", "psi0", "wxyz"} & set(keywords)
        return has_own and keywords.get("epoch") is not None

    def _has(self, name: str) -> bool:
        """Whether the entry has a value under a keyword of `load`."""
        if name in ("mode", "convention"):
            return getattr(self, name) is not None
        if name == "moments":
            return bool({"moments", "A_over_C", "tensor"} & set(self.given))
        if name == "angular_velocity":
            return bool({"angular_velocity", "principal_rates"} & set(self.given))
        return name in self.given

    def _value(self, name: str, keywords: Mapping[str, Any]) -> Any:
        """The value under a keyword of `load`: that of the caller, or the published one in SI."""
        if name in keywords:
            return keywords[name]
        return getattr(self, name) if name in ("mode", "convention") else self.given[name].si

    def _from_rates(self, body: Body, keywords: Mapping[str, Any], frame: str) -> Spin:
        if "angular_velocity" in {*keywords, *self.given}:
            rate = self._value("angular_velocity", keywords)
        else:
            about = self.given["principal_rates"].si
            rate = 2.0 * np.pi / self.printed["spin_period"].si * (body.principal_axes @ about)
        return Spin(self._value("epoch", keywords), self._value("wxyz", keywords), rate, frame)

    def _values(self) -> tuple[Value, ...]:
        return (*self.given.values(), *self.printed.values())


def names() -> tuple[str, ...]:
    """The names of all entries."""
    return tuple(_entries())


@arguments({}, 'entry("toutatis")')
def entry(name: str) -> Entry:
    """The `Entry` of a name, of its number, or of the beginning of a word of it, in any case.

    Of several entries of the body the newest.  Numbers are whole: "41" means no body.

    >>> entry("apophis").name
    '99942 Apophis (2022)'

    Raises
    ------
    AttitudeError
        For a name that no body has, or several bodies have.
    """
    if not isinstance(name, str) or not name.strip():
        raise AttitudeError(f"name is {quoted(name)}; give one of {', '.join(names())}.")
    matches = matching(name, _entries())
    bodies = {candidate.name.partition(" (")[0] for candidate in matches}
    if len(bodies) == 1:
        return max(matches, key=lambda match: match.year)
    if bodies:
        raise AttitudeError(
            f"{quoted(name)} belongs to {', '.join(sorted(bodies))}; give one of them."
        )
    entries = _entries()
    similar = difflib.get_close_matches(name, entries, n=1)
    other = f"did you mean {similar[0]!r}?" if similar else f"it has {', '.join(entries)}."
    raise AttitudeError(f"the catalogue has no {quoted(name)}; {other}")


def has(name: str) -> bool:
    """Whether `entry` finds one body by a name."""
    if not isinstance(name, str):
        raise AttitudeError(f"name is {quoted(name)}; give the name of a body as text.")
    matches = matching(name, _entries())
    return len({candidate.name.partition(" (")[0] for candidate in matches}) == 1


def load(name: str, **keywords: Any) -> Loaded:
    """Body and spin of a published state: ``body, spin = load(name)``."""
    return entry(name).load(**keywords)


def motion_of(given: HasAttitudes | str, name: str = "motion") -> Motion:
    """The motion itself, or that of a complete entry of the catalogue by its name."""
    if isinstance(given, str):
        return entry(given).motion()
    return motions.motion_of(given, name)


@cache
def _entries() -> dict[str, Entry]:
    """The entries of the package's file of spin states, by name."""
    name = "data/spin_states.toml"
    tables = toml.parsed(packaged(name), name)
    sources = tables.pop("sources")
    return {name: _entry(name, table, sources) for name, table in tables.items()}


def _entry(name: str, table: Mapping[str, Any], sources: Mapping[str, str]) -> Entry:
    """One entry from its TOML table."""
    absent: dict[str, Any] = {"unit": None, "error": None}

    def values(rows: list[dict[str, Any]]) -> dict[str, Value]:
        return {
            row["name"]: Value(**{**absent, **row, "source": sources[row["source"]]})
            for row in rows
        }

    return Entry(
        name=name,
        year=table["year"],
        frame=table["frame"],
        mode=table.get("mode"),
        convention=table.get("convention"),
        given=values(table.get("given", [])),
        printed=values(table.get("printed", [])),
        note=table.get("note", ""),
        scene=path_of_packaged(f"data/scenes/{table['scene']}") if "scene" in table else None,
    )


if not TYPE_CHECKING:
    # Hidden from type checkers: a module with __getattr__ has every name, misspelt ones too.
    __getattr__ = of_module(__name__)
