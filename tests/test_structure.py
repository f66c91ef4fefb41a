"""Imports run one way: no cycle between modules, and none from a lower floor of the package to a higher one."""

from __future__ import annotations

import ast
import graphlib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FILES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
    for tree in ("synth", "cad", "reports")
    for path in sorted((ROOT / tree).rglob("*.py"))
}
# DESIGN: each floor may import its own and those above it in this list.
FLOORS = (
    ("errors", "units", "units_often", "arrays", "threads", "cache"),
    ("estimation", "compiling"),
    ("drives",),
    ("swing", "jump"),
    ("parts", "spring", "motion", "files", "effects"),  # synth.effects: what a user's effect imports
    ("design", "diagnosis", "fit", "batch", "validation", "hopper"),
    ("commands", "cli", "__main__"),
)
LEVEL = {room: level for level, rooms in enumerate(FLOORS) for room in rooms}
# None is left; one that cannot be taken away at once would be named here.
KNOWN_CIRCLES: set[frozenset[str]] = set()


def imported(path: Path) -> set[str]:
    """Modules of ours that a file imports anywhere: at its top, in functions, for types only."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: write the whole name of the module"
            inside = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in FILES else str(node.module) for name in inside}
    return found & FILES.keys()


IMPORTS = {name: imported(path) - {name} for name, path in FILES.items()}


def circles(imports: dict[str, set[str]]) -> set[frozenset[str]]:
    """Modules that import one another, directly or by others: each strongly connected set of more than one."""
    reached = {name: set(others) for name, others in imports.items()}
    for middle in imports:  # Warshall's transitive closure
        for others in reached.values():
            if middle in others:
                others |= reached[middle]
    return {frozenset(b for b in reached[a] if a in reached[b]) for a in reached if a in reached[a]}


def test_no_module_imports_itself_by_others() -> None:
    assert circles(IMPORTS) == KNOWN_CIRCLES


def test_circles_are_found() -> None:
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == {frozenset("abc")}
    order = {"a": {"b"}, "b": {"c"}, "c": set[str]()}
    assert circles(order) == set()
    assert [*graphlib.TopologicalSorter(order).static_order()] == ["c", "b", "a"]


def level(name: str) -> int:
    """Floor of a module; the root of synth, which loads its public names when they are first used, is on all."""
    tree, _, room = name.partition(".")
    return LEVEL[room.split(".")[0]] if tree == "synth" and room else len(FLOORS)


def test_no_floor_imports_a_higher_one() -> None:
    upward = []
    for name, others in IMPORTS.items():
        for other in sorted(others - {"synth"}):
            if name.split(".")[0] in ("cad", "reports") and other.startswith("synth"):
                upward.append(f"{name} -> {other}: {name.split('.')[0]} imports nothing from synth")
            elif other.startswith("synth") and level(name) < level(other):
                upward.append(f"{name} -> {other}")
    assert upward == []
