"""The sources' structure: imports run one way, functions and their arguments are few, names stand once."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

from tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
GRAPH = tool("architecture")
FILES: dict[str, Path] = GRAPH.modules()
# DESIGN: each floor may import its own and those above it in this list.
FLOORS = (
    (
        "errors",
        "remarks",
        "units",
        "units_often",
        "units_spelling",
        "arrays",
        "noise",
        "pace",
        "sampling",
        "threads",
        "shared_calls",
        "side_processes",
        "mujoco_warnings",
        "cache",
        "planting",
    ),
    ("estimation", "compiling"),
    ("drives",),
    ("swing", "jump"),
    ("parts", "spring", "motion", "files", "effects"),  # synth.effects: what a user's effect imports
    ("design", "diagnosis", "fit", "batch", "validation", "hopper", "comparison", "model_checks", "rehearsal"),
    ("api",),
    ("commands", "cli", "__main__"),
)
LEVEL = {room: level for level, rooms in enumerate(FLOORS) for room in rooms}
ASIDE = ("cad", "reports")  # every floor may use them; they import nothing else of synth
# None is left; one that cannot be taken away at once would be named here.
KNOWN_CIRCLES: set[frozenset[str]] = set()


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Everything may ask the root for its version; the root loads its public names only when they are first used."""
    return {name: others - {"synth"} for name, others in GRAPH.imports(FILES).items()}


def test_no_module_imports_itself_by_others(imports: dict[str, set[str]]) -> None:
    assert {frozenset(circle) for circle in GRAPH.cycles(imports)} == KNOWN_CIRCLES


def test_circles_are_found() -> None:
    assert GRAPH.cycles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]
    assert GRAPH.cycles({"a": {"b"}, "b": {"c"}, "c": set()}) == []


def test_imports_name_the_whole_module() -> None:
    relative = [
        f"{name}:{node.lineno}"
        for name, path in FILES.items()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and node.level
    ]
    assert relative == []


def room(name: str) -> str:
    """The package or module directly in synth that a module belongs to; none of the root itself."""
    return [*name.split("."), ""][1]


def level(name: str) -> int:
    """Floor of a module; the root of synth, which loads its public names when they are first used, is on all."""
    return LEVEL[room(name)] if room(name) else len(FLOORS)


def test_cad_and_reports_are_imported_by_one_name() -> None:
    """As synth.cad and synth.reports, here as in the wheel: by two names a module would be loaded twice."""
    plain = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for tree in ("synth", "cad", "reports", "tests", "tools", "docs")
        for path in sorted((ROOT / tree).rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        for name in imported(node)
        if name.split(".")[0] in ASIDE
    ]
    assert plain == []


def imported(node: ast.AST) -> list[str]:
    """Modules that a statement imports."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    return [node.module] if isinstance(node, ast.ImportFrom) and node.module and not node.level else []


def test_no_floor_imports_a_higher_one(imports: dict[str, set[str]]) -> None:
    upward = []
    for name, others in imports.items():
        for other in sorted(others - {"synth"}):
            if room(name) in ASIDE:
                if room(other) != room(name):
                    upward.append(f"{name} -> {other}: {room(name)} imports nothing else of synth")
            elif room(other) not in ASIDE and level(name) < level(other):
                upward.append(f"{name} -> {other}")
    assert upward == []


MOST_LINES, MOST_ARGUMENTS = 60, 8  # of a function without its docstring; of a call, the object itself aside
# Compiled code takes flat arrays and numbers, no records, and what is split off is a call that LLVM cannot see through.
COMPILED = {"compiled", "compiled_when_called", "njit", "inlined"}
# What is longer all the same, and why.
LONG = {
    "synth.swing.chain_integrator.integrate": "compiled: one loop over steps, its pieces are inlined functions already",
    "synth.jump.planar_engine._accelerations": "compiled: one system of equations, filled row by row",
    "synth.jump.jump_integrator.jump": "compiled: one loop over steps",
}
# What takes more arguments all the same, and why.
MANY = {
    "synth.swing.chain.simulate": "a documented call of notebooks and users' scripts: state and conditions by keyword",
    "synth.motion.importers.registry.loader": "a decorator whose keywords describe a format, each in one word",
}


def functions() -> Iterator[tuple[str, ast.FunctionDef]]:
    """Every function with its full name."""
    for module, path in FILES.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef):
                yield f"{module}.{node.name}", node


def is_compiled(name: str, node: ast.FunctionDef) -> bool:
    """Whether numba compiles it: by its decorator, or as an effect's law."""
    called = [each.func if isinstance(each, ast.Call) else each for each in node.decorator_list]
    decorated = any(isinstance(each, ast.Name) and each.id in COMPILED for each in called)
    return decorated or (name.startswith("synth.swing.effects.") and node.name == "torque")


def code_lines(node: ast.FunctionDef) -> int:
    """Lines of a function without its docstring."""
    assert node.end_lineno is not None
    first = node.body[0]
    told = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str)
    documented = (first.end_lineno or 0) - first.lineno + 1 if told else 0
    return node.end_lineno - node.lineno + 1 - documented


def arguments(node: ast.FunctionDef) -> list[str]:
    given = node.args
    every = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
    return [each.arg for each in every if each is not None and each.arg not in ("self", "cls")]


def test_functions_are_short() -> None:
    long = {name: code_lines(node) for name, node in functions() if code_lines(node) > MOST_LINES}
    assert {name: lines for name, lines in long.items() if name not in LONG} == {}
    assert LONG.keys() - long.keys() == set()  # an exception that is no longer needed goes


def test_functions_take_few_arguments() -> None:
    many = {
        name: len(arguments(node))
        for name, node in functions()
        if len(arguments(node)) > MOST_ARGUMENTS and not is_compiled(name, node)
    }
    assert {name: count for name, count in many.items() if name not in MANY} == {}
    assert MANY.keys() - many.keys() == set()


def duplicates(names: Iterator[tuple[str, str]]) -> dict[str, list[str]]:
    """Name -> the modules in which it stands, for each name that stands in more than one."""
    places = defaultdict(list)
    for name, module in names:
        places[name].append(module)
    return {name: modules for name, modules in places.items() if len(modules) > 1}


def test_a_class_name_stands_once() -> None:
    assert not duplicates(
        (node.name, module)
        for module, path in FILES.items()
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef)
    )


def test_a_module_name_stands_once() -> None:
    assert not duplicates((path.stem, module) for module, path in FILES.items() if path.name != "__init__.py")


MOST_MODULE_LINES = 400  # the rule is 350; what lies between is on its way to be split


def test_modules_are_of_readable_length() -> None:
    long = [
        name for name, path in FILES.items() if len(path.read_text(encoding="utf-8").splitlines()) > MOST_MODULE_LINES
    ]
    assert long == []
