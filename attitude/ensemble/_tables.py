"""Ensembles in tables (astropy, pandas, arrow, files), and random draws about a motion.

One row is one member, with the columns of `Ensemble.from_table`, or with those of a survey's
simulation, which `attitude.survey` lists: ObjID, axis_a, axis_b, axis_c, pole_lon_deg, period_h ...
The meta data ``frame`` and ``relative`` are those of the ensemble.  Files written here also have
``low_w, low_x, low_y, low_z``, the second doubles of attitudes, if there are any.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from attitude import frames
from attitude._solver import covariance as covariances
from attitude._solver.states import States
from attitude._support import pairs, validation
from attitude._support.constants import DAY_S, MJD_OF_J2000
from attitude._textfiles.lines import prefixed
from attitude.errors import AttitudeError
from attitude.formats.tables import ATTITUDE, RATES, meta_of
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions import _published

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude._support.annotations import BoolArray, FloatArray
    from attitude.motions._free_rotation import FreeRotation


_XYZ = "xyz"
# Columns of several numbers, with the columns that may stand for them, and the unit.
_PARTS: dict[str, tuple[tuple[str, ...], str | None]] = {
    "wxyz": (ATTITUDE, None),
    "low": (tuple(f"low_{k}" for k in ATTITUDE), None),
    "angular_velocity": (RATES, "rad/s"),
    "moments": (tuple(f"moment_{k}" for k in _XYZ), "kg m2"),
    "tensor": (tuple(f"tensor_{j}{k}" for j in _XYZ for k in _XYZ), "kg m2"),
}


def columns_of(table: Any, origin: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The columns and the meta data of an astropy, pandas or arrow table, or of a mapping."""
    if hasattr(table, "colnames"):  # astropy
        return {name: table[name] for name in table.colnames}, _lower(table.meta)
    if hasattr(table, "column_names") and hasattr(table, "schema"):  # pyarrow
        meta = meta_of(table)
        columns = {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}
        return columns, _lower(meta)
    if hasattr(table, "columns") and hasattr(table, "to_numpy"):  # pandas
        columns = {str(name): table[name].to_numpy() for name in table.columns}
        return columns, _lower(getattr(table, "attrs", {}))
    if isinstance(table, Mapping):
        return dict(table), {}
    raise AttitudeError(
        f"{origin} is {validation.shown(table)}; give an astropy, pandas or arrow table, or the "
        "name of a file."
    )


def arguments(
    columns: Mapping[str, Any], relative: bool, origin: str, on_error: str
) -> dict[str, Any]:
    """The arguments of `Ensemble` in some columns, with ``low`` if there are second doubles."""
    if ROTATOR_EPOCH in columns:
        return _of_rotators(columns, origin, on_error)
    keywords: dict[str, Any] = {}
    for name, (parts, unit) in _PARTS.items():
        known = None if relative and unit == "kg m2" else unit
        values = _numbers(columns, name, parts, known, origin)
        if values is not None:
            keywords[name] = values
    for name in ("wxyz", "angular_velocity"):
        if name not in keywords:
            raise AttitudeError(
                f"{origin}: it has no {name}; give a column {name}, or "
                f"{', '.join(_PARTS[name][0])}, or the columns of a survey ({ROTATOR_EPOCH}, "
                "period_h, ...)."
            )
    if "tensor" in keywords:
        keywords["tensors"] = keywords.pop("tensor").reshape(-1, 3, 3)
        keywords.pop("moments", None)
    elif "moments" not in keywords:
        raise AttitudeError(f"{origin}: it has neither moments nor tensor; give one of them.")
    keywords["epoch"] = _epochs(columns, origin) if len(keywords["wxyz"]) else "2000-01-01"
    return keywords | {"names": _names(columns, ("name",), origin)}


def words(column: Any) -> list[Any]:
    """The entries of a column of text: None where it is masked, text in place of FITS' bytes."""
    entries = np.ma.asarray(np.atleast_1d(np.asanyarray(column, dtype=object))).tolist()
    return [word.decode("utf-8", "replace") if type(word) is bytes else word for word in entries]


def _names(columns: Mapping[str, Any], labels: tuple[str, ...], origin: str) -> list[str] | None:
    """The names in the first column with one of some labels, or None."""
    label = next((label for label in labels if label in columns), None)
    names = [] if label is None else words(columns[label])
    missing = [k for k, name in enumerate(names) if name is None]
    if missing:
        raise AttitudeError(
            f"{origin}: the {label} of row {missing[0]} is missing; give one for each row, or "
            "leave out the column."
        )
    return None if label is None else [str(name) for name in names]


def _epochs(columns: Mapping[str, Any], origin: str) -> Any:
    """What `Ensemble` takes as epochs: dates, or Seconds."""
    if "epoch_seconds" in columns:
        both = {"epoch_low": np.zeros(len(columns["epoch_seconds"])), **columns}
        names = ("epoch_seconds", "epoch_low")
        seconds = np.asarray(_numbers(both, "seconds", names, "s", origin)).T
        if not np.all(np.isfinite(seconds)):
            row = int(np.argmin(np.isfinite(seconds).all(axis=0)))
            raise AttitudeError(f"{origin}: the epoch of row {row} is missing.")
        return pairs.Seconds(*(seconds[:, :1] if np.all(seconds == seconds[:, :1]) else seconds))
    if "epoch" not in columns:
        raise AttitudeError(
            f"{origin}: it has no epochs; give a column epoch of dates, or epoch_seconds."
        )
    return columns["epoch"]


def _numbers(
    columns: Mapping[str, Any], name: str, parts: tuple[str, ...], unit: str | None, origin: str
) -> FloatArray | None:
    """A column (N, W), from one of rows or from W columns; None where there is neither."""
    try:
        if name in columns:
            column = columns[name]
            if getattr(getattr(column, "dtype", None), "kind", "") == "O":
                column = np.stack([np.asarray(row) for row in column])
            array = validation.real(column, name, unit=unit, finite=False)
            if array.ndim == 3:
                array = array.reshape(len(array), math.prod(array.shape[1:]))
            return array
        if not set(parts) <= set(columns):
            return None
        components = [validation.real(columns[k], k, unit=unit, finite=False) for k in parts]
        return np.stack(components, axis=-1)
    except AttitudeError as err:
        raise AttitudeError(f"{origin}: {err}") from err
    except (ValueError, TypeError) as err:
        raise AttitudeError(f"{origin}: the column {name} cannot be read ({err}).") from err


def of_arrays(arrays: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Columns (N,) of the arrays wxyz, low, angular_velocity, moments or tensor of N members."""
    columns: dict[str, Any] = {}
    for name, array in arrays.items():
        flat = array.reshape(len(array), math.prod(array.shape[1:]))
        columns.update({component: flat[:, k] for k, component in enumerate(_PARTS[name][0])})
    return columns


def origin_of(source: Any) -> str | None:
    """The name of a file, or None for a table."""
    return os.fspath(source) if isinstance(source, (str, os.PathLike)) else None


def _lower(meta: Any) -> dict[str, Any]:
    return {str(key).lower(): value for key, value in dict(meta).items()}


# ---- Rotators in the columns of `attitude.survey`: ellipsoids, poles in the ecliptic of J2000

AXES: tuple[str, str, str] = ("axis_a", "axis_b", "axis_c")
ROTATOR_EPOCH: str = "spin_epochMJD_TDB"
# Columns of numbers with their default, or None if each object needs them.
_ROTATOR_NUMBERS: dict[str, float | None] = {
    **dict.fromkeys(("pole_lon_deg", "pole_lat_deg", "phi0_deg", ROTATOR_EPOCH)),
    **dict.fromkeys(("period_h", "P_psi_h", "P_phi_h", "psi0_deg"), math.nan),
}
_ROTATOR_WORDS = ("mode", "convention", "theta_branch")
# Units of plain numbers, by the ends of the names of columns; of others m.
_UNITS = {"_h": "h", "eg": "deg", "DB": "d"}
ROTATOR_COLUMNS: frozenset[str] = frozenset({*AXES, "shape", *_ROTATOR_NUMBERS, *_ROTATOR_WORDS})
# Modified Julian date, TDB, of J2000.


def rotator_label(k: int, names: Sequence[object] | None) -> str:
    """How errors name object k of a survey."""
    return f"Member {k}" if names is None else f"ObjID {str(names[k])!r}"


def rotator_numbers(
    columns: Mapping[str, Any],
    name: str,
    default: float | None = None,
    names: Sequence[object] | None = None,
) -> FloatArray:
    """A column as float64, NaN where it is masked; a default for each object if it is absent."""
    if name not in columns and default is None:
        raise AttitudeError(
            f"the column {name} is missing; give it, or a distribution from which it is drawn."
        )
    first = next(iter(columns))
    shape = np.shape(columns[first])[:1]
    if name not in columns:
        return np.full(shape, default)
    values, mask = validation.unmasked(columns[name])
    if getattr(values, "unit", None) not in (None, "") or validation.holds_quantities(values):
        values = validation.real(values, name, unit=_UNITS.get(name[-2:], "m"), finite=False)
    values = np.asarray(values)
    if values.ndim != 1 or values.shape != shape:
        raise AttitudeError(
            f"the column {name} has shape {values.shape}; give one number for each object, as many "
            f"as the column {first} has, {shape}."
        )
    try:
        numbers = np.array(values, dtype=np.float64)
        return numbers if mask is None else np.where(mask, math.nan, numbers)
    except (TypeError, ValueError):
        for k, value in enumerate(values.tolist()):
            try:
                float(value)
            except (TypeError, ValueError):
                raise AttitudeError(
                    f"{rotator_label(k, names)}: {name} is {validation.shown(value)}; give a "
                    "number, or nan where it does not apply."
                ) from None
        raise


def rotator_moments(
    columns: Mapping[str, Any], names: Sequence[object] | None
) -> tuple[FloatArray, FloatArray]:
    """Semi-axes (N, 3), and relative moments (N, 3) of the homogeneous ellipsoids with them."""
    axes = np.stack([rotator_numbers(columns, name, None, names) for name in AXES], axis=1)
    bad = np.flatnonzero(~np.all((axes > 0.0) & (axes < math.inf), axis=1))
    if len(bad):
        raise AttitudeError(
            f"{rotator_label(bad[0], names)} has the semi-axes {axes[bad[0]].tolist()}; give three "
            "numbers above zero."
        )
    squares = axes**2
    return axes, 0.2 * (squares.sum(axis=1, keepdims=True) - squares)


def rotator_states(
    columns: Mapping[str, Any],
    moments: FloatArray,
    principal_axes: FloatArray | None,
    names: Sequence[object] | None,
    on_error: str = "raise",
) -> tuple[_published.PeriodStates, FloatArray]:
    """States in the ecliptic of J2000, and their epochs (N,), modified Julian dates in TDB."""
    numbers = {
        name: rotator_numbers(columns, name, default, names)
        for name, default in _ROTATOR_NUMBERS.items()
    }
    degree, hour = math.pi / 180.0, 3600.0
    states = _published.states_from_periods(
        moments,
        principal_axes=principal_axes,
        pole=np.stack([numbers["pole_lon_deg"], numbers["pole_lat_deg"]], axis=1) * degree,
        phi0=numbers["phi0_deg"] * degree,
        psi0=np.where(np.isnan(numbers["period_h"]), numbers["psi0_deg"] * degree, math.nan),
        P_psi=numbers["P_psi_h"] * hour,
        P_phi=numbers["P_phi_h"] * hour,
        P=numbers["period_h"] * hour,
        on_error="nan",
        **{name: words(columns[name]) for name in _ROTATOR_WORDS if name in columns},
    )
    if on_error == "raise" and states.bad.any():
        k = int(np.flatnonzero(states.bad)[0])
        raise AttitudeError(f"{rotator_label(k, names)}: {states.reason(k)}")
    epochs = numbers[ROTATOR_EPOCH]
    unknown = np.flatnonzero(~np.isfinite(epochs))
    if len(unknown):
        raise AttitudeError(
            f"{rotator_label(int(unknown[0]), names)} has no {ROTATOR_EPOCH}; give the epoch of "
            "its state."
        )
    return states, epochs


def _of_rotators(columns: Mapping[str, Any], origin: str, on_error: str) -> dict[str, Any]:
    """The arguments of `Ensemble` in the columns of a survey."""
    names = _names(columns, ("ObjID", "name"), origin)
    with prefixed(origin):
        _, moments = rotator_moments(columns, names)
        states, mjd = rotator_states(columns, moments, None, names, on_error)
    return {
        "wxyz": states.wxyz,
        "angular_velocity": states.angular_velocity,
        "moments": moments,
        "epoch": pairs.Seconds(*pairs.product(mjd - MJD_OF_J2000, DAY_S)),
        "names": names,
        "frame": "ecliptic",
        "relative": True,
    }


# ---- Random states about a motion: draws from a covariance or from distributions, kept physical

_WIDTHS = {"attitude": 3, "wxyz": 4, "angular_velocity": 3, "moments": 3}


class Drawn(NamedTuple):
    """States of N members."""

    wxyz: FloatArray  # (N, 4), body to ICRF
    rates: FloatArray  # (N, 3), rad/s over the body axes
    moments: FloatArray | None  # (N, 3), principal ones; None: those of the motion


def drawn(
    motion: FreeRotation,
    count: int,
    seed: int | np.random.Generator,
    covariance: Any,
    distributions: Mapping[str, Any] | None,
) -> Drawn:
    """States drawn about a motion; arguments as in `Ensemble.sample`."""
    generator = validation.generator(seed)
    if distributions is None:
        draw = _of_covariance(motion, covariance, generator)
    else:
        draw = _of_distributions(motion, distributions, generator)
    parts: list[Drawn] = []
    accepted, tried, most = 0, 0, 10 * count + 100
    while accepted < count or not parts:
        number = min(count - accepted, most - tried)
        if number == 0 and count:
            raise AttitudeError(
                f"{tried} draws gave {accepted} motions whose moments are those of a body; give "
                "smaller errors of the moments."
            )
        some = draw(number)
        if some.moments is not None:
            kept = _physical(some.moments)
            some = Drawn(some.wxyz[kept], some.rates[kept], some.moments[kept])
        parts.append(some)
        accepted, tried = accepted + len(some.wxyz), tried + number
    moments = None
    if parts[0].moments is not None:
        moments = np.concatenate([batch.moments for batch in parts if batch.moments is not None])
    wxyz, rates = (np.concatenate([batch[k] for batch in parts]) for k in (0, 1))
    return Drawn(wxyz, rates, moments)


def _of_covariance(
    motion: FreeRotation, covariance: Any, generator: np.random.Generator
) -> Callable[[int], Drawn]:
    spin = motion.spin if covariance is None else motion.spin.with_covariance(covariance)
    if spin.covariance_icrf is None:
        raise AttitudeError(
            "the spin has no covariance; give covariance= or distributions=, or make the spin with "
            "Spin(..., covariance=...)."
        )
    factor = covariances.factor(spin.covariance_icrf)
    exact = not np.any(factor[6:])

    def draw(count: int) -> Drawn:
        changes = generator.standard_normal((count, 9)) @ factor.T
        turn = forms.from_rotation_vector(changes[:, :3])
        wxyz = quaternion.multiply(turn, spin.wxyz_icrf)
        moments = None if exact else motion.body.moments + changes[:, 6:]
        return Drawn(wxyz, spin.angular_velocity + changes[:, 3:6], moments)

    return draw


def _of_distributions(
    motion: FreeRotation, distributions: Mapping[str, Any], generator: np.random.Generator
) -> Callable[[int], Drawn]:
    unknown = [name for name in distributions if name not in _WIDTHS]
    if unknown or not distributions:
        raise AttitudeError(
            f"distributions has {validation.shown(unknown)}; give some of {', '.join(_WIDTHS)}."
        )
    if {"attitude", "wxyz"} <= set(distributions):
        raise AttitudeError("distributions has attitude and wxyz; give one of them.")
    spin = motion.spin
    to_icrf = frames.wxyz_to_icrf(spin.frame)

    def rows(name: str, count: int) -> FloatArray:
        source = distributions[name]
        if hasattr(source, "rvs"):
            size = count if np.ndim(source.rvs(random_state=0)) else (count, _WIDTHS[name])
            draws = source.rvs(size=size, random_state=generator)
        else:
            draws = source(generator, count)
        return validation.real(draws, f"the draw of {name}", shape=(count, _WIDTHS[name]))

    def draw(count: int) -> Drawn:
        wxyz = np.broadcast_to(spin.wxyz_icrf, (count, 4))
        if "attitude" in distributions:
            turns = forms.from_rotation_vector(rows("attitude", count))
            wxyz = quaternion.multiply(to_icrf, quaternion.multiply(turns, spin.wxyz))
        elif "wxyz" in distributions:
            wxyz = rows("wxyz", count)
            if not np.all(np.any(wxyz, axis=1)):
                raise AttitudeError("the draw of wxyz holds a zero quaternion; give unit ones.")
            wxyz = quaternion.multiply(to_icrf, wxyz)
        rates = np.broadcast_to(spin.angular_velocity, (count, 3))
        if "angular_velocity" in distributions:
            rates = rows("angular_velocity", count)
        return Drawn(wxyz, rates, rows("moments", count) if "moments" in distributions else None)

    return draw


def _physical(moments: FloatArray) -> BoolArray:
    """Whether a body has each of some principal moments (N, 3)."""
    physical = np.ones(len(moments), dtype=bool)
    physical[States.of_principal_axes(moments, np.zeros_like(moments)).faults()] = False
    return physical
