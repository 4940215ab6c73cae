"""The files of a C-kernel: segments written by SPICE, texts of the frame and clock kernels."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.errors import AttitudeError
from attitude.formats.ck import daf_head
from attitude.formats.ck.plan import DEGREE, apart, longest
from attitude.formats.ck.spice_pool import spiceypy

if TYPE_CHECKING:
    from attitude.formats.ck.plan import Plan

# Ticks a second: a power of two, so that doubles of seconds become ticks without rounding.
_TICKS = 2.0**20
_REFERENCE = "J2000"
# Records of a segment; and records of each neighbour that it repeats, so that the windows of
# interpolation are centered up to its ends.
_PIECE, _PAD = 50_000, 8
# Random epochs at which the finished kernel is read.
_CHECKS = 2000


def write(path: str, plan: Plan, instrument: int) -> None:
    """Write the C-kernel of a `Plan` to a new file.

    Parameters
    ----------
    path : str
        Must not exist.
    plan : Plan
    instrument : int
        NAIF number.

    Raises
    ------
    AttitudeError
        For errors of SPICE, and if the disk is full; the file is closed and can be deleted.
    """
    spice = spiceypy()
    stretches = plan.records()
    handle = None
    try:
        handle = spice.ckopn(path, "attitude", 0)
        for number, seconds in enumerate(stretches):
            for start in range(0, max(len(seconds) - 1, 1), _PIECE):
                _write_segment(spice, handle, plan, instrument, number, seconds, start)
        spice.ckcls(handle)
        # SPICE does not notice a full disk.
        if broken := daf_head.fault(path):
            raise _cannot(f"the C-kernel is not whole: {broken}.")
    except spice.exceptions.SpiceyError as err:
        spice.reset()
        if handle is not None:
            with suppress(spice.exceptions.SpiceyError):
                spice.dafcls(handle)
            spice.reset()
        raise _cannot(f"SPICE cannot write the C-kernel ({err.short}).") from err


def _cannot(sentence):
    return AttitudeError(f"{sentence} Is the disk full? Give a file in a folder with free space.")


def _write_segment(spice, handle, plan, instrument, number, seconds, start):
    stop = min(start + _PIECE, len(seconds) - 1)
    pad = _PAD if plan.kind == 5 else 0
    part = slice(max(start - pad, 0), stop + 1 + pad)
    history = plan.history(seconds[part], number)
    ticks = seconds[part] * _TICKS
    ends = float(seconds[start] * _TICKS), float(seconds[stop] * _TICKS)
    frames = instrument, _REFERENCE, True
    if plan.kind == 5:
        packets = _packets(history)
        spice.ckw05(
            *(handle, 2, DEGREE, *ends, *frames, "attitude", ticks, packets),
            *(1.0 / _TICKS, 1, ticks[:1]),
        )
    else:
        quats = np.ascontiguousarray(quaternion.conjugate(history.wxyz))
        rates = np.ascontiguousarray(history.angular_velocity_inertial)
        spice.ckw03(
            *(handle, *ends, *frames, "attitude", len(ticks), ticks, quats, rates),
            *(1, ticks[:1]),
        )


def _packets(history):
    """Subtype 2 of type 5: quaternion, its rate, angular velocity in J2000, its rate."""
    return np.concatenate(
        [
            quaternion.conjugate(history.wxyz),
            quaternion.conjugate(forms.quaternion_rate(history.wxyz, history.angular_velocity)),
            history.angular_velocity_inertial,
            # d/dt of R w is R w', since w x w vanishes
            quaternion.rotate(history.wxyz, history.angular_acceleration),
        ],
        axis=1,
    )


def measured(path: str, plan: Plan, instrument: int) -> tuple[float, float]:
    """Largest deviations from the motion, rad and rad/s, of the C-kernel read by SPICE.

    They are measured at 2000 random epochs, and at four beside each jump of the angular velocity,
    of at most 2000.  The kernel is read by its handle, so that the user's kernels in SPICE's pool
    are neither used nor changed.

    Raises
    ------
    AttitudeError
        If SPICE cannot read the kernel.
    """
    spice = spiceypy()
    random = np.random.default_rng(2006)
    et = plan.first + plan.checks(_CHECKS, random)
    # Doubles of TDB: on the clock they are exact.
    seconds = np.clip(et - plan.first, plan.begin, plan.end)
    true = plan.history(seconds)
    matrices, rates = np.empty((len(seconds), 3, 3)), np.empty((len(seconds), 3))
    handle = None
    try:
        handle = spice.cklpf(path)
        for k, second in enumerate(seconds):
            matrices[k], rates[k], _ = spice.ckgpav(instrument, second * _TICKS, 0.0, _REFERENCE)
    except (spice.exceptions.SpiceyError, spice.exceptions.NotFoundError) as err:
        spice.reset()
        raise _cannot(
            f"SPICE cannot read the kernel it has written ({getattr(err, 'short', 'not found')})."
        ) from err
    finally:
        if handle is not None:
            spice.ckupf(handle)
    error = apart(forms.from_dcm(matrices), true.wxyz)
    return error, longest(rates - true.angular_velocity_inertial)


# Text of the frame kernel, with name, instrument, clock and center to be filled in.
FRAME: str = """\
KPL/FK

The frame of a body whose attitude is in the C-kernel of the same name.

\\begindata
FRAME_{name} = {instrument}
FRAME_{instrument}_NAME = '{name}'
FRAME_{instrument}_CLASS = 3
FRAME_{instrument}_CLASS_ID = {instrument}
FRAME_{instrument}_CENTER = {center}
CK_{instrument}_SCLK = {clock}
CK_{instrument}_SPK = {center}
\\begintext
"""

# Text of the clock kernel, with minus_clock and start (s past J2000) to be filled in.
CLOCK: str = """\
KPL/SCLK

A clock of 2^20 ticks a second of TDB from the first epoch of the C-kernel of the same name.

\\begindata
SCLK_KERNEL_ID = ( @2026-01-01 )
SCLK_DATA_TYPE_{minus_clock} = ( 1 )
SCLK01_TIME_SYSTEM_{minus_clock} = ( 1 )
SCLK01_N_FIELDS_{minus_clock} = ( 2 )
SCLK01_MODULI_{minus_clock} = ( 10000000000 1048576 )
SCLK01_OFFSETS_{minus_clock} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{minus_clock} = ( 1 )
SCLK_PARTITION_START_{minus_clock} = ( 0.0 )
SCLK_PARTITION_END_{minus_clock} = ( 1.0E15 )
SCLK01_COEFFICIENTS_{minus_clock} = ( 0.0 {start} 1.0 )
\\begintext
"""
