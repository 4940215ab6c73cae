"""What does a light-curve plugin of a survey simulation cost an object?

    python benchmarks/survey.py

CPU time of ``compute`` of the class for sorcha, on a table as sorcha gives it: 5000 objects at 160
visits, with the parameters of the object repeated in each row.  It needs the extra ``sorcha``.
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from attitude._compilation.choice import compiling
from attitude.motions._published import longest_P_phi
from benchmarks.doc_tables import Table, markdown

OBJECTS = 5000
VISITS = 160
MAKES = ("survey",)
NEEDS = ("pandas", "sorcha")


def tables(quick):
    """The table of docs/survey.md."""
    found = {f"{name} ellipsoids": cost for name, cost in measured()}
    head = "an object at 160 rows, all that `compute` does (pandas columns, grouping, light time)"
    rows = [(name, f"{cost * 1e6:.0f}") for name, cost in found.items()]
    costs = {name: cost * 1e9 for name, cost in found.items()}
    yield Table("survey", markdown((head, "µs"), rows), costs=costs)


def main():
    for kind, cost in measured():
        print(f"{kind:10}{cost * 1e6:8.1f} us an object, {cost / VISITS * 1e9:6.1f} ns a row")


def measured():
    """Kinds of objects, and seconds for one of them."""
    from attitude.survey import LightCurve

    for kind in ("relaxed", "tumbling"):
        rows = observations(parameters(kind == "relaxed"))
        found = []
        for _ in range(8):
            start = time.process_time()
            LightCurve().compute(rows)
            found.append(time.process_time() - start)
        yield kind, min(found) / OBJECTS


def parameters(relaxed):
    """The table of parameters of the objects."""
    import pandas

    random = np.random.default_rng(1)
    b, c = random.uniform(0.6, 1.0, OBJECTS), random.uniform(0.4, 0.6, OBJECTS)
    table = {
        "ObjID": [f"S{k:07d}a" for k in range(OBJECTS)],
        "axis_a": np.ones(OBJECTS),
        "axis_b": b,
        "axis_c": c,
        "pole_lon_deg": random.uniform(0.0, 360.0, OBJECTS),
        "pole_lat_deg": random.uniform(-90.0, 90.0, OBJECTS),
        "phi0_deg": random.uniform(0.0, 360.0, OBJECTS),
        "spin_epochMJD_TDB": np.full(OBJECTS, 60000.0),
    }
    if relaxed:
        return pandas.DataFrame({**table, "period_h": random.uniform(2.2, 50.0, OBJECTS)})
    P_psi = random.uniform(90.0, 100.0, OBJECTS)
    longest = [
        longest_P_phi(np.sort((y * y + z * z, 1.0 + z * z, 1.0 + y * y)), "SAM", "S", period)
        for y, z, period in zip(b, c, P_psi, strict=True)
    ]
    return pandas.DataFrame(
        {
            **table,
            "mode": "SAM",
            "convention": "S",
            "psi0_deg": random.uniform(0.0, 360.0, OBJECTS),
            "P_psi_h": P_psi,
            "P_phi_h": np.array(longest) * random.uniform(0.5, 0.99, OBJECTS),
        }
    )


def observations(table):
    """The rows of all objects at all visits, with twenty columns that are not read."""
    import pandas

    random = np.random.default_rng(2)
    count = OBJECTS * VISITS
    rows = table.loc[np.repeat(np.arange(OBJECTS), VISITS)].reset_index(drop=True)
    sun, own = random.normal(size=(2, count, 3))
    sun *= 4e8 / np.linalg.norm(sun, axis=1)[:, None]
    own *= 1.5e8 / np.linalg.norm(own, axis=1)[:, None]
    more = {f"Obj_Sun_{axis}_LTC_km": sun[:, k] for k, axis in enumerate("xyz")}
    more |= {f"Obs_Sun_{axis}_km": own[:, k] for k, axis in enumerate("xyz")}
    more["fieldMJD_TAI"] = np.tile(np.sort(random.uniform(60200.0, 63800.0, VISITS)), OBJECTS)
    more["Range_LTC_km"] = np.linalg.norm(sun - own, axis=1)
    more |= {f"unread_{k}": np.zeros(count) for k in range(20)}
    return pandas.concat([rows, pandas.DataFrame(more)], axis=1)


if __name__ == "__main__":
    with compiling():
        main()
