"""A thousand small asteroids under sunlight and friction: who tumbles, and who has relaxed.

Bodies of ten sizes begin to turn in random states, with periods of 3 to 300 h.  Sunlight (YORP)
changes rate, pole and mode in a time that grows as the square of the diameter, friction damps the
tumbling in a time that grows as the cube of the period; the ends of a thousand mean rotations are
drawn in the plane of Pravec et al. (2014, Icarus 233, 48, on Apophis): period against diameter,
the diameters spread by 15 %, with lines of equal damping time.  Slow and small bodies stay
tumblers, fast and large ones relax.

All have one invented convex shape, with moments that sunlight acts on as strongly as on (54509)
YORP of that size.  Friction is that of a quality factor, `attitude.torques.Rheology` with mu Q =
5e12 Pa (Harris 1994, Icarus 107, 209): its times rest on that number, which may be wrong by orders
of magnitude, and impacts are left out.  The span is 1 Myr for 1 km, and grows as the square.

    python examples/asteroid_end_states.py [COUNT]
"""

import sys

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from attitude import Body, Ensemble, paths, plots
from attitude.paths import Kepler
from attitude.shape import Ellipsoid, Mesh
from attitude.torques import InternalDissipation, QualityFactor, Rheology, SolarRadiation

Array = NDArray[np.float64]

PICTURE = "asteroid_end_states.png"
AU, YEAR, HOUR = 149597870700.0, 365.25 * 86400.0, 3600.0
SHAPE = np.array([150.0, 128.0, 93.0]) / 121.0  # of mean diameter 1
DENSITY, RIGIDITY, QUALITY = 2500.0, 5e9, 1000.0
DIAMETERS = np.geomspace(0.3, 20.0, 10)  # km
PERIODS = 3.0, 300.0  # h
SPAN = 1e6 * YEAR  # for 1 km
BARRIER = 2.2  # h: faster bodies of rubble lose mass
STATES = (
    ("relaxed", "#0072b2"),
    ("tumbling, short-axis mode", "#e69f00"),
    ("tumbling, long-axis mode", "#d55e00"),
    ("too slow for mean torques", "0.6"),
)


def asteroid(diameter: float) -> Mesh:
    """A convex body of a mean diameter in km: the hull of an ellipsoid with cubic bumps."""
    vertices = Ellipsoid(500.0 * diameter * SHAPE).facets(320).vertices
    x, y, z = vertices.T / np.sqrt(np.sum(vertices**2, axis=-1))
    bumps = 0.3 * x * z * (x - 0.5 * y) + 0.3 * x * y * z - 0.2 * x * y**2
    hull = ConvexHull(vertices * (1.0 + bumps)[:, None])
    corners = hull.points[hull.simplices]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside_out = np.sum(outward * hull.equations[:, :3], axis=-1) < 0.0
    return Mesh(hull.points, np.where(inside_out[:, None], hull.simplices[:, ::-1], hull.simplices))


def orbit() -> Kepler:
    """A circle of 1.5 au."""
    return paths.kepler(
        semi_major_axis=1.5 * AU,
        eccentricity=0.05,
        inclination=0.1,
        node=0.0,
        pericenter_argument=0.0,
        mean_anomaly=0.0,
        epoch="2026-01-01",
    )


def evolved(diameter: float, count: int, seed: int) -> tuple[Array, NDArray[np.int64]]:
    """Periods at the end in h, and the final state as a place in `STATES`."""
    mesh = asteroid(diameter)
    body = Body.from_shape(mesh, density=DENSITY)
    rng = np.random.default_rng(seed)
    periods = PERIODS[0] * (PERIODS[1] / PERIODS[0]) ** rng.random(count)
    along = rng.normal(size=(count, 3))
    momentum = along / np.linalg.norm(along, axis=1)[:, None]
    momentum *= (2.0 * np.pi / HOUR / periods * body.moments.max())[:, None]
    rates = (momentum / body.moments) @ body.principal_axes.T
    members = Ensemble(body, rng.normal(size=(count, 4)), rates, "2026-01-01")
    torques = [SolarRadiation(mesh, orbit()), InternalDissipation(friction(diameter))]
    settings = {"orbit": "averaged", "degree": 12, "tolerance": 1e-5, "on_error": "nan"}
    motions = members.averaged(torques, passages=seed, **settings)
    table = motions.table(SPAN * diameter**2)
    size = np.asarray(table["size"].value)
    tumbling = np.where(np.char.startswith(np.array(table["region"], str), "LAM"), 2, 1)
    state = np.where(np.degrees(table["theta"].value) < 1.0, 0, tumbling)
    state[np.array([event not in ("", "stays at the separatrix") for event in table["end"]])] = 3
    # |L| tells the period of relaxed rotation, as the lines of damping times take it
    return 2.0 * np.pi * body.moments.max() / size / HOUR, state


def friction(diameter: float) -> Rheology:
    """The friction of an ellipsoid of a mean diameter in km."""
    return Rheology(500.0 * diameter * SHAPE, DENSITY, QualityFactor(RIGIDITY, QUALITY))


def damping_time(diameter: float, period: float) -> float:
    """s, in which friction takes a small tilt to an e-th part, for a period in h."""
    a, b, c = 500.0 * diameter * SHAPE
    mass = 4.0 / 3.0 * np.pi * DENSITY * a * b * c
    body = Body(moments=mass / 5.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b]))
    least, _, most = body.moments
    momentum, tilt = most * 2.0 * np.pi / (period * HOUR), 1e-4
    power = friction(diameter).power(body, momentum, tilt)
    return float(momentum**2 * (1.0 / least - 1.0 / most) * tilt / power)


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    members = max(count // len(DIAMETERS), 1)
    print(f"{members} bodies of each size; mu Q = {RIGIDITY * QUALITY:.1g} Pa")
    print(f"{'km':>6}{'Myr':>8}  " + "  ".join(name for name, _ in STATES))
    points = []
    for seed, diameter in enumerate(DIAMETERS):
        periods, state = evolved(float(diameter), members, seed)
        counts = [int(np.sum(state == k)) for k in range(len(STATES))]
        columns = "".join(
            f"{n:{len(name) + 2}d}" for n, (name, _) in zip(counts, STATES, strict=True)
        )
        print(f"{diameter:6.2f}{diameter**2:8.2f}{columns}")
        points.append((np.full(members, diameter), periods, state))
    x, y, state = (np.concatenate(column) for column in zip(*points, strict=True))
    known = np.isfinite(y) & (y > BARRIER)
    for k, name in ((0, "relaxed"), (1, "tumbling")):
        chosen = known & ((state == 0) if k == 0 else (state == 1) | (state == 2))
        years = [damping_time(d, p) / YEAR for d, p in zip(x[chosen], y[chosen], strict=True)]
        if years:
            low, middle, high = np.percentile(years, (10.0, 50.0, 90.0)) / 1e6
            print(f"{name}: damping times of {low:.3g}, {middle:.3g}, {high:.3g} Myr", end=" ")
            print("(10, 50, 90 % of them)")
    draw(x, y, state)


def draw(diameters: Array, periods: Array, state: NDArray[np.int64]) -> None:
    figure, (panel,) = plots.stacked((9, 7), 1)
    spread = np.random.default_rng(len(DIAMETERS)).uniform(0.85, 1.18, len(diameters))
    for k, (name, color) in enumerate(STATES):
        chosen = state == k
        panel.plot(
            (diameters * spread)[chosen], periods[chosen], ".", color=color, ms=6, label=name
        )
    ends = DIAMETERS[[0, -1]] * np.array([0.8, 1.25])
    for years in (1e6, 1e7, 1e8, 1e9):
        # the time grows as the cube of the period
        lines = [(years * YEAR / damping_time(float(d), 1.0)) ** (1.0 / 3.0) for d in ends]
        panel.plot(ends, lines, "k-", lw=0.8)
        panel.annotate(f"{years / 1e6:g} Myr", (ends[0], lines[0]), fontsize=9, va="bottom")
    harris = 17.0 * ends ** (2.0 / 3.0) * 0.1 ** (1.0 / 3.0)
    panel.plot(ends, harris, "k:", lw=1, label="100 Myr by the rule of Harris (1994)")
    panel.axhline(BARRIER, color="0.4", ls="--", lw=1, label="spin barrier of rubble, 2.2 h")
    panel.set(
        xscale="log",
        yscale="log",
        xlabel="diameter (km)",
        ylabel="period of the momentum about the short axis (h)",
        title=f"{len(state)} asteroids under sunlight and friction: lines of equal damping time",
        xlim=ends,
        ylim=(0.3, 3000.0),
    )
    panel.legend(fontsize=9, loc="upper right")
    figure.savefig(PICTURE, dpi=150)
    print(f"\nPicture: {PICTURE}")


if __name__ == "__main__":
    main()
