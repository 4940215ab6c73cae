"""Files of the readers, and mutations of them, for `test_formats_fuzz_more` and benchmarks."""

import functools
import re
import tempfile
from pathlib import Path

import numpy as np

from attitude import Body, FreeRotation, Spin
from attitude.arcs import Arcs, Impulse
from attitude.formats import acm, aem, apm, cic, stk
from tests.support import photometry_files
from tests.support.places import TEST_DATA as DATA

SPIN = Spin(
    epoch="2016-12-31T23:59:50",
    wxyz=(1, 2, 3, 4),
    angular_velocity=(0.01, 0.15, 0.01),
    covariance={"attitude": 0.01, "angular_velocity": 1e-4},
)
BODY = Body(moments=(10, 20, 26))
# What breaks number and date parsers, keyword tables and line counts.
NASTY = [
    *(b"nan", b"inf", b"-1e999", b"1e-400", b"1_0", b"0x10", b"", b"=", b"\n\n", b"\r\n", b"\t"),
    *(b"META_START\n", b"META_STOP\n", b"DATA_STOP\n", b"DATA_START\n", b"COMMENT x\n", b"</data>"),
    *(b"ATT_START\n", b"ATT_STOP\n", b"COV_STOP\n", b"MAN_START\n", b"PHYS_STOP\n", b"AD_START\n"),
    *(b"SENSOR_START\n", b"<sensor>", b"</att>", b"<attLine>", b"<SENSOR/>", b"<n:att>", b'"'),
    *(b"2026-02-30T00:00:00", b"0000-01-01T00:00:00", b"9999-12-31T23:59:60", b"31 Feb 2026"),
    *(b"\x00", b"\xff", b"\xef\xbb\xbf", b"&amp;", b"&x;", b"<!DOCTYPE a>", b"]]>", b"<![CDATA["),
    *(b"QUATERNION/RATE", b"EULER_ANGLE/RATE", b"GYRO_BIAS", b"EULER_RATE", b"DCM", b"Q_DOT"),
    *(b"ANGLE", b"QUATERNION_ANGVEL", b"TrueOfEpoch", b"UTCG", b"EpDay", b"JDate", b"Inertial"),
    *(b"1e308", b"-0", b"99999999999999999999", b"\xd9\xa3", "²".encode(), b" " * 300, b"UT1"),
    *(
        b"TCB",
        b"TDB",
        b"212",
        b"313",
        b"[rad]",
        b"9" * 400,
        b"END Attitude\n",
        b"TOD",
        b"NSW",
        b"X",
    ),
    *(b"Q" * 7000, b"Q," * 3000, b"7" * 5000, b"7" * 400, b"=1+A1", "é".encode("latin-1")),
]
# Longest sentence of an error without the name of the file, characters.
LONGEST_SENTENCE = 600
_PHOTOMETRY = ("CSV", "ALCDEF", "PSV", "XML", "MPC", "DAMIT")
_STK = {
    "AttitudeTimeYPRAngles": "10 20 30",
    "AttitudeTimeEulerAnglesAndRates": "10 20 30 0.1 0.2 0.3",
    "AttitudeTimeYPRAngleRates": "0.1 0.2 0.3",
    "AttitudeTimeDCMAngVels": "1 0 0 0 1 0 0 0 1 0 0 0.1",
    "AttitudeTimeQuatScalarFirst": "1 0 0 0",
}
# Names of `samples`, which a parametrised test needs before the files are written.
NAMES = (
    *(f"{name}{mark}" for name in ("acm", "acm arcs", "apm") for mark in ("", " xml")),
    *(
        f"rates {kind}/ANGVEL{mark}"
        for kind in ("QUATERNION", "EULER_ANGLE")
        for mark in ("", " xml")
    ),
    *("aem two", "aem xml", "aem qualified", "lenient", "stk", "stk dates", "cic"),
    *(f"photometry {name}" for name in _PHOTOMETRY),
    *(f"stk {section}" for section in _STK),
    *(f"acm {path.name}" for path in (DATA / "orekit").glob("ACMExample*.txt")),
)


def _stk_texts():
    for section, numbers in _STK.items():
        head = [
            *("stk.v.11.0", "BEGIN Attitude", "NumberOfAttitudePoints\t4.000000"),
            *("ScenarioEpoch\t1 July 1999 00:00:00.00", "CentralBody\tEarth", "Sequence 321"),
            *("CoordinateAxes TrueOfEpoch", 'CoordinateAxesEpoch "1 Jan 2000 12:00:00"'),
            *("InterpolationOrder 2", "TimeFormat EpMin", "InitialYPRAngle 321 1 2 3", section),
        ]
        rows = [f"{k}.5 {numbers}" for k in range(4)]
        yield section, "\n".join([*head, *rows, "END Attitude", ""])
    dates = [f"1 Jul 1999 00:0{k}:00.5 0 0 0 1" for k in range(4)]
    head = ["stk.v.11.0", "BEGIN Attitude", "TimeFormat UTCG", "CoordinateAxes Fixed"]
    rows = ["AttitudeTimeQuaternions", *dates, "END Attitude", ""]
    yield "dates", "\n".join([*head, *rows])


@functools.cache
def samples():
    """Name -> (bytes, ending)."""
    found = {}
    motion = FreeRotation(BODY, SPIN)
    history = motion.at(np.arange(12) / 3.0)
    arcs = Arcs(BODY, Spin(SPIN.epoch, SPIN.wxyz, (0.01, 0.15, 0.01)), [Impulse(2.2, (1, 0, 0))])
    with tempfile.TemporaryDirectory() as folder:

        def keep(name, ending, write, *arguments, **how):
            path = Path(folder) / f"x.{ending}"
            write(path, *arguments, **how)
            found[name] = path.read_bytes(), ending

        for xml in (False, True):
            ending, mark = ("xml", " xml") if xml else ("acm", "")
            keep(f"acm{mark}", ending, acm.write, motion, t=np.arange(5.0), xml=xml)
            keep(f"acm arcs{mark}", ending, acm.write, arcs, t=np.arange(5.0), xml=xml)
            for kind in ("QUATERNION/ANGVEL", "EULER_ANGLE/ANGVEL"):
                how = {"version": "1.0", "kind": kind, "rates": "euler", "sequence": "YXY"}
                keep(f"rates {kind}{mark}", "aem", aem.write, history[:5], xml=xml, **how)
            keep(
                f"apm{mark}",
                "xml" if xml else "apm",
                apm.write,
                motion,
                xml=xml,
                version="1.0",
                rates="euler",
            )
        keep("aem two", "aem", aem.write, [history[:5], history[4:9]], frame="TOD")
        keep("aem xml", "xml", aem.write, history[:5], xml=True)
        text = re.sub(rb"<(/?)([a-zA-Z])", rb"<\1n:\2", found["aem xml"][0])
        text = text.replace(b"xmlns:xsi", b'xmlns:n="a" xmlns:xsi', 1)
        found["aem qualified"] = text, "xml"
        keep("lenient", "aem", aem.write, history, frame="MOD")
        gone = rb"(?m)^(OBJECT_ID|START_TIME|DATA_START|DATA_STOP|TIME_SYSTEM).*\n"
        found["lenient"] = re.sub(gone, b"", found["lenient"][0]), "aem"
        keep("cic", "cic", cic.write, history)
        keep("stk", "a", stk.write, history, frame="TrueOfDate")
    for section, text in _stk_texts():
        found[f"stk {section}"] = text.encode(), "a"
    for name in _PHOTOMETRY:
        found[f"photometry {name}"] = getattr(photometry_files, name).encode(), "txt"
    for path in sorted((DATA / "orekit").glob("ACMExample*.txt")):
        found[f"acm {path.name}"] = path.read_bytes(), "acm"
    return found


def mutated(data, random):
    """Other bytes: one to three changes of a file."""
    for _ in range(random.integers(1, 4)):
        data = _changed(data, random)
    return data


def _changed(data, random):
    if not data:
        return data
    place, length = int(random.integers(len(data))), int(random.integers(1, 41))
    nasty = NASTY[random.integers(len(NASTY))]
    kind = random.integers(11)
    if kind == 0:
        return data[:place] + bytes([random.integers(256)]) + data[place + 1 :]
    if kind > 7:  # another digit, or a sign
        digits = [k for k, byte in enumerate(data) if 48 <= byte < 58]
        if not digits:
            return data
        k = digits[random.integers(len(digits))]
        return data[:k] + b"0123456789-.e"[(n := random.integers(13)) : n + 1] + data[k + 1 :]
    if kind == 1 and random.integers(4) == 0:
        return data[:place]
    if kind == 2:
        return data[:place] + data[place + length :]
    if kind == 3:
        return data[: place + length] + data[place:]
    if kind == 4:
        return data[:place] + nasty + data[place:]
    if kind in (5, 6):  # a whole word: another one, or that of another place
        words = re.split(rb"([ \n=<>]+)", data)
        i, j = (2 * int(random.integers((len(words) + 1) // 2)) for _ in range(2))
        words[i] = nasty if kind == 5 else words[j]
        return b"".join(words)
    lines = data.split(b"\n")
    i, j = random.integers(len(lines), size=2)
    lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)
