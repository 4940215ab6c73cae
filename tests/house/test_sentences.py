"""Calls with wrong arguments raise an AttitudeError that states what is allowed."""

import warnings

import numpy as np
import pytest

from attitude import (
    AttitudeError,
    AttitudeTable,
    Body,
    Ensemble,
    FreeRotation,
    Scene,
    Spin,
    fit,
    photometry,
    propagate,
    shape,
)
from attitude.arcs import Arcs, Impulse
from attitude.formats import ck, damit
from attitude.frames import representations
from attitude.light_curve import Visibility
from attitude.shape import Mesh
from attitude.splitting import TorquedRotation
from attitude.torques import ConstantTorque, CustomTorque, GravityGradient, SolarRadiation

BODY = Body(moments=(1, 2, 2.5))
SPIN = Spin("2026-01-01", (1, 0, 0, 0), (0.1, 0.2, 0.3))
FREE = FreeRotation(BODY, SPIN)
HISTORY = FREE.at([0.0, 0.5, 1.0])
ENSEMBLE = Ensemble.of([FREE, FREE])
BOX = shape.box((1, 2, 3))
TORQUE = ConstantTorque((0.1, 0, 0))
PLACES = {"center": None, "observer": (1, 0, 0), "sun": (0, 1, 0)}
MOTIONS = {
    "free": FREE,
    "arcs": Arcs(BODY, SPIN, [Impulse(at=1.0, angular_momentum=(1, 0, 0))]),
    "torqued": TorquedRotation(BODY, SPIN, TORQUE, step=0.1),
    "table": AttitudeTable.from_history(FREE.at(np.linspace(0.0, 10.0, 50))),
}


def sunlight(seconds):
    return np.broadcast_to((1.5e11, 0.0, 0.0), (*np.shape(seconds), 3))


CASES = {
    "one change": (lambda: Arcs(BODY, SPIN, 5), "changes is 5; give an Impulse"),
    "no change": (lambda: Arcs(BODY, SPIN, None), "changes is None; give an Impulse"),
    "one torque": (lambda: TorquedRotation(BODY, SPIN, 5, step=1), "torques is 5; give an object"),
    "class of torques": (
        lambda: TorquedRotation(BODY, SPIN, ConstantTorque, step=1),
        "torques is the class ConstantTorque; give an object, made by ConstantTorque",
    ),
    "classes of torques": (
        lambda: TorquedRotation(BODY, SPIN, [TORQUE, ConstantTorque], step=1),
        r"torques\[1\] is the class ConstantTorque",
    ),
    "facets": (
        lambda: SolarRadiation(BOX, sunlight, diffuse=[1, 2]),
        r"diffuse has shape \(2,\); give a single number, or one for each facet .*, \(12,\)",
    ),
    "rows of facets": (
        lambda: SolarRadiation(BOX, sunlight, mirrored=[[0, 0]]),
        r"mirrored has shape \(1, 2\)",
    ),
    "class of shapes": (lambda: SolarRadiation(Mesh, sunlight), "shape is .*Mesh.*, whose areas"),
    "class of paths": (lambda: GravityGradient(Scene, 4e14), "path is the class Scene"),
    "empty fit": (lambda: fit(HISTORY[:0]), "the table has 0 records; give three"),
    "short fit": (lambda: fit(HISTORY[:1], BODY), "the table has 1 record; give three"),
    "epochs of vectors": (
        lambda: HISTORY.body_to_inertial(np.ones((5, 3))),
        r"v has shape \(5, 3\), and the history has epochs \(3,\); give one vector \(3,\), or",
    ),
    "epochs of vectors back": (
        lambda: HISTORY.inertial_to_body(np.ones((5, 3))),
        r"v has shape \(5, 3\), and the history has epochs \(3,\)",
    ),
    "number for a file": (lambda: shape.read(5), "path is 5; give the name of a file"),
    "no file": (lambda: shape.read(None), "path is None; give the name"),
    "word for a flag": (
        lambda: shape.read("a.obj", closed="yes"),
        "closed is 'yes'; it must be True or False",
    ),
    "kernel at epochs": (
        lambda: ck.write("x.bc", FREE, t=np.linspace(0.0, 1.0, 3)),
        "t is given: give start= and stop=",
    ),
    "kernel of no span": (lambda: ck.write("x.bc", FREE, 0.0), "start or stop is missing"),
    "overflow of moments": (
        lambda: Body(moments=(1e308,) * 3),
        r"moments holds 1e\+308, so large that sums overflow; give numbers up to 4.49e\+307",
    ),
    "structure of units": (
        lambda: Body(moments="1, 2, 2.5 (m, kg)"),
        r"moments is in '\(m, kg\)', which is not a unit that astropy knows",
    ),
    "logarithmic unit": (lambda: Body(moments="1, 2, 2.5 mag(AB)"), "not a unit that astropy"),
    "many digits": (
        lambda: Body(moments=(1, 2, 10**5000)),
        "moments is a very large tuple, beyond",
    ),
    "overflow of a tensor": (lambda: Body(tensor=1e308 * np.eye(3)), "tensor holds .*overflow"),
    "overflow of points": (
        lambda: Body.from_points([1e308, 1e308], [[1e10, 0, 0], [0, 1e10, 0]]),
        "the moments of inertia of these masses and positions exceed the largest double",
    ),
    "overflow of axes": (
        lambda: Body.from_ellipsoid((1e200, 1e200, 1e200), mass=1.0),
        "the moments of inertia of these axes exceed",
    ),
    "word for relative": (
        lambda: Body(moments=(1, 2, 2.5), relative="x"),
        "relative is 'x'; it must be True or False",
    ),
    "word for relative points": (
        lambda: Body.from_points([1, 2], [[1, 0, 0], [0, 1, 0]], relative="x"),
        "relative is 'x'",
    ),
    "word for rates": (
        lambda: propagate((1, 2, 2.5), (1, 0, 0, 0), (1, 1, 1), [1.0], angular_velocity="yes"),
        "angular_velocity is 'yes'; it must be True or False",
    ),
    "array for a frame": (
        lambda: Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 1), frame=np.zeros(3)),
        r"frame is array\(\[0., 0., 0.\]\); it must be one of 'icrf'",
    ),
    "array for a convention": (lambda: FREE.published(np.zeros(3)), "convention is array"),
    "array for a word": (lambda: FREE.sensitivity_at([0.0], by=np.zeros(3)), "by is array"),
    "array for axes": (lambda: FREE.sensitivity_at([0.0], axes=np.zeros(3)), "axes is array"),
    "truth value among numbers": (
        lambda: shape.Ellipsoid(True, 2, 1),
        r"semi_axes is \[True, 2, 1\]; give real numbers in m",
    ),
    "number of wings": (
        lambda: shape.box_wing((1, 1, 1), (1, 1), wings=1.0),
        "wings is 1.0; give a whole number from 1 to 2",
    ),
    "too many points": (lambda: FREE.polhode(10**18), "points is 10*; give a whole number from 2"),
    "too many lines": (lambda: photometry.lines(FREE, order=2**63), "a whole number from 1 to"),
    "word for refine": (
        lambda: photometry.fold(np.arange(9.0), 2.5, np.cos(np.arange(9.0)), order=1, refine="no"),
        "refine is 'no'; it must be True or False",
    ),
    "zero for scipy": (
        lambda: representations.to_rotation([0, 0, 0, 0]),
        r"wxyz holds \(0, 0, 0, 0\), which is no attitude",
    ),
    "word for a rate": (
        lambda: CustomTorque(lambda t, q, w: (0, 0, 0), depends_on_rate="no"),
        "depends_on_rate is 'no'; it must be True or False",
    ),
    "period of a DAMIT spin": (
        lambda: damit.RelaxedRotator(10.0, 20.0, 0.0, 2451545.0, 0.0),
        "period_h is 0.0; it must be greater than zero",
    ),
    "epoch of a DAMIT spin": (
        lambda: damit.RelaxedRotator(10.0, 20.0, 5.0, np.inf, 0.0),
        "jd0 holds inf",
    ),
    "member of an ensemble": (lambda: ENSEMBLE.label(5), "member 5 is out of range"),
    "epoch of a member": (lambda: ENSEMBLE.epoch_of("a"), "no member is called 'a'"),
    "epochs of members": (lambda: ENSEMBLE.epochs_of([7]), "member 7 of row 0 is out of range"),
    "law": (lambda: Scene(FREE, law="x"), "law is 'x'; give one of 'lambert'"),
    "class of laws": (lambda: Scene(FREE, law=Scene, **PLACES), "law is <class .*Scene"),
    "shadows": (lambda: Scene(FREE, shadows="x", **PLACES), "shadows is 'x'; give True, False"),
    "threads": (lambda: Scene(FREE, threads=0, **PLACES), "threads is 0; give a whole number"),
    "light of the Sun": (lambda: Scene(FREE, sun_magnitude="x", **PLACES), "sun_magnitude is 'x'"),
    "start of a scene": (lambda: Scene(FREE, **PLACES).since(5, [1, 2]), "start is 5; give an I"),
    "epochs of a scene": (
        lambda: Scene(FREE, **PLACES).since(SPIN.epoch, "x"),
        "seconds is 'x'; give plain seconds",
    ),
    "far from a table": (lambda: MOTIONS["table"].at(1e300), r"no attitude at 1e\+300 s;"),
    "no history": (lambda: AttitudeTable.from_history(5), "history is 5; give an AttitudeHistory"),
    "rates of accelerations": (
        lambda: FREE.angular_acceleration_from([1, 2]),
        r"angular_velocity has shape \(2,\); give \(..., 3\)",
    ),
    "rates at other epochs": (
        lambda: MOTIONS["arcs"].angular_acceleration_at([1, 2], angular_velocity=[[1, 2, 3]]),
        r"angular_velocity has shape \(1, 3\); give \(2, 3\)",
    ),
    "bounds of rates": (lambda: MOTIONS["arcs"].rate_bounds("x"), "seconds is 'x'"),
}


@pytest.mark.parametrize("case", CASES)
def test_wrong_arguments(case):
    call, sentence = CASES[case]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(AttitudeError, match=sentence):
            call()


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("name", ["wxyz_at", "angular_velocity_at", "angular_acceleration_at"])
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("x",), "seconds is 'x'; give plain seconds"),
        ((None,), "seconds is None; give plain seconds"),
        ((["2026-01-01"],), "seconds is .'2026-01-01'.; give plain seconds"),
        (([[1, 2], [3]],), "seconds is ragged"),
        (([1, 2], [1]), r"low has shape \(1,\), seconds has \(2,\)"),
        (([1, 2], [1, 2, 3]), r"low has shape \(3,\), seconds has \(2,\)"),
        (([1, 2], "x"), "low is 'x'; give plain seconds"),
    ],
)
def test_seconds_of_motions(motion, name, arguments, sentence):
    method = getattr(MOTIONS[motion], name, None)
    if method is None:
        assert name == "wxyz_at"
        assert motion != "arcs"
        return
    with pytest.raises(AttitudeError, match=sentence):
        method(*arguments)


@pytest.mark.parametrize("motion", MOTIONS)
def test_one_low_part_serves_all_epochs(motion):
    motion = MOTIONS[motion]
    low = 1e-3
    expected = motion.angular_velocity_at(np.array([1.0, 2.0]), np.array([low, low]))
    assert np.array_equal(motion.angular_velocity_at([1, 2], low), expected)


def test_flags_of_numpy_and_tables_of_shadows_are_taken():
    rates = propagate((1, 2, 2.5), (1, 0, 0, 0), (1, 1, 1), [1.0], angular_velocity=np.bool_(True))
    assert len(rates) == 2
    assert Body(moments=(1, 2, 2.5), relative=np.True_).relative is True
    table = Visibility.of(BOX)
    assert Scene(FREE, shadows=table, **PLACES).shadows is table


def test_largest_moments_are_taken():
    body = Body(moments=(4e307, 4e307, 4e307))
    motion = FreeRotation(body, Spin("2026-01-01", (1, 0, 0, 0), (0.0, 0.0, 0.1)))
    assert np.allclose(motion.at(1.0).wxyz, (np.cos(0.05), 0, 0, np.sin(0.05)), atol=1e-15)
