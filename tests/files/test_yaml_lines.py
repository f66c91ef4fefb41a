"""YAML from strangers: lines for messages, limits, no surprises."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from synth.errors import UserError
from synth.files.yaml_lines import Document, load


def read(tmp_path: Path, text: str | bytes) -> Document:
    path = tmp_path / "x.yaml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return load(path)


def refused(tmp_path: Path, text: str | bytes) -> UserError:
    with pytest.raises(UserError) as caught:
        read(tmp_path, text)
    return caught.value


def test_lines_of_every_key(tmp_path: Path) -> None:
    document = read(tmp_path, "\ufeffa: 1\nb:\n  - {c: x, d: [1, 2]}\n  -\n    c: y\n")
    assert document.value == {"a": 1, "b": [{"c": "x", "d": [1, 2]}, {"c": "y"}]}
    assert document.line(("a",)) == 1
    assert document.line(("b", 0, "d")) == 3
    assert document.line(("b", 1, "c")) == 5
    assert document.line(("b", 1, "missing")) == 5  # its parent
    assert document.problem("text", ("b", 1, "c")).key == "b[2].c"


def test_plain_values(tmp_path: Path) -> None:
    text = "a: +1\nb: -1.5e-3\nc: yes\nd: null\ne: 2024-99-99\nf: 1:30\ng: 0x1F\nh: .nan\ni: 1_000\nj: 'no'\n"
    value = read(tmp_path, text).value
    assert value["a"] == 1
    assert value["b"] == pytest.approx(-1.5e-3)
    assert value["c"] is True
    assert value["d"] is None
    assert (value["e"], value["f"], value["h"], value["j"]) == ("2024-99-99", "1:30", ".nan", "no")
    assert isinstance(value["g"], str)
    assert isinstance(value["i"], str)


@pytest.mark.parametrize("number", ["1.0e+999", "-1.0e+400", "9" * 400])
def test_a_number_beyond_all_doubles_is_no_infinity(number: str, tmp_path: Path) -> None:
    """It stays as it is written, so that the message on it shows it."""
    assert read(tmp_path, f"a: {number}\n").value["a"] == number
    assert read(tmp_path, "a: 1.0e-999\n").value["a"] == 0.0


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("a: 1\na: 2\n", 2, "given twice (first in line 1)"),
        ("a:\n  b: 1\n  c: 1\n  b: 2\n", 4, "given twice"),
        ("a: [1, 2\nb: 3\n", 2, "not valid YAML"),
        ("a: 1\n\tb: 2\n", 2, "spaces, not tabs"),
        ("a: %5\n", 1, "quotes"),
        ("a: 1\nb: [x.csv, r/ST_[1245].csv]\n", 2, 'put a name with brackets in quotes: "r/ST_[1245].csv"'),
        ("a: [*.csv]\n", 1, "begins with * in quotes"),
        ("- 1\n", 1, "key: value"),
        ("", 1, "key: value"),
        ("just text\n", 1, "key: value"),
        ("a: 1\n---\nb: 2\n", 2, "not valid YAML"),
        ("a: 1\nb: !!python/object/apply:os.system ['true']\n", 2, "tag"),
        ("a: !!set {x, y}\n", 1, "tag"),
        ("a: !!python/name:os.system\n", 1, "tag"),
        ("a: *nothing\n", 1, "not valid YAML"),
        ("? [1, 2]\n: 3\n", 1, "must be text"),
        (b"a: 1\nb: \xff\xfe\n", 2, "UTF-8"),
        ("a: 1\nb: \x07\n", 2, "not valid YAML"),
    ],
)
def test_refused_with_line(tmp_path: Path, text: str | bytes, line: int, words: str) -> None:
    error = refused(tmp_path, text)
    assert len(error.problems) == 1
    assert error.problems[0].line == line
    assert words in error.problems[0].text


def test_two_duplicate_keys_are_both_reported(tmp_path: Path) -> None:
    assert [p.line for p in refused(tmp_path, "a: 1\na: 2\nb: {c: 1, c: 2}\n").problems] == [2, 3]


@pytest.mark.parametrize(
    "text",
    [
        "a: &a [x,x,x,x,x,x,x,x,x,x]\n"
        + "".join(f"b{i}: &b{i} [{','.join(['*' + ('a' if i == 0 else f'b{i - 1}')] * 10)}]\n" for i in range(9)),
        "a: &a [*a]\n",
        "a: " + "[" * 5000,
        "a: " + "{x: " * 5000,
        "a: " + "[1]," * 10 + "\n" + "x: [" + "1," * 100_000 + "]\n",
        "a: " + "x" * 1_100_000,
        "".join(f"k{i}: 1\n" for i in range(50_000)),
    ],
    ids=["billion laughs", "self", "deep list", "deep mapping", "syntax in bulk", "large", "many keys"],
)
def test_bombs_are_refused_quickly(tmp_path: Path, text: str) -> None:
    start = time.process_time()
    error = refused(tmp_path, text)
    assert time.process_time() - start < 5.0
    assert len(str(error)) < 500


def test_a_harmless_alias_is_read(tmp_path: Path) -> None:
    assert read(tmp_path, "a: &d {rate: 1}\nb: *d\n").value["b"] == {"rate": 1}


def test_missing_file_and_folder(tmp_path: Path) -> None:
    (tmp_path / "rat.leg.yaml").write_text("a: 1")
    with pytest.raises(UserError, match=r"did you mean rat.leg.yaml"):
        load(tmp_path / "rat.leg.yml")
    with pytest.raises(UserError, match="is a folder"):
        load(tmp_path)


def test_keys_of_another_mapping_are_merged_with_their_lines(tmp_path: Path) -> None:
    """As in YAML's own example: own keys count before merged ones, earlier merged mappings before later ones."""
    path = tmp_path / "merged.yaml"
    path.write_text(
        "one: &one {a: 1, b: 2}\ntwo: &two {b: 3, c: 4}\nboth:\n  <<: [*one, *two]\n  c: 5\nafter: {a: 9, <<: *one}\n"
    )
    document = load(path)
    assert document.value["both"] == {"a": 1, "b": 2, "c": 5}
    assert document.value["after"] == {"a": 9, "b": 2}
    assert document.line(("both", "a")) == 1
    assert document.line(("both", "c")) == 5
    assert document.line(("after", "a")) == 6


@pytest.mark.parametrize("value", ["5", "[*one, 5]", "hip", "{<<: 5}"])
def test_a_merge_of_what_is_no_mapping_says_how_to_write_it(tmp_path: Path, value: str) -> None:
    path = tmp_path / "merged.yaml"
    path.write_text(f"one: &one {{a: 1}}\nboth:\n  <<: {value}\n")
    with pytest.raises(UserError, match=r"merged.yaml:3: both.<<: .*mark that with &name and write <<: \*name"):
        load(path)


def test_merged_mappings_cannot_unfold_without_end(tmp_path: Path) -> None:
    lines = ["a0: &a0 {k: 1}", *(f"a{n}: &a{n} {{x: *a{n - 1}, <<: *a{n - 1}, y{n}: *a{n - 1}}}" for n in range(1, 30))]
    path = tmp_path / "bomb.yaml"
    path.write_text("\n".join(lines))
    with pytest.raises(UserError, match="unfold to more than a project can hold"):
        load(path)


def test_a_merge_key_in_quotes_is_a_key(tmp_path: Path) -> None:
    path = tmp_path / "quoted.yaml"
    path.write_text('a: {"<<": 1}\n')
    assert load(path).value == {"a": {"<<": 1}}
