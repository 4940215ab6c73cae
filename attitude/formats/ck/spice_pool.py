"""Kernels loaded in SPICE's pool, which keeps the kernels and variables of the user.

SPICE has one pool for the whole process.  `unload` removes the last instance of a name: one call
too many removes a kernel that the user has loaded.  When a text kernel is unloaded, SPICE also
drops all variables that a program has set (by pdpool, pcpool, pipool); `LoadedKernels.close`
restores them.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from attitude import calls
from attitude.errors import AttitudeError
from attitude.formats.ck import daf_head
from attitude.textfiles.lines import unreadable

if TYPE_CHECKING:
    from collections.abc import Iterable

    from attitude.annotations import FilePath

# Names of variables that one call returns; and a number that exceeds the capacity of the pool.
_BATCH, _MOST = 500, 100_000


def spiceypy() -> Any:
    """The module `spiceypy`; AttitudeError if it is not installed."""
    try:
        import spiceypy
    except ImportError as err:
        raise AttitudeError(f"CK needs SPICE; install it by {calls.installing('spice')}.") from err
    return spiceypy


class LoadedKernels:
    """Kernels in the pool, until `close` or the end of a ``with`` block.

    Parameters
    ----------
    names : iterable of paths

    Raises
    ------
    AttitudeError
        If a kernel is broken or SPICE cannot load it; no kernel stays loaded then.
    """

    def __init__(self, names: Iterable[FilePath]):
        self._spice = spiceypy()
        self._count = self._spice.ktotal("ALL")
        self._known = self._variables()
        self._own: set[str] = set()
        self._names: list[str] = []
        for given in names:
            # whole, since the folder of the process may be another one when it is unloaded
            name = os.path.abspath(os.fspath(given))
            self._refuse_broken(name)
            try:
                self._spice.furnsh(name)
            except self._spice.exceptions.SpiceyError as err:
                self._spice.reset()
                self._roll_back()
                raise AttitudeError(f"SPICE cannot load {name}: {err.short}.") from err
            self._names.append(name)
        self._own = self._variables() - self._known

    def close(self) -> None:
        """Unload these kernels, and no others; a second call does nothing."""
        names, self._names = self._names, []
        if not names:
            return
        kept = {name: self._values(name) for name in self._variables() - self._own}
        for name in reversed(names):
            self._spice.unload(name)
        for name in kept.keys() - self._variables():
            self._put(name, *kept[name])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _refuse_broken(self, name):
        """AttitudeError for a kernel at which SPICE would end the process."""
        try:
            broken = daf_head.fault(name)
        except OSError as err:
            self._roll_back()
            raise unreadable(name, err) from err
        if broken is not None:
            self._roll_back()
            raise AttitudeError(f"{name}: it is a broken kernel: {broken}.")

    def _roll_back(self):
        """Unload after a failure, including the loaded part of a meta-kernel."""
        total = self._spice.ktotal("ALL")
        self._names = [self._spice.kdata(k, "ALL")[0] for k in range(self._count, total)]
        self.close()
        for name in self._variables() - self._known:
            self._spice.dvpool(name)

    def _variables(self):
        """The names of all variables in the pool."""
        names = set()
        for start in range(0, _MOST, _BATCH):
            try:
                found = self._spice.gnpool("*", start, _BATCH)
            except self._spice.exceptions.NotFoundError:
                break
            names |= set(found)
            if len(found) < _BATCH:
                break
        return names

    def _values(self, name):
        """Type ("N" for numbers, "C" for text) and values of a variable."""
        count, kind = self._spice.dtpool(name)
        get = self._spice.gdpool if kind == "N" else self._spice.gcpool
        return kind, list(get(name, 0, count))

    def _put(self, name, kind, values):
        (self._spice.pdpool if kind == "N" else self._spice.pcpool)(name, values)
