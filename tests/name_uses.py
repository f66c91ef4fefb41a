"""Who uses what a module defines, resolved by the imports in the syntax trees."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

Name = tuple[str, str]  # module and name in it
Definition = ast.FunctionDef | ast.ClassDef
CALL = re.compile(r"\b([A-Za-z_]\w*)\(")
WORD = re.compile(r"[A-Za-z_]\w*")
IMPORT = re.compile(r"^\s*from (synth[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
LOCAL = (ast.FunctionDef, ast.Lambda)


@dataclass
class ModuleNames:
    """Of one module: names that it defines, loads and imports, and the attributes of modules that it reads.

    ``defined`` : name -> the statements that define it. ``loaded`` : name -> definitions in which it is read, '' where
    in none. ``taken`` : own name -> module and name there. ``modules`` : own name -> dotted name of a module.
    ``dotted`` : chains of attributes of a name. ``written`` : calls in its strings, which may be code that it writes.
    """

    defined: dict[str, list[ast.stmt]] = field(default_factory=lambda: defaultdict(list))
    loaded: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))
    taken: dict[str, Name] = field(default_factory=dict)
    modules: dict[str, str] = field(default_factory=dict)
    dotted: set[str] = field(default_factory=set)
    written: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, text: str) -> ModuleNames:
        made = cls()
        for statement in ast.parse(text).body:
            names = defined_by(statement)
            for name in names:
                made.defined[name].append(statement)
            made.read(statement, statement.name if isinstance(statement, Definition) else "", frozenset())
        return made

    def read(self, node: ast.AST, inside: str, hidden: frozenset[str]) -> None:
        """Gather what ``node`` reads, in the definition ``inside``; ``hidden`` : variables of enclosing functions."""
        if isinstance(node, LOCAL):
            hidden = hidden | own_variables(node)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id not in hidden:
            self.loaded[node.id].add(inside)
        elif isinstance(node, ast.Attribute):
            self.dotted |= {chain for chain in [attributes(node)] if chain and chain.partition(".")[0] not in hidden}
        elif isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                self.taken[alias.asname or alias.name] = (node.module, alias.name)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            self.written |= set(CALL.findall(node.value))
            for module, names in IMPORT.findall(node.value):
                self.taken |= {name: (module, name) for name in WORD.findall(names)}
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return  # a docstring
        elif isinstance(node, ast.Import):
            for alias in node.names:
                self.modules[alias.asname or alias.name.partition(".")[0]] = (
                    alias.name if alias.asname else alias.name.partition(".")[0]
                )
        for child in ast.iter_child_nodes(node):
            self.read(child, inside, hidden)


def defined_by(statement: ast.stmt) -> list[str]:
    """Names that a statement of a module defines, annotations alone excluded."""
    if isinstance(statement, Definition):
        return [statement.name]
    if isinstance(statement, ast.AnnAssign) and statement.value is not None:
        targets: list[ast.expr] = [statement.target]
    else:
        targets = statement.targets if isinstance(statement, ast.Assign) else []
    return [node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)]


def own_variables(function: ast.FunctionDef | ast.Lambda) -> set[str]:
    """Arguments and variables of a function, not those of functions in it; what it imports is the module's."""
    given = function.args
    every = *given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg
    found = {each.arg for each in every if each}

    def gather(node: ast.AST) -> None:
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        if not isinstance(node, (*LOCAL, ast.ClassDef)):
            for child in ast.iter_child_nodes(node):
                gather(child)

    for node in function.body if isinstance(function, ast.FunctionDef) else [function.body]:
        gather(node)
    return found


def attributes(node: ast.expr) -> str:
    """``a.b.c`` of a chain of attributes of a name; empty for others."""
    if isinstance(node, ast.Name):
        return node.id
    before = attributes(node.value) if isinstance(node, ast.Attribute) else ""
    return f"{before}.{node.attr}" if before and isinstance(node, ast.Attribute) else ""


@dataclass(frozen=True)
class Uses:
    """``modules`` : dotted name -> what it defines and reads."""

    modules: Mapping[str, ModuleNames]

    @cached_property
    def takers(self) -> Mapping[Name, list[Name]]:
        """Module and name -> the modules that import it, and their names for it."""
        found: dict[Name, list[Name]] = defaultdict(list)
        for module, names in self.modules.items():
            for own, taken in names.taken.items():
                found[taken].append((module, own))
        return found

    @cached_property
    def of_modules(self) -> set[Name]:
        """Modules and names that are read as attributes of the module."""
        return {found for names in self.modules.values() for found in self._read_of_modules(names)}

    def _read_of_modules(self, names: ModuleNames) -> Iterator[Name]:
        own = {**names.modules, **{name: ".".join(taken) for name, taken in names.taken.items()}}
        for chain in names.dotted:
            first, *rest = chain.split(".")
            whole = [*own.get(first, "").split("."), *rest]
            for end in range(len(whole) - 1, 0, -1):
                if ".".join(whole[:end]) in self.modules:
                    yield ".".join(whole[:end]), whole[end]
                    break

    def used(self, module: str, name: str) -> bool:
        """Whether anything but the definition itself reads a name of a module; to hand it on is no use."""
        names = self.modules[module]
        by = names.loaded.get(name, set())
        inside = name if any(isinstance(each, Definition) for each in names.defined.get(name, [])) else None
        if by - {inside} or (module, name) in self.of_modules:
            return True
        if name in names.written:
            return True
        return any(self.used(*taker) for taker in self.takers.get((module, name), []))


def assigned_twice(text: str) -> list[str]:
    """Upper-case names that the statements of a module assign more than once: only the last value is ever read."""
    defined = ModuleNames.of(text).defined
    return [name for name, statements in defined.items() if name.isupper() and len(statements) > 1]


def unread_fields(texts: Mapping[str, str], named: set[str]) -> list[str]:
    """``module.Class.field`` of annotated fields of classes whose name nothing reads: no attribute, and none ``named``.

    By the name: whose field an attribute is, a syntax tree does not tell.
    """
    read, fields = set(named), []
    for module, text in texts.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
                read.add(node.attr)
            elif isinstance(node, ast.ClassDef):
                items = [item.target for item in node.body if isinstance(item, ast.AnnAssign)]
                fields += [(module, node.name, item.id) for item in items if isinstance(item, ast.Name)]
    return [".".join(each) for each in fields if each[2] not in read]
