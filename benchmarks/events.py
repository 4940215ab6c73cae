"""Does the search miss an event that samples show, and what does it cost?

Random tumblers of several kinds turn for ten thousand rotations.  The search covers four
conditions at once: a direction in a wide and in a narrow cone, a facet that is lit, a glint of the
Sun's disc.  The same conditions are evaluated, by other formulas, at samples every 1e-4 rad of
rotation: each change between two samples must be an event of the search, and each single event
between two samples must be such a change.  It prints the number of missed events (0 is required),
the number of pairs of events between two samples, which samples cannot show, and the time.

    python benchmarks/events.py [--quick] [--tumblers 0:100] [--rotations 10000] [--step 1e-4]

The full run samples 6e10 attitudes, a quarter of an hour on one core; --quick a thousandth of them.
"""

import argparse
import sys
import time
from pathlib import Path
from random import Random

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from attitude import Body, FreeRotation, Spin, events
from attitude._compilation.choice import compiling
from attitude._compilation.decorators import entry_point
from benchmarks.doc_tables import Table, markdown
from tests.support import states

KINDS = ("tumbling", "near_separatrix", "wobble", "near_symmetric", "needle", "spinning_needle")
# Half angles of the cones about an axis that the Sun and the observer cross, rad.
WIDE = 0.5
NARROW = 0.02
MAKES = ("events",)


def tables(quick):
    """The table of docs/events.md, in a quarter of an hour."""
    if quick:
        return
    count, rotations, step = 100, 1e4, 1e-4
    compare(0, 1, 1e-3)  # compiles
    total = np.sum([compare(number, rotations, step) for number in range(count)], axis=0)
    turn = total[4] / rotations / count
    head = (
        *("tumblers", "rotations of each", "samples", "events found"),
        *("changes between samples", "missed", "us a rotation, four conditions"),
    )
    row = (
        count,
        f"{rotations:.0e}",
        f"{count * rotations * 2.0 * np.pi / step:.1e}",
        f"{total[0]:,.0f}",
        f"{total[1]:,.0f}",
        f"{total[2]:.0f}",
        f"{turn * 1e6:.0f}",
    )
    yield Table("events", markdown(head, [row]), costs={"a rotation": turn * 1e9})


_CHUNK = 1 << 14
# Events this near to a sample, rad, can be on its other side by the other formulas.
_ROUNDING = 1e-7


def tumbler(number):
    """Motion, body axis, normal, and directions to Sun and observer."""
    random = Random(f"events {number}")
    state = states.draw(KINDS[number % len(KINDS)] if number % 2 else "tumbling", random)
    spin = Spin(epoch="2026-01-01", wxyz=state.wxyz0, angular_velocity=state.omega0)
    motion = FreeRotation(Body(moments=state.moments), spin)
    return motion, *(_unit([random.gauss(0, 1) for _ in range(3)]) for _ in range(4))


def searched(motion, axis, normal, sun, observer, span):
    conditions = [
        events.in_cone(motion, axis, sun, WIDE),
        events.in_cone(motion, axis, observer, NARROW),
        events.illuminated(motion, normal, sun),
        events.glint(motion, normal, sun, observer),
    ]
    begin = time.perf_counter()
    found = events.find_discrete(0.0, span, conditions)
    return found, time.perf_counter() - begin


@entry_point
def sampled(wxyz, vectors, limits, states):
    """The conditions that hold at each sample, one bit for each."""
    axis, normal, sun, observer = vectors[0], vectors[1], vectors[2], vectors[3]
    for i in range(wxyz.shape[1]):
        w, x, y, z = wxyz[0, i], wxyz[1, i], wxyz[2, i], wxyz[3, i]
        # Entries of the matrix from body to inertial axes.
        xx, xy, xz = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
        yx, yy, yz = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
        zx, zy, zz = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
        a0 = xx * axis[0] + xy * axis[1] + xz * axis[2]
        a1 = yx * axis[0] + yy * axis[1] + yz * axis[2]
        a2 = zx * axis[0] + zy * axis[1] + zz * axis[2]
        n0 = xx * normal[0] + xy * normal[1] + xz * normal[2]
        n1 = yx * normal[0] + yy * normal[1] + yz * normal[2]
        n2 = zx * normal[0] + zy * normal[1] + zz * normal[2]
        to_sun = n0 * sun[0] + n1 * sun[1] + n2 * sun[2]
        to_observer = n0 * observer[0] + n1 * observer[1] + n2 * observer[2]
        wide = a0 * sun[0] + a1 * sun[1] + a2 * sun[2] > limits[0]
        narrow = a0 * observer[0] + a1 * observer[1] + a2 * observer[2] > limits[1]
        mirrored = 2.0 * to_observer * to_sun - limits[3] > limits[2]
        bright = mirrored & (to_observer > 0.0)
        states[i] = wide + 2.0 * narrow + 4.0 * (to_sun > 0.0) + 8.0 * bright


@entry_point
def changed(states, last, changes):
    """Fill changes: 4 times the number of the later sample, plus the number of the condition."""
    count = 0
    for i in range(len(states)):
        if states[i] != last:
            bits = int(states[i]) ^ int(last) if last >= 0.0 else 0
            last = states[i]
            for k in range(4):
                if bits >> k & 1:
                    changes[count] = 4 * i + k
                    count += 1
    return count, last


def compare(number, rotations, step):
    """Counts of events, of changes between samples, missed, pairs between samples; seconds."""
    motion, axis, normal, sun, observer = tumbler(number)
    rate = motion.regime.mean_spin_rate
    dt = step / rate
    total = int(2.0 * np.pi * rotations / step)
    found, cost = searched(motion, axis, normal, sun, observer, total * dt)
    given = np.stack([axis, normal, sun, observer])
    radius = np.cos(events.SUN_RADIUS)
    limits = np.array([np.cos(WIDE), np.cos(NARROW), radius, sun @ observer])
    changes, last, seen = np.empty(4 * _CHUNK, np.int64), -1.0, []
    states = np.empty(_CHUNK)
    for begin in range(0, total + 1, _CHUNK):
        i = np.arange(begin, min(begin + _CHUNK, total + 1))
        wxyz = motion.at(i * dt).wxyz.T
        sampled(wxyz, given, limits, states[: len(i)])
        count, last = changed(states[: len(i)], last, changes)
        seen.append(changes[:count] + 4 * begin)
    seen = np.sort(np.concatenate(seen))
    place = found.seconds / dt
    bins, counts = np.unique(4 * np.ceil(place).astype(np.int64) + found.which, return_counts=True)
    odd = bins[counts % 2 == 1]
    # The differences of the two lists, except events within rounding of a sample.
    near = np.abs(place - np.rint(place)) * step < _ROUNDING
    near = np.unique(
        np.concatenate(
            [4 * (np.rint(place[near]).astype(np.int64) + d) + found.which[near] for d in (0, 1)]
        )
    )
    missed = np.setdiff1d(np.setdiff1d(seen, odd), near)
    wrong = np.setdiff1d(np.setdiff1d(odd, seen), near)
    return len(found), len(seen), len(missed) + len(wrong), int(np.sum(counts // 2)), cost


def _unit(vector):
    return np.array(vector) / np.sqrt(np.dot(vector, vector))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="10 tumblers, 100 rotations")
    parser.add_argument("--tumblers", default="0:100", help="which of them, first:last")
    parser.add_argument("--rotations", type=float, default=1e4)
    parser.add_argument("--step", type=float, default=1e-4, help="rad of rotation")
    chosen = parser.parse_args()
    if chosen.quick:
        chosen.tumblers, chosen.rotations = "0:10", 100.0
    compare(0, 1, 1e-3)  # compiles
    first, last = (int(part) for part in chosen.tumblers.split(":"))
    print("tumbler     events    by samples     missed    pairs between samples    us a rotation")
    total = np.zeros(5)
    for number in range(first, last):
        row = compare(number, chosen.rotations, chosen.step)
        total += row
        cost = row[4] / chosen.rotations * 1e6
        print(f"{number:7d} {row[0]:10d} {row[1]:14d} {row[2]:9d} {row[3]:24d} {cost:16.1f}")
    rotations = chosen.rotations * (last - first)
    print(
        f"{'all':>7s} {total[0]:10.0f} {total[1]:14.0f} {total[2]:9.0f} {total[3]:24.0f} "
        f"{total[4] / rotations * 1e6:16.1f}"
    )
    return 1 if total[2] else 0


if __name__ == "__main__":
    with compiling():
        sys.exit(main())
