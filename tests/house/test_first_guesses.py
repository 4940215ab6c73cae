"""What a new user types first: it works, or the answer names what does.

Each guess is a line of code; `works` have a value, the others raise an error whose sentence holds
the words given.  They were written down as a user would type them who knows scipy, astropy,
skyfield, trimesh or a paper, before reading a page of the docs.
"""

import importlib
import inspect
import re

import numpy as np
import pytest

import attitude
from attitude import Arcs, Body, Ensemble, FreeRotation, Impulse, Scene, Spin, paths, shape
from attitude._support import synonyms
from attitude.motions import Motion

WORKS = [
    "motion.plot()",
    "motion.view(output=folder / 'm.html')",
    "motion.write(folder / 'm.toml')",
    "motion.write(folder / 'm.apm')",
    "motion.write(folder / 'm.aem', t)",
    "motion.write(folder / 'm.csv', t)",
    "motion.write(folder / 'm.aem', start=0.0, stop=60.0, tolerance=1e-6)",
    "attitude.plots.polhode(motion)",
    "history.in_frame('ecliptic')",
    "history.in_frame('lvlh', orbit)",
    "shape.Ellipsoid(3, 2, 1)",
    "attitude.inversion",
    "attitude.viewer",
    "Spin(epoch='2026-01-01', dcm=np.eye(3), angular_velocity=(0, 0, 1))",
    "scene.view(output=folder / 's.html')",
]
THIRD_WORKS = [
    "shape.box(1, 2, 3)",
    "Spin(epoch='2026-01-01', wxyz=(1, 0, 0, 0), angular_velocity='0, 0, 10 rpm')",
    "attitude.catalog.entry('toutatis').motion().plot()",
]
ANSWERED = {
    "Body(10, 20, 26)": "Body(moments=(10, 20, 26))",
    "Body(inertia=(10, 20, 26))": "moments",
    "Body(axes=(3, 2, 1))": "Body.from_ellipsoid",
    "body.inertia": "tensor",
    "body.I": "tensor",
    "body.principal_moments": "moments",
    "Spin(epoch='2026-01-01', quaternion=(1, 0, 0, 0), omega=(0, 0, 1))": "wxyz=",
    "Spin(epoch='2026-01-01', wxyz=(1, 0, 0, 0), omega=(0, 0, 1))": "angular_velocity=",
    "Spin.from_periods(body, period=3600.0)": "P_psi",
    "spin.quaternion": "wxyz",
    "spin.omega": "angular_velocity",
    "spin.period": "period_psi",
    "FreeRotation(moments=(1, 2, 3), spin=spin)": "Body",
    "FreeRotation((1, 2, 3), (1, 0, 0, 0), (0, 0, 1))": "it takes body, spin",
    "FreeRotation(body)": "spin",
    "motion.period": "period_psi",
    "motion.periods": "period_psi",
    "motion.P_phi": "published",
    "motion.pole": "momentum",
    "motion.spin_axis": "momentum",
    "motion.angular_momentum": "momentum",
    "motion.quaternion": ".at(t).wxyz",
    "motion.rotation": "as_rotation",
    "motion.euler_angles": 'euler("ZXZ")',
    "motion.omega": ".at(t).angular_velocity",
    "motion.propagate": ".at(t)",
    "motion.to_aem(folder / 'm.aem')": "write(file)",
    "motion.save('m.toml')": "write(file)",
    "motion.animate()": "attitude.viewer.animate",
    "motion.write('m.aem')": "start=",
    "motion.write('m.xyz')": ".toml",
    "history.quaternion": "wxyz",
    "history.omega": "angular_velocity",
    "history.euler_angles": 'euler("ZXZ")',
    "history.to_csv('m.csv')": "table()",
    "history.rotation": "as_rotation()",
    "Scene(motion, path=orbit)": "center=",
    "Scene(motion, center=orbit, site='568')": "observer=",
    "scene.magnitude": "at(times).magnitude",
    "Arcs(body, spin, impulses=[impulse])": "changes=",
    "mesh.faces": "facets",
    "attitude.read('m.aem')": "attitude.formats.detect.read",
    "attitude.plot(motion)": "motion.plot()",
    "attitude.view(motion)": "attitude.viewer.view",
    "attitude.load('toutatis')": "attitude.catalog.load",
    "attitude.catalog.list()": "names()",
}


# A second look, by another new user, after the list above was answered.
SECOND = {
    "motion.is_tumbling": "mode",
    "motion.nutation": "angles(t)",
    "motion.describe()": "str(motion)",
    "motion.momentum_direction": "momentum",
    "motion.evaluate(t)": ".at(t)",
    "history.to_dataframe()": "to_pandas()",
    "history.R": "as_rotation()",
    "history.rpy": 'euler("zyx")',
    "history.interpolate(3.0)": ".at(t)",
    "body.shape": "Scene(shape=)",
    "Spin.from_euler('ZXZ', (1, 2, 3))": "angles",
    "scene.magnitude_at(t)": "at(times).magnitude",
    "scene.at(t).mag": "reduced_magnitude",
    "mesh.scale(2)": "scaled(factor)",
    "mesh.plot()": "view(output=file)",
    "mesh.save('m.obj')": "write(file)",
    "shape.cube(1.0)": "shape.box",
    "shape.sphere(1.0)": "shape.Ellipsoid",
    "attitude.catalog.toutatis": "catalog.entry(name)",
    "attitude.catalog.search('apophis')": "names()",
    "attitude.paths.horizons('apophis')": "paths.spk(file)",
    "attitude.events.find_glints(scene)": "events.glints(scene, ...)",
    "attitude.from_file('a.aem')": "attitude.formats.detect.read",
    "attitude.invert": "spin_states",
    "attitude.torques.SolarPressure": "SolarRadiation",
    "attitude.torques.Drag": "AerodynamicTorque",
    "attitude.torques.Thruster": "Impulse",
    "attitude.scattering.lambert": "Lambert()",
    "Impulse(t=60, torque=(0, 0, 1))": "use at=",
    "Impulse(at=60, delta_h=(0, 0, 1))": "angular_momentum=",
}

# A third look: constructors and arguments by the names of other packages.
THIRD = {
    "Spin(epoch='2026-01-01', wxyz=(1, 0, 0, 0), angular_velocity='10 rpm')": '"0, 0, 10 rpm"',
    "Spin(wxyz=(1, 0, 0, 0), angular_velocity=(0, 0, 1))": 'as in Spin(epoch="2026-01-01",',
    "Spin(epoch='2026-01-01', wxyz=(1, 0, 0, 0))": "give angular_velocity=",
    "Spin(epoch='2026-01-01', period='5 h')": "Spin.from_periods",
    "Spin.from_quaternion((1, 0, 0, 0))": "Spin(epoch=, wxyz=",
    "Spin.from_rotvec((0, 0, 1))": "Spin.from_rotation",
    "Spin.from_dcm(np.eye(3))": "dcm=",
    "Spin.from_rpm(10)": "Spin.from_periods",
    "Spin.from_catalog('toutatis')": "attitude.catalog.load",
    "Spin.from_pole(body, ra=10, dec=20, period=5)": "give pole=",
    "Spin.from_rotation(1)": "rotation=",
    "Body.from_mesh(mesh)": "Body.from_shape(mesh",
    "Body.from_box(1, 2, 3)": "attitude.shape.box",
    "Body.from_tensor(np.eye(3))": "tensor=",
    "Body.from_ellipsoid(3, 2, 1)": "Body.from_ellipsoid((380, 240, 180)",
    "Body.from_shape(mesh, mass=3.0)": "density=",
    "motion.at()": "motion.at(60.0)",
    "motion.at(times=t)": "give t=",
    "motion.spin_rate": "angular_velocity",
    "motion.is_sam": "mode",
    "motion.flips()": "flip_time",
    "motion.light_curve(t)": "Scene",
    "attitude.paths.kepler(a=7e6, e=0, i=0)": "semi_major_axis=",
    "attitude.paths.tle(line1='1', line2='2')": "tle([line1, line2])",
    "attitude.paths.site(lat=10, lon=20)": "latitude=",
    "Ensemble([motion, motion])": "Ensemble.of(",
    "Ensemble.random(10)": "Ensemble.sample",
    "attitude.photometry.LightCurve(jd=[1, 2, 3], mag=[1, 2, 3])": "times=",
    "attitude.inversion.spin_states('curve.csv')": "LightCurve.read(file)",
    "Scene(motion, None, (1, 0, 0), (0, 1, 0), shape='box.obj')": "attitude.shape.read(file)",
    "shape.Mesh(vertices=np.eye(3), faces=[[0, 1, 2]])": "facets=",
    "mesh.inertia": "mass_properties",
    "attitude.propagate(body, spin, t)": "FreeRotation(body, spin).at(t)",
    "attitude.fit(times=t, quaternions=history.wxyz)": "AttitudeTable(epoch, t, wxyz)",
    "attitude.light_curve.magnitude(scene, t)": "at(times).magnitude",
    "attitude.integrate(motion)": ".at(t)",
    "attitude.Orbit": "attitude.paths.kepler",
    "attitude.glints(scene)": "attitude.events.glints",
    "attitude.photometry.periods(t, t, min='2 h', max='40 h')": "min_period=",
    "attitude.photometry.LightCurve.read(path='c.csv')": 'as in LightCurve.read("curve.csv")',
    "attitude.photometry.fold(t, t, periods=3.0)": "period=",
    "attitude.photometry.Lightcurve": "LightCurve",
    "attitude.events.passes(center=orbit)": "the scene",
    "attitude.events.glints(scene, shape=mesh)": "the scene",
    "motion.view(file='q.html')": "output=",
    "attitude.catalog.entry()": 'entry("toutatis")',
    "attitude.catalog.entry('toutatis', 1992)": 'entry("toutatis")',
    "attitude.averaged.AveragedMotion(body, spin, torque=1)": "torques=",
    "attitude.TorquedRotation(body, spin, torque=1)": "torques=",
    "attitude.formats.aem.read(file='m.aem')": 'aem.read("m.aem")',
    "attitude.formats.aem.write('m.aem', motion=motion)": "source=",
    "attitude.formats.detect.read(file='m.aem')": 'detect.read("m.aem")',
    "attitude.AttitudeTable.from_history(history).times": "history.time",
    "attitude.quaternions": "attitude.frames.quaternion",
    "attitude.lightcurve": "attitude.light_curve",
}


@pytest.fixture(scope="module")
def names(tmp_path_factory):
    """The objects that a user would have."""
    body = Body(moments=(10, 20, 26))
    spin = Spin(epoch="2026-01-01", wxyz=(1, 0, 0, 0), angular_velocity=(1, 15, 1))
    motion = FreeRotation(body, spin)
    t = np.linspace(0.0, 60.0, 7)
    names = {"body": body, "spin": spin, "motion": motion, "t": t, "history": motion.at(t)}
    names |= {each.__name__: each for each in (Arcs, Body, Ensemble, FreeRotation, Scene, Spin)}
    center = paths.uniform((7e6, 0, 0), (0, 7500.0, 0), epoch="2026-01-01", center="earth")
    here = Scene(motion, None, (1, 0, 0), (0, 1, 0), shape=shape.Ellipsoid((3, 2, 1)))
    names |= {"orbit": center, "scene": here, "mesh": shape.box((1, 2, 3)), "shape": shape}
    names |= {"impulse": Impulse(at=60.0, angular_momentum=(0, 0, 1)), "np": np}
    names["Impulse"] = Impulse
    return names | {"attitude": attitude, "folder": tmp_path_factory.mktemp("guesses")}


def test_there_are_61():
    assert len(WORKS) + len(ANSWERED) == 61
    assert len(SECOND) == 30 and len(THIRD) + len(THIRD_WORKS) == 58


@pytest.mark.parametrize("guess", [*WORKS, *THIRD_WORKS])
def test_works(guess, names):
    found = eval(guess, names)
    for each in re.findall(r"folder / '([^']+)'", guess):
        assert (names["folder"] / each).stat().st_size > 200
    assert found is not None or "write" in guess


@pytest.mark.parametrize("guess", [*ANSWERED, *SECOND, *THIRD])
def test_is_answered_with_the_right_name(guess, names):
    with pytest.raises((attitude.AttitudeError, AttributeError)) as error:
        eval(guess, names)
    sentence = str(error.value)
    assert {**ANSWERED, **SECOND, **THIRD}[guess] in sentence, sentence
    assert sentence.endswith("."), sentence


def _classes():
    """The public classes, with those of private modules that the table names, by name."""
    found = {}
    for module in attitude.PUBLIC_MODULES:
        if module in ("attitude.jax", "attitude.torch", "attitude.survey"):
            continue  # they need optional packages, and have no classes of the table
        loaded = importlib.import_module(module)
        members = vars(loaded) | {k: getattr(loaded, k) for k in getattr(loaded, "__all__", ())}
        for value in members.values():
            if inspect.isclass(value):
                found |= {base.__name__: base for base in value.__mro__}
    return found


def test_no_hint_hides_a_name_and_each_names_one_that_exists():
    """Every class and module of the table exists, lacks the names it answers, has those it says."""
    classes = _classes()
    assert set(synonyms.ATTRIBUTES) <= set(classes), set(synonyms.ATTRIBUTES) - set(classes)
    for name, hints in synonyms.ATTRIBUTES.items():
        assert issubclass(classes[name], synonyms.Answering), name
        for absent, hint in hints.items():
            assert not hasattr(classes[name], absent), f"{name}.{absent} exists"
            assert absent not in getattr(classes[name], "__annotations__", {}), f"{name}.{absent}"
            for module, function in re.findall(r"attitude\.([a-z_.]+?)\.(\w+)\(", hint):
                assert hasattr(importlib.import_module(f"attitude.{module}"), function), hint
    for name, hints in synonyms.MODULES.items():
        module = importlib.import_module(name)
        for absent, hint in hints.items():
            assert absent not in dir(module), f"{name}.{absent} exists"
            for address in re.findall(r"\battitude(?:\.\w+)+", hint):
                assert eval(address) is not None
            with pytest.raises(AttributeError, match="use "):
                getattr(module, absent)


def test_the_own_error_of_a_property_is_kept():
    class Broken(synonyms.Answering):
        @property
        def period(self):
            return self.nothing

    with pytest.raises(AttributeError, match="nothing"):
        _ = Broken().period


def test_a_type_error_inside_of_a_call_stays_one():
    @synonyms.arguments({}, "half(2)")
    def half(value):
        return value / 2

    with pytest.raises(TypeError, match="unsupported operand"):
        half("text")
    with pytest.raises(
        attitude.AttitudeError, match=r"half has no argument number; it takes value"
    ):
        half(number=2)


def test_absent_names_are_not_listed():
    spin = Spin("2026-01-01", (1, 0, 0, 0), (0, 0, 0.1))
    motion = FreeRotation(Body(moments=(1, 2, 3)), spin)
    table = attitude.AttitudeTable.from_history(motion.at([0.0, 1.0, 2.0]))
    for owner in (motion, type(motion)):
        assert {"quaternion", "propagate", "period"}.isdisjoint(dir(owner)) and "at" in dir(owner)
    # an attribute that Motion answers, which tables have
    assert "wxyz" in dir(table) and "wxyz" not in dir(motion)
    assert "quaternion" not in dir(table) and not hasattr(table, "quaternion")


def test_hints_leave_what_a_users_class_has():
    """Its own members, where its name is in the table too, and those of another base."""

    class Turns:
        limit = 3

        @property
        def rotation(self):
            return 2 * self.limit

    class View(Motion, Turns):
        def flux(self):
            return self.rotation

    assert View().flux() == 6 and "rotation" in dir(View()) and View.limit == 3
    with pytest.raises(AttributeError, match="use magnitude"):
        _ = View().mag
