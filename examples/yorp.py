"""Sunlight spins a small asteroid up and turns its axis: the YORP effect, integrated and averaged.

Size, period and orbit are about those of (54509) YORP, on which the effect was first measured: 150
by 128 by 93 m, 12.17 min, 1.006 au, e = 0.230 (Taylor et al. 2007, Science 316, 274; Lowry et al.
2007, Science 316, 272: the spin rate grows by 2.0e-4 deg/day2).  The shape is invented, convex and
without symmetry, and the density is assumed: the rates have that order of magnitude, but do not
predict those of that body.

For some obliquities the motion is integrated over one orbit, 43,600 rotations, and the change of
the spin rate and the obliquity is compared with that from the torque averaged by quadrature.

    python examples/yorp.py
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from attitude import Body, Spin, paths
from attitude.frames import quaternion
from attitude.paths import Kepler
from attitude.shape import Ellipsoid, Mesh
from attitude.splitting import TorquedRotation
from attitude.torques import SolarRadiation

Array = NDArray[np.float64]

PICTURE = "yorp.png"
AU, LIGHT, FLUX = 149597870700.0, 299792458.0, 1361.0
DAY, YEAR = 86400.0, 365.25 * 86400.0
DIAMETERS, DENSITY, PERIOD = (150.0, 128.0, 93.0), 2500.0, 12.17 * 60.0
STEPS_A_ROTATION = 25.4  # not a whole number, so that an orbit samples each phase of the rotation
OBLIQUITIES = np.radians([15.0, 45.0, 75.0, 105.0, 135.0, 165.0])


def asteroid() -> Mesh:
    """The convex hull of an ellipsoid with a few cubic bumps, without mirror symmetry."""
    vertices = Ellipsoid(0.5 * np.array(DIAMETERS)).facets(320).vertices
    x, y, z = vertices.T / np.sqrt(np.sum(vertices**2, axis=-1))
    bumps = 0.3 * x * z * (x - 0.5 * y) + 0.3 * x * y * z - 0.2 * x * y**2
    hull = ConvexHull(vertices * (1.0 + bumps)[:, None])
    corners = hull.points[hull.simplices]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside_out = np.sum(outward * hull.equations[:, :3], axis=-1) < 0.0
    facets = np.where(inside_out[:, None], hull.simplices[:, ::-1], hull.simplices)
    mesh = Mesh(hull.points, facets)
    assert mesh.is_convex  # facets do not shade each other
    return mesh


def orbit() -> Kepler:
    """The orbit about the Sun, in the ecliptic; the real one is inclined by 1.6 deg."""
    return paths.kepler(
        semi_major_axis=1.006 * AU,
        eccentricity=0.230,
        inclination=0.0,
        node=0.0,
        pericenter_argument=0.0,
        mean_anomaly=0.0,
        epoch="2026-01-01",
    )


def spinning(body: Body, path: Kepler, obliquity: float) -> Spin:
    """Rotation about the short axis, the pole tilted by the obliquity towards the pericentre."""
    normal, towards = orbit_axes(path)
    pole = np.cos(obliquity) * normal + np.sin(obliquity) * towards
    short = body.principal_axes[:, np.argmax(body.moments)]
    x = np.array([1.0, 0.0, 0.0])
    turn = quaternion.from_matrix(frame_of(pole, normal) @ frame_of(short, x).T)
    return Spin(epoch="2026-01-01", wxyz=turn, angular_velocity=2.0 * np.pi / PERIOD * short)


def orbit_axes(path: Kepler) -> tuple[Array, Array]:
    """Unit vectors along the orbit's normal and towards the pericentre, ICRF."""
    start = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 0)).epoch
    place, speed = (x[0] for x in path.state(start, np.zeros(1)))
    normal = np.cross(place, speed)
    return normal / np.sqrt(normal @ normal), place / np.sqrt(place @ place)


def frame_of(third: Array, other: Array) -> Array:
    """A matrix whose columns are right-handed axes, the last along `third`."""
    first = np.cross(other, third)
    first /= np.sqrt(first @ first)
    return np.column_stack([first, np.cross(third, first), third])


# Rates, integrated and averaged -------------------------------------------------------------------


def integrated(
    motion: TorquedRotation, body: Body, normal: Array, span: float, rotations: int = 8
) -> Array:
    """(dw/dt, dobliquity/dt) from means over some rotations about the start and the end of a span.

    The span is an orbit, so that seasonal changes cancel.
    """
    ends = []
    for middle in (0.0, span):
        history = motion.at(middle + PERIOD * rotations * (np.arange(512.0) / 512.0 - 0.5))
        momentum = history.body_to_inertial(history.angular_velocity @ body.tensor)
        size = np.sqrt(np.sum(momentum**2, axis=-1))
        tilt = np.arccos(momentum @ normal / size)
        ends.append((np.mean(size) / body.moments.max(), np.mean(tilt)))
    return np.subtract(ends[1], ends[0]) / span


def averaged(
    mesh: Mesh,
    body: Body,
    path: Kepler,
    spin: Spin,
    normal: Array,
    places: int = 240,
    phases: int = 240,
) -> Array:
    """The same from the torque on a uniformly rotating body, averaged over orbit and rotation."""
    seconds = path.period * (np.arange(places) + 0.5) / places
    place = path.position(spin.epoch, seconds)
    distance = np.sqrt(np.sum(place**2, axis=-1))
    short = spin.angular_velocity / np.sqrt(spin.angular_velocity @ spin.angular_velocity)
    half = np.pi * (np.arange(phases) + 0.5) / phases
    turns = np.column_stack([np.cos(half), np.sin(half)[:, None] * short])
    total = np.zeros(3)
    for turn in turns:
        wxyz = quaternion.multiply(spin.wxyz_icrf, turn)
        sun = quaternion.rotate(quaternion.conjugate(wxyz), -place / distance[:, None])
        torque = light(mesh, body.center_of_mass, sun) * (AU / distance[:, None]) ** 2
        total += quaternion.rotate(wxyz, np.mean(torque, axis=0)) / phases
    pole = quaternion.rotate(spin.wxyz_icrf, short)
    inertia, rate = float(body.moments.max()), 2.0 * np.pi / PERIOD
    cosine = pole @ normal
    across = total @ (cosine * pole - normal) / np.sqrt(1.0 - cosine**2)
    return np.array([total @ pole, across / rate]) / inertia


def light(mesh: Mesh, center: Array, sun: Array) -> Array:
    """Torque (N, 3) at 1 au on facets that scatter all light by Lambert's law (Rubincam 2000)."""
    cosine = np.maximum(sun @ mesh.normals.T, 0.0)
    lit = -FLUX / LIGHT * mesh.areas * cosine
    arm = mesh.centroids - center
    along_normal = lit @ np.cross(arm, mesh.normals) * (2.0 / 3.0)
    torque: Array = np.cross(lit @ arm, sun) + along_normal
    return torque


# Evolution ----------------------------------------------------------------------------------------


def evolution(grid: Array, rates: Array, obliquity: float, years: Array) -> Array:
    """Spin rate and obliquity (N, 2) over time, changed by the averaged rates alone."""
    start = 2.0 * np.pi / PERIOD
    state, states = np.array([start, obliquity]), []

    def slope(y: Array) -> Array:
        spin_up, turning = (np.interp(y[1], grid, rates[:, k]) for k in (0, 1))
        return np.array([spin_up, turning * start / y[0]])  # the axis turns by torque / momentum

    step = (years[1] - years[0]) * YEAR
    for _ in years:
        states.append(state)
        state = state + step * slope(state + 0.5 * step * slope(state))
    return np.array(states)


def main() -> None:
    mesh, path = asteroid(), orbit()
    body = Body.from_shape(mesh, density=DENSITY)
    normal, _ = orbit_axes(path)
    sunlight = SolarRadiation(mesh, path, diffuse=1.0, flux=FLUX)
    print(f"{len(mesh)} facets, {mesh.volume * DENSITY:.3g} kg; one orbit:")
    print(f"{path.period / DAY:.1f} days, {path.period / PERIOD:.0f} rotations of", end=" ")
    print(f"{STEPS_A_ROTATION} steps\n")
    print(f"{'obliquity':>9}{'spin rate, 1e-4 deg/day2':>29}{'obliquity, deg in 1e5 years':>31}")
    print(f"{'deg':>9}{'integrated':>17}{'averaged':>12}{'integrated':>19}{'averaged':>12}")
    unit = np.array([np.degrees(1.0) * DAY**2 / 1e-4, np.degrees(1.0) * 1e5 * YEAR])
    found, worst = [], np.zeros(2)
    for obliquity in OBLIQUITIES:
        spin = spinning(body, path, obliquity)
        motion = TorquedRotation(body, spin, sunlight, step=PERIOD / STEPS_A_ROTATION)
        rates = integrated(motion, body, normal, path.period)
        expected = averaged(mesh, body, path, spin, normal)
        found.append(rates * unit)
        worst = np.maximum(worst, np.abs(rates - expected))
        (a, c), (b, d) = rates * unit, expected * unit
        print(f"{np.degrees(obliquity):9.0f}{a:17.4f}{b:12.4f}{c:19.4f}{d:12.4f}")
    grid = np.radians(np.linspace(0.5, 179.5, 60))
    curve = [averaged(mesh, body, path, spinning(body, path, e), normal, 90, 90) for e in grid]
    share = worst / np.max(np.abs(curve), axis=0)
    print(f"\nThey differ by at most {share[0]:.2%} and {share[1]:.2%} of the largest rates.")
    years = np.linspace(0.0, 2e6, 4001)
    ahead = [evolution(grid, np.array(curve), e, years) for e in OBLIQUITIES]
    for obliquity, states in zip(OBLIQUITIES, ahead, strict=True):
        hours = 2.0 * np.pi / states[-1, 0] / 60.0
        print(
            f"From {np.degrees(obliquity):.0f} deg, after {years[-1]:.0f} years: "
            f"{np.degrees(states[-1, 1]):.1f} deg, a period of {hours:.2f} min."
        )
    draw(np.degrees(grid), np.array(curve) * unit, np.array(found), years, ahead)


def draw(degrees: Array, curve: Array, found: Array, years: Array, ahead: list[Array]) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
    names = ("spin rate (1e-4 deg/day2)", "obliquity (deg in 1e5 years)")
    for k, name in enumerate(names):
        axes[0, k].plot(degrees, curve[:, k], label="torque averaged by quadrature")
        axes[0, k].plot(np.degrees(OBLIQUITIES), found[:, k], "o", label="one orbit integrated")
        axes[0, k].set(xlabel="obliquity (deg)", title=f"change of the {name}")
        axes[0, k].axhline(0.0, color="0.7", lw=0.8)
    axes[0, 1].legend()
    for states in ahead:
        axes[1, 0].plot(years / 1e3, 2.0 * np.pi / states[:, 0] / 60.0)
        axes[1, 1].plot(years / 1e3, np.degrees(states[:, 1]))
    axes[1, 0].set(xlabel="1000 years", ylabel="period (min)")
    axes[1, 1].set(xlabel="1000 years", ylabel="obliquity (deg)")
    for panel in axes.flat:
        panel.grid(alpha=0.3)
    figure.savefig(PICTURE, dpi=150)
    plt.close(figure)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
