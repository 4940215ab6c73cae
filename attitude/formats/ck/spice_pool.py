"""SPICE's pool of kernels, left as it was found.

SPICE has one pool for the whole process, in which the user's kernels and variables are too.  Two
of its habits ask for care.  `unload` takes away the last instance of a name, so that to unload
once too often is to unload what the user has loaded.  And with a text kernel it forgets all
variables that were set by program (pdpool and the like): these are put back here.
"""

import os

from attitude.errors import AttitudeError
from attitude.formats.ck import daf_head
from attitude.textfiles.lines import unreadable

# Names of variables that are asked for at a time, and more than SPICE's pool has room for.
_ROOM, _MOST = 500, 100_000


def spiceypy():
    """The module; AttitudeError where it is not installed."""
    try:
        import spiceypy
    except ImportError as err:
        raise AttitudeError(
            'CK needs SPICE; install it with pip install "attitude-propagation[spice]".'
        ) from err
    return spiceypy


class Loaded:
    """Some kernels in the pool, until `close` or the end of a ``with`` block.

    Raises
    ------
    AttitudeError
        For a kernel that SPICE does not take; none of them stays loaded.
    """

    def __init__(self, names):
        self._spice = spiceypy()
        self._count = self._spice.ktotal("ALL")
        self._known = self._variables()
        self._own = set()
        self._names = []
        for name in map(os.fspath, names):
            self._refuse_broken(name)
            try:
                self._spice.furnsh(name)
            except self._spice.exceptions.SpiceyError as err:
                self._spice.reset()
                self._take_back()
                raise AttitudeError(f"SPICE cannot load {name}: {err.short}.") from err
            self._names.append(name)
        self._own = self._variables() - self._known

    def close(self):
        """Unload what was loaded, and nothing else; a second time does nothing."""
        names, self._names = self._names, []
        if not names:
            return
        held = {name: self._values(name) for name in self._variables() - self._own}
        for name in reversed(names):
            self._spice.unload(name)
        for name in held.keys() - self._variables():
            self._put(name, held[name])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _refuse_broken(self, name):
        """Such as SPICE would not survive."""
        try:
            broken = daf_head.fault(name)
        except OSError as err:
            self._take_back()
            raise unreadable(name, err) from err
        if broken is not None:
            self._take_back()
            raise AttitudeError(f"{name}: it is a broken kernel: {broken}.")

    def _take_back(self):
        """Unload after a failure: a part of a meta-kernel may be loaded, and less be listed."""
        total = self._spice.ktotal("ALL")
        self._names = [self._spice.kdata(k, "ALL")[0] for k in range(self._count, total)]
        self.close()
        for name in self._variables() - self._known:
            self._spice.dvpool(name)

    def _variables(self):
        """The names of all variables in the pool."""
        names = set()
        for start in range(0, _MOST, _ROOM):
            try:
                found = self._spice.gnpool("*", start, _ROOM)
            except self._spice.exceptions.NotFoundError:
                break
            names |= set(found)
            if len(found) < _ROOM:
                break
        return names

    def _values(self, name):
        count, kind = self._spice.dtpool(name)
        get = self._spice.gdpool if kind == "N" else self._spice.gcpool
        return kind, list(get(name, 0, count))

    def _put(self, name, held):
        kind, values = held
        (self._spice.pdpool if kind == "N" else self._spice.pcpool)(name, values)
