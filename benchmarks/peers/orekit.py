"""Orekit's TorqueFree attitude provider, where a Java virtual machine is present."""

import shutil

import numpy as np

from benchmarks.peers import Missing, Peer


def peers():
    try:
        import jpype  # noqa: F401
        import orekit_jpype
    except ImportError as err:
        raise Missing("package orekit-jpype is not installed") from err
    if shutil.which("java") is None:
        raise Missing("no Java virtual machine is installed")
    try:
        orekit_jpype.initVM()
    except Exception as err:  # any error of Java
        raise Missing(f"Orekit does not start ({err})") from err
    return [Peer("Orekit TorqueFree", "double", _solver(), 1e12)]


def _solver():
    from org.hipparchus.geometry.euclidean.threed import Rotation, Vector3D
    from org.orekit.attitudes import Attitude, Inertia, InertiaAxis, TorqueFree
    from org.orekit.frames import FramesFactory
    from org.orekit.time import AbsoluteDate
    from org.orekit.utils import AbsolutePVCoordinates, PVCoordinates

    frame = FramesFactory.getGCRF()
    start = AbsoluteDate.ARBITRARY_EPOCH

    def vector(v):
        return Vector3D(*(float(x) for x in v))

    still = AbsolutePVCoordinates(
        frame, start, PVCoordinates(Vector3D(7e6, 0.0, 0.0), Vector3D(0.0, 7.5e3, 0.0))
    )

    def solve(moments, wxyz0, omega0, t):
        # Orekit's rotations go from inertial to body: the conjugate of ours with its own signs.
        rotation = Rotation(*(float(x) for x in wxyz0), True)
        axes = (Vector3D.PLUS_I, Vector3D.PLUS_J, Vector3D.PLUS_K)
        inertia = Inertia(
            *(InertiaAxis(float(i), axis) for i, axis in zip(moments, axes, strict=True))
        )
        initial = Attitude(start, frame, rotation, vector(omega0), Vector3D.ZERO)
        provider = TorqueFree(initial, inertia)
        out = np.empty((len(t), 4))
        for k, seconds in enumerate(t.tolist()):
            found = provider.getAttitude(still, start.shiftedBy(seconds), frame).getRotation()
            out[k] = (found.getQ0(), found.getQ1(), found.getQ2(), found.getQ3())
        return out

    return solve
