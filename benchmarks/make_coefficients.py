"""Remake every polynomial coefficient and quadrature node of the package with mpmath.

    python benchmarks/make_coefficients.py      # 10 s

It prints, for each table, the file, the definition, the largest error with the stored doubles, and
whether they are the doubles that this script computes.  The largest error is found over the whole
interval in 60 digits.  A least-maximum polynomial is found by Remez's exchange and then rounded
coefficient by coefficient: the rounding of its first coefficients dominates the error.  Its last
coefficients can differ in many places; the difference of the polynomials is printed then.

The exit status is 1 if a comment states a bound that does not hold, or if doubles differ that must
be equal.
"""

import sys
import time
from pathlib import Path

from mpmath import mp

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks.coefficients import motion, numbers, polynomials, schemes

# Measured or adopted numbers, which cannot be computed.
MEASURED = {
    # rational numbers as Dormand & Prince printed them
    ("averaged/_rates.py", "error_of"),
    ("averaged/_rates.py", "keep_terms"),
    ("averaged/_rates.py", "slopes"),
    ("frames/_earth.py", "_B1950"),
    ("paths/_ground.py", "RATE"),
    ("paths/_ground.py", "rotation_angle"),
    ("paths/_two_body.py", "GM"),
    ("_support/constants.py", "EARTH_FLATTENING"),
    ("scene/_scene.py", "_OF_ORBIT"),
    ("torques/_magnetic.py", "_MU_0_OVER_4_PI"),
}


def tables():
    return [*polynomials.tables(), *motion.tables(), *numbers.tables(), *schemes.tables()]


def main():
    start = time.perf_counter()
    broken, every = 0, sorted(tables(), key=lambda table: table.file)
    for table in every:
        measured = table.measure()
        print(f"attitude/{table.file}: {table.name}\n  {table.definition}\n  {_line(measured)}")
        for claim in table.claims:
            print(f'  stated: "{claim.sentence}"')
        for sentence in table.broken_claims(measured):
            broken += 1
            print(f"  WRONG: {sentence}")
        print()
    print(f"{len(every)} tables, {broken} wrong; {time.perf_counter() - start:.0f} s")
    return 1 if broken else 0


def _line(measured):
    line = f"largest error {mp.nstr(measured.stored, 3)}"
    if measured.exact > 0:
        line += f", {mp.nstr(measured.exact, 3)} before rounding"
    if measured.ideal is not None:
        line += f", {mp.nstr(measured.ideal, 3)} by the best polynomial of that degree"
    different = sum(1 for n in measured.ulps if n)
    if not different:
        return f"{line}\n  all doubles are equal to those recomputed"
    farthest = max(map(abs, measured.ulps))
    line += (
        f"\n  {different} of {len(measured.ulps)} doubles differ from those recomputed, by up to "
        f"{farthest} ulps; largest error with those {mp.nstr(measured.remade, 3)}"
    )
    if measured.difference is not None:
        line += f"; the polynomials differ by {mp.nstr(measured.difference, 2)}"
    return line


if __name__ == "__main__":
    sys.exit(main())
