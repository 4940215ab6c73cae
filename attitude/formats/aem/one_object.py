"""The segments of a message that belong to one object, as one table."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from attitude import quaternion
from attitude import representations as forms
from attitude.attitude_table.table import AttitudeTable
from attitude.errors import AttitudeError
from attitude.textfiles.lines import cut

if TYPE_CHECKING:
    from collections.abc import Sequence

# Attitudes of two segments at one epoch contradict each other beyond this many times the tolerance
# of the length of quaternions: interpolation and few digits explain less.
_CONTRADICTING = 10.0
# Epochs at which two overlapping segments are compared.
_COMPARED = 1000


def chosen(
    tables: Sequence[AttitudeTable],
    path: str,
    name: str | None,
    segment: int | None,
    tolerance: float,
) -> AttitudeTable:
    """The segments of one object as one AttitudeTable.

    Parameters
    ----------
    tables : sequence of AttitudeTable
        The segments of the message.
    path : str
        Name of the file.
    name : str or None
        OBJECT_ID or OBJECT_NAME of the segments to take.
    segment : int or None
        The place of the one segment to take, counted from 0.
    tolerance : float
        Largest deviation from 1 of the length of a quaternion.

    Raises
    ------
    AttitudeError
        If no segment is of that name or place; if the segments are of several objects or body
        frames, or contradict each other where they overlap.
    """
    if segment is not None:
        whole = isinstance(segment, int) and not isinstance(segment, bool)
        if not whole or not 0 <= segment < len(tables):
            raise AttitudeError(
                f"{path}: segment is {segment!r}; the file has the segments 0 to "
                f"{len(tables) - 1}, give one."
            )
        tables = tables[segment : segment + 1]
    if name is not None:
        names = [(each.meta["object_id"], each.meta["object_name"]) for each in tables]
        found = [t for t, known in zip(tables, names, strict=True) if name in known]
        if not found:
            raise AttitudeError(
                f"{path}: object is {cut(name)}; the segments are those of {_listed(names)}."
            )
        tables = found
    for what, keys, advice in (
        ("objects", ("object_id", "object_name"), "choose one with object= or segment="),
        ("body frames", ("body_frame",), "choose one segment with segment="),
    ):
        # The identifier decides; names may be written differently.
        values = [tuple(each.meta[key] for key in keys) for each in tables]
        if len({value[0].upper() for value in values}) > 1:
            raise AttitudeError(
                f"{path}: its segments are those of several {what}: {_listed(values)}; {advice} "
                "(on the command line --object, --segment)."
            )
    _refuse_contradictions(tables, path, _CONTRADICTING * tolerance)
    return AttitudeTable.joined(tables)


def _listed(names):
    different = list(dict.fromkeys(names))
    texts = [" ".join(dict.fromkeys(cut(part, "") for part in name)) for name in different]
    return ", ".join(texts[:6]) + (", ..." if len(texts) > 6 else "")


def _refuse_contradictions(tables, path, most):
    """AttitudeError for two segments whose attitudes differ where both are usable."""
    # By first epochs, each segment is compared with the one before: enough to find an overlap.
    order = sorted(range(len(tables)), key=lambda k: tables[k].span[0].seconds)
    for first, second in pairwise(order):
        one, two = tables[first], tables[second]
        end = min(one.span[1], two.span[1], key=lambda each: each.seconds)
        start = two.span[0]
        if end.since(start) <= 0.0:
            continue
        # At records of the second, which the first interpolates.
        shift = two.epoch.since(one.epoch)
        t = two.seconds[(two.seconds + shift >= start.since(one.epoch))]
        t = t[t + shift <= end.since(one.epoch)]
        t = t[:: max(1, len(t) // _COMPARED)]
        try:
            a, b = one.at(t + shift).wxyz, two.at(t).wxyz
        except AttitudeError:
            continue  # records too far apart to be interpolated
        angle = forms.to_axis_angle(quaternion.multiply(quaternion.conjugate(a), b))[1]
        if np.any(angle > most):
            k = int(np.argmax(angle > most))
            raise AttitudeError(
                f"{path}: the segments {first} and {second} overlap, and at "
                f"{two.epoch.after(float(t[k])).utc_iso} UTC their attitudes are {angle[k]:.3g} "
                "rad apart; choose one with segment= (on the command line --segment)."
            )
