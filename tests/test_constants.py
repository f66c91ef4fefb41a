"""Every named number, and every number that decides or limits, has its reason beside it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Definitions and tables whose entries explain themselves: an effect's parameters, line styles, columns of a table.
EXPLAINED = ("EFFECT", "ROWS", "Line(", "re.compile")


@cache
def parsed(text: str) -> ast.Module:
    """A module's tree, which both tests read."""
    return ast.parse(text)


def constants(path: Path) -> Iterator[tuple[int, str, bool]]:
    """Line, text and whether a comment stands in or above it, for each module-level constant that holds a number."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for node in parsed(text).body:
        if isinstance(node, ast.Assign):
            target: ast.expr = node.targets[0]
        elif isinstance(node, ast.AnnAssign):
            target = node.target
        else:
            continue
        names = [item.id for item in ast.walk(target) if isinstance(item, ast.Name)]
        if not names or not all(name.isupper() for name in names) or node.value is None:
            continue
        values = (item.value for item in ast.walk(node.value) if isinstance(item, ast.Constant))
        if not any(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
            continue
        own = "\n".join(lines[node.lineno - 1 : node.end_lineno]).replace("# fmt: skip", "")
        first = node.lineno - 1  # up to the blank line above: one comment may head a block of constants
        while first and lines[first - 1].strip():
            first -= 1
        headed = any(line.startswith("#") for line in lines[first : node.lineno - 1])
        yield node.lineno, own, ("#" in own or headed) and is_explained(own, headed=headed)


# A unit alone is no reason, except for conversion factors and for places in a drawing (px).
UNIT = re.compile(r"# (s|ms|Hz|1/s|rad|deg|rad/s|m|mm|m/s|kg|g|N|N m|N\*m|Pa|MPa|V|A|K|bytes|samples|times|relative)$")


def is_explained(text: str, *, headed: bool) -> bool:
    """Whether a constant has a comment with more than its unit, or stands under one."""
    return headed or "pi" in text or not UNIT.search(text.splitlines()[0])


def test_every_named_number_has_its_reason_beside_it() -> None:
    files = [path for tree in ("synth", "cad", "reports") for path in sorted((ROOT / tree).rglob("*.py"))]
    bare = [
        f"{path.relative_to(ROOT)}:{line}: {text.splitlines()[0]}"
        for path in files
        for line, text, explained in constants(path)
        if not explained and not any(word in text for word in EXPLAINED)
    ]
    assert bare == []


# Numbers without a name that decide (in a comparison) or limit (arguments of these functions): each needs a comment in
# its statement or in the lines above, or its value in the docstring of its function or module.
LIMITS = {"min", "max", "clip", "maximum", "minimum", "quantile", "percentile", "allclose", "isclose"}
# Counts, halves, powers of ten and conversion factors explain themselves; a millionth of a unit is rounding.
PLAIN = {0.5, *range(13), 16, 60, 100, 180, 360, 1000, 1e6, 1e-3}
ROUNDING = 1e-6
DISTANCE = 4  # lines from a comment to the statement below that it explains
DRAWN = ("reports/figures", "reports/stick_figure.py")  # places and sizes in a drawing


def is_decisive(node: ast.AST) -> bool:
    """Whether its numbers decide or limit."""
    if isinstance(node, ast.Call):
        return getattr(node.func, "attr", getattr(node.func, "id", "")) in LIMITS
    return isinstance(node, ast.Compare)


@dataclass(frozen=True)
class Place:
    """Where a node stands: its innermost function and statement, and whether its numbers decide or limit."""

    function: ast.FunctionDef | None = None
    statement: ast.stmt | None = None
    decisive: bool = False

    def inside(self, node: ast.AST) -> Place:
        """Of the nodes in ``node``."""
        if isinstance(node, ast.FunctionDef):
            return Place(node, node)
        statement = node if isinstance(node, ast.stmt) else self.statement
        return Place(self.function, statement, self.decisive or is_decisive(node))


def numbers(node: ast.AST, place: Place) -> Iterator[tuple[ast.Constant, Place]]:
    """Numbers of functions that decide or limit; those in texts are none."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Constant):
            value = child.value
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if number and place.decisive and place.function and value not in PLAIN and value > ROUNDING:
                yield child, place
        elif isinstance(child, ast.Subscript):  # an index is no threshold
            yield from numbers(child.value, place.inside(child.value))
        elif not isinstance(child, ast.JoinedStr):
            yield from numbers(child, place.inside(child))


def deciding(path: Path) -> Iterator[str]:
    """Each number without a name that decides or limits and has no reason near."""
    text = path.read_text(encoding="utf-8")
    lines, tree = text.splitlines(), parsed(text)
    for node, place in numbers(tree, Place()):
        assert place.function is not None
        assert place.statement is not None
        value = float(node.value)  # type: ignore[arg-type]
        first = max(place.function.lineno, place.statement.lineno - 1 - DISTANCE)
        near = lines[first : max(node.lineno + 1, place.statement.lineno)]
        stated = (ast.get_docstring(place.function) or "") + (ast.get_docstring(tree) or "")
        written = {f"{value:g}", str(value), f"{value:.0e}".replace("+0", ""), f"{value * 100:g}", f"{value * 1000:g}"}
        documented = any(re.search(rf"(?<![\d.]){re.escape(item)}(?![\d])", stated) for item in written)
        if not documented and not any("# " in line.replace("# fmt: skip", "") for line in near):
            yield f"{path}:{node.lineno}: {value:g}: {lines[node.lineno - 1].strip()}"


def test_every_number_that_decides_has_its_reason_beside_it() -> None:
    files = [path for tree in ("synth", "cad", "reports") for path in sorted((ROOT / tree).rglob("*.py"))]
    shown = [path for path in files if not path.relative_to(ROOT).as_posix().startswith(DRAWN)]
    assert [line for path in shown for line in deciding(path)] == []


def test_a_number_without_a_reason_is_found(tmp_path: Path) -> None:
    """A bare threshold counts; one with a comment, in the docstring, or plain does not."""
    path = tmp_path / "sample.py"
    path.write_text(
        'def f(x: float) -> bool:\n    """At most 0.7."""\n    a = x < 0.31\n\n\n\n\n'
        "    # A choice.\n    b = max(x, 0.47) + min(x, 0.7) + (x < 100)\n    return a and bool(b)\n"
    )
    assert [line.split(": ")[1] for line in deciding(path)] == ["0.31"]
