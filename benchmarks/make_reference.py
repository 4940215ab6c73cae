"""Write attitude/reference/states.json, the stored answers of `attitude check`.

    python benchmarks/make_reference.py

It contains two states of every family of tests/support/states.py at 10, 1e3, 1e6 and 1e9
revolutions, with answers to 30 digits by the mpmath oracle of tests/support/oracle.py.
"""

import json
import sys
from pathlib import Path

from mpmath import mp

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.support import oracle, states

ABOUT = (
    "States of every regime and exact answers: doubles as hexadecimal text, answers to 30 digits, "
    "by benchmarks/make_reference.py with the mpmath oracle of the tests. wxyz is body to "
    "inertial, scalar first; omega rad/s in body axes; t seconds."
)


def main():
    entries = [entry(state) for state in states.sample(2, seed=30)]
    target = ROOT / "attitude" / "reference" / "states.json"
    lines = ",\n".join(json.dumps(each) for each in entries)
    target.write_text(f'{{"_about": {json.dumps(ABOUT)},\n"states": [\n{lines}\n]}}\n', "utf-8")
    print(f"{target.relative_to(ROOT)}: {len(entries)} states, {target.stat().st_size} bytes")


def entry(state):
    exact = oracle.Oracle(state.moments, state.wxyz0, state.omega0)
    t = [sign * x for x, sign in zip(states.epochs(state)[::2], (1, -1, 1, -1), strict=True)]
    answers = [exact.at(x) for x in t]
    return {
        "family": state.family,
        "moments": [x.hex() for x in state.moments],
        "wxyz0": [x.hex() for x in state.wxyz0],
        "omega0": [x.hex() for x in state.omega0],
        "t": [x.hex() for x in t],
        "wxyz": [[mp.nstr(x, 30) for x in wxyz] for wxyz, _ in answers],
        "omega": [[mp.nstr(x, 30) for x in omega] for _, omega in answers],
    }


if __name__ == "__main__":
    main()
