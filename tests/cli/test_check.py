"""The self-test: it passes here, it can fail, and its stored answers are those of the oracle."""

import re
import subprocess

import numpy as np
import pytest
from mpmath import mp, mpf

import attitude
from attitude import cli
from attitude._solver import warm_up
from attitude.cli import _selftest
from attitude.motions import _propagation
from tests.support.oracle import Oracle, rotation_error


def test_this_installation_passes(capsys):
    assert cli.main(["check", "--families"]) == 0
    shown = capsys.readouterr().out
    assert "passed" in shown and "times numpy.sin" in shown and "numba" in shown
    assert "near_separatrix" in shown


@pytest.mark.slow
def test_the_full_check_compares_more_and_can_fail(monkeypatch, capsys):
    assert cli.main(["check", "--full"]) == 0
    shown = capsys.readouterr().out
    found = re.findall(r"^(restarts|a constant torque|brightness).*: (\S+), at most", shown, re.M)
    assert [name for name, _ in found] == ["restarts", "a constant torque", "brightness"]
    errors = [float(error) for _, error in found]
    # Not zero, as they would be if one side were compared with itself.
    assert 1e-15 < errors[0] < 1e-12 and 1e-16 < errors[1] < 1e-10 and 1e-7 < errors[2] < 1e-4
    assert "near_separatrix" in shown and "passed" in shown
    monkeypatch.setattr(_selftest, "_TORQUE_ERROR", 1e-20)
    assert cli.main(["check", "--full"]) == 1
    assert "FAILED" in capsys.readouterr().out


def test_another_project_in_the_same_folder_is_named(tmp_path, monkeypatch, capsys):
    """PyPI's Attitude 0.5.0, by its metadata, and by a file where these are lost."""
    assert _selftest.other_project() is None
    assert (_selftest._FOLDER / "__init__.py").samefile(attitude.__file__)
    monkeypatch.setattr(_selftest, "_FOLDER", tmp_path / "attitude")
    (tmp_path / "attitude" / "orientation").mkdir(parents=True)
    assert _selftest.other_project() is None
    (tmp_path / "attitude" / "orientation" / "pca.py").touch()
    assert "PyPI's Attitude, lie in" in _selftest.other_project()
    (tmp_path / "attitude" / "orientation" / "pca.py").unlink()
    metadata = tmp_path / "Attitude-0.5.0.dist-info" / "METADATA"
    metadata.parent.mkdir()
    metadata.write_text("Metadata-Version: 2.1\nName: Attitude\nVersion: 0.5.0\n")
    assert _selftest.other_project() is None  # installed, but not where Python looks for modules
    monkeypatch.syspath_prepend(tmp_path)
    assert cli.main(["check"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("Warning: files of another project, PyPI's Attitude 0.5.0, lie in ")
    assert "passed" in shown
    monkeypatch.delattr("attitude.__version__")  # installed after this package
    assert cli.main(["check"]) == 2
    assert "PyPI's Attitude 0.5.0" in capsys.readouterr().err


def test_proofs_of_the_self_test_and_of_a_file(tmp_path, monkeypatch, capsys):
    pytest.importorskip("flint", reason="python-flint is not installed")
    assert cli.main(["check", "--prove"]) == 0
    shown = capsys.readouterr().out
    worst = float(re.search(r"errs by more than (\S+) rad", shown)[1])
    assert 5e-16 < worst < 4e-15 and "IEEE 754" in shown and "FLINT" in shown

    monkeypatch.chdir(tmp_path)
    convert = ["convert", "4179 Toutatis", "t.aem", "--stop", "2 d", "--step", "6 h"]
    assert cli.main(convert) == 0
    capsys.readouterr()
    assert cli.main(["check", "--prove", "t.aem", "--spin", "4179 Toutatis"]) == 0
    shown = capsys.readouterr().out
    # epochs are written to 1e-12 s
    assert "none of 9 records of t.aem" in shown
    assert float(re.search(r"more than (\S+) rad", shown)[1]) < 4e-15
    lines = (tmp_path / "t.aem").read_text().splitlines()
    last = lines.index("DATA_STOP") - 1  # with the attitude of the first record
    first = lines[lines.index("DATA_START") + 1].split()[1:]
    lines[last] = " ".join([lines[last].split()[0], *first])
    (tmp_path / "wrong.aem").write_text("\n".join(lines) + "\n")
    against = ["--spin", "4179 Toutatis"]
    assert cli.main(["check", "--prove", "wrong.aem", *against]) == 1
    assert "FAILED: 1 of the records is farther than 1e-06 rad" in capsys.readouterr().out
    assert cli.main(["check", "--prove", "wrong.aem", *against, "--tolerance", "3.2"]) == 0
    assert cli.main(["check", "--prove", "t.aem", *against, "--tolerance", "1e-20"]) == 1
    assert "FAILED: 9 of the records are" in capsys.readouterr().out
    for wrong, sentence in (
        (["--prove", "t.aem"], "--prove FILE needs --spin FILE"),
        (["--spin", "4179 Toutatis"], "--spin is for --prove FILE"),
        (["--tolerance", "1e-9"], "--tolerance is for --prove FILE"),
        (["--prove", "t.aem", *against, "--tolerance", "-1"], "--tolerance is -1"),
        (["--prove", "t.aem", "--spin", "t.aem"], "t.aem holds no free rotation"),
    ):
        assert cli.main(["check", *wrong]) == 2
        assert sentence in capsys.readouterr().err


def test_every_family_of_states_is_in_the_file():
    from tests.support import states

    assert {state["family"] for state in _selftest.reference_states()} == set(states.FAMILIES)


def test_stored_answers_are_the_exact_ones():
    """To all 30 digits, for one state of each family."""
    for state in _selftest.reference_states()[::2]:
        moments, wxyz0, omega0, t = (
            [float.fromhex(x) for x in state[key]] for key in ("moments", "wxyz0", "omega0", "t")
        )
        exact = Oracle(moments, wxyz0, omega0)
        for seconds, wxyz in zip(t, state["wxyz"], strict=True):
            with mp.workdps(40):
                found = exact.at(seconds)[0]
                assert max(abs(a - mpf(b)) for a, b in zip(found, wxyz, strict=True)) < 1e-29


def test_errors_are_measured_as_the_oracle_measures_them():
    """Against the 40-digit angle, for an answer that is made wrong on purpose."""
    state = dict(_selftest.reference_states()[0])
    assert _selftest.errors_of(state)[0] < 2e-15
    turned = [[str(mpf(x) + mpf("1e-9") * k) for k, x in enumerate(row)] for row in state["wxyz"]]
    wrong = _selftest.errors_of({**state, "wxyz": turned})[0]
    expected = max(
        rotation_error([float(x) for x in row], [mpf(x) for x in other])
        for row, other in zip(state["wxyz"], turned, strict=True)
    )
    assert wrong == pytest.approx(expected, rel=1e-5)  # the 1e-16 rounding of the float() above


@pytest.mark.parametrize("fault", [1e-13, np.nan, "sign"])
def test_a_wrong_installation_fails(monkeypatch, capsys, fault):
    """Exit code 1 for an error above the promise, a NaN, or a wrong sign."""
    real = _propagation.propagate

    def broken(*state, **settings):
        answer = real(*state, **settings)
        wxyz, omega = (np.array(part) for part in answer)
        if fault == "sign":
            wxyz *= -1.0
        else:
            wxyz[-1, 0] += fault
        return wxyz, omega

    monkeypatch.setattr(_selftest, "propagate", broken)
    assert cli.main(["check"]) == 1
    assert "FAILED" in capsys.readouterr().out


def test_a_single_core_compiles_at_the_first_use(monkeypatch):
    monkeypatch.setattr(warm_up, "_cores", lambda: 1)
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("another process"))
    warm_up.compile_ahead()


def test_interrupted_it_leaves_no_other_process(monkeypatch):
    """Ctrl-C in the first is the end of the second too."""
    done = []

    class Other:
        def __init__(self, *_, **__):
            pass

        def kill(self):
            done.append("killed")

        def wait(self):
            done.append("waited for")

    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr(warm_up, "_cores", lambda: 2)
    monkeypatch.setattr(subprocess, "Popen", Other)
    monkeypatch.setattr(warm_up, "compile_stages", interrupted)
    with pytest.raises(KeyboardInterrupt):
        warm_up.compile_ahead()
    assert done == ["killed", "waited for"]
