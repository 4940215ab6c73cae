"""Results stay the same, bit for bit: attitudes, light curves, events, files, inversions.

    python tests/house/test_fixed_results.py  # compare, and print what changed
    python tests/house/test_fixed_results.py --remake  # store them
    python tests/house/test_fixed_results.py --remake --only files  # parts by name
    python tests/house/test_fixed_results.py --processors [PYTHON]  # which depend on it?

A net for changes that must not change results: it says nothing about which result is right.  Names
are public, so that a file that moves needs no change here.  What is stored of a result:

* `sha256` of its bytes, and `places`: the value at 24 places of it;
* `anywhere`: it has the same bits with every processor that `--processors` imitates, and with the
  versions of the other PYTHON.  Its sha256 is compared everywhere.  Others are compared by sha256
  where processor and versions are those of `made_with` of their part, elsewhere at the 24 places,
  with ROOM;
* numbers with a tolerance of their own (inversions and fits, which iterate), compared everywhere.

Random numbers are those of `random.Random`, the same in all versions of Python.
"""
# as a script, it puts the checkout on the path before it imports from it

import argparse
import hashlib
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import warnings
from contextlib import redirect_stdout
from importlib.metadata import PackageNotFoundError, version
from io import StringIO
from pathlib import Path

from tests.support.places import ROOT

if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    os.environ.setdefault("ATTITUDE_COMPILE", "always")
    os.environ["ATTITUDE_CACHE"] = "off"

import llvmlite.binding
import numpy as np
import pytest

from attitude import (
    Arcs,
    AttitudeTable,
    Body,
    Ensemble,
    FreeRotation,
    Impulse,
    InertiaChange,
    Scene,
    Spin,
    TorquedRotation,
    catalog,
    epochs,
    events,
    fit,
    fit_directions,
    fit_rates,
    inversion,
    light_curve,
    paths,
    photometry,
    propagate,
    scattering,
    shape,
    torques,
    viewer,
)
from attitude.ensemble import AngleTo
from attitude.formats import (
    acm,
    aem,
    apm,
    ck,
    damit,
    damit_light_curve,
    detect,
    mission,
    spin_file,
    stk,
    tables,
)
from tests.support.raycast import brightness_by_rays

DATA = ROOT / "data"
STORED = ROOT / "tests" / "data" / "fixed_results.json"
COMMAND = "python tests/house/test_fixed_results.py --remake"
PLACES = 24
# Of the largest value of a result, where another processor or version rounds otherwise: some
# hundred roundings, which matrix products, astropy's tables and libm's functions may differ by.
ROOM = 1e-13
EPOCH = "2026-01-01T00:00:00"
DAY = 86400.0
CREATED = "2026-01-01T00:00:00"
# The versions that may change a bit.
PACKAGES = ("numpy", "scipy", "numba", "astropy", "pyerfa", "skyfield", "sgp4")


class Numbers(dict):
    """Named numbers or texts that are compared with a tolerance: {name: (value, tolerance)}."""


PARTS = {}


def part(slow=False):
    """Register a function that yields (name, result): an array, text, bytes or Numbers."""

    def registered(function):
        PARTS[function.__name__] = function, slow
        return function

    return registered


# --- bodies


def states(count=125, seed=2026):
    """{kind: (moments (N, 3), wxyz (N, 4), omega (N, 3))} of all modes of motion."""
    draw = random.Random(seed)

    def body():
        a, b = sorted((draw.random(), draw.random()))
        c = b + (a - 0.02) * draw.random() if a > 0.02 else b
        return [10.0 * a + 0.5, 10.0 * b + 0.6, 10.0 * c + 0.65]

    def turn():
        return [draw.random() - 0.5 for _ in range(4)]

    def rates(scale=2.0):
        return [scale * (draw.random() - 0.5) for _ in range(3)]

    def near_separatrix(moments):
        a, b, c = moments
        ratio = math.sqrt(c * (c - b) / (a * (b - a)))
        off = 1.0 + draw.choice((1, -1)) * 10.0 ** -draw.randint(1, 15)
        z = 0.3 + draw.random()
        return [ratio * z * off, draw.random() - 0.5, z]

    def along(axis, tilt):
        omega = [tilt * (draw.random() - 0.5) for _ in range(3)]
        omega[axis] = draw.choice((1, -1)) * (0.2 + draw.random())
        return omega

    kinds = {
        "long_and_short_axis": lambda: (body(), rates()),
        "any_order_of_moments": lambda: (draw.sample(body(), 3), rates()),
        "near_separatrix": lambda: ((m := body()), near_separatrix(m)),
        "principal": lambda: (body(), along(draw.randrange(3), 0.0)),
        "nearly_principal": lambda: (
            body(),
            along(draw.randrange(3), 10.0 ** -draw.randint(2, 14)),
        ),
        "symmetric": lambda: (
            [(m := body())[0], m[0], m[2] if m[2] < 2 * m[0] else m[0] * 1.5],
            rates(),
        ),
        "spherical": lambda: ([body()[0]] * 3, rates()),
        "at_rest": lambda: (body(), [0.0, 0.0, 0.0]),
    }
    made = {}
    for kind, drawn in kinds.items():
        rows = [(*drawn(), turn()) for _ in range(count)]
        moments, omega, wxyz = (np.array(column) for column in zip(*rows, strict=True))
        made[kind] = moments, wxyz / np.sqrt(np.sum(wxyz**2, axis=1))[:, None], omega
    return made


def grid(count, length, seed=1):
    """Epochs in no order, zero and negative ones among them, s."""
    draw = random.Random(seed)
    t = [0.0, -0.0, 1e-9, -length, length * 100.0]
    return np.array(t + [length * (2.0 * draw.random() - 0.5) for _ in range(count - len(t))])


@part()
def propagated():
    """1000 bodies at 100 epochs each, and with t_low and derivatives."""
    t = grid(100, 300.0)
    low = np.array([1e-17 * k for k in range(len(t))])
    for kind, (moments, wxyz, omega) in states().items():
        found = propagate(moments, wxyz, omega, t, angular_velocity=True)
        yield from zip((f"{kind}/wxyz", f"{kind}/omega"), found, strict=True)
        yield f"{kind}/t_low", propagate(moments, wxyz, omega, 1e7 + t, t_low=low)
        yield (
            f"{kind}/sensitivity",
            propagate(moments[:10], wxyz[:10], omega[:10], t[5:25], sensitivity=True)[1],
        )
    moments, wxyz, omega = states()["long_and_short_axis"]
    yield "single", propagate(moments[0], wxyz[0], omega[0], 12.5)
    long = np.linspace(0.0, 1e5, 20_000)
    yield "long", propagate(moments[0], wxyz[0], omega[0], long)
    tensors = [FreeRotation(*pair).body.tensor for pair in tensor_motions()]
    yield "tensors", propagate(None, wxyz[:5], omega[:5], t, tensors=np.array(tensors))


def tensor_motions():
    """Bodies with tensors over turned axes, and their spins."""
    for moments, wxyz, omega in zip(*(x[:5] for x in states()["near_separatrix"]), strict=True):
        w, x, y, z = wxyz
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        # Sums of three products one by one: a matrix product may round otherwise elsewhere.
        tensor = sum(m * turn[:, None, k] * turn[None, :, k] for k, m in enumerate(moments))
        yield Body(tensor=0.5 * (tensor + tensor.T)), Spin(EPOCH, wxyz, omega, frame="ecliptic")


@part()
def free_rotations():
    """Single motions: attitudes, rates, what follows from them, and what describes the motion."""
    t = grid(60, 500.0, seed=3)
    for kind, rows in states(12).items():
        motions = [
            FreeRotation(Body(moments=m), Spin(EPOCH, q, w)) for m, q, w in zip(*rows, strict=True)
        ]
        yield f"{kind}/wxyz", np.array([each.at(t).wxyz for each in motions])
        yield f"{kind}/low", np.array([each.at(t + 1e8, low=t * 1e-16).wxyz for each in motions])
        yield f"{kind}/omega", np.array([each.at(t).angular_velocity for each in motions])
        yield f"{kind}/acceleration", np.array([x.at(t).angular_acceleration for x in motions])
        yield f"{kind}/mode", " ".join(each.mode.name for each in motions)
        described = [[x.period_psi, x.period_phi, x.energy, *x.momentum] for x in motions]
        yield f"{kind}/periods_energy_momentum", np.array(described, dtype=float)
        yield f"{kind}/sensitivity", np.array([x.sensitivity_at(0.2 * t[5:14]) for x in motions])
    for k, (body, spin) in enumerate(tensor_motions()):
        history = FreeRotation(body, spin).at(t)
        yield f"tensor{k}/wxyz", history.wxyz
        yield f"tensor{k}/omega", history.angular_velocity
    history = toutatis().at(np.linspace(0.0, 30.0 * DAY, 300))
    yield "toutatis/matrix", history.matrix
    yield "toutatis/inertial_rates", history.angular_velocity_inertial
    yield "toutatis/euler", history.euler("ZXZ")
    yield "toutatis/to_body", history.inertial_to_body([0.6, 0.0, 0.8])
    dates = [f"199{k % 10}-1{k % 3}-{k % 28 + 1:02d}T{k % 24:02d}:{k % 60:02d}" for k in range(60)]
    yield "toutatis/dates", toutatis().at(dates).wxyz
    yield "toutatis/print", str(toutatis())
    for frame in ("teme", "tod", "itrf", "eme2000", "gcrf", "ecliptic"):
        try:
            yield f"toutatis/in_{frame}", history.in_frame(frame).wxyz
        except ValueError as err:
            yield f"toutatis/in_{frame}", str(err)


def toutatis():
    """The tumbler of data/spin."""
    return spin_file.read(DATA / "spin" / "toutatis.toml").motion


def uncertain():
    """A spin with errors of 1 to 3 mrad and 1e-5 rad/s, correlated."""
    draw = random.Random(4)
    factor = np.array([[draw.random() - 0.5 for _ in range(9)] for _ in range(9)])
    scale = np.array([3e-3] * 3 + [1e-5] * 3 + [1e-3] * 3)
    factor *= scale[:, None]
    covariance = np.zeros((9, 9))
    for k in range(9):
        covariance += factor[:, None, k] * factor[None, :, k]
    spin = Spin(EPOCH, (0.5, 0.5, -0.1, 0.7), (0.03, 0.011, -0.02), covariance=covariance)
    return FreeRotation(Body(moments=(1.2, 3.1, 3.4)), spin)


@part()
def derivatives():
    """Sensitivities with the axes, parameters and rates that may be asked for; covariances."""
    motion, t = uncertain(), np.linspace(-900.0, 1e4, 40)
    yield "inertial", motion.sensitivity_at(t)
    yield "body", motion.sensitivity_at(t, axes="body")
    for k, found in enumerate(motion.sensitivity_at(t, angular_velocity=True)):
        yield f"both{k}", found
    yield "elements", motion.sensitivity_at(t, by="elements")
    history = motion.at(t)
    for name in ("covariance", "sigma", "attitude_covariance", "nonlinearity"):
        yield name, getattr(history, name)
    yield "sigma_angular_velocity", history.sigma_angular_velocity
    yield "momentum_covariance", motion.momentum_covariance
    yield "sample", np.array([each.at(t).wxyz for each in motion.sample(5, seed=3)])
    yield "sigma_points", np.array([each.at(t[:4]).wxyz for each in motion.sigma_points()])


@part()
def ensembles():
    """Shared, own and ragged epochs; blocks; descriptions; derivatives; draws; quantities."""
    rows = [np.concatenate(each) for each in zip(*states(40).values(), strict=True)]
    moments, wxyz, omega = rows
    count = len(moments)
    ensemble = Ensemble(
        moments=moments, wxyz=wxyz, angular_velocity=omega, epoch=EPOCH, frame="ecliptic"
    )
    t = grid(50, 800.0, seed=6)
    shared = ensemble.at(t)
    yield "shared/wxyz", shared.wxyz
    yield "shared/omega", shared.angular_velocity
    own = t[None, :20] + np.arange(count)[:, None]
    yield "own/wxyz", ensemble.at(own).wxyz
    yield "own/low", ensemble.at(own, low=own * 1e-17).wxyz
    draw = random.Random(8)
    member = np.array([draw.randrange(count) for _ in range(4000)])
    ragged = np.array([900.0 * draw.random() for _ in range(4000)])
    yield "ragged/wxyz", ensemble.at(ragged, member=member).wxyz
    yield "ragged/omega", ensemble.at(ragged, member=member).angular_velocity
    order = np.argsort(member, kind="stable")
    yield "sorted/wxyz", ensemble.at(ragged[order], member=member[order]).wxyz
    yield "threads", ensemble.at(t, threads=2).wxyz
    yield "blocks", np.concatenate([x.wxyz.reshape(-1, 4) for _, x in ensemble.blocks(t, rows=999)])
    yield "mode", np.asarray(ensemble.mode, dtype=int)
    for name in ("period_psi", "period_phi", "energy", "momentum", "energy_ratio"):
        yield name, np.asarray(getattr(ensemble, name), dtype=float)
    yield "sensitivity", ensemble[::8].sensitivity_at(t[5:15])
    dated = Ensemble(
        moments=moments[:20],
        wxyz=wxyz[:20],
        angular_velocity=omega[:20] * 1e-4,
        epoch=[f"2026-01-{k + 1:02d}T01:02:03" for k in range(20)],
    )
    yield "own_epochs", dated.at(["2026-03-01", "2027-01-01T10:00:00.5"]).wxyz
    drawn = Ensemble.sample(uncertain(), 50, 7)
    yield "sample", drawn.at(t).wxyz
    changes = [Impulse(100.0, (0.01, -0.02, 0.03)), InertiaChange(300.0, Body(moments=(2, 3, 4)))]
    tumblers = Ensemble(
        moments=moments[:20], wxyz=wxyz[:20], angular_velocity=omega[:20], epoch=EPOCH
    )
    yield "arcs", tumblers.arcs(changes).at(np.linspace(0.0, 600.0, 30)).wxyz
    torqued = tumblers.torqued(torques.LinearDamping(0.01), 0.5)
    yield "torqued", torqued.at(np.linspace(0.0, 60.0, 30)).wxyz
    sun, observer = np.array([0.6, 0.0, 0.8]), np.array([0.0, 0.6, 0.8])
    body = shape.Ellipsoid((3.0, 2.0, 1.0)).facets(200)
    lit = ensemble[:40].brightness(t, sun=sun, observer=observer, shape=body)
    yield "brightness", lit
    angle = AngleTo((0, 0, 1), (0.0, 0.6, 0.8))
    yield "percentiles", np.asarray(ensemble[:40].percentiles(angle, t))


@part()
def other_motions():
    """Arcs, torqued rotations and tables."""
    body, spin = Body(moments=(10, 20, 26)), Spin(EPOCH, (1, 0, 0, 0), (0.1, 0.15, 0.1))
    t = np.linspace(-100.0, 900.0, 400)
    changes = [
        Impulse(50.0, (0.5, -0.2, 1.0)),
        InertiaChange(300.0, Body(moments=(12, 25, 30))),
        Impulse(500.0, (0.0, 0.3, 0.0), frame="icrf"),
    ]
    arcs = Arcs(body, spin, changes)
    yield "arcs/wxyz", arcs.at(t).wxyz
    yield "arcs/omega", arcs.at(t).angular_velocity
    yield "arcs/joints", np.asarray(arcs.joints)
    yield "arcs/sensitivity", arcs.sensitivity_at(t[::40])
    damped = [
        torques.LinearDamping(0.02),
        torques.ConstantTorque((1e-3, 2e-3, -1e-3)),
        torques.InternalDissipation(1e-3),
    ]
    seconds = np.linspace(0.0, 120.0, 200)
    for torque in damped:
        name = type(torque).__name__
        motion = TorquedRotation(body, spin, torque, step=0.5)
        yield f"{name}/wxyz", motion.at(seconds).wxyz
        yield f"{name}/omega", motion.at(seconds).angular_velocity
    yield (
        "torqued/sensitivity",
        TorquedRotation(body, spin, damped[1], step=1.0).sensitivity_at(seconds[::40]),
    )
    adaptive = TorquedRotation(body, spin, damped[1], step_tolerance=1e-9, scheme="blanes-moan")
    yield "adaptive/wxyz", adaptive.at(seconds).wxyz
    oem = paths.oem(DATA / "paths" / "apophis-2029-encounter.oem")
    before = catalog.entry("99942 Apophis (2014)").motion(phi0=0.3, psi0=1.0, epoch="2029-04-13")
    tidal = TorquedRotation(
        before.body, before.spin, torques.GravityGradient(oem, "earth"), step_tolerance=1e-8
    )
    # Integrations under torques have last bits that depend on the process: to 13 digits.
    yield "tides/wxyz", np.round(tidal.at(np.linspace(0.0, 1.5 * DAY, 100)).wxyz, 13)
    lit = TorquedRotation(
        body, spin, torques.SolarRadiation(shape.box((2.0, 1.0, 3.0)), oem), step=1.0
    )
    dated = Spin("2029-04-10", spin.wxyz, spin.angular_velocity)
    lit = TorquedRotation(body, dated, lit.torques, step=1.0)
    yield "sunlight/wxyz", np.round(lit.at(np.linspace(0.0, 100.0, 50)).wxyz, 13)
    nodes = np.linspace(0.0, 100.0, 201)
    history = FreeRotation(body, spin).at(nodes)
    between = np.linspace(0.0, 100.0, 777)
    for name, settings in {
        "hermite": {"angular_velocity": history.angular_velocity},
        "lagrange": {},
        "linear": {"method": "linear"},
    }.items():
        table = AttitudeTable(EPOCH, nodes, history.wxyz, **settings)
        yield f"table/{name}/wxyz", table.at(between).wxyz
        yield f"table/{name}/omega", table.at(between).angular_velocity


@part()
def along_paths():
    """Positions and velocities of each kind of path, s from an epoch, m."""
    start = epochs.instant("2026-03-01T12:00:00")
    t = np.linspace(-30.0 * DAY, 60.0 * DAY, 200)
    low = np.zeros_like(t)
    for name in ("sun", "earth", "moon", "mars barycenter"):
        position, velocity = paths.body(name).state(start, t, low)
        yield f"{name}/position", position
        yield f"{name}/velocity", velocity
    orbit = paths.kepler(
        eccentricity=0.3,
        inclination=0.2,
        node=1.0,
        pericenter_argument=2.0,
        epoch=start,
        semi_major_axis=2e11,
        mean_anomaly=0.5,
    )
    yield "kepler", np.concatenate(orbit.state(start, t, low))
    site = paths.site(np.radians(15.5), np.radians(47.1), 400.0)
    yield "site", np.concatenate(site.state(start, t, low))
    for name in ("apophis-2012-2013", "apophis-2029-encounter"):
        path = paths.oem(DATA / "paths" / f"{name}.oem")
        begin = epochs.instant("2012-12-20" if "2012" in name else "2029-04-10")
        seconds = np.linspace(0.0, 5.0 * DAY, 300)
        yield f"{name}/oem", np.concatenate(path.state(begin, seconds, 0.0 * seconds))
        pressed = paths.compress(path, begin, begin.after(5.0 * DAY), 1.0)
        yield f"{name}/chebyshev", np.concatenate(pressed.state(begin, seconds, 0.0 * seconds))
    tle = paths.tle((DATA / "paths" / "envisat-2013.tle").read_text())
    begin, seconds = epochs.instant("2013-10-23T15:00:00"), np.linspace(0.0, 1e4, 200)
    yield "tle", np.concatenate(tle.state(begin, seconds, 0.0 * seconds))
    x = [begin.after(float(s)) for s in seconds[::20]]
    yield "utc", " ".join(each.utc_iso for each in x)


# --- scenes and light curves

COLUMNS = (
    *("phase_angle", "sun_direction", "observer_direction", "observer_distance", "sun_distance"),
    *("light_time", "solar_elongation", "aspect_angle", "sub_observer", "sub_solar"),
    *("observer_axis_angles", "lit_fraction", "emission_time", "obliquity"),
    *("long_axis_position_angle", "phase_angle_bisector", "momentum_direction_icrf"),
)
AT_A_SITE = ("elevation", "azimuth", "airmass", "sun_elevation", "moon_separation", "sky_dark")
LIGHT = ("brightness", "magnitude", "reduced_magnitude")


@part()
def scenes():
    """Columns and magnitudes of the missions in data/."""
    for file in sorted((DATA / "mission").glob("*.toml")):
        if "[times]" not in file.read_text("utf-8"):  # a motion without a scene
            continue
        found = mission.read(file)
        start = epochs.instant(found.times["start"])
        length = 5.0 * DAY if "apophis" in file.stem else 800.0
        view = found.scene.since(start, np.linspace(0.0, length, 150))
        names = (*COLUMNS, *(AT_A_SITE if "envisat" in file.stem else ()))
        for name in (*names, *(LIGHT if found.scene.shape is not None else ())):
            value = getattr(view, name)
            if name == "emission_time":
                value = np.array([[x.jd1, x.jd2] for x in value.tdb])
            yield f"{file.stem}/{name}", np.asarray(value)
        if found.magnitude is not None:
            yield f"{file.stem}/as the file asks", found.magnitude.of(view)


@part()
def light_curves():
    """Each law on convex, concave and ellipsoidal bodies, with shadows and rays."""
    draw = random.Random(9)

    def directions(count):
        rows = np.array([[draw.random() - 0.5 for _ in range(3)] for _ in range(count)])
        return rows / np.sqrt(np.sum(rows**2, axis=1))[:, None]

    sun = directions(300)
    observer = sun + 0.8 * directions(300)
    observer /= np.sqrt(np.sum(observer**2, axis=1))[:, None]
    ellipsoid = shape.Ellipsoid((3.0, 2.0, 1.0))
    bodies = {
        "ellipsoid": ellipsoid,
        "facets": ellipsoid.facets(500),
        "box": shape.box((3.0, 2.0, 1.0)),
        "cylinder": shape.cylinder(1.0, 3.0),
        "box_wing": shape.box_wing(
            (3.0, 2.0, 1.2), (4.0, 1.5), gap=0.5, wings=1, wing_angle=0.5, thickness=0.1
        ),
        "two_lobes": ellipsoid.facets(200).joined(
            shape.Ellipsoid((1.5, 1.5, 1.0)).facets(150).moved((3.8, 0.0, 0.0))
        ),
    }
    laws = {
        "lambert": scattering.Lambert(),
        "lommel-seeliger": scattering.LommelSeeliger(),
        "lommel-seeliger-lambert": scattering.LommelSeeligerLambert(),
        "hapke": scattering.Hapke(),
    }
    for body_name, body in bodies.items():
        for law_name, law in laws.items():
            if body_name == "ellipsoid" and law_name != "lommel-seeliger":
                continue
            found = light_curve.brightness(body, law, sun, observer)
            yield f"{body_name}/{law_name}", found
    material = scattering.Material(0.25, 0.35, exponent=40.0)
    shiny = scattering.Materials(dict.fromkeys(sorted(set(bodies["box_wing"].materials)), material))
    yield "box_wing/materials", light_curve.brightness(bodies["box_wing"], shiny, sun, observer)
    yield (
        "two_lobes/no shadows",
        light_curve.brightness(bodies["two_lobes"], laws["lambert"], sun, observer, shadows=False),
    )
    yield (
        "two_lobes/rays",
        brightness_by_rays(bodies["two_lobes"], laws["lambert"], sun[:40], observer[:40]),
    )
    yield "hg", scattering.hg(np.linspace(0.0, 2.0, 50), 19.09, 0.24)
    divided = bodies["two_lobes"].divided()
    yield (
        "two_lobes/divided",
        light_curve.brightness(divided, laws["lommel-seeliger"], sun[:100], observer[:100]),
    )
    for name, body in bodies.items():
        if name != "ellipsoid":
            made = Body.from_shape(body, density=2000.0)
            yield f"{name}/moments", made.moments
            yield f"{name}/tensor", made.tensor


# --- files


def normalised(data):
    """The bytes of a file without the date of its making and without versions."""
    if b"\0" in data[:4096] or data[:4] == b"glTF":
        return re.sub(rb"attitude[ -]?[\w-]* \d+\.\d+\.\d+[\w.+]*", b"attitude", data)
    text = data.decode("utf-8")
    text = re.sub(r"(CREATION_DATE\W*)[\dT:.\-Z]+", r"\1DATE", text)
    text = re.sub(r"\b\d+\.\d+\.\d+(?:\.?\w+)?(?=[\s\"'<,;)])", "VERSION", text)
    return text.encode("utf-8")


@part()
def files():
    """Each file that writers write."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name, write in writers(folder):
            before = set(folder.rglob("*"))
            write(folder / name)
            for file in sorted(set(folder.rglob("*")) - before):
                if file.is_file():
                    yield file.relative_to(folder).as_posix(), normalised(file.read_bytes())


def writers(folder):
    """(name of the file, function of its path)."""
    motion = toutatis()
    t = np.linspace(0.0, 2.0 * DAY, 50)
    table = AttitudeTable.from_history(motion.at(t))
    dated = {"creation_date": CREATED}
    named = {"object_name": "TUMBLER", "object_id": "2026-001A"}
    short = uncertain()
    seconds = np.linspace(0.0, 100.0, 40)
    yield "a.aem", lambda p: aem.write(p, table, **dated)
    yield "a.xml", lambda p: aem.write(p, table, xml=True, **dated, **named)
    yield "v1.aem", lambda p: aem.write(p, table, version="1.0", frame="EME2000", **dated)
    yield "v1.xml", lambda p: aem.write(p, table, version="1.0", xml=True, **dated)
    for tool in ("gmat", "orekit"):
        yield f"{tool}.aem", lambda p, tool=tool: aem.write(p, short, t=seconds, for_=tool, **dated)
    for kind, settings in {
        "euler": {"kind": "EULER_ANGLE", "sequence": "ZXZ"},
        "spin": {"kind": "SPIN", "version": "1.0"},
        "derivative": {"kind": "QUATERNION/DERIVATIVE"},
        "rate": {"kind": "QUATERNION/ANGVEL"},
        "first": {"scalar_first": True, "version": "1.0"},
        "tod": {"frame": "TOD"},
        "itrf": {"frame": "ITRF"},
        "tai": {"time_system": "TAI", "digits": 15},
    }.items():

        def written(p, settings=settings):
            try:
                aem.write(p, short, t=seconds, **settings, **dated)
            except ValueError as err:
                p.write_text(str(err))

        yield f"{kind}.aem", written
    yield (
        "tolerance.aem",
        lambda p: aem.write(p, short, start=0.0, stop=200.0, tolerance=1e-6, **dated),
    )
    for form in ("1.0", "2.0"):
        for xml in (False, True):
            yield (
                f"{form}{'x' * xml}.apm",
                lambda p, form=form, xml=xml: apm.write(p, short, version=form, xml=xml, **dated),
            )
    changes = [Impulse(50.0, (0.01, 0.0, 0.02))]
    arcs = Arcs(short.body, short.spin, changes)
    for xml in (False, True):
        yield (
            f"a{'x' * xml}.acm",
            lambda p, xml=xml: acm.write(p, short, t=seconds, xml=xml, **dated),
        )
        yield (
            f"arcs{'x' * xml}.acm",
            lambda p, xml=xml: acm.write(p, arcs, t=seconds, xml=xml, **dated),
        )
    yield "a.a", lambda p: stk.write(p, table)
    for section in ("Quaternions", "QuatScalarFirst", "EulerAngles"):
        yield (
            f"{section}.a",
            lambda p, section=section: stk.write(
                p, short, t=seconds, section=f"AttitudeTime{section}"
            ),
        )
    yield "tolerance.a", lambda p: stk.write(p, short, start=0.0, stop=200.0, tolerance=1e-6)
    yield "ecef.a", lambda p: stk.write(p, short, t=seconds, frame="J2000")
    for ending in ("csv", "ecsv"):
        yield f"a.{ending}", lambda p: tables.write(p, motion, t=t)
        yield f"sigma.{ending}", lambda p: tables.write(p, short, t=seconds, sigma=True)
    yield "spin.toml", lambda p: spin_file.write(p, motion, name="Toutatis", note="a note")
    yield "errors.toml", lambda p: spin_file.write(p, short)
    uniform = FreeRotation(
        Body(moments=(1, 2, 3)), Spin(EPOCH, (0.5, 0.5, -0.1, 0.7), (0, 0, 3e-4))
    )
    yield "a.spin", lambda p: damit.write(p, uniform)
    yield "lc.txt", lambda p: damit_light_curve.write_damit_light_curves(p, [damit_curve()])
    yield "x.aem", lambda p: detect.write(p, short, t=seconds, **dated)
    found = mission.read(DATA / "mission" / "envisat-glints.toml")
    start = epochs.instant("2013-10-23T15:30:00")
    span = {"start": start, "stop": start.after(600.0)}
    yield "pass.czml", lambda p: viewer.write_czml(p, found.scene, **span)
    yield "toutatis.glb", lambda p: viewer.write_glb(p, motion)
    yield "mesh.glb", lambda p: viewer.write_glb(p, short, shape=shape.box((1.0, 2.0, 3.0)))
    yield "toutatis.html", lambda p: viewer.view(motion, output=p)
    yield "scene.html", lambda p: viewer.view(found.scene, output=p, **span)
    ensemble = Ensemble.of([uniform, short], names=["one", "two"])
    yield "ensemble.ecsv", ensemble.write
    yield (
        "view.ecsv",
        lambda p: tables.write_columns(
            p,
            found.scene.since(start, np.linspace(0.0, 60.0, 20)).table("phase_angle", "elevation"),
        ),
    )
    try:
        import spiceypy  # noqa: F401
    except ImportError:
        return
    for kind in (3, 5):
        yield f"kind{kind}.bc", lambda p, kind=kind: ck.write(p, short, 0.0, 600.0, kind=kind)
    yield "cosmographia.json", lambda p: viewer.write_cosmographia(p, found.scene, **span)


def damit_curve():
    """A DAMIT light curve of 20 points."""
    t = np.linspace(0.0, 0.4, 20) * DAY
    sun = np.stack([np.full(20, 2e11), np.linspace(1e10, 1.1e10, 20), np.full(20, 1e9)], axis=-1)
    return damit_light_curve.from_positions(
        epochs.times(epochs.instant(EPOCH), t, 0.0 * t),
        1.0 + 0.2 * np.linspace(-1.0, 1.0, 20) ** 2,
        sun,
        -0.5 * sun,
        calibrated=False,
    )


# --- events


@part()
def found_events():
    """Events of motions and scenes, glints, passes and windows."""
    motion = toutatis()
    angle = events.separation(motion, (1, 0, 0), (0.0, 0.6, 0.8))
    stop = 20.0 * DAY
    for name in ("find_maxima", "find_minima"):
        yield from columns_of(name, getattr(events, name)(0.0, stop, angle))
    cone = events.in_cone(motion, (0, 0, 1), (0.0, 0.6, 0.8), np.radians(50.0))
    yield from columns_of("cone", events.find_discrete(0.0, stop, cone))
    yield from columns_of("meridian", events.find_discrete(0.0, stop, events.past_meridian(
        motion, (1, 0, 0), (0.0, 0.6, 0.8)
    )))  # fmt: skip
    windows = events.windows(cone, 0.0, stop)
    yield "windows", tabled(windows.table())
    found = mission.read(DATA / "mission" / "envisat-glints.toml")
    start = epochs.instant("2013-10-23T15:30:00")
    end = start.after(4.0 * 3600.0)
    passes = events.passes(found.scene, start, end, elevation=np.radians(5)).table()
    # Rounding moves the epoch of a maximum by its root, some 1e-5 s, in which the azimuth turns by
    # up to 3e-5 degrees.
    culminations = {f"azimuth {k}": (float(x), 1e-4) for k, x in enumerate(passes["azimuth"].value)}
    passes.remove_column("azimuth")
    yield "passes", tabled(passes)
    yield "culminations", Numbers(culminations)
    night = start.after(8.0 * 3600.0)
    yield "glints", tabled(events.glints(found.scene, start, night).table())
    begin = found.scene.epoch
    first = start.since(begin)
    first = float(first[0] if isinstance(first, tuple) else first)
    shadow = events.find_discrete(first, first + 2e4, events.shadow_state(found.scene), step=5.0)
    yield from columns_of("shadow", shadow)


def columns_of(name, table):
    """The epochs and values of events."""
    yield f"{name}/seconds", np.asarray(table.seconds)
    yield f"{name}/values", np.asarray(table.values, dtype=float)


def tabled(table):
    """A table as text, with all digits of its numbers."""
    rows = []
    for row in table:
        cells = []
        for cell in row:
            value = getattr(cell, "value", cell)
            if hasattr(cell, "jd1"):
                value = cell.tdb.jd1, cell.tdb.jd2
            cells.append(repr(np.asarray(value).tolist()))
        rows.append(" ".join(cells))
    return "\n".join([" ".join(table.colnames), *rows])


# --- periods, fits and inversions: numbers with a tolerance


def relative(value, tolerance):
    """A number and a tolerance that is a share of it."""
    return float(value), tolerance * abs(float(value))


@part()
def periods():
    """One and two frequencies of the observed curve of Toutatis."""
    curve = photometry.LightCurve.read(DATA / "light_curve" / "toutatis-1992-photometry.csv")
    one = photometry.periods(curve, min_period="1 d", max_period="20 d")
    yield (
        "one",
        Numbers(
            {f"period {k}": relative(peak.period, 1e-9) for k, peak in enumerate(one.peaks[:5])}
            | {f"power {k}": (float(peak.power), 1e-9) for k, peak in enumerate(one.peaks[:5])}
        ),
    )
    two = photometry.periods(curve, count=2, first=("7.2 d", "7.5 d"), second=("5.3 d", "5.5 d"))
    yield "two", Numbers(pair_numbers(two.peaks))


@part(slow=True)
def two_periods():
    """The same curve, over all periods from 2 to 10 days."""
    curve = photometry.LightCurve.read(DATA / "light_curve" / "toutatis-1992-photometry.csv")
    found = photometry.periods(curve, count=2, min_period="2 d", max_period="10 d")
    yield "toutatis", Numbers(pair_numbers(found.peaks))


def pair_numbers(pairs):
    """Frequencies or periods of the best pairs, and what they leave."""
    return {
        f"{name} {k}": relative(getattr(pair, name), 1e-9)
        for k, pair in enumerate(pairs[:5])
        for name in ("first", "second", "left")
    }


def motion_numbers(motion):
    """Mode, periods and momentum of a fitted free rotation."""
    size = float(np.sqrt(motion.momentum @ motion.momentum))
    return {
        "mode": (motion.mode.name, None),
        "P_psi, s": relative(motion.period_psi, 1e-9),
        "P_phi, s": relative(motion.period_phi, 1e-9),
        **{f"pole {k}": (float(motion.momentum[k]) / size, 1.7e-8) for k in range(3)},
    }


def noisy(draw, sigma, shape):
    """Errors (shape), the sum of twelve uniform numbers each, in multiples of 1e-6 sigma."""
    flat = [sum(draw.random() for _ in range(12)) - 6.0 for _ in range(int(np.prod(shape)))]
    return sigma * np.round(np.reshape(flat, shape), 6)


@part()
def fits():
    """Fits of a table, of directions and of rates."""
    body = Body(moments=(10, 20, 26))
    truth = FreeRotation(body, Spin(EPOCH, (1, 0, 0, 0), (0.01, 0.15, 0.02)))
    t = np.linspace(0.0, 600.0, 301)
    draw = random.Random(11)
    history = truth.at(t)
    wxyz = history.wxyz + noisy(draw, 1e-3, history.wxyz.shape)
    wxyz /= np.sqrt(np.sum(wxyz**2, axis=1))[:, None]
    table = AttitudeTable(EPOCH, t, wxyz)
    vector = np.array([0.6, 0.0, 0.8])
    seen = history.inertial_to_body(vector) + noisy(draw, 1e-3, (t.size, 3))
    seen /= np.sqrt(np.sum(seen**2, axis=1))[:, None]
    other = history.inertial_to_body([0.0, 0.8, -0.6])
    rates = history.angular_velocity + noisy(draw, 1e-4, (t.size, 3))
    # One vector and the other in turn.
    second = np.arange(t.size)[:, None] % 2 == 1
    both = np.where(second, other, seen)
    inertial = np.where(second, [0.0, 0.8, -0.6], vector)
    found = {
        "table": fit(table, body),
        "table, moments free": fit(table),
        "directions": fit_directions(t, both, inertial, body, epoch=EPOCH),
        "rates": fit_rates(t, rates, body, epoch=EPOCH),
    }
    for name, result in found.items():
        numbers = motion_numbers(result.motion) if name != "rates" else {}
        rms = result.rms if name != "rates" else result.rate_rms
        yield name, Numbers(numbers | {"rms": relative(np.max(rms), 1e-7)})


def inverted(solutions):
    """What an inversion says: verdict, ranking, and the numbers of its best entries."""
    best = solutions[0].evidence
    numbers = {
        "verdict": (solutions.verdict, None),
        "ranking": (" ".join(each.mode for each in solutions if each.evidence < best + 6.0), None),
    }
    for k, each in enumerate(solutions[:3]):
        longitude, latitude = np.degrees(each.pole)
        numbers |= {
            f"{k} mode": (each.mode, None),
            f"{k} P_phi, s": relative(each.P_phi, 1e-9),
            f"{k} longitude, deg": (float(longitude), 1e-6),
            f"{k} latitude, deg": (float(latitude), 1e-6),
            f"{k} evidence": (float(each.evidence), 0.1),
        }
        if each.P_psi is not None and np.isfinite(each.P_psi):
            numbers[f"{k} P_psi, s"] = relative(each.P_psi, 1e-9)
    return Numbers(numbers)


def synthetic(motion, path, body, start, nights, per_night, sigma, seed, length=0.3):
    """A light curve of a motion on nights drawn at random, magnitudes to 1e-5."""
    draw = random.Random(seed)
    first = epochs.instant(start)
    chosen = sorted(draw.sample(range(nights[0]), nights[1]))
    seconds = np.sort(
        [(night + length * draw.random()) * DAY for night in chosen for _ in range(per_night)]
    ).round(3)
    scene = Scene(motion, path, shape=body)
    magnitude = scene.since(first, seconds).magnitude + noisy(draw, sigma, seconds.shape)
    times = epochs.times(first, seconds, 0.0 * seconds)
    return inversion.LightCurve(times, magnitude.round(5), sigma, scene=scene)


def apophis(per_night=10):
    """A curve of the tumbler of data/mission/apophis-2012.toml, in short-axis mode."""
    scene = mission.read(DATA / "mission" / "apophis-2012.toml").scene
    return synthetic(
        scene.motion, scene.center, scene.shape, "2012-12-25", (90, 40), per_night, 0.02, 5
    ), scene


@part(slow=True)
def inversion_of_short_axis_mode():
    """Apophis in 2012-13, computed."""
    curve, _ = apophis()
    yield "apophis", inverted(inversion.spin_states(curve, "1.4 /d", budget=600.0, seed=0))


@part(slow=True)
def inversion_of_long_axis_mode():
    """Toutatis in 1992-93, observed."""
    curve = inversion.LightCurve.read(DATA / "light_curve" / "toutatis-1992-photometry.csv")
    yield "toutatis", inverted(inversion.spin_states(curve, "0.75 /d", budget=600.0, seed=0))


@part(slow=True)
def inversion_about_one_axis():
    """A rotator about its short axis, on the path of Apophis."""
    path = mission.read(DATA / "mission" / "apophis-2012.toml").scene.center
    ellipsoid = shape.Ellipsoid((200.0, 140.0, 100.0))
    body = Body.from_ellipsoid((200.0, 140.0, 100.0))
    spin = Spin("2012-12-25", (0.8, 0.3, -0.1, 0.5), (0.0, 0.0, 2.0 * np.pi / (20.0 * 3600.0)))
    curve = synthetic(FreeRotation(body, spin), path, ellipsoid, "2012-12-25", (60, 25), 6, 0.02, 6)
    found = inversion.spin_states(curve, "1.5 /d", modes=("SAM",), budget=600.0, seed=0)
    yield "rotator", inverted(found)


@part(slow=True)
def inversion_of_a_known_shape():
    """A box with a wing in one pass; rates are found from 60 points."""
    curve, mesh, law, body = satellite_pass()
    found = inversion.spin_states(
        curve, "0.01 Hz", shape=mesh, law=law, moments=body, budget=600.0, seed=0
    )
    yield "satellite", inverted(found)


def satellite_pass():
    """A light curve of 60 points within 300 s, its shape, law and body."""
    mesh = shape.box_wing(
        (3.0, 2.0, 1.2), (4.0, 1.5), gap=0.5, wings=1, wing_angle=0.5, thickness=0.1
    )
    law = scattering.Materials(
        {
            "body": scattering.Material(0.25, 0.35, exponent=40.0),
            "panel front": scattering.Material(0.05, 0.25, exponent=60.0),
            "panel back": scattering.Material(0.3, 0.05, exponent=30.0),
            "panel edge": scattering.Material(0.3),
        }
    )
    body = Body.from_shape(mesh, density=100.0)
    motion = FreeRotation(body, Spin(EPOCH, (0.5, 0.1, -0.7, 0.4), (0.03, 0.01, -0.04)))
    draw = random.Random(12)
    t = np.sort([round(300.0 * draw.random(), 3) for _ in range(60)])
    angle = np.radians(120.0) * t / 300.0
    observer = np.stack([np.cos(angle), np.sin(angle), 0.3 + 0.0 * angle], axis=-1)
    observer /= np.sqrt(np.sum(observer**2, axis=1))[:, None]
    sun = np.broadcast_to([0.6, 0.48, 0.64], (t.size, 3))
    matrix = motion.at(t).matrix
    seen = [np.sum(matrix * each[:, :, None], axis=1) for each in (sun, observer)]
    flux = light_curve.brightness(mesh, law, *seen)
    magnitude = (5.0 - 2.5 * np.log10(flux) + noisy(draw, 0.05, t.shape)).round(5)
    given = {"sun": sun * 1.5e11, "observer": observer * 1e6}
    curve = inversion.LightCurve(t, magnitude, 0.05, epoch=EPOCH, light_time=False, **given)
    return curve, mesh, law, body


@part()
def refined():
    """A spin state of a known shape, from a start near it."""
    curve, mesh, law, body = satellite_pass()
    near = FreeRotation(body, Spin(EPOCH, (0.52, 0.1, -0.7, 0.38), (0.0301, 0.0101, -0.0399)))
    found = inversion.refine(curve, near, shape=mesh, law=law)
    yield (
        "satellite",
        Numbers(motion_numbers(found.motion) | {"evidence": (float(found.evidence), 0.1)}),
    )


# --- examples

# Those that invert print what the parts above compare, and take minutes.
EXAMPLES = sorted(
    file.name for file in (ROOT / "examples").glob("*.py") if "inversion" not in file.name
)


@part(slow=True)
def examples():
    """What the examples print."""
    with tempfile.TemporaryDirectory() as folder:
        for name in EXAMPLES:
            run = subprocess.run(
                [sys.executable, ROOT / "examples" / name],
                cwd=folder,
                env=os.environ | {"PYTHONPATH": str(ROOT)},
                capture_output=True,
                check=True,
            )
            # A message about a picture depends on whether matplotlib is installed.
            text = re.sub(r"(?m)^(No picture|Picture:).*\n?", "", run.stdout.decode("utf-8"))
            yield name, text


# --- what is stored, and how it is compared


def summary(result):
    """What the file keeps of a result."""
    if isinstance(result, Numbers):
        return {"numbers": {name: list(pair) for name, pair in result.items()}}
    if isinstance(result, (str, bytes)):
        data = result.encode("utf-8") if isinstance(result, str) else result
        return {"sha256": hashlib.sha256(data).hexdigest(), "places": _numbers_of(data)}
    array = np.ascontiguousarray(result)
    assert array.dtype.kind in "fib", array.dtype
    kept = hashlib.sha256(f"{array.shape} {array.dtype.str}".encode() + array.tobytes())
    flat = array.ravel().astype(float)
    chosen = flat[np.linspace(0, flat.size - 1, PLACES).round().astype(int)] if flat.size else flat
    finite = np.abs(flat[np.isfinite(flat)])
    return {
        "sha256": kept.hexdigest(),
        "places": [float(x) for x in chosen],
        "largest": float(finite.max()) if finite.size else 0.0,
    }


def _numbers_of(data):
    """Some numbers of a text, for the comparison elsewhere; none of a binary file."""
    try:
        found = re.findall(r"-?\d+\.\d+(?:[eE][+-]?\d+)?", data.decode("utf-8"))
    except UnicodeDecodeError:
        return []
    return [float(found[int(k)]) for k in np.linspace(0, len(found) - 1, PLACES)] if found else []


def results(name):
    """{name: summary} of a part, computed now."""
    function, _ = PARTS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return {f"{name}/{label}": summary(result) for label, result in function()}


def machine():
    """Processor and versions, with which the bits of every result are compared.

    Processors that differ have one name in virtual machines: their instructions have others.
    """
    from benchmarks.record import processor

    target = os.environ.get("NUMBA_CPU_NAME") or llvmlite.binding.get_host_cpu_name()
    found = {"processor": processor(), "target": target, "python": sys.version.split()[0]}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "none"
    return found


def changed(stored, computed, *, same_machine):
    """A sentence that says how a result differs from the one stored, or None."""
    if "numbers" in stored:
        off = [
            f"{name} is {computed['numbers'].get(name, ('absent',))[0]!r}, was {value!r}"
            for name, (value, tolerance) in stored["numbers"].items()
            if not _close(computed["numbers"].get(name, (None,))[0], value, tolerance)
        ]
        off += [f"{name} is new" for name in computed["numbers"] if name not in stored["numbers"]]
        return "; ".join(off) or None
    if stored["sha256"] == computed["sha256"]:
        return None
    one, two = stored["places"], computed["places"]
    if len(one) != len(two):
        return "other bytes, and another number of places"
    difference = max(
        (abs(a - b) for a, b in zip(one, two, strict=True) if a == a or b == b), default=0
    )
    if same_machine or stored["anywhere"]:
        return f"other bits; at {len(one)} places it differs by at most {difference:.3g}"
    room = ROOM * stored.get("largest", max(map(abs, one), default=0.0))
    same = [_close(b, a, room) for a, b in zip(one, two, strict=True)]
    return None if all(same) else f"differs by {difference:.3g}, more than {room:.3g}"


def _close(computed, stored, tolerance):
    if tolerance is None or computed is None or isinstance(computed, str):
        return computed == stored
    if math.isnan(stored) or math.isinf(stored):
        return repr(computed) == repr(stored)
    return abs(computed - stored) <= tolerance


KEPT = json.loads(STORED.read_text("utf-8")) if STORED.is_file() else {"results": {}}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if slow else name
        for name, (_, slow) in PARTS.items()
    ],
)
def test_results_stay(name):
    stored = {key: each for key, each in KEPT["results"].items() if key.startswith(f"{name}/")}
    said = f"nothing is stored of {name}: {COMMAND} --only {name}"
    if PARTS[name][1] and not stored:
        pytest.skip(said)
    assert stored, said
    sentences = compared(stored, results(name))
    assert not sentences, "\n".join([*sentences, f"If this is intended: {COMMAND} --only {name}"])


def compared(stored, computed):
    """Sentences: results that changed, that are gone, that are new."""
    this = machine()
    sentences = []
    for key in {**stored, **computed}:
        if key not in computed:
            # Optional packages write further files.
            if not _is_optional(key):
                sentences.append(f"{key} is gone")
        elif key not in stored:
            sentences.append(f"{key} is new")
        elif said := changed(
            stored[key],
            computed[key],
            same_machine=this == KEPT["made_with"].get(key.partition("/")[0]),
        ):
            sentences.append(f"{key}: {said}")
    return sentences


def _is_optional(key):
    return key.endswith((".bc", ".tf", ".tsc")) or "cosmographia" in key


def test_a_change_is_a_sentence():
    """A bit, a place beyond the room, a number beyond its tolerance."""
    array = np.linspace(1.0, 2.0, 100)
    stored = summary(array) | {"anywhere": True}
    assert changed(stored, summary(array), same_machine=False) is None
    other = array.copy()
    other[99] = np.nextafter(2.0, 3.0)
    assert changed(stored, summary(other), same_machine=False).startswith("other bits")
    stored["anywhere"] = False
    assert changed(stored, summary(other), same_machine=False) is None
    assert changed(stored, summary(other), same_machine=True).startswith("other bits")
    assert "more than" in changed(stored, summary(array + 1e-12), same_machine=False)
    stored = summary(Numbers({"P": (1.0, 1e-9), "mode": ("LAM", None)}))
    close, far = (Numbers({"P": (x, 1e-9), "mode": ("LAM", None)}) for x in (1 + 5e-10, 1 + 2e-9))
    assert changed(stored, summary(close), same_machine=True) is None
    assert "P is 1.000000002" in changed(stored, summary(far), same_machine=True)


# --- the command

# Names before and after numpy 2.4; numpy passes over those it does not know.
NUMPY_BASELINE = "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX X86_V3 X86_V4"
VARIANTS = {
    "no AVX in numpy": {"NPY_DISABLE_CPU_FEATURES": NUMPY_BASELINE},
    "x86-64-v2": {
        "NUMBA_CPU_NAME": "x86-64-v2",
        "NUMBA_CPU_FEATURES": "+sse4.2,+sse4.1,+ssse3,+sse3,+sse2,+cx16,+popcnt",
        "NPY_DISABLE_CPU_FEATURES": NUMPY_BASELINE,
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2",
        "OPENBLAS_CORETYPE": "Nehalem",
    },
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--remake", action="store_true", help=f"write {STORED.name}")
    parser.add_argument("--only", nargs="*", default=[""], help="beginnings of names of parts")
    parser.add_argument("--slow", action="store_true", help="inversions and examples too")
    parser.add_argument("--processors", nargs="?", const="", metavar="PYTHON")
    parser.add_argument("--print", dest="printed", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    chosen = [
        name
        for name, (_, slow) in PARTS.items()
        if any(name.startswith(each) for each in given.only)
        and (not slow or given.slow or given.only != [""])
    ]
    if given.processors is not None:
        return processors(chosen, given.processors)
    found = {}
    for name in chosen:
        begin = os.times()
        with redirect_stdout(StringIO()):
            found |= results(name)
        end = os.times()
        seconds = sum(end[:4]) - sum(begin[:4])
        print(f"{name:32}{seconds:8.1f} s of processor", file=sys.stderr, flush=True)
    if given.printed:
        print(json.dumps({key: each for key, each in found.items() if "sha256" in each}))
        return 0
    stored = {key: x for key, x in KEPT["results"].items() if key.partition("/")[0] in chosen}
    for key in found:
        if "sha256" in found[key]:
            found[key]["anywhere"] = stored.get(key, {}).get("anywhere", False)
    sentences = compared(stored, found) if KEPT["results"] else []
    print(*sentences, f"{len(sentences)} of {len(found)} results changed.", sep="\n")
    if given.remake:
        write(chosen, found)
    return 0 if given.remake else bool(sentences)


def write(parts, computed):
    """Store the results computed of some parts, beside those stored of others."""
    stored = json.loads(STORED.read_text("utf-8"))["results"] if STORED.is_file() else {}
    kept = {key: x for key, x in stored.items() if key.partition("/")[0] not in parts} | computed
    order = list(PARTS)
    keys = sorted(kept, key=lambda key: (order.index(key.partition("/")[0]), key))
    lines = ",\n".join(f"  {json.dumps(key)}: {json.dumps(kept[key])}" for key in keys)
    machines = json.loads(STORED.read_text("utf-8"))["made_with"] if STORED.is_file() else {}
    made_with = {name: machines.get(name) for name in order} | dict.fromkeys(parts, machine())
    head = json.dumps({"made_by": COMMAND, "made_with": made_with}, indent=1)[:-2]
    STORED.write_text(f'{head},\n "results": {{\n{lines}\n }}\n}}\n', "utf-8")


def processors(chosen, python):
    """Compute the parts as on other processors and versions, and store which bits are the same."""
    found, here = {}, {key: each for key, each in KEPT["results"].items() if "sha256" in each}
    runs = {name: (sys.executable, more) for name, more in VARIANTS.items()}
    if python:
        runs["versions of " + python] = python, {}
    for name, (program, more) in runs.items():
        with tempfile.TemporaryDirectory() as cache:
            run = subprocess.run(
                [program, __file__, "--print", "--only", *chosen],
                env=os.environ | more | {"NUMBA_CACHE_DIR": cache},
                stdout=subprocess.PIPE,
                check=True,
            )
        found[name] = json.loads(run.stdout)
    for key, each in here.items():
        if key.partition("/")[0] not in chosen:
            continue
        others = [name for name in found if found[name].get(key, each)["sha256"] != each["sha256"]]
        if others:
            said = [
                changed(each | {"anywhere": False}, found[name][key], same_machine=False)
                for name in others
            ]
            print(f"{key}: other bits with {', '.join(others)}; {' '.join(filter(None, said))}")
        each["anywhere"] = not others
    write(PARTS, KEPT["results"])
    same = sum(each["anywhere"] for each in here.values())
    print(f"{same} of {len(here)} results have the same bits everywhere.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
