"""JPL kernels (SPK files): one path for each pair of bodies that a file holds.

jplephem reads the directory of a file; the coefficients of types 2 and 3 (Chebyshev polynomials)
are mapped into memory and evaluated by `attitude._solver.chebyshev`, at some 20 ns an epoch and
pair of bodies.  spiceypy evaluates all other types (`SpiceSegment`).

Source: NAIF, SPK Required Reading; jplephem.
"""

from __future__ import annotations

import importlib.util
import os
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import frames
from attitude._support import pairs, validation
from attitude._support.arrays import read_only
from attitude._textfiles.lines import path_text
from attitude.epochs._instants import Instant
from attitude.errors import AttitudeError
from attitude.paths._compressed import EqualPieces
from attitude.paths._path import KM, Ephemeris, Path, body_name, since

if TYPE_CHECKING:
    from attitude._support.annotations import FilePath


# ---- The base class of the segments of a kernel

# The supported inertial frames of SPICE, by SPICE's numbers.
FRAMES: dict[int, str] = {1: "icrf", 17: "ecliptic"}


class Segment(Path):
    """A segment of an SPK file, `number` from 0: one body relative to one center over one span."""

    def __init__(self, kernel: Kernel, number: int, name: str, segment: Any) -> None:
        self.kernel = kernel
        self.number = number
        self.name = name
        self.center = body_name(segment.center)
        self.source = kernel.source
        self.span = Instant(segment.start_second), Instant(segment.end_second)
        self.rotation = frames.matrix_to_icrf(FRAMES[segment.frame])
        self.is_turned = segment.frame != 1

    def __reduce__(self) -> tuple[Any, ...]:
        return self.kernel.segment, (self.number,)

    def _in_icrf(self, vectors):
        """Vectors (3, N) over ICRF axes."""
        return self.rotation @ vectors if self.is_turned else vectors


# ---- Segments of SPK files that only SPICE can read: types 1, 5, 8 to 21, through spiceypy
# SPICE keeps loaded kernels in a pool for the whole process; a `SpiceSegment` reads one segment of
# one file by its own handle, and neither uses nor changes the pool.  SPICE is not thread-safe:
# compress the path of such a segment before several threads use it.


class SpiceSegment(Segment):
    """A segment that SPICE evaluates, one epoch at a time: some 4 microseconds each.

    SPICE takes epochs as one double (1e-7 s, 4 mm at 30 km/s); the velocity adds the rest.
    """

    def __init__(self, kernel: Kernel, number: int, name: str, segment: Any) -> None:
        super().__init__(kernel, number, name, segment)
        if importlib.util.find_spec("spiceypy") is None:
            raise AttitudeError(
                f"{kernel.source} has {name} in a segment of type {segment.data_type}, which needs "
                f"SPICE; install it by {validation.installing('spice')}."
            )

    def _state(self, instant, hi, lo):
        import spiceypy

        self.check_span(instant, hi, lo)
        seconds, remainder = pairs.add((hi, lo), instant.seconds, instant.low)
        seconds, remainder = np.broadcast_arrays(seconds, remainder)
        states = np.empty((seconds.size, 6))
        # Opened each time, because SPICE reads on in a file that another one has replaced.
        if _status(self.kernel.file, self.source) != self.kernel.status:
            raise AttitudeError(
                f"another file has replaced {self.source} since {self.name} was read from it; make "
                "the path anew."
            )
        handle = spiceypy.dafopr(self.kernel.file)
        try:
            spiceypy.dafbfs(handle)
            for _ in range(self.number + 1):
                spiceypy.daffna()
            descriptor = spiceypy.dafgs()[:5]
            for k, second in enumerate(seconds.tolist()):
                states[k] = self._evaluated(handle, descriptor, second)
        finally:
            spiceypy.dafcls(handle)
        position, velocity = KM * states.T[:3], KM * states.T[3:]
        position += velocity * remainder
        return self._in_icrf(position), self._in_icrf(velocity)

    def _evaluated(self, handle, descriptor, second):
        """The state (6,) at a second past J2000, km and km/s."""
        import spiceypy

        try:
            return spiceypy.spkpvn(handle, descriptor, second)[1]
        except spiceypy.exceptions.SpiceyError as err:
            spiceypy.reset()
            raise AttitudeError(
                f"SPICE cannot evaluate {self.name} in {self.source} at {second!r} s past J2000 "
                f"({err.short}); check the file with SPICE's brief."
            ) from err


class Kernel(Ephemeris):
    """The bodies of one SPK file, of an absolute path.  Made by `open_kernel`, one for each file.

    ``kernel.step(body)`` is the path of a body relative to the center that the file gives for it.
    """

    advice = "Give one of these, another kernel, or a list of kernels."

    def __init__(self, file: str) -> None:
        self.file = file
        self.status = _status(file, file)
        self.source = os.path.basename(file)
        # jplephem's segments with their numbers in the file, by the target; paths by that number.
        self._segments: dict[int, list[tuple[int, Any]]] = {}
        self._paths: dict[int, Segment] = {}
        for number, segment in enumerate(_directory(file)):
            self._segments.setdefault(segment.target, []).append((number, segment))

    def __reduce__(self) -> tuple[Any, ...]:
        return open_kernel, (self.file,)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The names of the bodies in the file, and of the centers of their paths."""
        centers = {
            segment.center for segments in self._segments.values() for _, segment in segments
        }
        return tuple(body_name(number) for number in sorted(centers | set(self._segments)))

    def segment(self, number: int) -> Segment:
        """The path of one segment, by its number in the file from 0."""
        for target, segments in self._segments.items():
            if any(number == place for place, _ in segments):
                self._opened(body_name(target), segments)
                return self._paths[number]
        raise AttitudeError(
            f"{self.source} has no segment {number} any more, so another file has replaced it; "
            "make the path anew."
        )

    def step_within(self, name: str, whole: Ephemeris) -> Path | None:
        """As that of `Ephemeris`; relative to "ssb" where segments have different centers."""
        segments = self._segments_of(name)
        if len(self.centers(name)) < 2:
            return super().step_within(name, whole)
        return _joined([whole.to_barycentre(path) for path in self._opened(name, segments)])

    def _step(self, name: str) -> Path | None:
        segments = self._segments_of(name)
        return _joined(self._opened(name, segments)) if segments else None

    def centers(self, body: str | int) -> set[int]:
        """NAIF numbers of the centers that the file gives for a body."""
        return {segment.center for _, segment in self._segments_of(body_name(body))}

    def _segments_of(self, name):
        """The segments of a body and their numbers in the file."""
        numbers = [number for number in self._segments if body_name(number) == name]
        return self._segments[numbers[0]] if numbers else []

    def _opened(self, name, segments):
        """The paths of the segments of a body."""
        for number, segment in segments:
            if number not in self._paths:
                self._paths[number] = _segment_path(self, name, number, segment)
        return [self._paths[number] for number, _ in segments]


def _joined(paths):
    """The path of a body from those of its segments: the last that covers an epoch, as in SPICE."""
    return paths[0] if len(paths) == 1 else Succession(tuple(reversed(paths)), paths[0].name)


def open_kernel(file: FilePath) -> Kernel:
    """The `Kernel` of an SPK file, which is opened once."""
    name = path_text(file, "file")
    path = os.path.abspath(os.path.expanduser(name))
    return _open_once(path, _status(path, name))


@lru_cache(maxsize=64)
def _open_once(path, status):
    return Kernel(path)


def _status(file, name):
    """When a file was changed, in ns, and its size: another file of its name has others."""
    if not os.path.isfile(file):
        raise AttitudeError(
            f"the kernel {name!r} is not a file; give the path of an SPK file (.bsp), which must "
            "exist already: nothing is downloaded."
        )
    status = os.stat(file)
    return status.st_mtime_ns, status.st_size


def _directory(file):
    """jplephem's segments of a file, without the coefficients, which `_words` reads."""
    from jplephem.daf import DAF
    from jplephem.spk import SPK

    # Opened here: SPK.open of jplephem before 2.23 leaves a file open that it cannot read.
    try:
        with open(file, "rb") as opened:
            spk = SPK(DAF(opened))
    except Exception as err:  # jplephem raises whatever its unpacking raises
        raise AttitudeError(
            f"{os.path.basename(file)} is not an SPK kernel ({err}); give a file such as de440.bsp."
        ) from err
    segments = spk.segments
    if not segments or spk.daf.ni != 6:
        raise AttitudeError(
            f"{os.path.basename(file)} holds no positions of bodies (it is a DAF of another kind, "
            "or empty); give an SPK kernel such as de440.bsp."
        )
    return segments


def _words(file, segment):
    """All numbers of a segment, mapped into memory."""
    order = {b"BIG-IEEE": ">f8", b"LTL-IEEE": "<f8"}[segment.daf.locfmt]
    count = segment.end_i - segment.start_i + 1
    start = 8 * (segment.start_i - 1)
    try:
        words = np.memmap(file, dtype=order, mode="r", offset=start, shape=(count,))
    except ValueError as err:
        raise AttitudeError(
            f"{os.path.basename(file)} ends before the numbers that its directory lists; it is "
            "damaged or was copied in part: get it anew."
        ) from err
    # A plain array: a memmap is slow to slice, and numba does not support foreign byte order.
    return np.asarray(words).view(np.ndarray).astype(np.float64, copy=False)


def _segment_path(kernel, name, number, segment):
    """The path of one segment, by its type."""
    if segment.frame not in FRAMES:
        raise AttitudeError(
            f"{kernel.source} gives {name} in the frame number {segment.frame}; only inertial "
            "frames are read: J2000 (1) and ECLIPJ2000 (17)."
        )
    kind = KernelSegment if segment.data_type in (2, 3) else SpiceSegment
    return kind(kernel, number, name, segment)


class KernelSegment(Segment):
    """A segment of type 2 or 3: Chebyshev polynomials over equal intervals."""

    def __init__(self, kernel: Kernel, number: int, name: str, segment: Any) -> None:
        super().__init__(kernel, number, name, segment)
        words = _words(kernel.file, segment)
        start, width, size, count = words[-4:].tolist()
        self._has_rates = segment.data_type == 3
        components = 6 if self._has_rates else 3
        rows, size = int(count), int(size)
        if not (width > 0.0 and rows * size + 4 == words.size and (size - 2) % components == 0):
            raise AttitudeError(
                f"{kernel.source} has a damaged segment for {name}: its directory does not fit "
                "its size; get the file anew."
            )
        self.pieces = EqualPieces(
            start=Instant(start),
            widths=np.array([width]),
            records=read_only(words[:-4].reshape(rows, size)),
            skip=2,
            count=(size - 2) // components,
            factor=KM,
            least=segment.start_second - start,
            most=segment.end_second - start,
        )

    def _position(self, instant, hi, lo):
        return self._in_icrf(self.pieces.values(*self.pieces.place(self, instant, hi, lo)))

    def _state(self, instant, hi, lo):
        pieces = self.pieces
        piece, x = pieces.place(self, instant, hi, lo)
        if self._has_rates:
            # Type 3 has separate polynomials for the velocity, after those of the position.
            position = pieces.values(piece, x)
            velocity = pieces.values(piece, x, pieces.skip + 3 * pieces.count)
        else:
            position, velocity = pieces.values_and_rates(piece, x)
        return self._in_icrf(position), self._in_icrf(velocity)


@dataclass(frozen=True, eq=False, repr=False)
class Succession(Path):
    """Paths of one body from one center with spans of their own, of which the first counts."""

    parts: tuple[Path, ...]
    name: str

    @property
    def center(self) -> str | Path:  # type: ignore[override]  # computed
        """The center that all parts have."""
        return self.parts[0].center

    @property
    def source(self) -> str:  # type: ignore[override]  # computed
        """The sources of the parts, separated by commas."""
        return ", ".join(dict.fromkeys(path.source for path in self.parts))

    @property
    def span(self) -> tuple[Instant, Instant]:  # type: ignore[override]  # computed
        """The first and last epoch of all parts; there may be gaps between them."""
        first, last = zip(*self._spans(), strict=True)
        order = attrgetter("seconds", "low")
        return min(first, key=order), max(last, key=order)

    def _spans(self) -> list[tuple[Instant, Instant]]:
        spans = [path.span for path in self.parts if path.span is not None]
        return sorted(spans, key=lambda span: span[0].seconds)

    def _position(self, instant, hi, lo):
        position = np.empty((3, hi.size))
        for path, inside, at in self._by_part(instant, hi, lo):
            position[:, inside] = path._position(instant, *at)
        return position

    def _state(self, instant, hi, lo):
        position, velocity = np.empty((2, 3, hi.size))
        for path, inside, at in self._by_part(instant, hi, lo):
            position[:, inside], velocity[:, inside] = path._state(instant, *at)
        return position, velocity

    def _by_part(self, instant, hi, lo):
        """Yield each part that is used, a mask or slice of its epochs, and their hi and lo."""
        low, lo = lo, np.broadcast_to(lo, hi.shape)
        left = np.ones(hi.size, dtype=bool)
        for path in self.parts:
            first, last = (since(end, instant) for end in path.span)
            inside = left & ((hi - first[0]) + (lo - first[1]) >= 0.0)
            inside &= (hi - last[0]) + (lo - last[1]) <= 0.0
            if inside.all():
                yield path, slice(None), (hi, low)
                return
            if inside.any():
                yield path, inside, (hi[inside], lo[inside])
                left &= ~inside
        if left.any():
            self.refuse_outside(instant, hi[np.argmax(left)])
