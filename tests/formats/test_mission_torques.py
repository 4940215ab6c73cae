"""Sections [[torque]] of mission files: each kind, against the torque of Python; errors."""

import numpy as np
import pytest

from attitude import AttitudeError, Body, Spin, paths
from attitude.cli import main
from attitude.formats import mission
from attitude.shape import box
from attitude.splitting import TorquedRotation
from attitude.torques import (
    IGRF,
    AerodynamicTorque,
    ConstantTorque,
    DipoleField,
    EddyCurrent,
    GravityGradient,
    InternalDissipation,
    LinearDamping,
    MagneticDipole,
    Maxwell,
    QualityFactor,
    Rheology,
    SolarRadiation,
)

HEAD = """
[center.kepler]
epoch = "2024-03-01"
center = "earth"
semi_major_axis = "7140 km"
eccentricity = 0.001
inclination = "98 deg"
node = "20 deg"
pericenter_argument = 0.0
mean_anomaly = 0.0
[body]
moments = [900, 1100, 1300]
center_of_mass = [0.1, 0.05, -0.2]
[spin]
epoch = "2024-03-01"
wxyz = [1, 2, 3, 4]
angular_velocity = [0.01, 0.02, 0.1]
[shape]
box = [2, 1, 3]
[integration]
step = "1 s"
"""
ORBIT = paths.kepler(
    epoch="2024-03-01",
    center="earth",
    semi_major_axis=7.14e6,
    eccentricity=0.001,
    inclination=np.radians(98.0),
    node=np.radians(20.0),
    pericenter_argument=0.0,
    mean_anomaly=0.0,
)
FLAT = dict.fromkeys(("inclination", "node", "pericenter_argument", "mean_anomaly"), 0.0)
FLAT |= {"epoch": "2024-03-01", "eccentricity": 0.1}
SATURNIAN = paths.kepler(center="saturn barycenter", semi_major_axis=2e8, **FLAT)
HELIOCENTRIC = paths.kepler(semi_major_axis=1e10, **FLAT)
BODY = Body(moments=(900, 1100, 1300), center_of_mass=(0.1, 0.05, -0.2))
SPIN = Spin("2024-03-01", (1, 2, 3, 4), (0.01, 0.02, 0.1))
BOX = box((2.0, 1.0, 3.0))
FROM_SUN = paths.relative(ORBIT, "sun")


def air(heights):
    return 1e-11 * np.exp((5e5 - heights) / 6e4)


KINDS = {
    "gravity": ('kind = "gravity_gradient"', GravityGradient(ORBIT, "earth")),
    "gravity about Saturn": (
        'kind = "gravity_gradient"\nbody = "saturn barycenter"\npath = { kepler = { center = '
        '"saturn barycenter", semi_major_axis = "2e5 km", eccentricity = 0.1, inclination = 0.0, '
        'node = 0.0, pericenter_argument = 0.0, mean_anomaly = 0.0, epoch = "2024-03-01" } }',
        GravityGradient(SATURNIAN, "6"),
    ),
    "gravity of the Sun": (
        'kind = "gravity_gradient"\npath = { kepler = { semi_major_axis = "1e7 km", '
        "eccentricity = 0.1, inclination = 0.0, node = 0.0, pericenter_argument = 0.0, "
        'mean_anomaly = 0.0, epoch = "2024-03-01" } }',
        GravityGradient(HELIOCENTRIC, "sun"),
    ),
    "mass": ('kind = "gravity_gradient"\nmu = 4e14', GravityGradient(ORBIT, 4e14)),
    "currents": (
        'kind = "eddy_current"\ntensor = 5e7\nfield = 3',
        EddyCurrent(5e7, IGRF(3), ORBIT),
    ),
    "currents of a tensor": (
        'kind = "eddy_current"\ntensor = [[5e7, 0, 1e6], [0, 4e7, 0], [1e6, 0, 3e7]]\n'
        'field = { degree = 2, epoch = "2020-01-01" }',
        EddyCurrent(
            [[5e7, 0, 1e6], [0, 4e7, 0], [1e6, 0, 3e7]], IGRF(2, epoch="2020-01-01"), ORBIT
        ),
    ),
    "dipole": (
        'kind = "magnetic_dipole"\nmoment = [1e3, 0, 2e3]\nfield = { dipole = [0, 0, -7.7e22] }',
        MagneticDipole((1e3, 0, 2e3), DipoleField((0, 0, -7.7e22)), ORBIT),
    ),
    "air": (
        'kind = "aerodynamic"\nmirrored = 0.1\n'
        'density = { density = 1e-11, height = "500 km", scale_height = "60 km" }',
        AerodynamicTorque(BOX, ORBIT, air, 0.1),
    ),
    "light": (
        'kind = "solar_radiation"\ndiffuse = 0.5\nflux = 1e8\nshadows = true',
        SolarRadiation(BOX, FROM_SUN, 0.5, flux=1e8, shadows=True),
    ),
    "eclipsed light": (
        'kind = "solar_radiation"\nflux = 1e8\nshadow_of = ["earth"]',
        SolarRadiation(BOX, FROM_SUN, flux=1e8, shadow_of=paths.relative("earth", "sun")),
    ),
    "thruster": ('kind = "constant"\ntorque = [0, 0.5, 0.1]', ConstantTorque((0, 0.5, 0.1))),
    "damping": ('kind = "linear_damping"\ncoefficient = 0.3', LinearDamping(0.3)),
    "friction": ('kind = "internal_dissipation"\nstrength = 1e-3', InternalDissipation(1e-3)),
    "rubble": (
        'kind = "internal_dissipation"\naxes = [2, 1.5, 1]\ndensity = 2000\n'
        "rigidity = 1e4\nquality = 5",
        InternalDissipation(Rheology((2, 1.5, 1), 2000, QualityFactor(1e4, 5))),
    ),
    "ice": (
        'kind = "internal_dissipation"\naxes = [2, 1.5, 1]\ndensity = 900\n'
        'rigidity = "1e4 Pa"\nviscosity = "1e5 Pa s"\npoisson = 0.3',
        InternalDissipation(Rheology((2, 1.5, 1), 900, Maxwell(1e4, 1e5), 0.3)),
    ),
}


@pytest.mark.parametrize("name", KINDS)
def test_each_kind_is_the_torque_of_python(name, tmp_path):
    section, torque = KINDS[name]
    file = tmp_path / "mission.toml"
    file.write_text(HEAD + "[[torque]]\n" + section)
    motion = mission.read_motion(file)
    wanted = TorquedRotation(BODY, SPIN, torque, step=1.0)
    np.testing.assert_allclose(motion.at(40.0).wxyz, wanted.at(40.0).wxyz, atol=1e-14)
    # and the torque acts: the last digits of a free rotation differ
    free = TorquedRotation(BODY, SPIN, ConstantTorque((0, 0, 0)), step=1.0)
    assert np.abs(motion.at(40.0).wxyz - free.at(40.0).wxyz).max() > 1e-12


def test_torques_add_up_and_serve_a_scene(tmp_path):
    sections = "".join(f"[[torque]]\n{KINDS[name][0]}\n" for name in ("gravity", "thruster"))
    text = 'columns = ["phase_angle deg"]\ntimes.epochs = ["2024-03-01T00:01:00"]\n' + HEAD
    view = mission.parse(text + sections).scene.at("2024-03-01T00:01:00")
    torques = [KINDS["gravity"][1], KINDS["thruster"][1]]
    wanted = TorquedRotation(BODY, SPIN, torques, step=1.0)
    time = view.seconds if view.scene.motion is None else 60.0
    np.testing.assert_allclose(view.scene.motion.at(time).wxyz, wanted.at(60.0).wxyz, atol=1e-12)


def test_errors_of_the_state_follow_the_torques(tmp_path):
    file = tmp_path / "mission.toml"
    file.write_text(HEAD + '[errors]\nattitude = "1 deg"\n[[torque]]\n' + KINDS["thruster"][0])
    covariance = mission.read_motion(file).covariance_at(10.0)
    assert covariance[0, 0] == pytest.approx(np.radians(1.0) ** 2, rel=0.5)


def test_the_command_propagates_under_torques(tmp_path, capsys):
    file = tmp_path / "mission.toml"
    file.write_text(HEAD + "[[torque]]\n" + KINDS["thruster"][0])
    main(["propagate", str(file), "--stop", "60 s", "--step", "30 s", "--rates"])
    last = capsys.readouterr().out.splitlines()[-1].split(",")
    wanted = TorquedRotation(BODY, SPIN, ConstantTorque((0, 0.5, 0.1)), step=1.0).at(60.0)
    np.testing.assert_allclose(np.array(last[2:6], dtype=float), wanted.wxyz, atol=1e-9)


@pytest.mark.parametrize(
    ("section", "sentence"),
    [
        ("", r"number 1 has no kind; give one of gravity_gradient"),
        ('kind = "gravity"', r"has the kind .gravity.; give one of"),
        ('kind = "constant"', r"number 1 \(constant\) has no torque; give it, in N m"),
        ('kind = "constant"\ntorque = [1, 2]', "number 1 .constant."),
        ('kind = "constant"\ntorque = [0, 0, 1]\npush = 1', "key 'push' that is not known"),
        ('kind = "eddy_current"\ntensor = -1', "negative eigenvalue"),
        ('kind = "eddy_current"\ntensor = 1\nfield = "dipole"', "give a degree of the IGRF"),
        ('kind = "eddy_current"\ntensor = 1\nfield = 14', "degrees 1 to 13"),
        ('kind = "gravity_gradient"\nbody = "vulcan"', "vulcan"),
        ('kind = "gravity_gradient"\nbody = 3', "no body whose gravity acts; give body"),
        ('kind = "gravity_gradient"\npath = "moon"\nmu = 1e13', "no body whose gravity acts"),
        ('kind = "solar_radiation"\nshadow_of = 3', "give names of bodies"),
        ('kind = "solar_radiation"\nshadows = "yes"', "shadows"),
        ('kind = "internal_dissipation"', "quality"),
        ('kind = "internal_dissipation"\nstrength = 1\naxes = [1, 1, 1]', "give one of them"),
        ('kind = "aerodynamic"\ndensity = { density = 1 }', "has no height"),
    ],
)
def test_what_is_refused(section, sentence, tmp_path):
    file = tmp_path / "mission.toml"
    file.write_text(HEAD + "[[torque]]\n" + section)
    with pytest.raises(AttitudeError, match=sentence) as caught:
        mission.read_motion(file)
    assert str(caught.value).startswith(str(file))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("torque = 3\n[body]\nmoments = [1, 2, 2.5]\n", "no list of torques|spin"),
        ('[[torque]]\nkind = "constant"\ntorque = [0, 0, 1]\n', "no spin on which they act"),
        ("[integration]\nstep = 1\n", "no list of torques"),
        ('spin = "4179 Toutatis"\n[[torque]]\nkind = "gravity_gradient"\n', "give center"),
        ('spin = "4179 Toutatis"\n[[torque]]\nkind = "solar_radiation"\n', "give a section .shape"),
        ('spin = "4179 Toutatis"\n', "x"),
    ],
)
def test_files_that_lack_something(text, sentence, tmp_path):
    file = tmp_path / "mission.toml"
    file.write_text(text)
    if sentence == "x":  # without torques it is a free rotation
        assert mission.read_motion(file).spin is not None
        return
    with pytest.raises(AttitudeError, match=sentence):
        mission.read_motion(file)
