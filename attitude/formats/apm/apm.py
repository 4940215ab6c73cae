"""CCSDS Attitude Parameter Messages, versions 1.0 and 2.0, KVN and XML: one state and the inertia.

An APM with inertia and angular velocity is a complete Body and Spin, and a FreeRotation goes into
one.  Conventions of quaternions, angles, rates and spin are those of `attitude_types`; the
sign of the cross products of inertia is that of each version's book, and can be told (see
`apm_inertia`).  Maneuvers are kept among the keywords, no more.

Where a message tells the attitude in several ways, the first of quaternion, Euler angles and spin
counts, and for the rates the first of ANGVEL, derivatives of the quaternion, of the angles, spin.
"""

from dataclasses import dataclass, field

import numpy as np

from attitude import quaternion
from attitude.body import Body
from attitude.epochs.inputs import Instant
from attitude.errors import AttitudeError
from attitude.formats.apm import written
from attitude.formats.apm.blocks import VERSIONS, read_kvn, read_xml
from attitude.formats.apm.state import Interpreted
from attitude.formats.ccsds import axes
from attitude.formats.ccsds import epochs as ccsds_epochs
from attitude.formats.rows import TOLERANCE, known_tolerance
from attitude.free_rotation.free_rotation import FreeRotation
from attitude.spin import Spin
from attitude.textfiles import kvn
from attitude.textfiles.atomic_write import written_whole
from attitude.textfiles.lines import opened


@dataclass(frozen=True, eq=False)
class Parameters:
    """What an APM says.

    Attributes
    ----------
    epoch : Instant
    wxyz : (4,) array
        Body to ICRF.
    angular_velocity : (3,) array or None
        rad/s over the body axes, relative to inertial space.
    body : Body or None
        Over the axes that INERTIA_REF_FRAME names (``meta["inertia_frame"]``).
    meta : dict
        Keywords of the header, the meta data and each block, and comments.
    """

    epoch: Instant
    wxyz: np.ndarray
    angular_velocity: np.ndarray | None
    body: Body | None
    meta: dict = field(repr=False)

    @property
    def spin(self):
        """The Spin, in ICRF; AttitudeError without rates."""
        if self.angular_velocity is None:
            raise AttitudeError(
                "the message has no angular velocity; a Spin needs one: "
                "Spin(epoch=..., wxyz=..., angular_velocity=...)."
            )
        return Spin(self.epoch, self.wxyz, self.angular_velocity)

    @property
    def motion(self):
        """The FreeRotation from this state; AttitudeError without rates or inertia."""
        if self.body is None:
            raise AttitudeError(
                "the message has no inertia; give a Body: FreeRotation(body, parameters.spin)."
            )
        self.refuse_other_axes()
        return FreeRotation(self.body, self.spin)

    def refuse_other_axes(self):
        """AttitudeError where the inertia is not over the axes whose attitude is told."""
        inertia, body = self.meta["inertia_frame"], self.meta["body_frame"]
        if inertia.upper() != body.upper():
            raise AttitudeError(
                f"the inertia is over the axes {inertia}, and the attitude is that of {body}; give "
                f"a Body over the axes {body}: FreeRotation(body, parameters.spin)."
            )


def read(path, *, tolerance=TOLERANCE, frame=None, orbit=None, products=None):
    """A message as `Parameters`.

    Parameters
    ----------
    products : str, optional
        "tensor" where IXY is the entry of the inertia tensor, "integral" where that is -IXY; by
        default as the book of the message's version has it (see `apm_inertia`).

    Others, and errors, as of `aem.read`.
    """
    known_tolerance(tolerance)
    with opened(path) as lines:
        first = kvn.first(lines)
        message = None if first is None else read_kvn(lines, first)
    if message is None:
        message = read_xml(path)
    return Parameters(*Interpreted(message, tolerance, frame, orbit, products).result())


def write(
    path,
    motion,
    *,
    version="2.0",
    xml=False,
    frame=None,
    time_system="UTC",
    inertia=True,
    products=None,
    object_name=None,
    object_id=None,
    center=None,
    body_frame=None,
    originator="ATTITUDE",
    comments=None,
    creation_date=None,
    digits=ccsds_epochs.DIGITS,
):
    """Write the state and the inertia of a FreeRotation as an APM.

    Parameters
    ----------
    motion : FreeRotation, or Parameters that were read
        Of these, names and comments are kept where no others are given.
    frame : str, optional
        The external axes, fixed ones; those of the spin by default.
    inertia : bool
        False leaves the inertia out (relative moments have no unit and cannot be written).
    products : str, optional
        As of `read`: the sign of the cross products of inertia.

    Others as of `aem.write`.  Version 1 has its rates among the Euler angles (321), beside the
    quaternion.
    """
    if version not in VERSIONS:
        raise AttitudeError(f"version is {version!r}; APM has {' and '.join(VERSIONS)}.")
    spin, body = motion.spin, motion.body
    if inertia and body is None:
        raise AttitudeError("there is no inertia to be written; write inertia=False.")
    said = {}
    if isinstance(motion, Parameters):
        said = motion.meta
        if inertia:
            motion.refuse_other_axes()
    body_frame = body_frame or said.get("body_frame") or "SC_BODY_1"
    center = center or said.get("center")
    comments = said.get("comments", ()) if comments is None else comments
    found = axes.named(frame or axes.WRITTEN[spin.frame])
    if found.turning:
        raise AttitudeError(f"an APM is written in axes that do not turn, not {found.name}.")
    if axes.known(body_frame) is not None:
        raise AttitudeError(f"body_frame is {body_frame!r}, the name of other axes; give another.")
    wxyz = spin.wxyz
    if found.kind != spin.frame:
        outer = quaternion.conjugate(found.to_icrf(spin.epoch, 0.0, None))
        wxyz = quaternion.multiply(outer, spin.wxyz_icrf)
    scale = ccsds_epochs.writable(time_system)
    message = {
        "version": version,
        "header": {"CREATION_DATE": creation_date or ccsds_epochs.now(), "ORIGINATOR": originator},
        "comments": list(comments),
        "meta": {
            "OBJECT_NAME": object_name or said.get("object_name") or "UNKNOWN",
            "OBJECT_ID": object_id or said.get("object_id") or "UNKNOWN",
            **({"CENTER_NAME": center} if center else {}),
            "TIME_SYSTEM": scale.upper(),
        },
        "epoch": ccsds_epochs.texts(spin.epoch, np.zeros(1), None, scale, digits)[0],
        "blocks": written.blocks(version, found.name, body_frame, wxyz, spin.angular_velocity),
    }
    if inertia:
        message["blocks"].append(written.inertia(version, body, body_frame, products))
    for text in (*message["header"].values(), *message["meta"].values(), *comments, body_frame):
        kvn.refuse_line_breaks(text)
    with written_whole(path, "the APM") as file:
        (written.write_xml if xml else written.write_kvn)(file, message)
