"""Files of C-kernels through SPICE: loaded kernels, steps, segments, the clock, records.

SPICE does not check the head of a binary kernel and ends the process: `fault` checks it.  Source:
the DAF Required Reading of SPICE: the file record is the first 1024 bytes; ND and NI stand at byte
8, the addresses of the first and last summary records and of the first free double word (counted
from 1) at byte 76, the byte order at byte 88.
"""

from __future__ import annotations

import os
import struct
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude._support import pairs, validation
from attitude._textfiles.lines import path_text, unreadable
from attitude.catalog import motion_of
from attitude.epochs import _inputs, _time_scales
from attitude.errors import AttitudeError
from attitude.formats._sampling import MOST_RECORDS, apart, known_angle, longest_of
from attitude.frames import quaternion
from attitude.frames import representations as forms
from attitude.motions._table import AttitudeTable
from attitude.paths._tabulated import newton_form, newton_values

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from attitude._support.annotations import EpochOrSeconds, FilePath, FloatArray, IntArray
    from attitude.motions._history import AttitudeHistory
    from attitude.motions._motion import HasAttitudes


_RECORD = 1024
_ORDERS = {b"LTL-IEEE": "<", b"BIG-IEEE": ">"}
_SUMMARIES = {b"DAF/CK": (2, 6), b"DAF/SPK": (2, 6), b"DAF/PCK": (2, 5)}


def fault(path: FilePath) -> str | None:
    """The fault in the head of a kernel that is a DAF, as a sentence; None if there is none."""
    with open(path, "rb") as file:
        head = file.read(_RECORD)
    kind, order = head[:8].rstrip(), _ORDERS.get(head[88:96])
    if kind not in _SUMMARIES or (order is None and len(head) == _RECORD):
        return None
    if order is None or len(head) < _RECORD:
        return "it ends before its first 1024 bytes"
    summary = struct.unpack(order + "2i", head[8:16])
    first, last, free = struct.unpack(order + "3i", head[76:88])
    records = os.path.getsize(path) // _RECORD
    if summary != _SUMMARIES[kind]:
        return f"its head states summaries of {summary[0]} doubles and {summary[1]} integers"
    if not (1 < first <= records and 1 < last <= records and free > _RECORD // 8):
        return "its summaries are not within it"
    if _RECORD * records < 8 * (free - 1):
        return "it is shorter than its head states, as if cut off"
    return None


# ---- Kernels loaded in SPICE's pool, which keeps the kernels and variables of the user
# SPICE has one pool for the whole process.  `unload` removes the last instance of a name: one call
# too many removes a kernel that the user has loaded.  When a text kernel is unloaded, SPICE also
# drops all variables that a program has set (by pdpool, pcpool, pipool); `LoadedKernels.close`
# restores them.

# Names of variables that one call returns.
_BATCH = 500
# A number that exceeds the capacity of the pool.
_MOST = 100_000


def spiceypy() -> Any:
    """The module `spiceypy`; AttitudeError if it is not installed."""
    try:
        import spiceypy
    except ImportError as err:
        raise AttitudeError(
            f"CK needs SPICE; install it by {validation.installing('spice')}."
        ) from err
    return spiceypy


class LoadedKernels:
    """Kernels in the pool, until `close` or the end of a ``with`` block.

    AttitudeError if a kernel is broken or SPICE cannot load it; no kernel stays loaded then.
    """

    def __init__(self, names: Iterable[FilePath]):
        self._spice = spice = spiceypy()
        self._names: list[str] = []
        self._own: set[str] = set()
        count, known = spice.ktotal("ALL"), self._variables()
        # whole, since the folder of the process may be another one when a kernel is unloaded
        for name in [os.path.abspath(path_text(kernel, "kernels")) for kernel in names]:
            try:
                broken = fault(name)
                if broken is None:
                    spice.furnsh(name)
                    self._names.append(name)
                    continue
                error = AttitudeError(f"{name}: it is a broken kernel: {broken}.")
            # Before OSError, which some errors of SPICE are too.
            except spice.exceptions.SpiceyError as err:
                spice.reset()
                error = AttitudeError(f"SPICE cannot load {name}: {err.short}.")
            except OSError as err:
                error = unreadable(name, err)
            # Unload the loaded part of a meta-kernel, too.
            self._names = [spice.kdata(k, "ALL")[0] for k in range(count, spice.ktotal("ALL"))]
            self.close()
            for variable in self._variables() - known:
                spice.dvpool(variable)
            raise error
        self._own = self._variables() - known

    def close(self) -> None:
        """Unload these kernels, and no others; a second call does nothing."""
        names, self._names = self._names, []
        if not names:
            return
        kept = {name: self._values(name) for name in self._variables() - self._own}
        for name in reversed(names):
            self._spice.unload(name)
        for name in kept.keys() - self._variables():
            put, values = kept[name]
            put(name, values)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _variables(self):
        """The names of all variables in the pool."""
        names = set()
        for start in range(0, _MOST, _BATCH):
            try:
                variables = self._spice.gnpool("*", start, _BATCH)
            except self._spice.exceptions.NotFoundError:
                break
            names |= set(variables)
            if len(variables) < _BATCH:
                break
        return names

    def _values(self, name):
        """The function that sets a variable of numbers or of text, and its values."""
        spice = self._spice
        count, kind = spice.dtpool(name)
        get, put = (spice.gdpool, spice.pdpool) if kind == "N" else (spice.gcpool, spice.pcpool)
        return put, list(get(name, 0, count))


# ---- The motion on the clock of a C-kernel, and the step between records
# At this step the error between records, measured at some places of the span, is a quarter of the
# tolerances.  The span is divided into stretches where the angular velocity of the motion jumps:
# records of one stretch hold the state of this stretch up to both its ends, and SPICE interpolates
# within a stretch only.

# Degree of the Hermite polynomials of type 5.
DEGREE: int = 7
# Places at which the error of interpolation is measured.
_PROBES = 300
# Its ratio to the tolerances.
_MARGIN = 0.25
# Distance of these places from the middle of a step, in steps.
_OFF_MIDDLE = 0.25
# Seconds to either side of an epoch between which the speed of a clock is measured.
_BESIDE = 100.0


class Plan:
    """The span of a kernel on its clock, the motion there, and the step between records.

    The clock counts seconds of TDB or TT from `first`; stretch k runs from bounds[k] to the next.
    """

    def __init__(
        self,
        motion: HasAttitudes | str,
        start: EpochOrSeconds,
        stop: EpochOrSeconds,
        kind: int,
        tolerance: float,
        rate_tolerance: float | None,
        scale: str = "tdb",
    ):
        self._scale = scale
        if kind not in (3, 5):
            raise AttitudeError(f"kind is {kind!r}; CK is written in types 3 and 5, give one.")
        self._motion = motion_of(motion)
        self.kind: int = kind
        self.tolerance: float = known_angle(tolerance)
        epoch = self._motion.epoch
        ends = _inputs.one_since(epoch, start, "start"), _inputs.one_since(epoch, stop, "stop")
        # The clock starts at or before the start, at an epoch that is one double of its scale.
        first, low = self._of_clock(*ends[0])
        self.first: float = float(first if low >= 0.0 else np.nextafter(first, -np.inf))
        begin, end = (pairs.add(self._of_clock(*pair), -self.first)[0] for pair in ends)
        self.begin: float = float(begin)
        self.end: float = float(end)
        if not self.end > self.begin:
            raise AttitudeError("stop is not after start; give a span of time.")
        self._divide()
        probes = self.history(np.linspace(self.begin, self.end, _PROBES)).angular_velocity
        fastest = longest_of(probes)
        if rate_tolerance is None:
            rate_tolerance = self.tolerance * max(fastest, 1e-12)
        if not (isinstance(rate_tolerance, (int, float)) and rate_tolerance > 0.0):
            raise AttitudeError(f"rate_tolerance is {rate_tolerance!r}; give rad/s above zero.")
        self.rate_tolerance: float = float(rate_tolerance)
        self.step: float = self._first_step(fastest)

    def _of_clock(self, hi, lo):
        """Seconds of the clock's scale since J2000, hi and lo, of seconds of the motion."""
        epoch = self._motion.epoch
        pair = pairs.add((np.asarray(hi), np.asarray(lo)), epoch.seconds, epoch.low)
        return pair if self._scale == "tdb" else _time_scales.tt_from_tdb(*pair)

    def _of_motion(self, seconds):
        """Seconds of the motion, hi and lo, of seconds on the clock."""
        hi, lo = pairs.add((seconds, np.zeros(seconds.shape)), self.first)
        if self._scale != "tdb":
            hi, lo = _time_scales.tdb_from("tt", hi, lo)
        return pairs.add((hi, lo), -self._motion.epoch.seconds, -self._motion.epoch.low)

    def speed(self, seconds: FloatArray) -> FloatArray:
        """Seconds of TDB in a second of the clock, at seconds on the clock."""
        if self._scale == "tdb":
            return np.ones(np.shape(seconds))
        after, before = (self._of_motion(seconds + h) for h in (_BESIDE, -_BESIDE))
        ratio: FloatArray = ((after[0] - before[0]) + (after[1] - before[1])) / (2.0 * _BESIDE)
        return ratio

    def _divide(self):
        """Set `bounds`, and the first and last epoch of each stretch as the motion counts them."""
        breaks = self._motion.breaks()
        clock = pairs.add(self._of_clock(breaks[:, 0], breaks[:, 1]), -self.first)[0]
        inside = (clock > self.begin) & (clock < self.end)
        jumps = breaks[inside]
        self.bounds: FloatArray = np.concatenate([[self.begin], clock[inside], [self.end]])
        if np.any(np.diff(self.bounds) <= 0.0):
            raise AttitudeError(
                "the angular velocity of the motion jumps twice within the rounding of an epoch; "
                "a C-kernel cannot hold that."
            )
        before = np.stack([jumps[:, 0], np.nextafter(jumps[:, 1], -np.inf)], axis=1)
        far = [[np.inf, 0.0]]
        self._ends = np.concatenate([np.negative(far), jumps]), np.concatenate([before, far])

    def history(
        self, seconds: FloatArray, stretch: IntArray | int | None = None
    ) -> AttitudeHistory:
        """The motion at seconds on the clock, whose epochs are not rounded."""
        if stretch is None:
            stretch = np.searchsorted(self.bounds[1:-1], seconds, side="right")
        hi, lo = self._of_motion(np.asarray(seconds))
        first, last = (np.broadcast_to(pair[stretch], (*np.shape(hi), 2)) for pair in self._ends)
        early = (hi < first[..., 0]) | ((hi == first[..., 0]) & (lo < first[..., 1]))
        late = (hi > last[..., 0]) | ((hi == last[..., 0]) & (lo > last[..., 1]))
        for outside, end in ((early, first), (late, last)):
            hi, lo = np.where(outside, end[..., 0], hi), np.where(outside, end[..., 1], lo)
        return self._motion.at(hi, lo)

    @property
    def _width(self):
        """Records from which SPICE interpolates."""
        return 2 if self.kind == 3 else (DEGREE + 1) // 2

    def records(self) -> list[FloatArray]:
        """The times of all records of each stretch, s on the clock: equal steps up to its ends."""
        lengths = np.diff(self.bounds)
        # A full window of interpolation in each stretch.
        least = 2 if len(lengths) == 1 else self._width
        counts = np.maximum(np.ceil(lengths / self.step).astype(int) + 1, least)
        if np.sum(counts) > MOST_RECORDS:
            raise AttitudeError(
                f"the tolerances need {np.sum(counts)} records, more than {MOST_RECORDS}; give "
                "larger ones, a shorter span, or type 5."
            )
        ends = zip(self.bounds[:-1], self.bounds[1:], counts, strict=True)
        return [np.linspace(begin, end, count) for begin, end, count in ends]

    def checks(self, count: int, random: np.random.Generator) -> FloatArray:
        """Epochs at which the finished kernel is compared: random ones, and some beside jumps."""
        jumps = self.bounds[1:-1]
        if len(jumps) > count:
            jumps = random.choice(jumps, count, replace=False)
        share = random.uniform(-1.0, 1.0, (4, len(jumps))) ** 3
        beside = np.ravel(jumps + share * 2.0 * self.step)
        return np.concatenate([random.uniform(self.begin, self.end, count), beside])

    def _first_step(self, fastest):
        """A step at which the error between records is a quarter of the tolerances."""
        span = self.end - self.begin
        # SPICE interprets quaternions more than 90 deg apart as an error of sign.
        longest = min(span, 1.0 / fastest) if fastest > 0.0 else span
        step = 0.5 * longest
        order = 2.0 if self.kind == 3 else DEGREE + 1.0
        for _ in range(4):
            step = min(step, longest)
            errors = self._errors(step)
            worst = max(errors[0] / self.tolerance, errors[1] / self.rate_tolerance)
            step *= min((_MARGIN / max(worst, 1e-30)) ** (1.0 / order), 4.0)
        return min(step, longest)

    def _errors(self, step):
        """Largest errors of attitude and rate, rad and rad/s, between records with this step."""
        width = self._width
        spread = self.begin + np.linspace(0.0, 1.0, _PROBES) * (self.end - self.begin)
        stretch = np.searchsorted(self.bounds[1:-1], spread, side="right")
        low, high = self.bounds[stretch], self.bounds[stretch + 1]
        # A window lies within the stretch in which it begins, or fills it.
        steps = np.minimum(step, (high - low) / (width - 1))
        first = np.maximum(np.minimum(spread, high - (width - 1) * steps), low)
        place = np.arange(width) * steps[:, None]
        nodes = self.history(first[:, None] + place, stretch[:, None])
        # In the middle itself the error of a steady rotation is one of the length only.
        middle = first + (0.5 * (width - 1) + _OFF_MIDDLE) * steps
        true = self.history(middle, stretch)
        q, w = (np.moveaxis(a, 1, 0) for a in (nodes.wxyz, nodes.angular_velocity_inertial))
        if self.kind == 3:
            turn = quaternion.multiply(quaternion.conjugate(q[0]), q[1])
            share = 0.5 + _OFF_MIDDLE
            turned = forms.from_rotation_vector(share * forms.to_rotation_vector(turn))
            rates = w[0] + share * (w[1] - w[0])
            interpolated = quaternion.multiply(q[0], turned), rates
        else:
            at, x = np.arange(float(width))[:, None], (middle - first) / steps
            speed = self.speed(first[:, None] + place)[..., None]
            change = speed * forms.quaternion_rate(nodes.wxyz, nodes.turning_rate)
            bends = speed * quaternion.rotate(nodes.wxyz, nodes.angular_acceleration)
            slopes = [np.moveaxis(rates, 1, 0) * steps[:, None] for rates in (change, bends)]
            interpolated = [
                newton_values(*newton_form(at, values, rates), x)[0]
                for values, rates in zip((q, w), slopes, strict=True)
            ]
        off = longest_of(interpolated[1] - true.angular_velocity_inertial)
        return apart(quaternion.unit(interpolated[0]), true.wxyz), off


# ---- The files of a C-kernel: segments written by SPICE, texts of the frame and clock kernels

REFERENCE: str = "J2000"
# Records of a segment.
_PIECE = 50_000
# Records of each neighbour that it repeats, so that the windows of interpolation are centered up to
# its ends.
_PAD = 8
# Random epochs at which the finished kernel is read.
_CHECKS = 2000


@contextmanager
def opened(path: str) -> Iterator[tuple[Any, int]]:
    """SPICE and the handle of a new C-kernel, which is closed at the end of the block."""
    spice = spiceypy()
    handle = None
    try:
        handle = spice.ckopn(path, "attitude", 0)
        yield spice, handle
        spice.ckcls(handle)
        # SPICE does not notice a full disk.
        if broken := fault(path):
            raise cannot(f"the C-kernel is not whole: {broken}.")
    except spice.exceptions.SpiceyError as err:
        spice.reset()
        if handle is not None:
            with suppress(spice.exceptions.SpiceyError):
                spice.dafcls(handle)
            spice.reset()
        raise cannot(f"SPICE cannot write the C-kernel ({err.short}).") from err


def write(path: str, plan: Plan, clock: KernelClock, instrument: int) -> None:
    """Write the C-kernel of a `Plan` to a new file, for the NAIF number of an instrument."""
    with opened(path) as (spice, handle):
        for number, seconds in enumerate(plan.records()):
            for start in range(0, max(len(seconds) - 1, 1), _PIECE):
                stop = min(start + _PIECE, len(seconds) - 1)
                pad = _PAD if plan.kind == 5 else 0
                window = slice(max(start - pad, 0), stop + 1 + pad)
                history = plan.history(seconds[window], number)
                ticks = clock.ticks(seconds[window])
                ends = ticks[start - window.start], ticks[stop - window.start]
                wxyz, rates = history.wxyz, history.angular_velocity_inertial
                if plan.kind == 3:
                    _put_3(spice, handle, instrument, ends, ticks, wxyz, rates)
                    continue
                # SPICE differentiates by the clock; d/dt of R w is R w', since w x w vanishes.
                speed = plan.speed(seconds[window])[:, None]
                change = speed * forms.quaternion_rate(wxyz, history.turning_rate)
                bends = speed * quaternion.rotate(wxyz, history.angular_acceleration)
                parts = quaternion.conjugate(wxyz), quaternion.conjugate(change), rates, bends
                packets = np.concatenate(parts, axis=1)
                _put_5(spice, handle, instrument, ends, ticks, packets, clock, form=(2, DEGREE))


def _put_3(spice, handle, instrument, ends, ticks, wxyz, rates):
    """Write a segment of type 3; `rates` (N, 3) over J2000, or None."""
    has_rates = rates is not None
    rates = np.ascontiguousarray(rates) if has_rates else np.zeros((len(ticks), 3))
    begin, end = map(float, ends)
    spice.ckw03(
        handle,
        begin,
        end,
        instrument,
        REFERENCE,
        has_rates,
        "attitude",
        len(ticks),
        ticks,
        np.ascontiguousarray(quaternion.conjugate(wxyz)),
        rates,
        1,
        ticks[:1],
    )


def _put_5(spice, handle, instrument, ends, ticks, packets, clock, *, form, has_rates=True):
    """Write a segment of type 5, whose form is its subtype and degree."""
    begin, end = map(float, ends)
    subtype, degree = form
    spice.ckw05(
        handle,
        subtype,
        degree,
        begin,
        end,
        instrument,
        REFERENCE,
        has_rates,
        "attitude",
        ticks,
        np.ascontiguousarray(packets),
        clock.per_tick,
        1,
        ticks[:1],
    )


def cannot(sentence: str) -> AttitudeError:
    """The error for a kernel that cannot be written."""
    return AttitudeError(f"{sentence} Is the disk full? Give a file in a folder with free space.")


def measured(path: str, plan: Plan, clock: KernelClock, instrument: int) -> tuple[float, float]:
    """Largest deviations, rad and rad/s, of a C-kernel read by SPICE at random epochs and jumps."""
    random = np.random.default_rng(2006)
    et = plan.first + plan.checks(_CHECKS, random)
    # Doubles of the clock's time scale: on the clock they are exact.
    seconds = np.clip(et - plan.first, plan.begin, plan.end)
    true = plan.history(seconds)
    matrices, rates = measured_at(path, clock.ticks(seconds), instrument)
    error = apart(forms.from_dcm(matrices), true.wxyz)
    return error, longest_of(rates - true.angular_velocity_inertial)


def measured_at(
    path: str, ticks: FloatArray, instrument: int, *, rates: bool = True
) -> tuple[FloatArray, FloatArray]:
    """Matrices (N, 3, 3) and angular velocities (N, 3) in J2000 that SPICE reads at clock times."""
    spice = spiceypy()
    matrices, velocities = np.empty((len(ticks), 3, 3)), np.full((len(ticks), 3), np.nan)
    handle = None
    try:
        handle = spice.cklpf(path)
        for k, tick in enumerate(ticks.tolist()):
            if rates:
                matrices[k], velocities[k], _ = spice.ckgpav(instrument, tick, 0.0, REFERENCE)
            else:
                matrices[k], _ = spice.ckgp(instrument, tick, 0.0, REFERENCE)
    except (spice.exceptions.SpiceyError, spice.exceptions.NotFoundError) as err:
        spice.reset()
        reason = getattr(err, "short", "not found")
        sentence = f"SPICE cannot read the kernel it has written ({reason})."
        if "BADQUATSIGN" in reason:
            raise AttitudeError(
                f"{sentence} The body turns too far between two records for its interpolation; "
                "give start= and stop= (on the command line --start), for records that follow from "
                "the tolerance."
            ) from err
        raise cannot(sentence) from err
    finally:
        if handle is not None:
            spice.ckupf(handle)
    return matrices, velocities


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

# Text of the clock kernel, with minus_clock, start (s past J2000), the number and the name of its
# time scale to be filled in.
CLOCK: str = """\
KPL/SCLK

A clock of 2^20 ticks a second of {scale} from the first epoch of the C-kernel of the same name.

\\begindata
SCLK_KERNEL_ID = ( @2026-01-01 )
SCLK_DATA_TYPE_{minus_clock} = ( 1 )
SCLK01_TIME_SYSTEM_{minus_clock} = ( {system} )
SCLK01_N_FIELDS_{minus_clock} = ( 2 )
SCLK01_MODULI_{minus_clock} = ( 10000000000 1048576 )
SCLK01_OFFSETS_{minus_clock} = ( 0 0 )
SCLK01_OUTPUT_DELIM_{minus_clock} = ( 1 )
SCLK_PARTITION_START_{minus_clock} = ( 0.0 )
SCLK_PARTITION_END_{minus_clock} = ( 1.0E15 )
SCLK01_COEFFICIENTS_{minus_clock} = ( 0.0 {start} 1.0 )
\\begintext
"""


# ---- The clock of a C-kernel: one that is written beside it, or that of a mission
# The own clock counts 2^20 ticks a second, of TDB or, for SPICE's own relation between UTC and TDB,
# of TDT (TT): then SPICE takes an epoch of `str2et` back to TT by the formula by which it made it.
# With a mission's clock SPICE converts epochs, one double of TDB, to ticks.

# Ticks a second: a power of two, so that doubles of seconds become ticks without rounding.
_TICKS = 2.0**20
_DATA_TYPE = "SCLK_DATA_TYPE_"


@dataclass(frozen=True)
class KernelClock:
    """A clock, for seconds counted from the begin of a kernel."""

    number: int  # NAIF number, negative
    ticks: Callable[[FloatArray], FloatArray]  # encoded clock times (N,) of s (N,)
    per_tick: float  # seconds of a tick
    text: str | None  # the clock kernel to be written; None for that of a mission


def own(number: int, first: float, scale: str) -> KernelClock:
    """A clock that counts from `first`, seconds of TDB or TT since J2000, by `scale`."""
    system = {"tdb": 1, "tt": 2}[scale]
    text = CLOCK.format(start=repr(first), minus_clock=-number, system=system, scale=scale.upper())
    return KernelClock(number, lambda seconds: seconds * _TICKS, 1.0 / _TICKS, text)


@contextmanager
def of_mission(files: Sequence[FilePath], first: float, span: float) -> Iterator[KernelClock]:
    """The clock of a mission, loaded until the end of the block."""
    spice = spiceypy()
    known = _clocks(spice)
    with LoadedKernels(files):
        clocks = sorted(set(_clocks(spice)) - set(known)) or sorted(known)
        listed = ", ".join(os.fspath(name) for name in files)
        if len(clocks) != 1:
            raise AttitudeError(
                f"the files {listed} define {len(clocks)} clocks; give the clock kernel (SCLK) of "
                "one spacecraft."
            )
        number = -clocks[0]

        def ticks(seconds: FloatArray) -> FloatArray:
            try:
                return np.array([spice.sce2c(number, first + s) for s in seconds.tolist()])
            except spice.exceptions.SpiceyError as err:
                spice.reset()
                raise AttitudeError(
                    f"the clock {number} of {listed} has no time there ({err.short}); leap seconds "
                    "may be missing, or the epochs lie outside of its partitions."
                ) from err

        ends = ticks(np.array([0.0, span]))
        yield KernelClock(number, ticks, span / float(ends[1] - ends[0]), None)


def _clocks(spice: Any) -> list[int]:
    """The numbers, without their sign, of the clocks in the pool."""
    try:
        names = spice.gnpool(_DATA_TYPE + "*", 0, 1000)
    except spice.exceptions.NotFoundError:
        return []
    return [int(name.removeprefix(_DATA_TYPE)) for name in names]


# ---- The records of an AttitudeTable as they are, as segments of a C-kernel
# SPICE interpolates each stretch without gaps as the table does, from the same records: Hermite as
# type 5, subtype 0; Lagrange as subtype 3 with angular velocities and 1 without; great circles as
# type 3.  The degree is the greatest of SPICE's (4 n - 1 for Hermite, odd for Lagrange, at most 23)
# that is not above that of the table; `ck.write` judges what another degree costs.
#
# Near the ends of a segment SPICE interpolates from fewer records, a table from the first or last
# whole window.  Records beyond both ends, outside of the segment's span and on the polynomial of
# that window, make SPICE's the same.

_MOST_DEGREE = 23


class TableSegments:
    """The stretches of a table on the clock of a kernel, which counts TDB seconds from `first`.

    `end` and `step` are s to the last record, and the most between records of a stretch.
    """

    def __init__(self, table: AttitudeTable, tolerance: float):
        self.tolerance: float = known_angle(tolerance)
        self._parts = [_of_its_span(segment) for segment in table.segments]
        epochs = [
            pairs.add((segment.seconds, segment.low), segment.epoch.seconds, segment.epoch.low)
            for segment in self._parts
        ]
        # The clock counts from before the records beyond the ends, of which there are at most 11.
        margin = 12.0 * max(float(np.max(np.diff(p.seconds), initial=0.0)) for p in self._parts)
        start = min(float(hi[0]) for hi, _ in epochs)
        self.first: float = float(np.nextafter(start - margin, -np.inf))
        self._clock = [pairs.add(pair, -self.first)[0] for pair in epochs]
        # Records outside of the span serve the interpolation within it.
        self._ends = [
            [float(pairs.add((end.seconds, end.low), -self.first)[0]) for end in segment.span]
            for segment in self._parts
        ]
        steps = [np.diff(seconds) for seconds in self._clock]
        if any(np.any(step <= 0.0) for step in steps):
            raise AttitudeError("two records of the table fall on one double of time.")
        self.end: float = max(float(seconds[-1]) for seconds in self._clock)
        self.step: float = float(max(np.max(step, initial=0.0) for step in steps))

    def write(self, path: str, clock: KernelClock, instrument: int) -> None:
        """Write the C-kernel to a new file; AttitudeError for errors of SPICE."""
        with opened(path) as (spice, handle):
            for segment, seconds, ends in zip(self._parts, self._clock, self._ends, strict=True):
                ticks, limits = clock.ticks(seconds), clock.ticks(np.array(ends))
                _write_part(spice, handle, segment, ticks, limits, clock, instrument)

    def measured(self, path: str, clock: KernelClock, instrument: int) -> tuple[float, float]:
        """Largest deviations, rad and rad/s, of the kernel read by SPICE from the table."""
        random = np.random.default_rng(2006)
        worst = [0.0, 0.0]
        for segment, ends in zip(self._parts, self._ends, strict=True):
            some = np.sort(random.uniform(ends[0], ends[1], _CHECKS // len(self._parts) + 2))
            ticks = clock.ticks(some)
            has_rates = segment.angular_velocity is not None
            matrices, rates = measured_at(path, ticks, instrument, rates=has_rates)
            since_j2000 = pairs.add((some, 0.0), self.first)
            true = segment.at(*pairs.add(since_j2000, -segment.epoch.seconds, -segment.epoch.low))
            worst[0] = max(worst[0], apart(forms.from_dcm(matrices), true.wxyz))
            if has_rates:
                worst[1] = max(worst[1], longest_of(rates - true.angular_velocity_inertial))
        return worst[0], worst[1]


def _of_its_span(segment: AttitudeTable) -> AttitudeTable:
    """Great circles over the span of a segment: type 3 has a record at its ends, none beyond."""
    hi, lo, (begin, end) = segment.seconds, segment.low, segment._limits
    if segment.method != "slerp" or (begin, end) == ((hi[0], lo[0]), (hi[-1], lo[-1])):
        return segment
    inside = ((hi - begin[0]) + (lo - begin[1]) > 0.0) & ((end[0] - hi) + (end[1] - lo) > 0.0)
    ends = zip(begin, (hi, lo), end, strict=True)
    seconds, low = (np.concatenate([[a], column[inside], [b]]) for a, column, b in ends)
    has_rates = segment.angular_velocity is not None
    kept = segment.at(seconds, low)
    return AttitudeTable.from_history(kept, rates=has_rates, method="slerp")


def _degree(table: AttitudeTable) -> int:
    """The degree of SPICE's polynomials for those of a table."""
    if table.method == "hermite":
        return max(3, min((table.degree + 1) // 4 * 4 - 1, _MOST_DEGREE))
    return min(table.degree - (table.degree + 1) % 2, _MOST_DEGREE)


def _write_part(spice, handle, segment, ticks, ends, clock, instrument):
    wxyz, has_rates = segment.nodes, segment.angular_velocity is not None
    rates = quaternion.rotate(wxyz, segment.angular_velocity) if has_rates else None
    if segment.method == "slerp":
        _put_3(spice, handle, instrument, ends, ticks, wxyz, rates)
        return
    degree, quats = _degree(segment), quaternion.conjugate(wxyz)
    if segment.method == "hermite":
        change = forms.quaternion_rate(wxyz, segment.angular_velocity)
        slopes = quaternion.conjugate(change) * clock.per_tick
        ticks, quats, slopes = _padded(ticks, quats, slopes, (degree + 1) // 2)
        subtype, packets = 0, np.concatenate([quats, slopes / clock.per_tick], axis=1)
    else:
        subtype = 3 if has_rates else 1
        packets = np.concatenate([quats, rates], axis=1) if has_rates else quats
        ticks, packets, _ = _padded(ticks, packets, None, degree + 1)
    form = subtype, degree
    _put_5(spice, handle, instrument, ends, ticks, packets, clock, form=form, has_rates=has_rates)


def _padded(ticks, values, slopes, width):
    """Records with some beyond both ends, on the polynomials of the first and the last window."""
    count = width // 2 - 1
    if count < 1 or len(ticks) < width:
        return ticks, values, slopes
    scale = float(ticks[width - 1] - ticks[0])
    blocks = [(ticks, values, slopes)]
    for window, end, beyond in (
        (slice(0, width), 0, -np.arange(count, 0, -1)),
        (slice(len(ticks) - width, None), -1, np.arange(1, count + 1)),
    ):
        step = abs(ticks[end] - ticks[1 if end == 0 else -2])
        x = beyond * step / scale
        at = (ticks[window, None] - ticks[end]) / scale
        bends = None if slopes is None else slopes[window, None] * scale
        p, dp = newton_values(*newton_form(at, values[window, None], bends), x, 1)
        more = ticks[end] + beyond * step, p, None if slopes is None else dp / scale
        blocks.insert(0 if end == 0 else 2, more)
    return tuple(
        None if parts[0] is None else np.concatenate(parts) for parts in zip(*blocks, strict=True)
    )
