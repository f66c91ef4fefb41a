"""Every number with a name says beside it what it is, or where it comes from."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Definitions and tables whose entries explain themselves: an effect's parameters, line styles, columns of a table.
EXPLAINED = ("EFFECT", "ROWS", "Line(", "re.compile")


def constants(path: Path) -> Iterator[tuple[int, str, bool]]:
    """Line, text and whether a comment stands in or above it, for each module-level constant that holds a number."""
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for node in ast.parse(text).body:
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
        yield node.lineno, own, "#" in own or headed


def test_every_named_number_has_its_reason_beside_it() -> None:
    files = [path for tree in ("synth", "cad", "reports") for path in sorted((ROOT / tree).rglob("*.py"))]
    bare = [
        f"{path.relative_to(ROOT)}:{line}: {text.splitlines()[0]}"
        for path in files
        for line, text, explained in constants(path)
        if not explained and not any(word in text for word in EXPLAINED)
    ]
    assert bare == []
