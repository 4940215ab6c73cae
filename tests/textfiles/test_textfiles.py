"""Reading of text files: line ends, encodings, and errors that name the file and the line."""

import os

import numpy as np
import pytest

from attitude._textfiles import lines, messages, toml, xml
from attitude.errors import AttitudeError


def written(folder, content):
    path = folder / "x.txt"
    path.write_bytes(content)
    return path


def numbered(path):
    with lines.opened(path) as found:
        return [(found.number, found.text(line)) for line in found]


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_lines_end_as_on_any_system(tmp_path, end):
    path = written(tmp_path, b"\xef\xbb\xbfa" + end + end + "\u00e9 b".encode() + end + b"c")
    assert numbered(path) == [(1, "a"), (2, ""), (3, "\u00e9 b"), (4, "c")]
    assert lines.whole(path, "give text") == "a\n\n\u00e9 b\nc"
    given = "a\n\n\u00e9 b\nc".replace("\n", end.decode())
    assert [line.decode() for line in lines.of_text(given, "it")] == ["a", "", "\u00e9 b", "c"]


def test_long_files_with_carriage_returns_are_read_by_line(tmp_path):
    rows = [f"{k} {'x' * 90}" for k in range(1000)]
    path = written(tmp_path, "\r".join(rows).encode())
    assert numbered(path) == list(enumerate(rows, start=1))
    path = written(tmp_path, b"a\r" + b"b" * (lines.LONGEST + 1) + b"\rc")
    with pytest.raises(AttitudeError, match=r"x.txt, line 2: the line is longer than 20000"):
        numbered(path)


@pytest.mark.parametrize(
    "content, error",
    [
        (b"a\n\xff\n", r"x.txt, line 2: it is not UTF-8 text"),
        (b"a\nb\x00\n", r"x.txt, line 2: it holds zero bytes"),
    ],
)
def test_what_is_no_text_is_refused_with_its_line(tmp_path, content, error):
    with pytest.raises(AttitudeError, match=error):
        numbered(written(tmp_path, content))


def test_what_cannot_be_read_is_refused_with_advice(tmp_path):
    with pytest.raises(AttitudeError, match=r"none: cannot be read \(No such file.*; give text\."):
        lines.whole(tmp_path / "none", "give text")
    with pytest.raises(AttitudeError, match=r"x.txt: is not text in UTF-8 \(byte 2\); give text\."):
        lines.whole(written(tmp_path, b"ab\xff"), "give text")
    for read in (numbered, lines.beginning):
        with pytest.raises(AttitudeError, match=r"none' cannot be read: No such file"):
            read(tmp_path / "none")


def test_numbers_of_open_files_are_no_paths(tmp_path):
    with open(tmp_path / "x.txt", "w+") as file:
        for read in (numbered, lines.beginning, lambda path: lines.whole(path, "give text")):
            for wrong in (file.fileno(), True, None):
                with pytest.raises(
                    AttitudeError, match=f"path is {wrong}; give the name of a file"
                ):
                    read(wrong)
        assert os.fstat(file.fileno())  # it is still open
    with pytest.raises(AttitudeError, match=r"origin: text is None; give the content"):
        toml.parsed(None, "origin")


def test_the_beginning_of_a_file_tells_its_format(tmp_path):
    path = written(tmp_path, b"\xef\xbb\xbf \r\n<aem>" + b"x" * 9000)
    assert lines.beginning(path).startswith(b"<aem>xx")
    assert len(lines.beginning(path)) < 4096


def test_data_of_the_package_is_text():
    assert "[sources" in lines.packaged("data/spin_states.toml")


def test_keywords_values_and_comments():
    text = "a_1 = b = c\nCOMMENT\nCOMMENT x = y\nCOMMENT=z\nCOMMENTS\nU-1 x = 3 [km]\n"
    found = lines.of_text(text, "it")
    assert [messages.pair(found, line) for line in found] == [
        *(("A_1", "b = c"), ("COMMENT", ""), ("COMMENT", "x = y"), ("COMMENT", "z")),
        *(("COMMENT", "S"), ("U-1 X", "3 [km]")),
    ]
    both = messages.values(lines.of_text(text + "\n \nA_1 = 2\nN = X [P]", "it"), "N")
    assert both == [{"A_1": "2", "U-1 X": "3"}, {"N": "X [P]"}]
    for bad in ("no equals sign", "= 3", "  =  "):
        with pytest.raises(AttitudeError, match=r'it, line 1: .* is no "KEYWORD = value"'):
            messages.values(lines.of_text(bad, "it"), "N")


def test_records_of_xml_are_the_leaves_of_elements():
    text = "<a><r><b>1</b><c> x<!-- y -->z </c><b>2</b></r><d>0</d><r/><r> t <e/></r></a>"
    assert xml.records(text, "it", "r") == [{"b": "2", "c": "xz"}, {"r": ""}, {"e": ""}]
    # An element within one of the same tag is a record of its own, and part of the outer one.
    assert xml.records("<r><b>1</b><r><c>2</c></r></r>", "it", "r") == [
        {"b": "1", "c": "2"},
        {"c": "2"},
    ]
    assert xml.records("<a/>", "it", "r") == []


def test_escaped_text_comes_back():
    text = "a < b & c > d &amp; \"e\" 'f' ]]>"
    assert xml.records(f"<r><t>{xml.escaped(text)}</t></r>", "it", "r") == [{"t": text}]


def test_json_and_csv():
    assert toml.of_json('[{"a": 1}]', "it") == [{"a": 1}]
    assert toml.of_csv("a,b\n1,2\n\n3,4\n", "it") == [*({"a": "1", "b": "2"}, {"a": "3", "b": "4"})]
    for text, error in (
        ("{\n]", r"it, line 2: it is not valid JSON \(.*, column 1\)"),
        ("9" * 10_000, "it: it is JSON that cannot be read"),
        ("[" * 200_000, "it.* JSON"),
    ):
        with pytest.raises(AttitudeError, match=error):
            toml.of_json(text, "it")
    with pytest.raises(AttitudeError, match="it, line 2: it is not valid CSV"):
        toml.of_csv("a\n" + "x" * 200_000, "it")


def test_quoted_text_of_toml_comes_back():
    for text in ('a "b" \\ \n\t \x7f \u00e9', ""):
        assert toml.parsed(f"key = {toml.quoted(text, 'key')}", "it") == {"key": text}
    with pytest.raises(AttitudeError, match="key is 3; give text"):
        toml.quoted(3, "key")


def test_numbers_of_lines_take_no_underscores():
    tokens = [b"a_b", b"1", b"2", b"c", b"3", b"4e0"]
    assert np.array_equal(lines.numbers(tokens, 3, (1, 2)), [[1.0, 2.0], [3.0, 4.0]])
    tokens[4] = b"1_0"
    with pytest.raises(lines.NoNumber) as caught:
        lines.numbers(tokens, 3, (1, 2))
    assert (caught.value.line, caught.value.column, caught.value.shown) == (1, 0, "'1_0'")
