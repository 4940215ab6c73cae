"""The light-curve class for Rubin's simulator sorcha, and classes with shapes and distributions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from sorcha.lightcurves.base_lightcurve import AbstractLightCurve
from sorcha.lightcurves.lightcurve_registration import update_lc_subclasses

from attitude._support import validation
from attitude.ensemble._tables import ROTATOR_COLUMNS, rotator_numbers
from attitude.errors import AttitudeError
from attitude.survey._rotators import Rotators, drawn, emission, law_about_mean

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas

    from attitude._support.annotations import FloatArray
    from attitude.scattering._law import Law
    from attitude.shape._mesh import Mesh


_SUN = ("Obj_Sun_x_LTC_km", "Obj_Sun_y_LTC_km", "Obj_Sun_z_LTC_km")
_OBSERVER = ("Obs_Sun_x_km", "Obs_Sun_y_km", "Obs_Sun_z_km")
# Columns of sorcha that the computation reads.
_GIVEN = ("ObjID", "fieldMJD_TAI", "Range_LTC_km", *_SUN, *_OBSERVER)
# Distributions of relaxed ellipsoids: isotropic poles, periods uniform in their logarithm.
RELAXED: dict[str, Any] = {
    "axis_a": 1.0,
    "axis_b": (0.6, 1.0),
    "axis_c": (0.4, 0.6),
    "pole_lon_deg": (0.0, 360.0),
    "pole_lat_deg": lambda u: np.degrees(np.arcsin(2.0 * u - 1.0)),
    "phi0_deg": (0.0, 360.0),
    "spin_epochMJD_TDB": 60000.0,
    "period_h": lambda u: 2.2 * 10.0 ** (1.5 * u),
}


def light_curve_class(
    name: str,
    *,
    shape: Mesh | Mapping[str, Mesh] | None = None,
    law: str | Law = "lommel-seeliger",
    draws: Mapping[str, Any] | None = None,
    seed: int = 0,
    threads: int = 1,
) -> type[AbstractLightCurve]:
    """A light-curve class of sorcha, registered under a name: ``lc_model`` of its configuration.

    Parameters
    ----------
    name : str
        Of lower case.
    shape, law
        As in `attitude.survey.Rotators`.
    draws : dict, optional
        Distributions of columns that the parameter file does not have, by the name of the column;
        `RELAXED` is one.
    seed : int
        Of the draws.
    threads : int
        For the magnitudes of one call.

    Raises
    ------
    AttitudeError
        For a name that is not of lower case or is registered already, a column that does not exist,
        and shapes and laws that `attitude.survey.Rotators` refuses.
    """
    if not isinstance(name, str) or name != name.lower():
        raise AttitudeError(f"name is {validation.shown(name)}; give one of lower case.")
    law_about_mean(law, shape)
    unknown = sorted(set(draws or {}) - ROTATOR_COLUMNS)
    if unknown:
        raise AttitudeError(
            f"draws has {validation.shown(unknown[0])}; give columns among "
            f"{', '.join(sorted(ROTATOR_COLUMNS))}."
        )
    taken = {registered.name_id() for registered in AbstractLightCurve.__subclasses__()}
    if name in taken:
        raise AttitudeError(f"name is {name!r}, which another light-curve class has; give another.")
    seed, threads = validation.count(seed, "seed", 0), validation.count(threads, "threads")
    options = {"shape": shape, "law": law}
    new_class = _class(name, options, dict(draws or {}), seed, threads)
    update_lc_subclasses()
    return new_class


def _class(name, options, draws, seed, threads):
    """The class; sorcha makes an object of it, without arguments, for each chunk."""

    class _LightCurve(AbstractLightCurve):
        """Magnitudes of rotating bodies about their mean; see `attitude.survey`."""

        def __init__(self, required_column_names: list[str] | None = None) -> None:
            super().__init__(
                list(_GIVEN if required_column_names is None else required_column_names)
            )

        def compute(self, df: pandas.DataFrame) -> FloatArray:
            """Shifts (R,), mag, of the rows of a chunk of observations."""
            self._validate_column_names(df)
            try:
                return _shifts(df, options, draws, seed, threads)
            except AttitudeError as err:
                self._log_exception(err)
                raise

        def maxBrightness(self, df: pandas.DataFrame) -> FloatArray:
            """Least shifts (N,), mag, of the objects of a table of parameters."""
            names = df["ObjID"].to_numpy()
            columns = {column: df[column].to_numpy() for column in df.columns}
            return _rotators(columns, names, options, draws, seed).brightest()

        @staticmethod
        def name_id() -> str:
            """The name in sorcha's configuration."""
            return name

    _LightCurve.__name__ = _LightCurve.__qualname__ = f"LightCurve_{name}"
    return _LightCurve


def _shifts(df, options, draws, seed, threads):
    """The shifts of the rows of a table of observations."""
    import pandas

    member, names = pandas.factorize(df["ObjID"])
    count = len(member)
    first = np.empty(len(names), dtype=np.int64)
    first[member[::-1]] = np.arange(count - 1, -1, -1)  # the last of several assignments holds
    used = [column for column in df.columns if column in ROTATOR_COLUMNS]
    wanted = {column: df[column].take(first).to_numpy() for column in used}
    rotators = _rotators(wanted, names, options, draws, seed)
    sun, observer = np.empty((2, 3, count))
    for k, (body, seen) in enumerate(zip(_SUN, _OBSERVER, strict=True)):
        np.negative(df[body].to_numpy(), out=sun[k])
        np.add(df[seen].to_numpy(), sun[k], out=observer[k])
    left = emission(df["fieldMJD_TAI"].to_numpy(), df["Range_LTC_km"].to_numpy())
    return rotators.shifts(member, left, sun.T, observer.T, threads=threads)


def _rotators(columns, names, options, draws, seed):
    """The rotators of objects, with columns that are absent drawn."""
    columns = {name: values for name, values in columns.items() if name in ROTATOR_COLUMNS}
    tumbles = None
    if "P_psi_h" in columns:
        tumbles = ~np.isnan(rotator_numbers(columns, "P_psi_h", None, names))
    for column, distribution in draws.items():
        if column not in columns:
            columns[column] = drawn(names, column, seed, distribution)
            if column == "period_h" and tumbles is not None:
                columns[column] = np.where(tumbles, np.nan, columns[column])
    return Rotators(columns, names=names, **options)


LightCurve = light_curve_class("attitude")
light_curve_class("attitude-relaxed", draws=RELAXED)
