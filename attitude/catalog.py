"""Published spin states of tumbling bodies, each number with its source.

>>> from attitude import FreeRotation, catalog
>>> catalog.names()[:2]
('4179 Toutatis', '99942 Apophis (2014)')
>>> body, spin = catalog.load("4179 Toutatis")
>>> round(FreeRotation(body, spin).period_psi / 86400.0, 4)      # days
5.3685

What the entry does not hold is asked for:

>>> catalog.entry("99942 Apophis (2014)").missing
('phi0', 'psi0', 'epoch')
>>> body, spin = catalog.load("99942 Apophis (2014)", phi0=0.0, psi0=0.0, epoch="2012-12-23")
>>> spin.frame
'ecliptic'
"""

import difflib
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from attitude import validation
from attitude.body import Body
from attitude.errors import AttitudeError
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.published.dynamic_inertia import moments_from_ratios
from attitude.spin import Spin
from attitude.textfiles import toml
from attitude.textfiles.lines import packaged

# The ways to give a state, and what each needs.
_NEEDED = {
    "angles": ("moments", "angles", "angular_velocity", "epoch"),
    "rates": ("moments", "wxyz", "angular_velocity", "epoch"),
    "periods": ("moments", "mode", "convention", "P_psi", "P_phi", "pole", "phi0", "psi0", "epoch"),
}
_KEYWORDS = (*_NEEDED["periods"], "theta_branch", "wxyz", "angular_velocity", "frame")


class Loaded(NamedTuple):
    """What ``load`` gives: ``body, spin = catalog.load(name)``."""

    body: Body
    spin: Spin


@dataclass(frozen=True)
class Value:
    """One published number.

    Attributes
    ----------
    name : str
    value : float, list or str
        In `unit`.
    unit : str or None
    error : float or list or None
        As printed; [minus, plus] where they differ.
    source : str
    """

    name: str
    value: object
    unit: str
    error: object
    source: str

    @property
    def si(self):
        """The value as a float or array in SI units and radians; text as it is."""
        if isinstance(self.value, str):
            return self.value
        unit = {"deg": "rad", "h": "s", "day": "s", "deg/day": "rad/s"}.get(self.unit, self.unit)
        if self.unit is None or unit == self.unit:
            return validation.real(self.value, self.name)[()]
        from astropy import units

        return validation.real(np.array(self.value) * units.Unit(self.unit), self.name, unit=unit)[
            ()
        ]

    def __str__(self):
        value = self.value if isinstance(self.value, str) else _spelled(self.value)
        error = "" if self.error is None else f" ({_error(self.error)})"
        unit = "" if self.unit is None else f" {self.unit}"
        return f"{self.name}: {value}{error}{unit} [{self.source}]"


@dataclass(frozen=True)
class Entry:
    """One published spin state.

    Attributes
    ----------
    name, frame : str
    mode, convention : str or None
    year : int
    given : dict of str to Value
        What body and spin are made from.
    printed : dict of str to Value
        What else the paper prints, to compare with.
    note : str
    """

    name: str
    year: int
    frame: str
    mode: str
    convention: str
    given: dict
    printed: dict
    note: str

    @property
    def missing(self):
        """The keywords that `load` asks for, in order; () where nothing is wanting."""
        return tuple(name for name in _NEEDED[self._kind({})] if not self._has(name))

    @property
    def sources(self):
        """Every source, once."""
        return tuple(dict.fromkeys(each.source for each in self._values()))

    def body(self, *, moments=None):
        """The Body; relative where only ratios are known.

        Parameters
        ----------
        moments : (3,) array_like, optional
            About the body axes, instead of the published ones; relative unless a Quantity.
        """
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
            "axes, ratios will do."
        )

    def load(self, **given):
        """Body and spin; keywords give what was not published, or replace what was.

        Parameters
        ----------
        moments, mode, convention, P_psi, P_phi, pole, phi0, psi0, epoch, theta_branch, frame
            As in `Body` and `Spin.from_periods`.
        wxyz, angular_velocity, epoch, frame
            As in `Spin`; instead of the published state.

        Raises
        ------
        AttitudeError
            Naming what is missing, or no keyword.
        """
        unknown = [name for name in given if name not in _KEYWORDS]
        if unknown:
            raise AttitudeError(
                f"{', '.join(unknown)} is not known here; give any of {', '.join(_KEYWORDS)}."
            )
        given = {name: value for name, value in given.items() if value is not None}
        kind = self._kind(given)
        missing = [name for name in _NEEDED[kind] if name not in given and not self._has(name)]
        if missing:
            raise AttitudeError(self._request(missing))
        body = self.body(moments=given.get("moments"))
        frame = given.get("frame", self.frame)
        if kind == "rates":
            return Loaded(body, self._from_rates(body, given, frame))
        state = {
            name: given[name] if name in given else self._published(name)
            for name in _NEEDED[kind]
            if name != "moments"
        }
        if kind == "angles":
            state["convention"] = self.convention
            return Loaded(body, Spin.from_angles(body, **state, frame=frame))
        branch = given.get("theta_branch")
        return Loaded(body, Spin.from_periods(body, **state, theta_branch=branch, frame=frame))

    def motion(self, **given):
        """``FreeRotation`` of `load`."""
        return FreeRotation(*self.load(**given))

    def __str__(self):
        lines = [self.name]
        if self.mode or self.convention:
            lines.append(
                f"  {self.mode or 'mode open'}, convention {self.convention}, {self.frame}"
            )
        lines += [f"  {each}" for each in self._values()]
        if self.note:
            lines.append(f"  {self.note}")
        if self.missing:
            lines.append(f"  not in the catalogue: {', '.join(self.missing)}")
        return "\n".join(lines)

    def _request(self, missing):
        """The sentence that asks for what is missing."""
        them = "it as a keyword" if len(missing) == 1 else "them as keywords"
        open_mode = f" {self.note}" if "mode" in missing and self.note else ""
        return (
            f"the catalogue has no {', '.join(missing)} of {self.name}; give "
            f"{them} of catalog.load, or on the command "
            f"line {' '.join('--' + each.replace('_', '-') for each in missing)}.{open_mode}"
        )

    def _kind(self, given):
        """How the state is given: by what the caller says, else as it was published."""
        if "wxyz" in given or "angular_velocity" in given:
            return "rates"
        if set(given) & {*_NEEDED["periods"], "theta_branch"} - {"moments", "epoch"}:
            return "periods"
        if "angles" in self.given:
            return "angles"
        return "periods" if "P_phi" in self.given else "rates"

    def _has(self, name):
        if name in ("mode", "convention"):
            return getattr(self, name) is not None
        if name == "moments":
            return bool({"moments", "A_over_C", "tensor"} & set(self.given))
        if name == "angular_velocity":
            return bool({"angular_velocity", "principal_rates"} & set(self.given))
        return name in self.given

    def _published(self, name):
        return getattr(self, name) if name in ("mode", "convention") else self.given[name].si

    def _from_rates(self, body, given, frame):
        epoch = given["epoch"] if "epoch" in given else self.given["epoch"].si
        wxyz = given["wxyz"] if "wxyz" in given else self.given["wxyz"].si
        if "angular_velocity" in given:
            rate = given["angular_velocity"]
        else:
            about = self.given["principal_rates"].si
            rate = 2.0 * np.pi / self.printed["spin_period"].si * (body.principal_axes @ about)
        return Spin(epoch, wxyz, rate, frame)

    def _values(self):
        return (*self.given.values(), *self.printed.values())


def names():
    """The names of all entries."""
    return tuple(_entries())


def entry(name):
    """The `Entry` of a name.

    Case does not matter, and a part that only one body has will do: its newest entry, where there
    are several.

    >>> entry("apophis").name
    '99942 Apophis (2022)'

    Raises
    ------
    AttitudeError
        For a name that is not there or belongs to several bodies.
    """
    if not isinstance(name, str) or not name.strip():
        raise AttitudeError(f"name is {name!r}; give one of {', '.join(names())}.")
    entries, wanted = _entries(), name.strip().lower()
    exact = [each for each in entries.values() if each.name.lower() == wanted]
    found = exact or [each for each in entries.values() if wanted in each.name.lower()]
    bodies = {each.name.partition(" (")[0] for each in found}
    if len(bodies) == 1:
        return max(found, key=lambda each: each.year)
    if bodies:
        raise AttitudeError(f"{name!r} belongs to {', '.join(sorted(bodies))}; give one of them.")
    near = difflib.get_close_matches(name, entries, n=1)
    raise AttitudeError(
        f"the catalogue has no {name!r}; "
        + (f"did you mean {near[0]!r}?" if near else f"it has {', '.join(entries)}.")
    )


def load(name, **given):
    """Body and spin of a published state: ``body, spin = load(name)``; see `Entry.load`.

    Parameters
    ----------
    name : str
        As in `entry`.
    **given
        What was not published, as `Entry.missing` names it.

    Returns
    -------
    Loaded
        (body, spin)
    """
    return entry(name).load(**given)


@cache
def _entries():
    name = "data/spin_states.toml"
    tables = toml.parsed(packaged(name), name)
    sources = tables.pop("sources")
    return {name: _entry(name, table, sources) for name, table in tables.items()}


def _entry(name, table, sources):
    def values(rows):
        return {
            row["name"]: Value(
                row["name"],
                row["value"],
                row.get("unit"),
                row.get("error"),
                sources[row["source"]],
            )
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
    )


def _spelled(value):
    if isinstance(value, list):
        return "(" + ", ".join(_spelled(each) for each in value) + ")"
    return repr(value)


def _error(error):
    return f"-{error[0]} +{error[1]}" if isinstance(error, list) else f"+-{error}"
