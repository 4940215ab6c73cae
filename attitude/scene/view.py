"""A scene at some epochs; each quantity is computed once, at its first use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from attitude.errors import AttitudeError
from attitude.immutable import frozen
from attitude.scene.errors import Errors
from attitude.scene.lazy import LazyProperty

if TYPE_CHECKING:
    from attitude.annotations import FloatArray
    from attitude.epochs import Instant
    from attitude.flat_table import FlatTable
    from attitude.scene.scene import Scene


class View(Errors):
    """What is seen at some epochs of reception.  Made by ``scene.at(times)``.

    S is the shape of the times.  Vectors are (S, 3), views of component-major memory; all arrays
    are read-only; scalar times give scalars.  Radians, metres, seconds.

    Attributes
    ----------
    scene : Scene
    epoch : Instant
    seconds, low : S arrays (low may be None)
        TDB seconds from `epoch` at which light is received: seconds + low.
    """

    _evaluated: list[str]

    def __init__(
        self, scene: Scene, epoch: Instant, seconds: FloatArray, low: FloatArray | None
    ) -> None:
        self._set("scene", scene)
        self._set("epoch", epoch)
        self._set("seconds", frozen(seconds))
        self._set("low", None if low is None else frozen(low))
        self._set("_evaluated", [])

    @property
    def evaluated(self) -> tuple[str, ...]:
        """Names of the quantities that were computed, in the order of their computation."""
        return tuple(self._evaluated)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a view of one scalar epoch has no length")
        return self.shape[0]

    def __repr__(self) -> str:
        return f"<View of {self.seconds.size} epochs; evaluated: {', '.join(self.evaluated)}>"

    @classmethod
    def columns(cls) -> dict[str, LazyProperty[Any]]:
        """The quantities that a table can hold, by name, with their units, parts, descriptions."""
        return {
            name: value
            for owner in reversed(cls.__mro__)
            for name, value in vars(owner).items()
            if isinstance(value, LazyProperty) and value.is_column
        }

    def table(self, *names: str) -> FlatTable:
        """Some quantities as an astropy QTable, after a column of the times (TDB) of reception.

        Raises
        ------
        AttitudeError
            For a name that is not in `columns`, and for times that are not one-dimensional.
        """
        from astropy.units import Unit

        from attitude.flat_table import FlatTable

        known = self.columns()
        for name in names:
            if name not in known:
                raise AttitudeError(
                    f"{name!r} is not a quantity of a view; give some of {', '.join(known)}."
                )
        if len(self.shape) != 1:
            raise AttitudeError(
                f"the times have shape {self.shape}; a table needs times of shape (N,)."
            )
        columns = {"time": self.time}
        for name in names:
            value = np.array(getattr(self, name))
            columns[name] = value * Unit(known[name].unit) if known[name].unit else value
        table = FlatTable(columns, meta={"scene": repr(self.scene), **self.sources})
        for name in names:
            table[name].info.description = known[name].about
            if known[name].parts:
                flat = tuple(f"{name}_{part}" for part in known[name].parts)
                FlatTable.flat_names[name] = flat
        return table

    @property
    def sources(self) -> dict[str, str]:
        """Sources of the positions, by the name of each line of sight that was computed."""
        lines = ("observer_line", "sun_line", "observer_sun_line")
        return {name: self.__dict__[name].source for name in lines if name in self.__dict__}
