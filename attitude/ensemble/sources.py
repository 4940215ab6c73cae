"""Where ensembles come from and go to: published periods, tables and files, random draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from attitude import published, validation
from attitude.body import Body
from attitude.ensemble import draws, tables
from attitude.ensemble.collection import Collection
from attitude.errors import AttitudeError
from attitude.formats import tables as files
from attitude.free_rotation.free_rotation import FreeRotation

if TYPE_CHECKING:
    from astropy.table import QTable

    from attitude.annotations import Epochs, FilePath, Reals


class Sourced(Collection):
    """Base of `Ensemble`: constructors from other forms of states, and files."""

    @classmethod
    def from_periods(
        cls,
        body: Body | None = None,
        *,
        epoch: Epochs,
        pole: Reals,
        phi0: Reals,
        mode: Any = None,
        convention: Any = None,
        P_psi: Reals | None = None,
        P_phi: Reals | None = None,
        psi0: Reals | None = None,
        theta_branch: Any = None,
        P: Reals | None = None,
        frame: str = "ecliptic",
        moments: Reals | None = None,
        relative: bool = True,
        names: Sequence[str] | None = None,
        on_error: str = "raise",
    ) -> Self:
        """Members from published spin states, each as by `Spin.from_periods`.

        Parameters
        ----------
        body : Body
            Of all members; or moments=.
        moments : (3,) or (N, 3) array_like
            Principal moments about the body axes.
        relative : bool
            Whether the unit of the moments is unknown; of a body, its own.
        epoch, pole, phi0, mode, convention, P_psi, P_phi, psi0, theta_branch, P
            As of `Spin.from_periods`; each one value, or one for each member: pole (N, 2).  P is
            NaN for members that tumble; P_psi, P_phi and psi0 are NaN for relaxed rotators.
        frame, names, on_error
            As of `Ensemble`.

        Raises
        ------
        AttitudeError
            For the first member that no motion has, with its possible range, unless
            on_error="nan"; and as `Ensemble`.
        """
        if (body is None) == (moments is None):
            raise AttitudeError("from_periods takes either body= or moments= (N, 3).")
        known = _listed_names(names)
        states = published.states_from_periods(
            body if moments is None else moments, pole=pole, phi0=phi0, mode=mode,
            convention=convention, P_psi=P_psi, P_phi=P_phi, psi0=psi0, theta_branch=theta_branch,
            P=P, names=known, on_error=on_error,
        )  # fmt: skip
        return cls(
            body, states.wxyz, states.angular_velocity, epoch, frame, known,
            moments=moments, relative=relative if body is None else False, on_error=on_error,
        )  # fmt: skip

    @classmethod
    def from_table(
        cls,
        table: Any,
        *,
        frame: str | None = None,
        relative: bool | None = None,
        on_error: str = "raise",
    ) -> Self:
        """Members from the rows of a table or a file.

        Parameters
        ----------
        table : astropy QTable or Table, pandas DataFrame, pyarrow Table, mapping, or file name
            With the columns of `attitude.ensemble.tables`; files end in .parquet, .ecsv, .fits or
            .csv.
        frame, relative : optional
            By default those of the meta data of the table, else "icrf" and False.
        on_error
            As of `Ensemble`.

        Raises
        ------
        AttitudeError
            For columns that are missing or cannot be read, and as `Ensemble`.
        """
        origin = tables.origin_of(table)
        given = table if origin is None else files.columns_of(origin)
        origin = origin or "the table"
        columns, meta = tables.columns_of(given, origin)
        unknown = bool(meta.get("relative", False)) if relative is None else relative
        found = tables.arguments(columns, validation.flag(unknown, "relative"), origin)
        axes = str(meta.get("frame", "icrf")) if frame is None else frame
        low = found.pop("low", None)
        try:
            made = cls(**found, frame=axes, relative=unknown, on_error=on_error)
        except AttitudeError as err:
            raise AttitudeError(f"{origin}: {err}") from err
        return made if low is None else made._with_low(low)

    def table(self) -> QTable:
        """The members as an astropy QTable with the columns of `attitude.ensemble.tables`."""
        from astropy.table import QTable

        arrays = {"wxyz": self.wxyz, "angular_velocity": self.angular_velocity}
        if self._low is not None:
            arrays["low"] = self._low
        given = self._inertia.given
        arrays["tensor" if given.ndim == 3 else "moments"] = np.broadcast_to(
            given, (len(self), *given.shape[1:])
        )
        columns: dict[str, Any] = {} if self.names is None else {"name": np.array(self.names)}
        start = np.broadcast_to(self._start, (2, len(self)))
        columns |= {"epoch_seconds": start[0], "epoch_low": start[1], **tables.of_arrays(arrays)}
        meta = {"frame": self.frame, "relative": self._inertia.relative}
        return QTable({name: np.array(each) for name, each in columns.items()}, meta=meta)

    def write(self, path: FilePath) -> None:
        """Write a file that `from_table` reads back bit for bit: .parquet, .ecsv or .fits.

        The file appears whole or not at all.

        Raises
        ------
        AttitudeError
            For another ending, and a file that cannot be written.
        """
        files.write_columns(path, self.table())

    @classmethod
    def sample(
        cls,
        motion: FreeRotation,
        count: int,
        seed: int | np.random.Generator = 0,
        *,
        covariance: Reals | Mapping[str, Reals] | None = None,
        distributions: Mapping[str, Any] | None = None,
    ) -> Self:
        """Members drawn about a motion.

        Parameters
        ----------
        motion : FreeRotation
        count : int
            0 or more.
        seed : int or numpy Generator
        covariance : (9, 9) or (6, 6) array_like, or mapping, optional
            As of `Spin`, over the axes of the spin's frame; by default that of the spin.
        distributions : mapping, optional
            In place of a covariance: by name a function of (generator, n) or an object with
            ``rvs(size=, random_state=)``, such as of scipy.stats, that draws n rows of

            ``attitude``   rotation vectors (n, 3), rad, over the axes of the spin's frame
            ``wxyz``       attitudes (n, 4) in the frame, in place of `attitude`
            ``angular_velocity``  (n, 3), rad/s over the body axes
            ``moments``    (n, 3) principal moments

            What is not named is that of the motion.

        Returns
        -------
        Ensemble
            Its frame is "icrf".  Draws whose moments are no body's are drawn anew.

        Raises
        ------
        AttitudeError
            Without a covariance and distributions, for draws of other shapes, and if 9 of 10 draws
            are no body's moments.
        """
        if not isinstance(motion, FreeRotation):
            raise AttitudeError(f"motion is {validation.shown(motion)}; give a FreeRotation.")
        number = validation.count(count, "count", 0)
        if covariance is not None and distributions is not None:
            raise AttitudeError("covariance and distributions are both given; give one of them.")
        drawn = draws.drawn(motion, number, seed, covariance, distributions)
        body = motion.body
        shared: dict[str, Any] = {
            "epoch": motion.spin.epoch,
            "wxyz": drawn.wxyz,
            "angular_velocity": drawn.rates,
        }
        if drawn.moments is None:
            return cls(body, **shared)
        if body.has_given_axes:
            return cls(moments=drawn.moments, relative=body.relative, **shared)
        tensors = draws.tensors(body, drawn.moments)
        return cls(tensors=tensors, relative=body.relative, **shared)


def _listed_names(names: Any) -> list[str] | None:
    return None if names is None else [str(each) for each in np.asarray(names).ravel().tolist()]
