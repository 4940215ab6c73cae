"""The AEM, APM and ACM files of Orekit's tests, read here and by Orekit.

    python benchmarks/orekit_files.py FOLDER

FOLDER is src/test/resources/ccsds/adm of a checkout of https://github.com/CS-SI/Orekit.  It prints,
for each kind, how many files are read by both, refused by both or read by one only, and the largest
differences of attitudes (rad) and angular velocities (rad/s).  CENTER_NAME is left out for Orekit,
which needs a planetary ephemeris for it; files whose axes Orekit cannot compute without its data
files are counted apart.
"""

from __future__ import annotations

import re
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

from attitude import AttitudeError, frames
from attitude.formats import acm, aem, apm
from attitude.frames import quaternion
from tests.support import orekit

CENTER = re.compile(r"(?m)^\s*(<CENTER_NAME>.*|CENTER_NAME\s*=.*)\n")
FIXED = ("EME2000", "J2000", "ICRF", "GCRF")
EME2000 = frames.wxyz_to_icrf("eme2000")


def ours(kind: str, path: Path) -> list[tuple[np.ndarray, np.ndarray | None, str]]:
    """Attitudes to ICRF, rates and axes of each part of a file; rates of version 1 as Orekit's."""
    if kind == "apm":
        found = apm.read(path, rates="euler")
        values = [v for block in found.meta["blocks"] for v in block[1].values()]
        frame = next((v for v in values if v.upper() in FIXED), "")
        return [(np.atleast_2d(found.wxyz), found.angular_velocity, frame)]
    if kind == "acm":
        tables = acm.read(path).tables
    else:
        tables, k = [], 0
        while True:
            try:
                tables.append(aem.read(path, rates="euler", segment=k))
            except AttitudeError as err:
                if k and "segment is" in str(err):
                    break
                raise
            k += 1
    return [(t.wxyz, t.angular_velocity, t.meta["frame"]) for t in tables]


def theirs(kind: str, path: Path) -> list[tuple[np.ndarray, np.ndarray]]:
    """Attitudes and rates of each part of a file, as Orekit reads them."""
    if kind == "aem":
        return [(wxyz, rates) for _, wxyz, rates in orekit.segments_of(path)]
    if kind == "apm":
        return [orekit.read_apm(path)[1:]]
    message = orekit.read_acm(path)
    if message.getSegments().get(0).getData().getAttitudeBlocks() is None:
        return []
    return [(wxyz, rates) for _, wxyz, rates in orekit.states_of(message)]


def compared(kind: str, path: Path) -> tuple[str, float, float]:
    """What became of a file, and the largest differences."""
    try:
        mine = ours(kind, path)
    except AttitudeError as err:
        mine = "needs an orbit" if "axes of the orbit" in str(err) else None
    try:
        other = theirs(kind, path)
    except Exception as err:  # exceptions of Java
        text = str(err)
        other = "data" if re.search("ephemerides|EOP|IERS|gyro|Gyro", text) else None
    if isinstance(mine, str) or isinstance(other, str):
        return "not compared: an orbit, or data of Orekit", 0.0, 0.0
    if mine is None or other is None:
        who = {(True, True): "refused by both", (True, False): "read by Orekit only"}
        return who.get((mine is None, other is None), "read here only"), 0.0, 0.0
    off = [0.0, 0.0]
    for (wxyz, rates, frame), (their_wxyz, their_rates) in zip(mine, other, strict=False):
        if frame.upper() not in FIXED:
            continue
        turn = EME2000 if frame.upper() in ("EME2000", "J2000") else np.array([1.0, 0, 0, 0])
        found = quaternion.multiply(turn, their_wxyz)
        sign = np.sign(np.sum(found * wxyz, axis=1))[:, None]
        off[0] = max(off[0], 2.0 * float(np.max(np.abs(found * sign - wxyz))))
        # Of several blocks of an APM Orekit takes the first only, which may have no rates.
        if rates is not None and np.any(their_rates):
            off[1] = max(off[1], float(np.max(np.abs(their_rates - rates))))
    return "read by both", *off


def main() -> None:
    """Compare all files of a folder."""
    warnings.simplefilter("ignore")
    folder = Path(sys.argv[1])
    orekit.context()
    for kind in ("aem", "apm", "acm"):
        outcomes: dict[str, list[str]] = {}
        worst = [0.0, 0.0]
        for path in sorted((folder / kind).iterdir()):
            with tempfile.TemporaryDirectory() as place:
                copy = Path(place) / path.name
                copy.write_text(CENTER.sub("", path.read_text(encoding="utf-8")))
                what, *off = compared(kind, copy)
            outcomes.setdefault(what, []).append(path.name)
            worst = [max(a, b) for a, b in zip(worst, off, strict=True)]
        print(f"{kind}: attitudes within {worst[0]:.1e} rad, rates within {worst[1]:.1e} rad/s")
        for what, names in sorted(outcomes.items()):
            shown = "" if what in ("read by both", "refused by both") else ": " + ", ".join(names)
            print(f"  {len(names):3d} {what}{shown}")


if __name__ == "__main__":
    main()
