"""benchmarks/measures.py counts a made-up package as its definitions say; alternate.py compares."""

import textwrap

import pytest

from benchmarks import alternate, measures

FILES = {
    "__init__.py": '''
        """A package."""
        from attitude.body.body import Body as Body
    ''',
    "old.py": '''
        """An old path that hands names on: no room."""
        from attitude.body.body import Body as Body
    ''',
    "numbers.py": '''
        """Longer than a file that hands names on."""

        # A comment alone is no code.
        def total(a, b, c, d, e, f, g, h, i):
            """Nine positional parameters."""
            found, rest = a, b
            for each in (c, d):
                found += each
            return found + rest

        @entry_point
        def loop(a, b, c, d, e, f, g, h, i):
            return a

        def loop_of(given):
            def store(a, b, c, d, e, f, g, h, i):
                return a

            return entry_point(named(store, "store"))
    '''
    + "\n".join(f"        X{k} = {k}" for k in range(10)),
    "body/__init__.py": "",
    "body/base.py": """
        from __future__ import annotations
        from typing import TYPE_CHECKING

        if TYPE_CHECKING:
            from attitude.body.body import Body


        class Tower:
            pass
    """,
    "body/body.py": """
        from attitude.body.base import Tower
        from attitude import numbers


        class Body(Tower):
            def lazily(self):
                from attitude.scene import view
    """,
    "scene/__init__.py": "",
    "scene/view.py": """
        from ..body import body
        from attitude.body.body import Body
    """,
    "proof/__init__.py": "part = 1\n",
}


@pytest.fixture
def counted(tmp_path):
    for name, text in FILES.items():
        file = tmp_path / "attitude" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(textwrap.dedent(text).lstrip("\n"))
    return measures.measure(tmp_path)


def test_files_lines_and_tokens(counted):
    assert counted.files == 8  # proof/ comes after this step
    assert counted.folders["attitude.body"][:4] == (3, 16, 11, 53)
    assert counted.lines == sum(row[1] for row in counted.folders.values())
    assert counted.tokens == sum(row[3] for row in counted.folders.values())


def test_kinds_of_code(counted):
    """Imports inside functions are imports; nested functions have signatures too."""
    rows = {name: row[4:] for name, row in counted.folders.items()}
    assert dict(zip(measures.KINDS, rows["attitude.body"], strict=True)) == {
        "imports": 6,
        "signatures": 3,
        "errors": 0,
        "constants": 0,
        "fields": 0,
        "compiled": 0,
        "bodies": 2,
    }
    # a body that is compiled by a call has no decorator that says so
    assert rows["attitude.numbers"] == (0, 5, 0, 9, 0, 1, 7)
    assert all(sum(row[4:]) == row[2] for row in counted.folders.values())


def test_rooms_are_those_that_hold_something(counted):
    assert counted.rooms == ["__init__.py", "body", "numbers.py", "scene"]


def test_chains_are_of_what_is_loaded(counted):
    # attitude itself and attitude.scene.view each load body.body, which loads base.
    assert counted.chain[1:] == ["attitude.body.body", "attitude.body.base"]
    assert counted.load_circles == []


def test_circles_count_imports_for_types(counted):
    assert counted.circles == [["attitude.body.base", "attitude.body.body"]]
    assert counted.between == []


def test_bases_vague_names_and_long_calls(counted):
    assert counted.bases == [("Tower", "attitude.body.base", "attitude.body.body")]
    assert counted.several_names == 1
    assert [name for name, _ in counted.vague["attitude.numbers"]] == [
        "found",
        "rest",
        "each",
        "found",
        "given",
    ]
    assert counted.vague["attitude.proof"] == [("part", 1)]
    assert counted.long_calls == [("attitude.numbers", "total", 4, 9)]


def test_folders_in_a_circle_are_found(tmp_path):
    for name, other in (("one", "two"), ("two", "one")):
        folder = tmp_path / "attitude" / name
        folder.mkdir(parents=True)
        (folder / "__init__.py").write_text("")
        (folder / "a.py").write_text(f"from attitude.{other} import b\n")
        (folder / "b.py").write_text("")
    found = measures.measure(tmp_path)
    assert found.circles == []
    assert found.between == [["attitude.one", "attitude.two"]]


def test_the_command_prints_each_measure(capsys, tmp_path):
    (tmp_path / "attitude").mkdir()
    (tmp_path / "attitude" / "__init__.py").write_text("X = 1\n")
    measures.main([str(tmp_path), "--folders", "-v"])
    printed = capsys.readouterr().out
    assert "lines of code                                1\n" in printed
    assert "tokens                                       3\n" in printed


def test_figures_of_a_benchmark_have_names():
    text = "epochs       10^6\n| single call | 12.5 | 3e-2 |\n| single call | 13 |\nnothing\nx2y 1"
    found = alternate.figures_of(text)
    assert found["single call [1]"] == 12.5 and found["single call [2]"] == 0.03
    assert found["single call (2) [1]"] == 13.0
    assert found["x2y [1]"] == 1.0


def test_ratios_are_those_of_neighbouring_runs(capsys):
    """A machine that slows down by half while it measures, and a checkout 10 % slower."""
    speeds = [1.0, 1.1, 1.3, 1.4, 1.5]
    old = [{"call [1]": 10.0 * s, "error [1]": 0.0, "load [1]": 5.0} for s in speeds]
    new = [{"call [1]": 11.0 * s, "error [1]": 0.0, "load [1]": 5.0} for s in speeds]
    rows = alternate.compared(old, new)
    assert [row[0] for row in rows] == ["call [1]", "load [1]"]
    assert rows[0][1:4] == pytest.approx((13.0, 14.3, 1.1))
    assert rows[0][4] == pytest.approx(0.0, abs=1e-12)
    alternate.report(rows, 0.03, show_all=False)
    printed = capsys.readouterr().out
    assert "1.100   0.000 *" in printed and "load" not in printed


def test_two_checkouts_run_alternately(tmp_path, capsys):
    for name, number in (("old", 2), ("new", 3)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "script.py").write_text(f"print('answer {number}')\n")
    roots = [str(tmp_path / "old"), str(tmp_path / "new")]
    alternate.main(["-n", "1", *roots, "script.py"])
    assert "answer [1]" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        alternate.main([*roots, "absent.py"])
