"""Which kind of motion a state belongs to."""

from enum import IntEnum

from attitude.solution import codes


class Mode(IntEnum):
    """The kinds of free rotation, in the order in which they are asked for.

    Exact statements about the doubles given: a body is SYMMETRIC when two of its moments are the
    same number.  What holds within the rounding of the input is told by
    `FreeRotation.within_rounding`.
    """

    AT_REST = codes.AT_REST
    SPHERICAL = codes.SPHERICAL
    PRINCIPAL_AXIS = codes.PRINCIPAL_AXIS
    SEPARATRIX = codes.SEPARATRIX
    SYMMETRIC = codes.SYMMETRIC
    LONG_AXIS = codes.LONG_AXIS
    SHORT_AXIS = codes.SHORT_AXIS

    @property
    def phrase(self):
        """The mode in words."""
        return _PHRASES[self]


_PHRASES = {
    Mode.AT_REST: "at rest",
    Mode.SPHERICAL: "uniform rotation of a body with three equal moments",
    Mode.PRINCIPAL_AXIS: "uniform rotation about a principal axis",
    Mode.SEPARATRIX: "on the separatrix, between long-axis and short-axis mode",
    Mode.SYMMETRIC: "regular precession of a symmetric body",
    Mode.LONG_AXIS: "long-axis mode (LAM): the momentum circulates about the axis of least inertia",
    Mode.SHORT_AXIS: (
        "short-axis mode (SAM): the momentum circulates about the axis of greatest inertia"
    ),
}
