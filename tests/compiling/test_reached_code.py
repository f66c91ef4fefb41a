"""Stored code is that of what a function reaches now: its own text, functions of other modules, and their globals."""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from numba.extending import is_jitted

from synth.compiling.compiled import compiled_when_called
from synth.compiling.modules import module_from_text
from synth.compiling.reached_code import reached_by
from synth.drives import motor_law
from synth.jump import planar_engine
from synth.swing.chain import compiled_chain

HELPERS = """
from collections import namedtuple
from math import sin
import numpy as np
from numba import njit

FACTOR = 2.0
TABLE = np.loadtxt(["1.0", "4.0"])
PAIR = (3.0, 5)
Sizes = namedtuple("Sizes", "first second")
SIZES = Sizes(1.5, 2.5)
UNUSED = 1.0

@njit
def inner(x):
    return PAIR[0] * x + SIZES.second + sin(0.0)

@njit
def helper(x, shift=0.25):
    return inner(x) + shift

def of(own):
    @njit
    def enclosed(x):
        return own * x
    return enclosed

enclosed = of(7.0)
"""
# Its value at x: (2 + 4 + 3) x + 2.5 + 0.25 + 7 x.
CALLER = """
import {helpers} as numbers
from {helpers} import FACTOR, enclosed, helper

def caller(x):
    return FACTOR * x + numbers.TABLE[1] * x + helper(x) + enclosed(x)
"""
COUNT = iter(range(10**6))


def made(helpers: str = HELPERS, caller: str = CALLER):
    """The caller, from two modules of these texts, which nothing has seen before."""
    number = next(COUNT)
    module_from_text(f"probe_helpers_{number}", helpers)
    return module_from_text("probe_caller", caller.format(helpers=f"probe_helpers_{number}")).caller


def digest(helpers: str = HELPERS, caller: str = CALLER) -> str:
    """Hash of the caller, whose helpers always have one name."""
    module_from_text("probe_helpers", helpers)
    reached = reached_by(module_from_text("probe_caller", caller.format(helpers="probe_helpers")).caller)
    assert reached.obstacle == ""
    return reached.digest


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    """Modules of the tests are forgotten afterwards."""
    before = set(sys.modules)
    yield
    for name in set(sys.modules) - before:
        if name.startswith("probe_"):
            del sys.modules[name]


CHANGES = {
    "a number": ("FACTOR = 2.0", "FACTOR = 2.5"),
    "its type": ("FACTOR = 2.0", "FACTOR = 2"),
    "a table read at import": ('"4.0"', '"4.5"'),
    "a table's type": ('"4.0"])', '"4.0"], dtype=np.float32)'),
    "a number of a helper's helper": ("(3.0, 5)", "(3.5, 5)"),
    "a named tuple": ("2.5)", "2.75)"),
    "a function": ("+ sin(0.0)", "- sin(0.0)"),
    "a default": ("shift=0.25", "shift=0.5"),
    "an option": ("@njit\ndef inner", "@njit(fastmath=True)\ndef inner"),
    "an enclosed number": ("of(7.0)", "of(7.5)"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_each_change_of_what_is_reached_changes_the_hash(change: str) -> None:
    assert digest(HELPERS.replace(*CHANGES[change])) != digest()


def test_what_is_not_reached_does_not_count() -> None:
    assert digest(HELPERS.replace("UNUSED = 1.0", "UNUSED = 2.0")) == digest()
    assert digest(caller=CALLER + "\nother = 1\n") == digest()


def test_stored_code_computes_with_the_present_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    (tmp_path / "code").mkdir(mode=0o700)
    changed = {
        "": 16.0 + 2.75, "a number": 16.5 + 2.75, "a table read at import": 16.5 + 2.75, "a default": 16.0 + 3.0,
        "a number of a helper's helper": 16.5 + 2.75, "an enclosed number": 16.5 + 2.75,
    }  # fmt: skip
    for times in (1, 2):
        for change, expected in changed.items():
            module_from_text("probe_helpers", HELPERS.replace(*CHANGES.get(change, ("", ""))))
            caller = module_from_text("probe_caller", CALLER.format(helpers="probe_helpers")).caller
            compiled = compiled_when_called()(caller)
            assert compiled(1.0) == expected
            assert sum(compiled.stats.cache_misses.values()) == (times == 1)  # the second time it came from disk
    assert len(list((tmp_path / "code").iterdir())) == len(changed)


def test_what_cannot_be_hashed_is_compiled_in_each_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    plain = "from numba.extending import register_jitable\n\n@register_jitable\ndef helper"
    text = HELPERS.replace("@njit\ndef helper", plain)
    caller = made(text)
    reached = reached_by(caller)
    assert "helper, which is a function that is not compiled" in reached.obstacle
    assert reached_by(caller) == reached
    assert reached_by(made(text)).digest != reached.digest
    assert compiled_when_called()(caller)(1.0) == 18.75
    assert not list((tmp_path / "code").iterdir())


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("np.array([1.0, None])", "array of Python objects"),
        ("{1: 2.0}", "a dict"),
        ("np.ma.array([1.0])", "a MaskedArray"),
    ],
)
def test_values_without_a_hash_are_named(value: str, words: str) -> None:
    caller = module_from_text("probe_caller", f"import numpy as np\nT = {value}\ndef caller(x):\n    return T\n").caller
    assert reached_by(caller).obstacle.startswith("T, ")
    assert words in reached_by(caller).obstacle


def test_a_number_that_changes_after_its_function_was_compiled_is_not_stored() -> None:
    """Such a function goes on with the old number, and only in this process."""
    module = module_from_text("probe_helpers", HELPERS)
    assert module.inner(1.0) == 5.5
    caller = module_from_text("probe_caller", CALLER.format(helpers="probe_helpers")).caller
    assert reached_by(caller).obstacle == ""
    module.PAIR = (4.0, 5)
    assert module.inner(1.0) == 5.5
    assert "changed after it was compiled" in reached_by(caller).obstacle


def test_functions_that_call_each_other_are_hashed_once() -> None:
    text = "from numba import njit\n@njit\ndef even(n):\n    return n == 0 or odd(n - 1)\n"
    text += "@njit\ndef odd(n):\n    return n != 0 and even(n - 1)\ndef caller(n):\n    return even(n) + odd(n)\n"
    assert reached_by(module_from_text("probe_caller", text).caller).obstacle == ""


def test_each_process_finds_the_same_hash(tmp_path: Path) -> None:
    program = "from synth.compiling.reached_code import reached_by\nfrom synth.swing.explicit_steps import stage\n"
    program += "from synth.swing.effects.shear_thinning_damping import torque\n"
    program += "print(reached_by(stage), reached_by(torque))"
    found = {
        subprocess.run(
            [sys.executable, "-c", program], check=True, capture_output=True, text=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1
    assert "obstacle=''" in found.pop()


def test_the_jump_depends_on_the_motor_that_it_inlines(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its law lies in another folder."""
    before = reached_by(planar_engine.integrate).digest
    text = Path(str(motor_law.__file__)).read_text(encoding="utf-8")
    changed = module_from_text("probe_motor_law", text.replace("- slope * rate", "- 2.0 * slope * rate"))
    monkeypatch.setattr(planar_engine, "steady_line", changed.steady_line)
    assert reached_by(planar_engine.integrate).digest != before


COMPILING = ("compiling", "drives", "hopper", "jump", "planting", "swing", "swing.effects")


@pytest.mark.parametrize("folder", COMPILING)
def test_all_that_our_own_functions_reach_can_be_hashed(folder: str) -> None:
    package = importlib.import_module(f"synth.{folder}")
    texts = [Path(path, f"{m.name}.py").read_text(encoding="utf-8") for path in package.__path__
             for m in pkgutil.iter_modules([path]) if not m.ispkg]  # fmt: skip
    names = [m.name for m in pkgutil.iter_modules(package.__path__) if not m.ispkg]
    wanted = [name for name, text in zip(names, texts, strict=True) if re.search(r"^@|njit\(", text, re.MULTILINE)]
    modules = [importlib.import_module(f"synth.{folder}.{name}") for name in wanted]
    found = [each for module in modules for each in vars(module).values() if is_jitted(each)]
    assert {reached_by(function).obstacle for function in found} <= {""}
    assert found or folder == "compiling"


def test_all_that_a_generated_module_reaches_can_be_hashed() -> None:
    for source in compiled_chain(1).sources.values():
        functions = [each for each in vars(source.load()).values() if is_jitted(each)]
        assert {reached_by(function).obstacle for function in functions} == {""}


def test_overloads_stand_in_the_module_of_their_function() -> None:
    """Only then the source of that module tells a change of them."""
    root = Path(importlib.import_module("synth").__path__[0])
    for path in sorted(root.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for name in re.findall(r"^@overload\((\w+)", text, re.MULTILINE):
            assert f"\ndef {name}(" in text, path
