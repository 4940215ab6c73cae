"""Pictures: what is drawn is the motion, and the command writes a file."""

import warnings

import numpy as np
import pytest

from attitude import AttitudeError, Body, FreeRotation, Spin, plots
from attitude.cli import main
from attitude.errors import AttitudeWarning

MOTIONS = {
    "short axis": ((10.0, 20.0, 26.0), (1.0, 15.0, 1.0)),
    "long axis": ((10.0, 20.0, 26.0), (9.0, 2.0, 1.0)),
    "other order": ((26.0, 10.0, 20.0), (1.0, 9.0, 2.0)),
    "separatrix": ((2.0, 5.0, 6.0), (1.0, 0.7, 1.0)),
    "middle axis": ((10.0, 20.0, 26.0), (0.0, 1.0, 0.0)),
    "principal axis": ((10.0, 20.0, 26.0), (0.0, 0.0, 1.0)),
    "symmetric": ((10.0, 10.0, 15.0), (1.0, 0.5, 1.0)),
    "sphere": ((10.0, 10.0, 10.0), (1.0, 0.5, 1.0)),
}


def motion_of(moments, omega):
    return FreeRotation(Body(moments=moments), Spin("2026-01-01", (1, 2, 3, 4), omega))


@pytest.mark.parametrize("name", MOTIONS)
def test_an_overview_of_every_kind_of_motion(name, tmp_path):
    motion = motion_of(*MOTIONS[name])
    figure = plots.overview(motion, title=rf"{name}, no $\foo$ of mathematics")
    figure.savefig(tmp_path / "motion.png", dpi=40)
    assert (tmp_path / "motion.png").stat().st_size > 5000
    assert len(figure.axes) == 4


def test_the_polhode_lies_on_the_ellipsoid_through_the_state():
    motion = motion_of(*MOTIONS["short axis"])
    axes = plots.new_figure((4, 4)).add_subplot(projection="3d")
    plots.polhode(axes, motion)
    energies = []
    for line in axes.lines:
        points = np.radians(np.array(line.get_data_3d()).T)
        if len(points) > 2:
            energies.append(0.5 * (motion.body.moments * points**2).sum(axis=1))
    assert len(energies) == 25  # six curves on four sides, and the motion itself
    np.testing.assert_allclose(np.concatenate(energies), motion.energy, rtol=1e-12)


def test_the_sky_shows_where_the_axes_point():
    motion = motion_of(*MOTIONS["other order"])
    axes = plots.new_figure((4, 4)).add_subplot(projection="mollweide")
    t = np.linspace(0.0, 1.0, 50)
    plots.sky(axes, motion, t, frame="icrf")
    longitude, latitude = axes.lines[0].get_data()
    path = np.isfinite(longitude)
    x = motion.at(t).body_to_inertial([0.0, 1.0, 0.0])  # the least moment is about y
    np.testing.assert_allclose(np.sin(latitude[path]), x[:, 2], atol=1e-14)
    np.testing.assert_allclose(np.tan(longitude[path]), x[:, 1] / x[:, 0], rtol=1e-10)


def test_angles_and_rates_against_time():
    motion = motion_of(*MOTIONS["long axis"])
    figure = plots.new_figure((4, 4))
    t = np.linspace(0.0, 2.0, 30)
    plots.rates(axes := figure.add_subplot(), motion, t)
    rates = np.array([line.get_ydata() for line in axes.lines]).T
    np.testing.assert_allclose(rates, np.degrees(motion.at(t).angular_velocity), rtol=1e-12)
    plots.angles(axes := figure.add_subplot(), motion, t)
    theta = axes.lines[1].get_ydata()
    np.testing.assert_allclose(theta[np.isfinite(theta)], np.degrees(motion.angles(t, "L")[:, 1]))


def test_bad_input_is_a_sentence():
    for span in (None, 86400.0):
        with pytest.raises(AttitudeError, match=r"the body is at rest: .* give one that turns"):
            plots.overview(motion_of((1.0, 2.0, 2.5), (0, 0, 0)), span=span)
    with pytest.raises(AttitudeError, match="span is -1"):
        plots.overview(motion_of(*MOTIONS["long axis"]), span=-1.0)
    with pytest.raises(AttitudeError, match="rod"):
        plots.overview(motion_of((0.0, 1.0, 1.0), (0.0, 1.0, 0.0)))
    with pytest.raises(AttitudeError, match="frame"):
        plots.overview(motion_of(*MOTIONS["long axis"]), frame="galactic")
    for wrong in (None, motion_of(*MOTIONS["long axis"]).spin):
        for drawn in (plots.overview, plots.polhode):
            with pytest.raises(AttitudeError, match=r"motion is .*; give a FreeRotation"):
                drawn(wrong)


def run(arguments, capsys):
    code = main(["plot", *arguments])
    told = capsys.readouterr()
    return code, told.out.strip(), told.err.strip()


def test_the_command(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["toutatis", "--span", "20 d"], capsys)[:2] == (0, "4179-toutatis.png")
    assert (tmp_path / "4179-toutatis.png").stat().st_size > 20000
    (tmp_path / "spin.toml").write_text(
        'body.moments = [10, 20, 26]\nspin.epoch = "2026-01-01"\nspin.wxyz = [1, 0, 0, 0]\n'
        'spin.angular_velocity = "6, 90, 6 deg/s"\n'
    )
    assert run(["spin.toml", "--output", "x.svg"], capsys)[:2] == (0, "x.svg")
    assert (tmp_path / "x.svg").read_text().startswith("<?xml")


def test_the_command_completes_what_the_catalogue_does_not_hold(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, told = run(["1P/Halley"], capsys)
    assert code == 2 and "--moments --pole --phi0 --psi0 --epoch" in told
    options = ["--moments", "0.439,1,1", "--pole", "10, 20 deg", "--phi0", "0", "--psi0", "30 deg"]
    code, out, _ = run(["1P/Halley", *options, "--epoch", "1986-03-09"], capsys)
    assert (code, out) == (0, "1p-halley.png")


def test_the_command_says_what_is_wrong(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "ends in .png" in run(["toutatis", "--output", "x.gif"], capsys)[2]
    assert "no 'nothing'" in run(["nothing"], capsys)[2]
    assert "nothing.toml" in run(["nothing.toml"], capsys)[2]
    assert "cannot be written" in run(["toutatis", "--output", "no/where.png"], capsys)[2]
    (tmp_path / "spin.toml").write_text("")
    assert "write such values into the file" in run(["spin.toml", "--phi0", "0"], capsys)[2]


def test_the_time_axis_has_the_date_of_the_epoch():
    figure = plots.overview(motion_of(*MOTIONS["short axis"]))
    for axes in figure.axes[2:]:
        assert axes.get_xlabel() == "time since 2026-01-01T00:00:00 UTC, s"


def test_coarse_steps_are_said_once(tmp_path, capsys):
    motion = motion_of(*MOTIONS["short axis"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plots.overview(motion, span=30.0)
    with pytest.warns(AttitudeWarning, match=r"a point every 0\.8333 s, .* period") as said:
        plots.overview(motion, span=1000.0)
    assert len(said) == 1
    with pytest.warns(AttitudeWarning, match="at most 0.04"):
        plots.rates(plots.new_figure((4, 4)).add_subplot(), motion, np.arange(0.0, 60.0))
    spin = tmp_path / "fast.toml"
    spin.write_text(
        "[body]\nmoments = [10, 20, 26]\n[spin]\nepoch = '2026-01-01'\nwxyz = [1, 0, 0, 0]\n"
        "angular_velocity = [1, 15, 1]\n"
    )
    picture = str(tmp_path / "a.png")
    assert main(["plot", str(spin), "--span", "1000 s", "--output", picture]) == 0
    err = capsys.readouterr().err
    assert err.startswith("attitude: warning: the curves have a point every 0.8333 s")
    assert err.count("\n") == 1
