"""Nothing in the package is left over: each name has a user in it, and each name that a docstring gives exists."""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import synth
from name_uses import ModuleNames, Uses, assigned_twice, unread_fields
from tool_modules import tool

ROOT = Path(__file__).resolve().parents[1]
FILES: dict[str, Path] = tool("architecture").modules()
# What nothing in the package mentions, and why it stays.
UNMENTIONED = {
    "synth.api.report.Report._repr_html_": "notebooks call it",
    "synth.cad.export.export_leg": "a leg's files in one call, for who uses cad by itself",
    "synth.cad.joint.build_joint": "a joint in one call, for who uses cad by itself; the design keeps the layout",
    "synth.compiling.numba_internals.KeptCode.save_overload": "numba calls it",
    "synth.swing.chain_integrator.integrate": "synth.swing.chain reads it from the compiled module",
    "synth.swing.curve_integrator.integrate_curves": "likewise",
    "synth.swing.friction_integrator.integrate_rubbing": "likewise",
    "synth.motion.importers.ros_messages.joint_arrays": "the program that from_ros runs calls it",
    "synth.files.kept_templates.KeptTemplates.dump_bytecode": "jinja calls it",
    "synth.files.kept_templates.KeptTemplates.load_bytecode": "jinja calls it",
    "synth.files.reference.pages.pages": "tools/reference.py writes them",
    "synth.planting.explained_gap.PlainModel.linear_costs": "tests/blind, which plants with this model, asks it",
    "synth.planting.explained_gap.PlainModel.plausible": "likewise",
}

# What a program finds in every module of a package by its name.
DISCOVERED = {
    "synth.commands": {"add_arguments", "run"},
    "synth.jump.effects": {"EFFECT", "change"},
    "synth.swing.effects": {
        *(
            "EFFECT",
            "along",
            "bounded",
            "change",
            "control",
            "deviation",
            "drive",
            "extend",
            "read",
            "start",
            "to_rotation",
            "torque",
        ),
    },
}
# Methods, docstrings and comments by the text, which `ruff format` lays out: whose attribute a name is, a tree does not
# tell either.
COMMENT = re.compile(r"(^|\s)# .*$", re.MULTILINE)
BLOCK = re.compile(r'(^\s*r?)?"""[\s\S]*?"""', re.MULTILINE)  # a docstring, if nothing stands before it
STRING = re.compile(r'"(?:[^"\\\n]|\\.)*"')
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
    text: str

    @classmethod
    def of(cls, text: str) -> Module:
        blocks = [found[0] for found in BLOCK.finditer(text) if found[1] is None]
        code = COMMENT.sub(r"\1", BLOCK.sub(lambda found: '""' if found[1] is None else "", text))
        texts = Counter(word for found in (*blocks, *STRING.findall(code)) for word in WORD.findall(found))
        return cls(code, Counter(WORD.findall(code)), Counter(ATTRIBUTE.findall(code)), texts, text)


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


def is_discovered(module: str, name: str) -> bool:
    """Whether a registry finds a name of a module without an import."""
    return name in DISCOVERED.get(module.rpartition(".")[0], ())


@cache
def sources() -> dict[str, Module]:
    return {name: Module.of(path.read_text(encoding="utf-8")) for name, path in FILES.items()}


def templates() -> Counter[str]:
    """Words of what the pages' templates ask: they call functions and read fields."""
    asked = [own for path in (ROOT / "reports").rglob("*.html") for own in ASKED.findall(path.read_text("utf-8"))]
    return Counter(word for own in asked for word in WORD.findall(own))


def unmentioned(modules: dict[str, Module]) -> list[str]:
    """Full names of what nothing in the package uses but the definition itself.

    What modules define is resolved by imports, what classes define by the name.
    """
    uses = Uses({name: ModuleNames.of(module.text) for name, module in modules.items()})
    attributes, texts = templates(), Counter[str]()
    for module in modules.values():
        attributes.update(module.attributes)
        texts.update(module.texts)
    found = []
    for name, module in modules.items():
        for each in definitions(name, module):
            own = Module.of(each.code)
            if each.owner:
                used = attributes[each.name] + texts[each.name] > own.attributes[each.name] + own.texts[each.name]
            else:
                used = uses.used(name, each.name) or is_discovered(name, each.name)
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
    other = "from synth.one import (\n    read_two,\n)  # fmt: skip\n\nread_two()\n"
    two = "def read_two():\n    return 2\n\n\ndef gone():\n    return 'gone'\n"
    found = unmentioned({"synth.one": Module.of(one + two), "synth.two": Module.of(other)})
    assert found == ["synth.one.SPARE", "synth.one.unasked", "synth.one.Kept.turned", "synth.one.gone"]


def test_a_name_is_resolved_by_its_import() -> None:
    """A variable, a field, an entry of ``__all__`` or another module's function of the same name is no use."""
    one = """
import synth.two
from synth.three import kept as same, handed

__all__ = ["handed"]


def energy(leg):
    return same(leg) + synth.two.far


def _gap(limit):
    return "written(limit)"


def written(limit):
    return _gap(limit)
"""
    two = """
far = 1
limit = 2
kept = 3


def unasked(limit):
    energy = 3
    return energy + unasked(limit)
"""
    three = """
def kept(gap):
    return gap


def handed():
    return kept


def _lambda():
    return map(lambda limit: limit, energy)
"""
    modules = {f"synth.{name}": Module.of(text) for name, text in {"one": one, "two": two, "three": three}.items()}
    expected = ["one.energy", "two.limit", "two.kept", "two.unasked", "three.handed", "three._lambda"]
    assert unmentioned(modules) == [f"synth.{name}" for name in expected]


# Fields that nothing in the package reads, and why they stay.
UNREAD = {
    "synth.api.springs.SpringAnswer.in_the_way": "the user reads it",
    "synth.jump.mujoco_model.MujocoJump.closure_gap": "the other engine's own error, which tests/hopper bounds",
}


def test_every_field_is_read() -> None:
    modules = sources()
    named = {*templates(), *(word for module in modules.values() for word in module.texts)}
    assert sorted(unread_fields({name: module.text for name, module in modules.items()}, named)) == sorted(UNREAD)


def test_an_unread_field_is_found() -> None:
    one = "class Some:\n    kept: int\n    told: int\n    gone: int = 0\n\n\ndef f(some):\n    some.gone = some.kept\n"
    assert unread_fields({"synth.one": one}, {"told"}) == ["synth.one.Some.gone"]


def test_no_module_assigns_a_constant_twice() -> None:
    assert {name: twice for name, each in sources().items() if (twice := assigned_twice(each.text))} == {}


def test_a_constant_that_is_assigned_twice_is_found() -> None:
    assert assigned_twice("A = 1\nB: int = 2\nC: int\nC = 3\nB = A\nlow = 1\nlow = 2\n") == ["B"]


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
