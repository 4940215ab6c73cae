"""Paths with different centers joined: where one thing is, seen from another."""

from dataclasses import dataclass

import numpy as np

from attitude.errors import AttitudeError
from attitude.paths.bodies import SSB, body_name
from attitude.paths.path import Path, common_span
from attitude.paths.solar_system import ephemeris


@dataclass(frozen=True, eq=False, repr=False)
class Composed(Path):
    """A sum of paths, each with its sign.  Made by `relative`.

    Attributes
    ----------
    plus, minus : tuples of Path
    name : str
    center : str or Path
    """

    plus: tuple
    minus: tuple
    name: str
    center: object

    @property
    def source(self):
        return ", ".join(dict.fromkeys(part.source for part in self.plus + self.minus))

    @property
    def span(self):
        return common_span(self.plus + self.minus)

    @property
    def roughness(self):
        return sum(part.roughness for part in self.plus + self.minus)

    def _position(self, instant, hi, lo):
        total = np.zeros((3, hi.size))
        for part in self.plus:
            total += part._position(instant, hi, lo)
        for part in self.minus:
            total -= part._position(instant, hi, lo)
        return total

    def _state(self, instant, hi, lo):
        total = np.zeros((2, 3, hi.size))
        for part in self.plus:
            total += part._state(instant, hi, lo)
        for part in self.minus:
            total -= part._state(instant, hi, lo)
        return total[0], total[1]


def relative(target, origin=SSB, ephemeris=None):
    """The path of a target as seen from an origin: target minus origin, geometric.

    Parameters
    ----------
    target, origin : Path, str or int
        Paths, or bodies of the ephemeris by name or NAIF number.
    ephemeris : Ephemeris, path of a kernel, or None
        Where the bodies come from that lead from one to the other, see `ephemeris`.  It is not
        opened if none is needed: a satellite seen from a ground site needs no planets.

    Returns
    -------
    Path
        With ``center`` the origin.  `target` itself, if that is its center already.

    Raises
    ------
    AttitudeError
        If the ephemeris lacks a body that is needed, or a direction is given for a place.

    Notes
    -----
    Steps that both have in common cancel before anything is computed, so that the Moon seen from
    the Earth has no rounding of their distance to the Sun.
    """
    target_chain, origin_chain = _Chain(target, ephemeris), _Chain(origin, ephemeris)
    while True:
        shared = target_chain.meeting(origin_chain)
        if shared is not None:
            break
        # The one that has farther to go first: names lead up to the barycentre.
        if not target_chain.extend() and not origin_chain.extend():
            raise AttitudeError(
                f"no ephemeris leads from {target_chain.start} to {origin_chain.start}; give "
                "paths whose centers are bodies, or each other."
            )
        if target_chain.meeting(origin_chain) is None:
            origin_chain.extend()
    plus, minus = target_chain.parts[: shared[0]], origin_chain.parts[: shared[1]]
    center = origin if isinstance(origin, Path) else body_name(origin)
    if len(plus) == 1 and not minus:
        return plus[0]
    name = target.name if isinstance(target, Path) else body_name(target)
    return Composed(tuple(plus), tuple(minus), name, center)


def body(name, kernel=None, *, center=SSB):
    """The path of a body of the solar system.

    Parameters
    ----------
    name : str or int
        "sun", "moon", "earth", "emb", "mars barycenter", ...; or a NAIF number.
    kernel : path, "builtin", an ephemeris, or None
        See `ephemeris`.
    center : str, int or Path
        What it is relative to; the solar system barycentre if not given.

    Raises
    ------
    AttitudeError
        For a name that is not known, or a body that the ephemeris lacks.

    Notes
    -----
    Positions agree with skyfield and astropy on the same kernel and the same TDB to 0.1 mm at
    1 au and to rounding farther out (2 mm at Neptune).  1e6 epochs of the Earth or the Moon take
    0.06 s, of a planet 0.02 s: there is no need to compress what comes from a kernel.
    """
    return relative(name, center, ephemeris(kernel))


class _Chain:
    """The steps from a path or body towards the solar system barycentre, taken as needed."""

    def __init__(self, start, ephemeris):
        if getattr(start, "is_direction", False):
            raise AttitudeError(
                f"{start!r} is a direction, infinitely far away, and has no position; give a path "
                "for what is at a finite distance."
            )
        if not isinstance(start, Path):
            start = body_name(start)
        self.start = start
        self.ephemeris = ephemeris
        self.places = [start]
        self.parts = []

    def extend(self):
        """Take one more step; False at the barycentre."""
        here = self.places[-1]
        if here == SSB:
            return False
        if isinstance(here, Composed):
            steps = self._opened(here)
        else:
            steps = [here if isinstance(here, Path) else self._ephemeris().step(here)]
        for step in steps:
            self.parts.append(step)
            center = step.center
            self.places.append(center if isinstance(center, Path) else body_name(center))
        return True

    def _opened(self, path):
        # A sum that only goes up can be shortened against the other chain; else it is one step.
        up = not path.minus and all(
            before.center == after.name
            for before, after in zip(path.plus, path.plus[1:], strict=False)
        )
        return list(path.plus) if up else [path]

    def _ephemeris(self):
        self.ephemeris = ephemeris(self.ephemeris)
        return self.ephemeris

    def meeting(self, other):
        """How many steps of each chain lead to the first place they share, or None."""
        for theirs, place in enumerate(other.places):
            for ours, mine in enumerate(self.places):
                if mine is place or (isinstance(mine, str) and mine == place):
                    return ours, theirs
        return None
