"""The documentation holds: commands parse and run, files and links exist, project files are valid, pictures are small.

Fenced blocks of shell are checked by their mark: ``sh run`` is run, ``sh`` is read by the command's own parser and the
files that it names exist, ``sh yours`` names the reader's files and is only parsed. ``synth init`` is always run.
"""

from __future__ import annotations

import contextlib
import dataclasses
import inspect
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml

import synth
from synth.api.spring_wish import LIMITS, TWICE, UNITS
from synth.cli import COMMANDS, main, parser_of
from synth.files.gap_project import read_gap_project
from synth.spring.spring_requirements import SpringRequirements
from tool_modules import tool

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.glob("*.md"))]
MOST = 120_000  # bytes of a picture
SCREEN = 60  # lines of the README
NO_HEADING = re.compile(r"[^\w\- ]")


@dataclass(frozen=True)
class Block:
    """A fenced block: the first word of its mark, the rest of it, its lines."""

    page: str
    language: str
    mark: str
    lines: tuple[str, ...]


def blocks(path: Path) -> Iterator[Block]:
    """Fenced blocks of a page."""
    text = path.read_text(encoding="utf-8")
    for mark, body in re.findall(r"^```(.*?)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        language, _, rest = mark.partition(" ")
        yield Block(path.name, language, rest.strip(), tuple(body.splitlines()))


def commands() -> list[tuple[str, str, str]]:
    """Page, mark and line of every command of ours, in the order of reading; a line that stands twice is one."""
    found: dict[str, tuple[str, str, str]] = {}
    for path in PAGES:
        for block in blocks(path):
            for line in block.lines if block.language == "sh" else ():
                if line.startswith("synth "):
                    found.setdefault(line.partition(" #")[0].strip(), (block.page, block.mark, line))
    return list(found.values())


def words(line: str) -> list[str]:
    """Arguments of a command line, without a comment or where its output goes; ``PATH#VIEW`` is no comment."""
    return shlex.split(re.split(r"\s[#>]", line)[0])[1:]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the pages' commands are run one after the other, with the examples that they begin with."""
    made = tmp_path_factory.mktemp("pages")
    with contextlib.chdir(made):
        for _, _, line in commands():
            if line.startswith("synth init ") and "--from" not in line:
                assert main(["-q", *words(line)]) == 0, line
    return made


def inputs(arguments: list[str]) -> list[str]:
    """Paths among the arguments, without names and views."""
    kept, skip = [], False
    for word in arguments:
        if not skip and re.fullmatch(r"(?!-)\S*(/\S*|\.(ya?ml|csv|json))", word):
            kept.append(re.sub(r"^\w+=|#.*$", "", word))
        skip = word in ("--out", "--json", "--log")
    return kept


def test_every_command_of_the_pages_is_one_and_names_files_that_are_there(folder: Path) -> None:
    lines = [words(line) for _, _, line in commands()]
    written = tuple(line[line.index("--out") + 1] for line in lines if "--out" in line)
    for page, mark, line in commands():
        name, *rest = words(line)
        if name.startswith("-"):
            continue
        assert name in COMMANDS, (page, line)
        if "--help" not in rest:
            parser_of(name).parse_args(rest)
        if mark != "yours":
            read = [path for path in inputs(rest) if not path.startswith(written)]
            missing = [path for path in read if not (folder / path).exists()]
            assert missing == [], (page, line)


@pytest.mark.parametrize(
    "line", [line for _, mark, line in commands() if mark == "run" and not line.startswith("synth init")]
)
def test_what_is_marked_to_run_runs(line: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with contextlib.chdir(folder):
        assert main(words(line)) == 0
    assert capsys.readouterr().out.strip() or "--dry-run" in line


def test_make_targets_of_the_pages_are_in_the_makefile() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        named = set(re.findall(r"`make ([a-z-]+)", text)) | set(re.findall(r"^make ([a-z-]+)", text, re.MULTILINE))
        assert named <= targets, path.name
    assert "docs" in targets


def kinds() -> list[tuple[str, str]]:
    """Page and text of every project file that the pages show."""
    found = [block for path in PAGES for block in blocks(path) if block.language == "yaml"]
    shown = [(block.page, "\n".join(block.lines)) for block in found]
    return [(page, text) for page, text in shown if text.startswith("kind:")]


@pytest.mark.parametrize(("page", "text"), kinds())
def test_project_files_of_the_pages_fit_their_schemas(page: str, text: str) -> None:
    content = yaml.safe_load(text)
    kind = content["kind"]
    if kind == "gap" and "motor" in content:
        kind = "gap-of-jumps"
    schema = yaml.safe_load((DOCS / "reference" / f"{kind}.schema.json").read_text(encoding="utf-8"))
    jsonschema.validate(content, schema)


def anchors(path: Path) -> set[str]:
    """What a page's headings are called in links."""
    heads = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {NO_HEADING.sub("", head.replace("`", "").lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(path: Path) -> None:
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        led = (path.parent / name).resolve() if name else path
        assert led.is_file(), target
        if anchor:
            assert anchor in anchors(led), target


def test_every_page_is_in_a_table_of_contents() -> None:
    trees = [block for path in sorted(DOCS.glob("*.md")) for block in blocks(path) if block.language == "{toctree}"]
    listed = {re.sub(r".*<(.+)>", r"\1", line.strip()) for tree in trees for line in tree.lines if line.strip()}
    pages = {path.stem for path in DOCS.glob("*.md")} - {"index"}
    assert pages - listed == set()
    assert {name for name in listed if not name.startswith((":", "reference/"))} - pages == set()


def test_pictures_are_small_and_shown() -> None:
    text = "".join(path.read_text(encoding="utf-8") for path in PAGES)
    for path in (DOCS / "pictures").iterdir():
        assert path.stat().st_size <= MOST, path.name
        assert f"pictures/{path.name}" in text, path.name


def test_the_readme_is_one_screen_and_its_figures_are_those_of_the_page_of_measurements() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) <= SCREEN
    measured = (DOCS / "measured.md").read_text(encoding="utf-8")
    row = r"^\| (.+?) \| (.+?) \| `(make [a-z]+)`, (version|after) (\S+) \|$"
    rows = re.findall(row, readme, re.MULTILINE)
    assert len(rows) >= 4
    for _, figures, command, word, version in rows:
        (section,) = [part for part in measured.split("\n## ") if f"Command: `{command}`" in part]
        assert f"*Measured {'with' if word == 'version' else 'after'} {version}" in section, command
        assert re.findall(r"\d[\d ]*(?:\.\d+)?", figures)[0].strip() in section, figures


def test_the_dirty_rigs_in_readme_and_first_table_are_the_sums_of_their_seeds() -> None:
    """The first table omitted the latest seed, which the README counted."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    measured = (DOCS / "measured.md").read_text(encoding="utf-8")
    first, section = measured.split("\n## Dirty rigs, the answer withheld\n")
    table = section.partition("\nWhere it is weak:")[0]

    def total(row: str) -> str:
        (cells,) = re.findall(rf"^\| {row} \|(.*)$", table, re.MULTILINE)
        right, cases = np.sum([[int(a), int(b)] for a, b in re.findall(r"(\d+) of (\d+)", cells)], axis=0)
        return f"{right} of {cases}"

    named, invented = total("main cause named first"), total("no main cause: one named that is not there")
    assert f"[dirty rigs: main cause named first](#dirty-rigs-the-answer-withheld) | 85 % | {named} |" in first
    assert re.search(rf"\[dirty rigs: no main cause, one named [^|]*\| 5 % \| {invented} \|", first)
    assert f"{named}; {total('main cause in no list: flagged')}" in readme


def test_all_public_names_are_on_the_page_of_the_library() -> None:
    text = (DOCS / "api.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\.\. auto\w+:: synth\.(\w+)$", text, re.MULTILINE)
    assert sorted(shown) == sorted(set(synth.__all__) - {"__version__"})


def test_the_page_of_the_library_names_all_functions_and_all_requirements_on_a_spring() -> None:
    text = (DOCS / "library.md").read_text(encoding="utf-8")
    functions = {name for name in synth.__all__ if inspect.isfunction(getattr(synth, name))}
    assert "offers the eleven functions below" in text
    assert len(functions) == 11
    assert functions == set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`\w+`[^|]*)\|", text, re.MULTILINE))))
    wish = set(UNITS) | {item.name for item in dataclasses.fields(SpringRequirements)} | set(LIMITS)
    assert {name for name in wish - set(TWICE) if f"`{name}`" not in text} == set()


def test_the_docstrings_of_public_names_are_shown_as_they_are_written() -> None:
    """Sphinx's napoleon takes what stands before a property's first colon for its type, and ``Trial``s for no code."""
    for name in set(synth.__all__) - {"__version__"}:
        public = getattr(synth, name)
        properties = [(key, item.fget) for key, item in inspect.getmembers(public) if isinstance(item, property)]
        for key, made in [("", public), *properties, *inspect.getmembers(public, inspect.isfunction)]:
            text = inspect.getdoc(made) or ""
            assert not re.search(r"``\w", re.sub(r"(?<!`)``[^`]+``(?!\w)", "", text)), (name, key)
            if (key, made) in properties:
                assert ": " not in text.splitlines()[0], (name, key)
            sections = re.findall(r"^(\w+(?:, \w+)+)\n {4}", text, re.MULTILINE)
            assert not sections or not inspect.isfunction(made), (name, key, sections)


def test_the_page_of_effects_is_that_of_the_effects() -> None:
    """After a change of an effect: make reference."""
    assert (DOCS / "effects.md").read_text(encoding="utf-8") == tool("reference").effects_page()


def test_the_plans_of_the_recording_page_are_those_of_its_tool(tmp_path: Path) -> None:
    text = (DOCS / "record_for_cause.md").read_text(encoding="utf-8")
    plans = tool("recording_plans")
    assert re.findall(r"^\| ([^|]+?) \| [\d.]+ \| [\d.]+ \| ", text, re.MULTILINE) == list(plans.PLANS)
    project = read_gap_project(plans.write(tmp_path, *plans.PLANS["and the base tilted by 30°"]))
    assert [trial.locked for trial in project.trials[4:7]] == [("hip",), ("knee",), ("ankle",)]
    assert {round(float(np.ptp(trial.time)), 6) for trial in project.trials} == {2.0}


def test_the_places_to_change_are_where_contributing_says() -> None:
    """Of each row of its table every path exists, and every name stands in one of the row's files."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    rows = text[text.index("| what | where |") : text.index("## Rules")].splitlines()[2:]
    assert len(rows) > 12
    for row in filter(None, rows):
        words = [word for word in re.findall(r"`([^`]+)`", row) if not word.startswith("make ")]
        paths = [word.replace("NAME", "*") for word in words if "/" in word or word.endswith(".py")]
        folders = {ROOT, *((ROOT / path).parent for path in paths), *(ROOT / path for path in paths)}
        found = {path: [hit for folder in folders for hit in folder.glob(path)] for path in paths}
        assert all(found.values()), row
        files = [
            file for hits in found.values() for hit in hits for file in ([hit] if hit.is_file() else hit.glob("*.py"))
        ]
        texts = [file.read_text(encoding="utf-8") for file in files]
        for name in set(words) - {word for word in words if "/" in word or word.endswith(".py")}:
            assert any(re.search(rf"\b{name.rsplit('.')[-1]}\b", text) for text in texts), (row, name)
