"""The examples run as a reader would run them, and print what their heads say."""

from tests.support.examples import is_picture, run


def test_toutatis(tmp_path):
    found = run("toutatis.py", tmp_path)
    assert found.stderr == ""
    rows = [line for line in found.stdout.splitlines() if line[:4] in ("1992", "2008")]
    assert len(rows) == 18
    assert rows[2].split() == ["1992-12-04T18:10:00", "25.01", "15.45", "9.43", "13.26", "15.88"]
    assert float(rows[-1].split()[-1]) > 100.0
    assert "torques" in found.stdout
    assert is_picture(tmp_path / "toutatis.png")
    assert "Picture: toutatis.png" in found.stdout


def test_paper_figure3(tmp_path):
    found = run("paper_figure3.py", tmp_path)
    assert found.stderr == ""
    lines = found.stdout.splitlines()
    first = next(line for line in lines if line.startswith("  0.00"))
    assert [float(x) for x in first.split()] == [0, 1, 15, 1, 1, 1, 1]
    errors = [float(line.split()[-1]) for line in lines if line.startswith("  tolerance")]
    # An integration approaches the exact solution with its tolerance, here to 2.3e-11 at 1e-12.
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1e-10
    assert is_picture(tmp_path / "paper_figure3.png")
