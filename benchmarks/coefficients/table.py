"""A table of numbers of the package: its definition, how to recompute it, and its largest error."""

import struct
from collections.abc import Callable
from dataclasses import dataclass

from mpmath import mp, mpf

from benchmarks.coefficients import sources

# Decimal digits of all recomputed numbers.
PRECISION = 60
# Polynomials with values of about 1 that differ by less are the same: a thousandth of an ulp.
SAME = 1e-19


@dataclass(frozen=True)
class Claim:
    """A bound that a comment states, in the words of the source.

    `truncation`: the comment means what the formula leaves out, before its numbers are rounded.
    """

    bound: float
    sentence: str
    truncation: bool = False


@dataclass(frozen=True)
class Measured:
    """Largest errors: of the stored doubles, of those remade, of the exact numbers, of the best.

    `ulps`: how far stored and remade doubles are apart; `difference`: the two polynomials.
    """

    stored: mpf
    remade: mpf
    exact: mpf
    ideal: mpf | None
    ulps: tuple[int, ...]
    difference: mpf | None


@dataclass(frozen=True)
class CoefficientTable:
    """Numbers of one file below the package.

    Attributes
    ----------
    file : str
    owners : tuple of str
        The module-level names that hold the numbers, or the function in which they are literals.
    definition : str
        What the numbers are, and for approximations: of what, where, and in which sense.
    read : callable
        The stored doubles, a flat list.
    remake : callable
        The numbers in high precision.
    pairs : bool
        Whether two stored doubles make one number.
    apart : int
        By how many ulps doubles may differ from those remade.
    difference : callable, optional
        The largest difference of two polynomials.  It decides, and not the ulps, where an exchange
        that was stopped earlier gives other last digits of the highest coefficients.
    error : callable, optional
        The largest error with given numbers; without it, their largest relative error.
    ideal : callable, optional
        The least largest error of any polynomial of that degree.
    claims : tuple of Claim
    """

    file: str
    owners: tuple[str, ...]
    definition: str
    read: Callable[[], list]
    remake: Callable[[], list]
    pairs: bool = False
    apart: int = 0
    difference: Callable[[list, list], mpf] | None = None
    error: Callable[[list], mpf] | None = None
    ideal: Callable[[], mpf] | None = None
    claims: tuple[Claim, ...] = ()

    def measure(self):
        with mp.workdps(PRECISION):
            exact = [mp.mpmathify(x) for x in self.remake()]
            stored, remade = self.read(), self._rounded(exact)
            if len(stored) != len(remade):
                raise ValueError(
                    f"{self.name} has {len(stored)} numbers, {len(remade)} were remade; give the "
                    "script the definition of all of them."
                )
            error = self.error or (lambda numbers: _relative(numbers, exact))
            return Measured(
                error(self._values(stored)),
                error(self._values(remade)),
                error(exact),
                self.ideal() if self.ideal else None,
                tuple(ulps(a, b) for a, b in zip(stored, remade, strict=True)),
                self.difference(stored, remade) if self.difference else None,
            )

    @property
    def name(self):
        if len(self.owners) > 4:
            return f"{self.owners[0]} ... {self.owners[-1]}"
        return ", ".join(self.owners)

    def broken_claims(self, measured):
        """Sentences for what a measurement contradicts."""
        found = []
        for claim in self.claims:
            error = measured.exact if claim.truncation else measured.stored
            if error > claim.bound:
                found.append(f'the error is {mp.nstr(error, 3)}: "{claim.sentence}"')
            if claim.sentence not in sources.prose(self.file):
                found.append(f'the file does not say "{claim.sentence}"')
        farthest = max(map(abs, measured.ulps))
        if self.difference is None and farthest > self.apart:
            found.append(f"doubles differ by {farthest} ulps")
        if self.difference is not None and measured.difference > SAME:
            found.append(f"the polynomials differ by {mp.nstr(measured.difference, 3)}")
        return found

    def _rounded(self, numbers):
        if not self.pairs:
            return [float(x) for x in numbers]
        return [half for x in numbers for half in (float(x), float(x - mpf(float(x))))]

    def _values(self, doubles):
        if not self.pairs:
            return [mpf(x) for x in doubles]
        halves = zip(doubles[::2], doubles[1::2], strict=True)
        return [mpf(high) + mpf(low) for high, low in halves]


def ulps(a, b):
    """How many doubles lie from b to a."""
    return _rank(a) - _rank(b)


def _rank(x):
    bits = struct.unpack("<q", struct.pack("<d", x))[0]
    return bits if bits >= 0 else -(bits & (2**63 - 1))


def _relative(numbers, exact):
    return max(abs(x - y) / (abs(y) or 1) for x, y in zip(numbers, exact, strict=True))
