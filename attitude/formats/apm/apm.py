"""CCSDS Attitude Parameter Messages, versions 1.0 and 2.0, KVN and XML: one state and the inertia.

An APM with inertia and angular velocity determines a Body and a Spin; a FreeRotation is written as
one APM.  Conventions of quaternions, angles, rates and spin are those of `attitude_types`; the sign
of the products of inertia is that of each version's book unless `products` is given (see
`inertia`).  Maneuvers are kept among the keywords only.

If a message has the attitude in several forms, the first of quaternion, Euler angles and spin is
used, and for the rates the first of ANGVEL, derivatives of the quaternion, of the angles, spin.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from attitude import quaternion
from attitude.axes import axes
from attitude.body import Body
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.formats.apm import written
from attitude.formats.apm.blocks import read_kvn, read_xml
from attitude.formats.apm.state import Interpreted
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.ccsds import old_rates
from attitude.formats.ccsds.attitude_types import VERSIONS
from attitude.formats.rows import TOLERANCE, known_tolerance
from attitude.formats.sources import refuse_breaks
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.spin import Spin
from attitude.textfiles import kvn
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import cut, opened

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FilePath, FloatArray
    from attitude.paths.path import Path


@dataclass(frozen=True, eq=False)
class Parameters:
    """The content of an APM.

    Attributes
    ----------
    epoch : Instant
    wxyz : (4,) array or None
        Attitude, body to ICRF, scalar first; None in a message with an inertia alone.
    angular_velocity : (3,) array or None
        rad/s over the body axes, relative to inertial space.
    body : Body or None
        Over the axes that INERTIA_REF_FRAME names (``meta["inertia_frame"]``).
    meta : dict
        Keywords of the header, the meta data and each block, and comments.
    """

    epoch: Instant
    wxyz: FloatArray | None
    angular_velocity: FloatArray | None
    body: Body | None
    meta: dict[str, Any] = field(repr=False)

    @property
    def spin(self) -> Spin:
        """The Spin, in ICRF; AttitudeError if the message has no attitude or angular velocity."""
        if self.wxyz is None:
            raise AttitudeError(
                "the message has no attitude; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        if self.angular_velocity is None:
            raise AttitudeError(
                "the message has no angular velocity; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        return Spin(self.epoch, self.wxyz, self.angular_velocity)

    @property
    def motion(self) -> FreeRotation:
        """The FreeRotation from this state; AttitudeError if the message lacks rates or inertia."""
        if self.body is None:
            raise AttitudeError(
                "the message has no inertia; give a Body: FreeRotation(body, parameters.spin)."
            )
        self.refuse_other_axes()
        return FreeRotation(self.body, self.spin)

    def refuse_other_axes(self) -> None:
        """AttitudeError if the inertia is over other axes than those whose attitude is given."""
        inertia, body = self.meta["inertia_frame"], self.meta["body_frame"]
        if body is None:
            return
        if inertia.upper() != body.upper():
            raise AttitudeError(
                f"the inertia is over the axes {cut(inertia, '')}, but the attitude is that of "
                f"{cut(body, '')}; give a Body over the axes of the attitude: "
                "FreeRotation(body, parameters.spin)."
            )


def read(
    path: FilePath,
    *,
    tolerance: float = TOLERANCE,
    frame: str | None = None,
    orbit: Path | None = None,
    products: str | None = None,
    rates: str | None = None,
) -> Parameters:
    """A message as `Parameters`.

    Parameters
    ----------
    path, tolerance, frame, orbit
        As of `aem.read`.
    products : str, optional
        "tensor" if IXY is the entry of the inertia tensor, "integral" if the entry is -IXY; by
        default as in the book of the message's version (see `inertia`).
    rates : str, optional
        What X_RATE, Y_RATE, Z_RATE of version 1 are, as of `aem.read`.

    Raises
    ------
    AttitudeError
        As `aem.read`.
    """
    known_tolerance(tolerance)
    with opened(path) as lines:
        first = kvn.first(lines)
        message = None if first is None else read_kvn(lines, first)
    if message is None:
        message = read_xml(path)
    return Parameters(*Interpreted(message, tolerance, frame, orbit, products, rates).result())


def write(
    path: FilePath,
    motion: FreeRotation | Parameters,
    *,
    version: str = "2.0",
    xml: bool = False,
    frame: str | None = None,
    time_system: str = "UTC",
    inertia: bool = True,
    products: str | None = None,
    rates: str | None = None,
    object_name: str | None = None,
    object_id: str | None = None,
    center: str | None = None,
    body_frame: str | None = None,
    originator: str = "ATTITUDE",
    comments: Sequence[str] | None = None,
    creation_date: str | None = None,
    digits: int = ccsds_epochs.DIGITS,
) -> None:
    """Write the state and the inertia of a FreeRotation as an APM.

    Version 1 has the rates as derivatives of the quaternion; on those of its block of Euler angles
    readers disagree.

    Parameters
    ----------
    motion : FreeRotation or Parameters
        Names and comments of Parameters are kept unless others are given.
    frame : str, optional
        The external axes, which must be fixed; by default those of the spin.
    inertia : bool
        False leaves the inertia out (relative moments have no unit and cannot be written).
    products : str, optional
        As of `read`: the sign of the products of inertia.
    rates : str, optional
        Version 1.0: write the block of Euler angles (321) too, with "body" or "euler" rates.

    The other parameters are those of `aem.write`.

    Raises
    ------
    AttitudeError
        For unknown names of versions, axes or time systems, a state without rates or inertia, a
        motion whose angular velocity jumps, and a file that cannot be written.
    """
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; APM has {' and '.join(VERSIONS)}.")
    refuse_breaks(motion, "an APM")
    spin, body = motion.spin, motion.body if inertia else None
    if inertia and body is None:
        raise AttitudeError("there is no inertia to be written; give inertia=False.")
    meta: dict[str, Any] = {}
    if isinstance(motion, Parameters):
        meta = motion.meta
        if inertia:
            motion.refuse_other_axes()
    body_frame = body_frame or meta.get("body_frame") or "SC_BODY_1"
    center = center or meta.get("center")
    comments = list(meta.get("comments", ()) if comments is None else comments)
    found = axes.named(frame or axes.WRITTEN[spin.frame])
    if found.turning:
        raise AttitudeError(f"an APM is written in axes that do not turn, not {found.name}.")
    if (why := axes.body_name_fault(body_frame)) is not None:
        raise AttitudeError(f"body_frame is {body_frame!r}, which {why}; give another name.")
    wxyz = spin.wxyz
    if found.kind != spin.frame:
        outer = quaternion.conjugate(found.to_icrf(spin.epoch, 0.0, None))
        wxyz = quaternion.multiply(outer, spin.wxyz_icrf)
    scale = ccsds_epochs.writable(time_system)
    message = written.WrittenMessage(
        version=version,
        header={"CREATION_DATE": creation_date or ccsds_epochs.now(), "ORIGINATOR": originator},
        comments=comments,
        meta={
            "OBJECT_NAME": object_name or meta.get("object_name") or "UNKNOWN",
            "OBJECT_ID": object_id or meta.get("object_id") or "UNKNOWN",
            **({"CENTER_NAME": center} if center else {}),
            "TIME_SYSTEM": scale.upper(),
        },
        epoch=ccsds_epochs.texts(spin.epoch, np.zeros(1), None, scale, digits)[0],
        blocks=written.blocks(
            version, found.name, body_frame, wxyz, spin.angular_velocity, old_rates.known(rates)
        ),
    )
    if body is not None:
        message.blocks.append(written.inertia(version, body, body_frame, products))
    for text in (*message.header.values(), *message.meta.values(), *comments, body_frame):
        kvn.refuse_line_breaks(text)
    with written_whole(path, "the APM") as file:
        (written.write_xml if xml else written.write_kvn)(file, message)
