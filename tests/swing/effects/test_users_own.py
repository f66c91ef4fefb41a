"""A user's own effect in a file takes part without a change to the package; and switching on compiles nothing."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import synth.swing.effects
from compiled_code import with_code
from swing.effects.one_joint import INERTIA, RATE, leg
from swing.effects.test_mirror import GIVEN
from synth.errors import UserError
from synth.files.leg_file import read_leg, write_leg
from synth.swing.chain import compiled_chain, is_compiled, simulate
from synth.swing.chain_modules import how_often
from synth.swing.effects import effect_named, registered
from synth.swing.effects.users_own import blamed_on, load_file

MAGNET = '''
"""Torque of a magnet at the joint: cogging with a number of poles."""

from math import sin

from synth.effects import Effect, Parameter, Shape, inlined, size


@inlined
def torque(rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, strength, poles):
    return -strength * sin(poles * rotation), 0.0


EFFECT = Effect(
    name="cogging",
    meaning="torque of a magnet",
    formula="-strength sin(poles q)",
    source="definition",
    way="torque",
    linear=True,
    parameters=(Parameter("strength", "N*m", prior=size(0.2)), Parameter("poles", "1", 6.0, off=6.0)),
    strengths=("strength",),
    shapes=(Shape(("strength",), {}),),
)
'''


@pytest.fixture
def magnet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's file, in a process that forgets it afterwards."""
    monkeypatch.setattr(synth.swing.effects, "from_files", {})
    path = tmp_path / "my magnet-1.py"
    path.write_text(MAGNET)
    return path


def test_a_users_effect_is_simulated(magnet: Path) -> None:
    load_file(magnet)
    assert [effect.name for effect in registered()].count("cogging") == 1
    made = leg({"cogging": {"strength": 0.8, "poles": 7.0}, "coulomb_friction": {"torque": 0.0}}, damper=0.02)
    times = np.linspace(0, 1, 51)

    def derivative(_: float, state: np.ndarray) -> list[float]:
        return [state[1], (-RATE * state[0] - 0.02 * state[1] - 0.8 * np.sin(7 * state[0])) / INERTIA]

    expected = solve_ivp(derivative, (0, 1), [0.7, 0.0], "DOP853", times, rtol=1e-11, atol=1e-12).y[0]
    got = simulate(made, [0.7], [0.0], times, tolerance=1e-10)[:, 0]
    np.testing.assert_allclose(got, expected, atol=1e-8)


def test_a_users_effect_stands_in_a_leg_file(magnet: Path, tmp_path: Path) -> None:
    load_file(magnet)
    path = tmp_path / "x.leg.yaml"
    write_leg(leg({"cogging": {"strength": 0.8, "poles": 7.0}}), path)
    assert read_leg(path).joints[0].effects == {"cogging": {"strength": 0.8, "poles": 7.0}}


def test_an_edited_file_is_another_effect(magnet: Path) -> None:
    load_file(magnet)
    made = leg({"cogging": {"strength": 0.8}}, rate=None)
    one = simulate(made, [0.1], [0.0], np.array([0.0, 0.02]), tolerance=1e-10)[-1, 0]
    magnet.write_text(MAGNET.replace("-strength * sin", "2.0 * strength * sin"))
    load_file(magnet)
    other = simulate(made, [0.1], [0.0], np.array([0.0, 0.02]), tolerance=1e-10)[-1, 0]
    assert one < 0.1 < other


POLES = "from synth.effects import inlined\n\nPOLES = {poles}\n\n\n@inlined\ndef turns(q):\n    return {turns} * q\n"


@pytest.mark.parametrize(("poles", "turns"), [(6.0, 1.0), (3.0, 4.0)])
def test_an_effect_follows_the_module_from_which_it_takes_a_number_and_a_function(
    poles: float, turns: float, magnet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its own file stays as it is."""
    (tmp_path / "magnet_numbers.py").write_text(POLES.format(poles=poles, turns=turns))
    monkeypatch.syspath_prepend(tmp_path)
    text = MAGNET.replace("EFFECT = ", "from magnet_numbers import POLES, turns\n\nEFFECT = ")
    magnet.write_text(text.replace("sin(poles * rotation)", "sin(POLES * turns(rotation))"))
    try:
        load_file(magnet)
        got = simulate(leg({"cogging": {"strength": 0.8}}), [0.7], [0.0], np.array([0.0, 0.1]), tolerance=1e-10)[-1, 0]
    finally:
        del sys.modules["magnet_numbers"]

    def derivative(_: float, state: np.ndarray) -> list[float]:
        return [state[1], (-RATE * state[0] - 0.8 * np.sin(poles * turns * state[0])) / INERTIA]

    assert got == pytest.approx(solve_ivp(derivative, (0, 0.1), [0.7, 0.0], rtol=1e-11, atol=1e-12).y[0, -1], abs=1e-8)


def test_code_that_cannot_be_stored_is_said_to_compile_at_each_start(magnet: Path) -> None:
    plain = "from numba.extending import register_jitable\n\n\n@register_jitable\ndef turned(q):\n    return q\n\n\n"
    magnet.write_text(
        MAGNET.replace("@inlined", f"{plain}@inlined").replace("poles * rotation", "poles * turned(rotation)")
    )
    assert how_often((effect_named("backlash"),)) == "once on this machine"
    told = how_often((effect_named("backlash"), load_file(magnet)))
    assert told.startswith("at each start, because code cannot be stored if cogging uses turned, which is a function")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("", ""), ""),
        (("EFFECT = ", "OTHER = "), "holds no EFFECT"),
        (('name="cogging"', 'name="backlash"'), "built-in"),
        (('name="cogging"', 'name="my magnet"'), "cannot be an effect's name"),
        (('strengths=("strength",)', 'strengths=("torque",)'), "strengths must name some of its parameters"),
        (("def torque(", "def another("), "no function torque"),
        (("@inlined\n", ""), "@inlined"),
        ((", strength, poles):", ", strength):"), "torque takes 9 arguments, not 8 and then strength, poles"),
        (("linear=True", "memory=True"), "no function start"),
        (("from math import sin", "from math import son"), "cannot be run: ImportError"),
        (("def torque(", "def torque(("), "cannot be run: SyntaxError"),
        (('way="torque"', 'way="torq"'), "way='torq' is not allowed; write one of 'torque', 'leg'"),
        (('way="torque"', "way=[]"), "way=[] is not allowed"),
        (('way="torque"', 'way="torque", where="knee"'), "write one of 'joint', 'base'"),
        (("EFFECT = ", "exit()\nEFFECT = "), "calls exit"),
        (("EFFECT = ", "raise SystemExit(0)\nEFFECT = "), "calls exit"),
        (('name="cogging"', "name=5"), "cannot be an effect's name"),
        (('strengths=("strength",)', 'strengths="strength"'), "strengths must be a tuple of str"),
        (('shapes=(Shape(("strength",), {}),)', "shapes=()"), "shapes is empty"),
        (('way="torque"', 'way="torque", ascending="poles"'), "ascending must be a tuple of str"),
        (('way="torque"', 'way="torque", any_of=("polse",)'), "any_of must name one of its parameters"),
        (('Shape(("strength",), {})', 'Shape(("poles",), {})'), "frees poles, which has no prior"),
        (('Shape(("strength",), {})', 'Shape(("strenght",), {})'), "a shape must name one of its parameters"),
        (('"N*m", prior', '"furlongs", prior'), "'furlongs' is no unit"),
        (("sin(poles * rotation), 0.0", "sin(poles * rotation)"), "torque must give two numbers"),
        (("-strength * sin", "-strength - sin"), "torque must be 0 where every parameter is off"),
        (("-strength * sin", "-strength * str"), "torque fails when it is called: TypingError"),
    ],
)
def test_faults_of_a_file_are_reported(magnet: Path, change: tuple[str, str], words: str) -> None:
    magnet.write_text(MAGNET.replace(*change))
    if not words:
        assert load_file(magnet).name == "cogging"
        return
    with pytest.raises(UserError) as caught:
        load_file(magnet)
    problem = caught.value.problems[0]
    assert words in problem.text
    assert problem.file == str(magnet)
    assert "\n" not in problem.text
    if "cannot be run" in words:
        assert problem.line == (4 if "ImportError" in words else 10)
    assert "cogging" not in [effect.name for effect in registered()]


SHIFT = """
from synth.swing.effects import Effect, Parameter, Shape
from synth.swing.effects.definition import signed


def read(time, rotation, rate, sign, zero, shift):
    return rotation + shift


EFFECT = Effect(
    name="slipped",
    meaning="a reading that slipped",
    formula="reading + shift",
    source="definition",
    way="reading",
    parameters=(Parameter("shift", "rad", prior=signed(0.1)),),
    strengths=("shift",),
    shapes=(Shape(("shift",), {}),),
)
"""


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("", ""), ""),
        (("rotation + shift", "rotation[:, 0] + shift[0]"), "read must give an array of the rotation's shape"),
        (("rotation + shift", "rotation + shift / missing"), "read fails in line 7 when it is called: NameError"),
        (('"reading"', '"leg"'), "no function change"),
        (('"reading"', '"structure"'), "no function extend"),
        (('way="reading",', ""), "cannot be run: TypeError: Effect.__init__() missing 1 required"),
    ],
)
def test_a_function_that_fails_is_found_before_any_work(magnet: Path, change: tuple[str, str], words: str) -> None:
    magnet.write_text(SHIFT.replace(*change))
    if not words:
        assert load_file(magnet).name == "slipped"
        return
    with pytest.raises(UserError) as caught:
        load_file(magnet)
    assert words in caught.value.problems[0].text


def test_a_function_that_changes_what_it_should_not_is_found(magnet: Path) -> None:
    change = SHIFT.replace("def read(time, rotation, rate, sign, zero, shift)", "def change(legs, joint, sign, shift)")
    change = change.replace("return rotation + shift", "legs.mass[joint] *= 1.1").replace('"reading"', '"leg"')
    magnet.write_text(change)
    with pytest.raises(UserError, match="change must change nothing where every parameter is off; it changes mass"):
        load_file(magnet)
    magnet.write_text(change.replace("*= 1.1", "*= 1.0 + shift"))
    assert load_file(magnet).way == "leg"


def test_an_error_in_a_users_effect_names_its_line(magnet: Path) -> None:
    magnet.write_text(SHIFT.replace("return rotation + shift", "return rotation + 1 // int(len(time) != 7) * shift"))
    effect = load_file(magnet)
    with pytest.raises(UserError, match="ZeroDivisionError") as caught, blamed_on({str(magnet): "mine.py"}):
        effect.function()(np.zeros(7), np.zeros((7, 1)), np.zeros((7, 1)), 1, 0.0, np.zeros(1))
    assert (caught.value.problems[0].file, caught.value.problems[0].line) == ("mine.py", 7)


def test_a_pipe_or_a_folder_is_no_effect(magnet: Path, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.py")
    for name in ("pipe.py", "."):
        with pytest.raises(UserError, match="no regular file"):
            load_file(tmp_path / name)


def test_two_files_cannot_share_a_name_and_one_must_be_there(magnet: Path, tmp_path: Path) -> None:
    load_file(magnet)
    twin = tmp_path / "twin.py"
    twin.write_text(MAGNET + "\n")
    with pytest.raises(UserError, match="magnet-1"):
        load_file(twin)
    with pytest.raises(UserError, match="no such file"):
        load_file(tmp_path / "nowhere.py")


def test_an_installed_package_adds_its_effect(magnet: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "magnets_from_a_package.py").write_text(MAGNET)
    monkeypatch.syspath_prepend(tmp_path)
    point = EntryPoint("cogging", "magnets_from_a_package", "synth.effects")
    monkeypatch.setattr(synth.swing.effects, "entry_points", lambda group: [point] if group == "synth.effects" else [])
    synth.swing.effects.installed.cache_clear()
    try:
        assert effect_named("cogging").module == "magnets_from_a_package"
        assert "backlash" in [effect.name for effect in registered()]
    finally:
        synth.swing.effects.installed.cache_clear()
        sys.modules.pop("magnets_from_a_package", None)


def test_switching_an_effect_on_compiles_nothing() -> None:
    chain = compiled_chain(1)
    chain.load()
    assert is_compiled(1)
    functions = (chain.right_hand_side, chain.extra_torques, chain.bearing_forces, chain.integrate)
    before = [(len(function.signatures), sum(function.stats.cache_misses.values())) for function in functions]
    times = np.linspace(0, 0.1, 5)
    plain = simulate(leg({}, damper=0.02), [0.7], [3.0], times)
    for name, given in GIVEN.items():
        moved = simulate(leg({name: given}, damper=0.02), [0.7], [3.0], times)
        assert np.abs(moved - plain).max() > 1e-9 or name == "joint_stop"
    after = [(len(function.signatures), sum(function.stats.cache_misses.values())) for function in functions]
    assert after == before
    assert compiled_chain(1) is chain


def test_a_second_process_compiles_nothing_for_a_users_effect(magnet: Path, tmp_path: Path) -> None:
    program = f"""
from synth.swing.effects.users_own import load_file
from synth.swing.chain import compiled_chain, is_compiled
load_file({str(magnet)!r})
there = is_compiled(1)
chain = compiled_chain(1)
for source in chain.sources.values():
    source.load()
print(there, sum(chain.extra_torques.stats.cache_misses.values()), "cogging" in [e.name for e in chain.effects])
"""
    environment = os.environ | {"SYNTH_CACHE": str(with_code(tmp_path / "cache", 1, but="torques"))}
    told = [
        subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert [done.stdout.split() for done in told] == [["False", "1", "True"], ["True", "0", "True"]]
