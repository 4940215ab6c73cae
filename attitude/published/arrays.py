"""States of many bodies from arrays of published numbers: `states_from_periods`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import validation
from attitude.body import TRIANGLE, Body
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.published import conventions, dynamic_inertia, states
from attitude.regime import known_convention

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from attitude.annotations import BoolArray, FloatArray, Reals

# So many members, some 50 ms of work, are computed together: Python acts on signals, such as that
# of Ctrl-C, between two blocks.
_BLOCK = 8192
# Names of the numbers with their units, one for each member.
_NUMBERS = {"P_psi": "s", "P_phi": "s", "P": "s", "phi0": "rad", "psi0": "rad"}
_UNKNOWN = -1


class PeriodStates(Immutable):
    """States of N bodies; made by `states_from_periods`.

    Attributes
    ----------
    wxyz : (N, 4) array
        Body axes to the frame of the pole, scalar first.
    angular_velocity : (N, 3) array
        rad/s over the body axes.
    bad : (N,) array of bool
        Members for which no motion has the numbers given; their rows are NaN.
    """

    wxyz: FloatArray
    angular_velocity: FloatArray
    bad: BoolArray

    def __init__(
        self,
        wxyz: FloatArray,
        angular_velocity: FloatArray,
        bad: BoolArray,
        again: Callable[[int], object],
    ) -> None:
        self._again: Callable[[int], object]
        self._set("wxyz", frozen(wxyz))
        self._set("angular_velocity", frozen(angular_velocity))
        self._set("bad", frozen(bad))
        self._set("_again", again)

    def reason(self, k: int) -> str:
        """Why member k is bad, as the sentence of `Spin.from_periods`; "" for a good one."""
        if not self.bad[k]:
            return ""
        try:
            self._again(int(k))
        except AttitudeError as err:
            return str(err)
        return "no motion has these numbers."


def states_from_periods(
    moments: Reals | Body | None,
    *,
    pole: Reals,
    phi0: Reals,
    mode: Any = None,
    convention: Any = None,
    P_psi: Reals | None = None,
    P_phi: Reals | None = None,
    psi0: Reals | None = None,
    theta_branch: Any = None,
    P: Reals | None = None,
    principal_axes: FloatArray | None = None,
    names: Sequence[object] | None = None,
    on_error: str = "raise",
) -> PeriodStates:
    """States of N bodies from published spin states, each as by `Spin.from_periods`.

    Parameters
    ----------
    moments : (3,) or (N, 3) array_like, Body, or None
        Principal moments, of any unit, in any order.  None, with P alone: rotators about z.
    pole : (2,) or (N, 2) array_like
        Longitude and latitude of the momentum, rad or Quantities.
    phi0, psi0, P_psi, P_phi, P : one number, or (N,) array_like
        rad and s, or Quantities.  A member whose P is a number is a relaxed rotator; its P_psi,
        P_phi and psi0, if given for other members, are NaN.
    mode, convention, theta_branch : one value, or (N,) array_like
        As in `Spin.from_periods`; of relaxed rotators they are not read.
    principal_axes : (3, 3) or (N, 3, 3) array, optional
        Columns: the principal axes of `moments` over the body axes; by default the body axes.
    names : sequence of N, optional
        Names of the members in error messages, in place of their numbers.
    on_error : "raise" or "nan"
        Whether the first member that is bad is an error, or has NaN in its rows.

    Returns
    -------
    PeriodStates

    Raises
    ------
    AttitudeError
        For shapes that do not fit, and for bad members unless on_error="nan".

    Notes
    -----
    One member costs some 7 us (benchmarks/ensembles_setup.py).

    >>> found = states_from_periods(
    ...     [(0.61, 0.965, 1.0), (0.5, 0.9, 1.0)], mode="SAM", convention=["S", "L"],
    ...     P_psi=[9.5e5, 4.0e4], P_phi=1.0e4, pole=(4.4, -1.3), phi0=0.0, psi0=0.0,
    ...     theta_branch="acute",
    ... )
    >>> found.wxyz.shape, found.bad.tolist()
    ((2, 4), [False, False])
    """
    on_error = validation.one_of(on_error, "on_error", ("raise", "nan"))
    given = {"phi0": phi0, "psi0": psi0, "P_psi": P_psi, "P_phi": P_phi, "P": P}
    numbers = {
        name: np.array(math.nan)
        if value is None
        else validation.real(value, name, unit=_NUMBERS[name], finite=False)
        for name, value in given.items()
    }
    numbers["moments"], order, axes = _bodies(moments, principal_axes)
    numbers["pole"] = _poles(pole)
    words = {
        "mode": _codes(mode, dynamic_inertia.known_mode, ("SAM", "LAM")),
        "convention": _codes(convention, known_convention, ("S", "L")),
        "theta_branch": _codes(theta_branch, _known_branch, ("", "acute", "obtuse")),
    }
    count = _count({**numbers, **words, "axes": axes})
    rows = {
        name: np.broadcast_to(each, (count, *each.shape[1:])) if each.ndim else np.full(count, each)
        for name, each in {**numbers, **words}.items()
    }
    order = np.broadcast_to(order, (count, 3))
    wxyz, omega = np.empty((count, 4)), np.empty((count, 3))
    bad = np.empty(count, dtype=bool)
    for first in range(0, count, _BLOCK):
        part = slice(first, min(first + _BLOCK, count))
        turned = axes[part] if len(axes) > 1 else axes
        some = {name: each[part] for name, each in rows.items()}
        wxyz[part], omega[part], bad[part] = _block(some, order[part], turned)
    shared = {"mode": mode, "convention": convention, "theta_branch": theta_branch}
    found = PeriodStates(wxyz, omega, bad, _again(moments, rows, shared))
    if on_error == "raise" and bad.any():
        k = int(np.flatnonzero(bad)[0])
        name = f"Member {k} of {count}" if names is None else f"Member {names[k]!r}"
        raise AttitudeError((f"{name}: " if count > 1 else "") + found.reason(k))
    return found


def _block(
    rows: dict[str, Any], order: Any, axes: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Attitudes, angular velocities and the mask of bad members of one block."""
    relaxed = ~np.isnan(rows["P"])
    moments = np.ascontiguousarray(np.take_along_axis(rows["moments"], order, axis=-1))
    tumbling = _possible(rows, moments, relaxed)
    P_psi, P_phi = (np.where(tumbling, rows[name], 1.0) for name in ("P_psi", "P_phi"))
    long_labels = (rows["convention"] == 1) & ~relaxed
    flags = (rows["mode"] == 1) & ~relaxed, long_labels, np.maximum(rows["theta_branch"], 0)
    labels = states.Labels(moments, order, axes, *flags)
    with np.errstate(over="ignore"):
        ratios = np.where(tumbling, P_psi / P_phi - ~long_labels, np.nan)
    places = dynamic_inertia.places(moments, labels.long_axis, ratios)
    angles = np.zeros((len(moments), 5))
    angles[:, :2], angles[:, 2] = rows["pole"], rows["phi0"]
    angles[:, 4] = np.where(relaxed, 0.0, rows["psi0"])
    rates = labels.rates(places, places[:, 2] / P_psi, angles)
    rates[labels.lost(places, rates, P_psi)] = np.nan
    if relaxed.any():
        _relax(relaxed, rows, rates, angles)
    rates[~_in_range(angles)] = np.nan
    wxyz, omega = labels.states(angles, rates)
    bad = np.isnan(rates[:, 0])
    wxyz[bad] = omega[bad] = np.nan
    return wxyz, omega, bad


def _possible(rows, moments, relaxed):
    """Members (N,) whose periods, mode and moments are those of a tumbling body, as far as seen."""
    a, b, c = moments.T
    found = ~relaxed & (rows["mode"] >= 0) & (rows["convention"] >= 0) & (rows["theta_branch"] >= 0)
    for name in ("P_psi", "P_phi"):
        found &= (rows[name] > 0.0) & (rows[name] < math.inf)
    with np.errstate(invalid="ignore"):
        found &= (a > 0.0) & (c < math.inf) & (c - a - b <= TRIANGLE * c)
    return found


def _relax(relaxed, rows, rates, angles):
    """Fill rates and theta of relaxed rotators; NaN where P is not positive or not alone."""
    P = rows["P"]
    fine = (P > 0.0) & (math.inf > P)
    for name in ("P_psi", "P_phi", "psi0"):
        fine &= np.isnan(rows[name])
    with np.errstate(divide="ignore", invalid="ignore"):
        spin = np.where(fine, 2.0 * math.pi / P, np.nan)
    rates[relaxed] = 0.0
    rates[relaxed, 2] = spin[relaxed]
    rates[relaxed & ~fine] = np.nan
    angles[relaxed, 3] = 0.0


def _in_range(angles):
    """Whether pole, phi and psi (N,) are within the ranges that `conventions` allows."""
    turn, quarter = conventions.TURN, conventions.QUARTER
    with np.errstate(invalid="ignore"):
        fine = np.abs(angles) <= (turn, quarter, turn, math.inf, turn)
    return fine.all(axis=1)


def _bodies(moments: Any, principal_axes: Any) -> tuple[FloatArray, Any, FloatArray]:
    """Moments (M, 3), the order (M, 3) of them, and axes (M', 3, 3); M, M' are 1 or N."""
    if isinstance(moments, Body):
        if principal_axes is not None:
            raise AttitudeError("a Body has its principal axes; leave out principal_axes.")
        order = conventions.order(moments)[None]
        return moments.moments[None], order, moments.principal_axes[None]
    if moments is None:
        known = np.ones((1, 3))
    else:
        known = validation.real(moments, "moments", shape=(..., 3), unit="kg m2", finite=False)
        known = known.reshape(1, 3) if known.ndim == 1 else known
    axes = np.eye(3)
    if principal_axes is not None:
        axes = validation.real(principal_axes, "principal_axes", shape=(..., 3, 3))
    return known, np.argsort(known, axis=-1, kind="stable"), axes.reshape(-1, 3, 3)


def _poles(pole: Any) -> FloatArray:
    """Poles (1 or N, 2) in rad; a pair of values may have different units."""
    if isinstance(pole, (list, tuple)) and len(pole) == 2 and np.ndim(pole[0]) == 0:
        parts = [validation.number(each, "pole", unit="rad") for each in pole]
        return np.array([parts])
    given = validation.real(pole, "pole", shape=(..., 2), unit="rad", finite=False)
    return given.reshape(1, 2) if given.ndim == 1 else given


def _codes(given: Any, known: Callable[[Any], str | None], allowed: Sequence[str]) -> Any:
    """The numbers () or (N,) of words in `allowed`; _UNKNOWN for other words, and none."""
    numbers: dict[object, int] = {}

    def code(word: object) -> int:
        if word not in numbers:
            try:
                numbers[word] = allowed.index(known(word) or "")
            except (AttitudeError, ValueError):
                numbers[word] = _UNKNOWN
        return numbers[word]

    if given is None or isinstance(given, (str, int)):
        return np.array(code(given))
    words = np.asarray(given, dtype=object)
    try:
        return np.array([code(word) for word in words.ravel().tolist()], int).reshape(words.shape)
    except TypeError as err:  # what cannot be hashed
        raise AttitudeError(
            f"mode, convention or theta_branch is {validation.shown(given)}; give words, one or "
            "one for each member."
        ) from err


def _known_branch(branch: Any) -> str | None:
    """A branch of theta, or None where it is not given."""
    if branch is None or branch == "" or branch != branch:
        return None
    if branch in ("acute", "obtuse"):
        return str(branch)
    raise AttitudeError("unknown branch")


def _count(arrays: dict[str, Any]) -> int:
    """The number of members, to which all arrays broadcast."""
    inner = {"moments": 1, "pole": 1, "axes": 2}
    lengths = {name: each.shape[: each.ndim - inner.get(name, 0)] for name, each in arrays.items()}
    counts = {shape[0] for shape in lengths.values() if shape != () and shape[0] != 1}
    if len(counts) > 1 or any(len(shape) > 1 for shape in lengths.values()):
        listed = ", ".join(f"{name} {shape}" for name, shape in lengths.items() if shape != ())
        raise AttitudeError(
            f"the numbers of members differ ({listed}); give one value, or one for each of the N "
            "members."
        )
    return int(counts.pop()) if counts else 1


def _again(moments: Any, rows: dict[str, Any], words: dict[str, Any]) -> Callable[[int], object]:
    """The call of `states.from_periods` for one member, which raises the error of a bad one."""

    def call(k: int) -> object:
        body = moments
        if body is not None and not isinstance(body, Body):
            body = Body(moments=rows["moments"][k], relative=True)
        numbers = {name: float(rows[name][k]) for name in _NUMBERS}
        labels = {name: _entry(each, k) for name, each in words.items()}
        if not math.isnan(numbers["P"]):
            labels = {}
        given: dict[str, Any] = {
            name: value for name, value in numbers.items() if not math.isnan(value)
        }
        given.setdefault("phi0", math.nan)
        return states.from_periods(body, pole=rows["pole"][k], **given, **labels)

    return call


def _entry(words: Any, k: int) -> Any:
    """Entry k of the words of the members, or the word of all of them; None for no word."""
    if words is None or isinstance(words, (str, int)):
        return words
    flat = np.asarray(words, dtype=object).ravel()
    word = flat[k if len(flat) > 1 else 0]
    return None if word == "" or word != word else word
