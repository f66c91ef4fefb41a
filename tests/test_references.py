"""Nothing in the package is left over: each name has a user in it, and each name that a docstring gives exists."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import synth
from tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
FILES: dict[str, Path] = tool("architecture").modules()
# What nothing in the package mentions, and why it stays.
UNMENTIONED = {
    "synth.api.report.Report._repr_html_": "notebooks call it",
    "synth.cad.joint.build_joint": "a joint in one call, for who uses cad by itself; the design keeps the layout",
    "synth.compiling.numba_internals.KeptCode.save_overload": "numba calls it",
    "synth.files.kept_templates.KeptTemplates.dump_bytecode": "jinja calls it",
    "synth.files.kept_templates.KeptTemplates.load_bytecode": "jinja calls it",
    "synth.files.reference.pages.pages": "tools/reference.py writes them",
    "synth.planting.explained_gap.PlainModel.linear_costs": "tests/blind, which plants with this model, asks it",
    "synth.planting.explained_gap.PlainModel.plausible": "likewise",
}

# By the text: to parse every module takes longer than all that is asked here. It is laid out by `ruff format`.
COMMENT = re.compile(r"(^|\s)# .*$", re.MULTILINE)
BLOCK = re.compile(r'(^\s*r?)?"""[\s\S]*?"""', re.MULTILINE)  # a docstring, if nothing stands before it
STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"')
IMPORT = re.compile(r"^\s*from (synth[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
ATTRIBUTE = re.compile(r"\.([A-Za-z_]\w*)")
WORD = re.compile(r"[A-Za-z_]\w*")
ASKED = re.compile(r"\{[{%][\s\S]*?[%}]\}")  # of a template
# A function or class of a module or of a class in it, or a variable of a module.
DEFINITION = re.compile(r"^(?P<indent> {4})?(def|class) (\w+)|^([A-Za-z_]\w*)(?:: [^=\n]+)? = ", re.MULTILINE)
OUTER = re.compile(r"^(?=[^\s)\]}])", re.MULTILINE)  # where what stands at the margin ends
INNER = re.compile(r"^(?= {0,4}[^\s)\]}])", re.MULTILINE)
# ``head.tail`` in a docstring or comment, which is no file, no other package's and no key of a project.
DOTTED = re.compile(r"``([a-z_]\w*(?:\.[A-Za-z_]\w*)+)``")
FILE_ENDS = {
    "csv",
    "glb",
    "html",
    "json",
    "m",
    "md",
    "png",
    "sdf",
    "step",
    "stl",
    "toml",
    "urdf",
    "usda",
    "xml",
    "yaml",
}
ELSEWHERE = {"dataclasses", "np", "numba", "scipy", "sys"}
KEYS = {"joints.knee.link.mass", "outer.inner", "solids.masses", "solids.parts"}
# Decorators that hand a function to whatever calls it.
REGISTERED = re.compile(r"^\s*@(?:[\w.]+\.)?(?:loader|overload|\w+_validator|\w+_serializer)\b", re.MULTILINE)


@dataclass(frozen=True)
class Module:
    """The code of a module without docstrings and comments, and how often each name stands in it."""

    code: str
    words: Counter[str]
    attributes: Counter[str]
    texts: Counter[str]
    imports: frozenset[tuple[str, str]]

    @classmethod
    def of(cls, text: str) -> Module:
        blocks = [found[0] for found in BLOCK.finditer(text) if found[1] is None]
        code = COMMENT.sub(r"\1", BLOCK.sub(lambda found: '""' if found[1] is None else "", text))
        texts = Counter(word for found in (*blocks, *STRING.findall(code)) for word in WORD.findall(found))
        imports = {(module, name) for module, names in IMPORT.findall(code) for name in WORD.findall(names)}
        return cls(code, Counter(WORD.findall(code)), Counter(ATTRIBUTE.findall(code)), texts, frozenset(imports))


@dataclass(frozen=True)
class Definition:
    """``name`` defined in ``module``, in the class ``owner`` if in any; ``code`` is all of it."""

    module: str
    owner: str
    name: str
    code: str

    @property
    def full(self) -> str:
        return ".".join(part for part in (self.module, self.owner, self.name) if part)


def definitions(name: str, module: Module) -> Iterator[Definition]:
    """Functions, classes, methods and variables of a module that Python or a decorator does not call by itself."""
    owner = ""
    for found in DEFINITION.finditer(module.code):
        own = found[3] or found[4]
        ends = INNER if found["indent"] else OUTER
        end = ends.search(module.code, found.end())
        decorated = REGISTERED.search(module.code[: found.start()].rpartition("\n\n")[2])
        if not found["indent"]:
            owner = own if found[2] == "class" else ""
        local = found["indent"] and not owner
        if local or re.fullmatch(r"__\w+__", own) or decorated:
            continue
        body = module.code[found.start() : end.start() if end else None]
        yield Definition(name, owner if found["indent"] else "", own, body)


@cache
def sources() -> dict[str, Module]:
    return {name: Module.of(path.read_text(encoding="utf-8")) for name, path in FILES.items()}


def templates() -> Counter[str]:
    """Words of what the pages' templates ask: they call functions and read fields."""
    asked = [own for path in (ROOT / "reports").rglob("*.html") for own in ASKED.findall(path.read_text("utf-8"))]
    return Counter(word for own in asked for word in WORD.findall(own))


def unmentioned(modules: dict[str, Module]) -> list[str]:
    """Full names of what nothing in the package mentions but the definition itself."""
    attributes, texts, imports = templates(), Counter[str](), set[tuple[str, str]]()
    for module in modules.values():
        attributes.update(module.attributes)
        texts.update(module.texts)
        imports |= module.imports
    found = []
    for name, module in modules.items():
        for each in definitions(name, module):
            own = Module.of(each.code)
            used = attributes[each.name] + texts[each.name] > own.attributes[each.name] + own.texts[each.name]
            if not each.owner:
                used |= module.words[each.name] > own.words[each.name] or (name, each.name) in imports
            if not used and each.name not in synth.__all__:
                found.append(each.full)
    return found


def test_every_definition_has_a_user_in_the_package() -> None:
    found = unmentioned(sources())
    assert [name for name in found if name not in UNMENTIONED] == []
    assert [name for name in UNMENTIONED if name not in found] == []  # an exception that is no longer needed goes


def test_what_is_left_over_is_found() -> None:
    """A helper that only its own recursion, a docstring or a comment mentions is none that is used."""
    one = '''
"""About ``unasked``."""
LIMIT = 3
SPARE = 4  # as LIMIT


@loader(
    "csv",
)
def read_one():
    return used(LIMIT)


def used(count):
    """Not ``unasked``."""
    return Kept(count).size


def unasked(count):
    # unasked again
    return unasked(count - 1)


class Kept:
    size: float = 0.0

    def turned(self):
        return self.turned()

    def __len__(self):
        return 1
'''
    other = "from synth.one import (\n    read_two,\n)  # fmt: skip\n"
    two = "def read_two():\n    return 2\n\n\ndef gone():\n    return 'gone'\n"
    found = unmentioned({"synth.one": Module.of(one + two), "synth.two": Module.of(other)})
    assert found == ["synth.one.SPARE", "synth.one.unasked", "synth.one.Kept.turned", "synth.one.gone"]


def untrue(modules: dict[str, Module], texts: dict[str, str]) -> list[str]:
    """Dotted names in docstrings and comments that are neither in the package nor a field of a variable there."""
    places = defaultdict(list)  # a module's name, with or without the packages that it is in -> modules
    for name in modules:
        for first in range(name.count(".") + 1):
            places[".".join(name.split(".")[first:])].append(name)
    fields = {word for module in modules.values() for word in module.words}
    found = []
    for name, text in texts.items():
        for dotted in (each.removeprefix("synth.") for each in DOTTED.findall(text)):
            parts = dotted.split(".")
            known = parts[-1] in FILE_ENDS or parts[0] in ELSEWHERE or dotted in {*KEYS, *places, *synth.__all__}
            known |= parts[0] in modules[name].words and parts[-1] in fields
            for count in range(1, len(parts)):
                holders = places.get(".".join(parts[:count]), [])
                known |= any(modules[each].words.keys() >= set(parts[count:]) for each in holders)
            if not known:
                found.append(f"{name}: {dotted}")
    return found


def test_what_docstrings_name_is_there() -> None:
    """Modules are split and renamed: a ``result`` and an ``integrator`` were named long after they had gone."""
    assert untrue(sources(), {name: path.read_text(encoding="utf-8") for name, path in FILES.items()}) == []


def test_a_name_that_is_gone_is_found() -> None:
    named = ("two.kept", "two.Some.kept", "two.gone", "three.kept", "wish.kept", "a.csv", "np.diff")
    one = f'def f(wish):\n    """Of {", ".join(f"``{each}``" for each in named)}."""\n'
    modules = {"synth.one": Module.of(one), "synth.two": Module.of("class Some:\n    kept = 1\n")}
    assert untrue(modules, {"synth.one": one}) == ["synth.one: two.gone", "synth.one: three.kept"]
