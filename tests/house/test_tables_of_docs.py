"""Tables and pictures of README and docs: their scripts, the writer, the record of ratios."""

import ast
import json

import pytest

from benchmarks import doc_tables as tables
from benchmarks import pictures
from benchmarks.record import FIGURES, ROOT


def test_every_table_has_a_script_and_every_script_a_table():
    made = [name for names in tables.makers().values() for name in names]
    assert len(set(made)) == len(made), "two scripts make the same table"
    shown = {name for page in tables.pages() for name in tables.names_in(page.read_text("utf-8"))}
    assert shown == set(made)


def test_marks_come_in_pairs():
    for page in tables.pages():
        text = page.read_text("utf-8")
        found = text.count("<!-- table: "), text.count(tables.END), len(tables.names_in(text))
        assert found[0] == found[1] == found[2], page.name


def test_scripts_that_make_tables_have_the_function_that_yields_them():
    for script in tables.makers():
        tree = ast.parse((ROOT / "benchmarks" / f"{script}.py").read_text("utf-8"))
        functions = [each for each in tree.body if isinstance(each, ast.FunctionDef)]
        (found,) = [each for each in functions if each.name == "tables"]
        assert [each.arg for each in found.args.args] == ["quick"], script


def test_every_picture_is_drawn_by_a_command():
    drawn = pictures.drawn()
    for name in pictures.shown():
        assert name in drawn or name.split("/")[0] in drawn, f"no command draws {name}"
        assert (FIGURES / name).is_file(), name
    for (script, *_), _, _, _ in pictures.COMMANDS:
        assert (ROOT / script).is_file(), script


def test_the_writer_replaces_in_place(tmp_path):
    (tmp_path / "docs").mkdir()
    page = tmp_path / "docs" / "page.md"
    page.write_text(
        "Before.\n\n<!-- table: one -->\n| old |\n<!-- end of table -->\n\n"
        "Costs <!-- table: two -->7 ns<!-- end of table --> an epoch,\n"
        "and <!-- table: three -->stays<!-- end of table -->.\n"
        "<!-- table: one -->\n<!-- end of table -->\nAfter.\n"
    )
    (tmp_path / "README.md").write_text("No tables.\n")
    made = {"one": "| new \\1 |\n", "two": "8 ns"}
    assert tables.write(made, tmp_path) == [page]
    assert page.read_text() == (
        "Before.\n\n<!-- table: one -->\n| new \\1 |\n<!-- end of table -->\n\n"
        "Costs <!-- table: two -->8 ns<!-- end of table --> an epoch,\n"
        "and <!-- table: three -->stays<!-- end of table -->.\n"
        "<!-- table: one -->\n| new \\1 |\n<!-- end of table -->\nAfter.\n"
    )
    assert tables.write(made, tmp_path) == []


def test_changes_beyond_the_limit_are_listed(tmp_path):
    file = tmp_path / "ratios.json"
    assert tables.recorded(file) == {}
    tables.record({"one": {"a": 1.0, "b": 2.0}, "two": {"c": 3.0}}, file)
    after = {"one": {"a": 1.09, "b": 2.5, "new": 1.0}}
    (line,) = tables.changes(tables.recorded(file), after)
    assert line.startswith("one: b: 2 -> 2.5 (+25 %)")
    tables.record(after, file)
    assert json.loads(file.read_text())["tables"] == {**after, "two": {"c": 3.0}}


def test_costs_become_ratios_to_an_attitude_of_the_same_process(monkeypatch):
    class Script:
        MAKES = ("one",)

        @staticmethod
        def tables(quick):
            yield tables.Table("one", "text", costs={"a": 20.0}, ratios={"b": 3.0})

    found = iter([8.0, 5.0])
    monkeypatch.setattr(tables, "reference", lambda: next(found))
    monkeypatch.setattr(tables.importlib, "import_module", lambda name: Script)
    made = tables.run_here("script", quick=True)
    assert made["ratios"] == {"one": {"a": 4.0, "b": 3.0}}
    assert made["texts"] == {"one": "text"}
    Script.NEEDS = ("no_such_package_of_this_name",)
    found = iter([8.0, 5.0])
    made = tables.run_here("script", quick=True)
    assert made["texts"] == {} and made["missing"] == ["no_such_package_of_this_name"]


def test_a_table_that_no_page_shows_is_an_error(monkeypatch):
    class Script:
        MAKES = ("one",)

        @staticmethod
        def tables(quick):
            yield tables.Table("two", "text")

    monkeypatch.setattr(tables, "reference", lambda: 8.0)
    monkeypatch.setattr(tables.importlib, "import_module", lambda name: Script)
    with pytest.raises(ValueError, match="two"):
        tables.run_here("script", quick=True)


# Pages show pictures at most 720 px wide: letters of N points in a figure N inches wide are 10 px.
_WIDEST = 9.0  # inches
_SMALLEST = 9.0  # points
_LEFT_OUT = {"make_first_screen.py"}  # thumbnails without letters, shown pixel by pixel


def _drawn_sizes(file):
    """(line, "width" or "letters", value) of the sizes that a source gives as numbers."""
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        named = {each.arg: each.value for each in node.keywords}
        first = node.args[0] if node.args else None
        called = getattr(node.func, "attr", getattr(node.func, "id", ""))
        size = named.get("figsize", first if called == "new_figure" else None)
        if isinstance(size, ast.Tuple) and isinstance(size.elts[0], ast.Constant):
            yield node.lineno, "width", size.elts[0].value
        for name in ("fontsize", "labelsize"):
            if name in named:
                value = named[name]
                yield node.lineno, "letters", getattr(value, "value", "not a number")


def test_letters_of_pictures_can_be_read_where_they_are_shown():
    folders = ("attitude", "examples", "benchmarks", "docs")
    files = [file for name in folders for file in sorted((ROOT / name).rglob("*.py"))]
    wrong, count = [], 0
    for file in files:
        if "_build" in file.parts or file.name in _LEFT_OUT:
            continue
        for line, what, value in _drawn_sizes(file):
            count += 1
            readable = value <= _WIDEST if what == "width" else value >= _SMALLEST
            if not readable:
                wrong.append(f"{file.relative_to(ROOT)}:{line}: {what} {value}")
    assert count > 50
    assert not wrong, wrong
