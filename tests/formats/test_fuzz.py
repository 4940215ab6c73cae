"""Readers of mutated files: an answer or an AttitudeError, never another exception, no hang."""

import json
import re
import time
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from attitude import AttitudeError, Body, FreeRotation, Spin, paths, shape
from attitude.formats import aem, apm, damit, detect, mission, spin_file, stk, tables
from tests.support.fuzzing import LONGEST_SENTENCE
from tests.support.places import DATA as INPUT
from tests.support.places import TEST_DATA as DATA

# A warning of the rates of version 1 is no exception of another type.
pytestmark = pytest.mark.filterwarnings("ignore::attitude.errors.AttitudeWarning")
PATHS = INPUT / "paths"
SPIN = Spin(epoch="2016-12-31T23:59:50", wxyz=(1, 2, 3, 4), angular_velocity=(0.01, 0.15, 0.01))
MOTION = FreeRotation(Body(moments=(10, 20, 26)), SPIN)
HISTORY = MOTION.at(np.arange(12) / 3.0)
# What breaks number and date parsers, keyword tables and line counts.
NASTY = [
    *(b"nan", b"inf", b"-1e999", b"1e-400", b"1_0", b"0x10", b"", b"=", b"\n\n", b"\r\n"),
    *(b"META_START\n", b"META_STOP\n", b"DATA_STOP\n", b"DATA_START\n", b"COMMENT x\n", b"</data>"),
    *(b"2026-02-30T00:00:00", b"0000-01-01T00:00:00", b"9999-12-31T23:59:60", b"2026-366T0:0:0"),
    *(b"\x00", b"\xff", b"\xef\xbb\xbf", b"&amp;", b"&x;", b"<!DOCTYPE a>", b"]]>", b"<![CDATA["),
    *(b"SPIN/NUTATION", b"EULER_ANGLE/RATE", b"QUATERNION/DERIVATIVE", b"ITRF", b"LVLH", b"FIRST"),
    *(b"1e308", b"-0", b"99999999999999999999", b"\xd9\xa3", "²".encode(), b" " * 300, b"UT1"),
    *(b"Q" * 7000, b"Q," * 3000, b"Q = " * 2000, b"7" * 5000, b"=" * 7000, b"<" + b"a" * 7000),
    *(b"TCB", b"UTC", b"321", b"[rad]", b"9" * 400, b"END Attitude\n", b"Sequence 313\n"),
]
_ELEMENTS = {
    **{"OBJECT_NAME": "ENVISAT", "OBJECT_ID": "2002-009A", "EPOCH": "2013-10-23T03:58:20.413"},
    **{"MEAN_MOTION": "14.37637337", "ECCENTRICITY": "0.0001126", "INCLINATION": "98.4160"},
    **{"RA_OF_ASC_NODE": "1.9229", "ARG_OF_PERICENTER": "79.5538", "MEAN_ANOMALY": "280.5787"},
    **{"NORAD_CAT_ID": "27386", "BSTAR": "0.000047533"},
}
OMM = {
    "omm": "CCSDS_OMM_VERS = 2.0\n" + "".join(f"{k} = {v}\n" for k, v in _ELEMENTS.items()),
    "omm xml": "<omm><segment>\n"
    + "".join(f"<{k}>{v}</{k}>\n" for k, v in _ELEMENTS.items())
    + "</segment></omm>\n",
    "omm json": json.dumps([_ELEMENTS], indent=1),
    "omm csv": ",".join(_ELEMENTS) + "\n" + ",".join(_ELEMENTS.values()) + "\n",
}
MISSION = (PATHS.parent / "mission" / "apophis-2012.toml").read_text("utf-8")
MISSION = MISSION.replace("../paths", PATHS.as_posix())
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


@cache
def samples():
    """Name -> (bytes, ending)."""
    import tempfile

    found = {}
    with tempfile.TemporaryDirectory() as folder:

        def keep(name, ending, write, *arguments, **how):
            path = Path(folder) / f"{name}.{ending}"
            write(path, *arguments, **how)
            found[name] = path.read_bytes(), ending

        keep("aem 2", "aem", aem.write, HISTORY)
        keep("aem 1", "aem", aem.write, [HISTORY[:5], HISTORY[6:]], version="1.0")
        keep("aem spin", "aem", aem.write, HISTORY, kind="SPIN/NUTATION")
        keep("aem nutation", "aem", aem.write, HISTORY, kind="SPIN/NUTATION_MOM")
        keep("toml", "toml", spin_file.write, MOTION, note="tumbler")
        keep("aem euler", "aem", aem.write, HISTORY, kind="EULER_ANGLE/DERIVATIVE")
        keep("aem xml", "xml", aem.write, HISTORY[:4], xml=True)
        keep("aem xml 1", "xml", aem.write, HISTORY[:3], xml=True, version="1.0", scalar_first=True)
        keep("apm", "apm", apm.write, MOTION)
        keep("apm xml", "xml", apm.write, MOTION, xml=True)
        keep("apm xml 1", "xml", apm.write, MOTION, xml=True, version="1.0")
        keep("stk", "a", stk.write, HISTORY)
        keep("stk euler", "a", stk.write, HISTORY, section="AttitudeTimeEulerAngles")
        keep("csv", "csv", tables.write, HISTORY)
        if find_spec("pyarrow"):
            keep("parquet", "parquet", tables.write, HISTORY[:4])
        keep("ecsv", "ecsv", tables.write, HISTORY[:4])
        keep("fits", "fits", tables.write, HISTORY[:4])
        spin = Spin(epoch="2026-01-01", wxyz=(1, 2, 3, 4), angular_velocity=(0, 0, 1e-3))
        keep("damit", "spin", damit.write, FreeRotation(Body(moments=(1, 2, 2.5)), spin))
        for name, fields in OMM.items():
            found[name] = fields.encode(), "omm"
        for name in ("apophis-2029-encounter.oem", "envisat-2013.tle"):
            rows = (PATHS / name).read_bytes().splitlines(keepends=True)[:60]
            found[name] = b"".join(rows), name[-3:]
        found["mission"] = MISSION.encode(), "mission"
        found["obj"] = OBJ.encode(), "obj"
        for name in ("two-segments.aem", "ccsds/aem-g5.txt", "ccsds/apm-g3.txt", "spinner-1.apm"):
            found[name] = (DATA / name).read_bytes(), name[-3:]
    return found


NAMES = [
    *("aem 2", "aem 1", "aem spin", "aem euler", "aem xml", "aem xml 1", "apm", "apm xml"),
    *("apm xml 1", "stk", "stk euler", "csv", "ecsv", "fits", "damit", "two-segments.aem"),
    *("ccsds/aem-g5.txt", "ccsds/apm-g3.txt", "spinner-1.apm", "toml", "aem nutation", "parquet"),
    *("omm", "omm xml", "omm json", "omm csv", "obj", "mission"),
    *("apophis-2029-encounter.oem", "envisat-2013.tle"),
]
READERS = {
    "mission": mission.read,
    "omm": paths.omm,
    "oem": paths.oem,
    "tle": paths.tle,
    "obj": shape.read,
}


# The inertia of apm-g3 is over other axes than the attitude, so that it holds no motion.
@pytest.mark.parametrize("name", [name for name in NAMES if name != "ccsds/apm-g3.txt"])
def test_files_are_read_before_they_are_mutated(tmp_path, name):
    if name not in samples():
        pytest.skip("pyarrow is not installed")
    data, ending = samples()[name]
    path = tmp_path / f"whole.{ending}"
    path.write_bytes(data)
    READERS.get(ending, detect.read)(path)


@pytest.mark.parametrize(
    ("name", "old", "sentence"),
    [
        ("aem 2", "ORIGINATOR", "is no .KEYWORD = value"),
        ("aem xml", "ORIGINATOR", "is longer than|not well-formed"),
        ("apm", "QUAT_START", "is not known; blocks are|is no .KEYWORD"),
        ("apm", "ORIGINATOR", "is no .KEYWORD = value"),
        ("apophis-2029-encounter.oem", "REF_FRAME", "is no .KEYWORD = value"),
        ("envisat-2013.tle", "27386U", "characters, not 69"),
        ("omm csv", "98.4160", "cannot be read"),
        ("obj", "usemtl", "is no statement of a polygon mesh"),
        ("obj", "f 1 3", "is no vertex number"),
        ("obj", "1 0 0", "are not numbers"),
        ("mission", "scattering", "has a key"),
        ("mission", "reduced", "kind is"),
        ("mission", '{ oem = "', "is not a file"),
        ("toml", "moments", "has a key"),
        ("csv", "omega_x", "the first line names"),
    ],
)
@pytest.mark.parametrize("long", ["x" * 7000, "x " * 5000], ids=["word", "words"])
def test_sentences_quote_little_of_the_file(tmp_path, name, old, sentence, long):
    data, ending = samples()[name]
    assert old.encode() in data
    path = tmp_path / f"a.{ending}"
    path.write_bytes(data.replace(old.encode(), (old + long).encode(), 1))
    with pytest.raises(AttitudeError) as raised:
        READERS.get(ending, detect.read)(path)
    said = str(raised.value).replace(str(path), "").replace(str(tmp_path), "")
    assert len(said) <= LONGEST_SENTENCE and long[:121] not in said
    if " " not in long:
        assert re.search(sentence, said)


@st.composite
def mutations(draw):
    """A function from bytes to other bytes."""
    steps = draw(
        st.lists(
            st.tuples(
                st.sampled_from(["flip", "cut", "drop", "repeat", "insert", "replace", "lines"]),
                st.floats(0.0, 1.0, exclude_max=True),
                st.floats(0.0, 1.0, exclude_max=True),
                st.integers(0, 255),
                st.sampled_from(NASTY),
            ),
            min_size=1,
            max_size=4,
        )
    )

    def mutated(data):
        for kind, first, second, byte, nasty in steps:
            data = _mutated(data, kind, first, second, byte, nasty)
        return data

    return mutated


def _mutated(data, kind, first, second, byte, nasty):
    place = int(first * len(data))
    length = 1 + int(second * 40)
    if kind == "flip":
        return data[:place] + bytes([byte]) + data[place + 1 :]
    if kind == "cut":
        return data[:place]
    if kind == "drop":
        return data[:place] + data[place + length :]
    if kind == "repeat":
        return data[: place + length] + data[place:]
    if kind == "insert":
        return data[:place] + nasty + data[place:]
    if kind == "replace":  # a whole word
        words = data.split(b" ")
        words[int(first * len(words))] = nasty
        return b" ".join(words)
    lines = data.split(b"\n")
    i, j = int(first * len(lines)), int(second * len(lines))
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def hunted(tmp_path, name, mutation):
    if name not in samples():
        pytest.skip("pyarrow is not installed")
    data, ending = samples()[name]
    path = tmp_path / f"mutated.{ending}"
    path.write_bytes(mutation(data))
    start = time.process_time()
    try:
        found = READERS.get(ending, detect.read)(path)
        if ending not in READERS:
            found.at(found.history.time[:1] if hasattr(found, "history") else 0.0)
    except AttitudeError as err:
        assert 0 < len(str(err).replace(str(path), "")) <= LONGEST_SENTENCE
    assert time.process_time() - start < 20.0  # of processor, which compiles in the first read


@pytest.mark.parametrize("name", NAMES)
@settings(
    max_examples=40,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(mutation=mutations())
def test_mutated_files(tmp_path, name, mutation):
    hunted(tmp_path, name, mutation)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
@settings(
    max_examples=400,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(mutation=mutations())
def test_many_mutated_files(tmp_path, name, mutation):
    hunted(tmp_path, name, mutation)


@settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(data=st.binary(max_size=400), ending=st.sampled_from([*detect.ENDINGS, ".txt"]))
def test_any_bytes(tmp_path, data, ending):
    path = tmp_path / f"any{ending}"
    path.write_bytes(data)
    if ending == ".bc" or data.startswith(b"DAF/CK"):
        return
    try:
        detect.read(path)
    except AttitudeError as err:
        assert str(err)
