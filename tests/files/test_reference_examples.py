"""Every example of the reference, put into a file of its kind, is taken by the file's reader."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import synth
from synth.api.jump_gaps import read_jump_gap
from synth.files.gap_project import read_gap_project
from synth.files.hopper_recordings import read_motor_runs, read_plate_jumps, read_pull_ups
from synth.files.import_project import read_import_project
from synth.files.leg_project import read_leg_project
from synth.files.part_request import read_part_request
from synth.files.projects import read_fit_project
from synth.files.reference.keys import rows
from synth.files.reference.sections import KINDS, KeySection, kind_word
from synth.parts.catalogs import Catalogue
from synth.parts.part_names import require_known_names, require_known_wishes
from synth.parts.resolver import resolver

ROOT = Path(synth.__file__).parent / "examples"
LINK = {"length": "200 mm", "mass": "740 g", "com": "91 mm", "inertia": "3.5e-3 kg*m^2"}
JOINT = {
    "zero": "90 deg",
    "sign": 1,
    "link": LINK,
    "spring": {"rate": "20 N*m/rad", "free_angle": "105 deg"},
    "damper": {"rate": "1 N*m*s/rad"},
}
LEG = {"kind": "leg", "name": "rat", "joints": [{"name": name, **JOINT} for name in ("hip", "knee", "ankle")]}
# As the projects name it: its hip's current may be recorded, so that a trial can tell that the drive is off.
DRIVEN_LEG = deepcopy(LEG)
DRIVEN_LEG["joints"][0]["drive"] = {"kind": "torque", "motor": {"torque_constant": "0.02 N*m/A"}}
MOVES = {"rest": "105 deg", "amplitude": "20 deg", "damping_ratio": 0.4, "damped_frequency": "2 Hz"}
TRIALS = {"leg": "rat.leg.yaml", "trials": ["trials/*.csv"]}
MOTOR = {"torque_constant": "0.02 N*m/A", "resistance": "2 ohm"}
MOTORS = {"motor": "N20 HP 6V 150:1", "length": "120 mm"}
DRIVEN = {"motor": MOTOR, "supply": "12 V", "gain": "2 1/rad"}
Tree = dict[str, Any]
# The least file of a kind, with what a section must hold.
BASES: dict[str, Tree] = {
    "leg": LEG,
    "fit": TRIALS,
    "gap": TRIALS,
    "leg-design": {"source": TRIALS, "target": "rat.leg.yaml"},
    "import": {"leg": "rat.leg.yaml", "files": ["videos/*.csv"]},
    "hopper-design": yaml.safe_load((ROOT / "hopper" / "hopper.yaml").read_text()),
    "gap-of-jumps": {"leg": "hopper.yaml", **MOTORS, "trials": ["jumps/*.csv"]},
    "hopper-motor": {"gear_ratio": 150, "runs": ["runs/*.csv"]},
    "hopper-pull-ups": {
        "design": "hopper.yaml",
        "body_mass": "37 g",
        "trials": [{"file": "pulls.csv", "length": "0.12 m"}],
    },
    "hopper-jumps": {"design": "hopper.yaml", **MOTORS, "jumps": ["jumps/*.csv"]},
    "part-wish": {"spring": {"rate": "2 N*m/rad"}, "damper": {}},
}
SECTIONS: dict[str, Tree] = {
    "spring": {"free_angle": "105 deg", "rate": "20 N*m/rad"},
    "damper": {"rate": "1 N*m*s/rad"},
    "drive": {"kind": "servo", "gain": "20 N*m/rad"},  # without a motor, but where one of its keys is shown
    "motor": MOTOR,
    "trial": {"file": "trials/a.csv"},
    "tip_mass": {"mass": "50 g"},
    "wanted": MOVES,
    "static": {"angles": {"hip": "105 deg", "knee": "105 deg", "ankle": "105 deg"}},
    "column": {"column": "hip_flexion_r"},
    "input_column": {"column": "goal_position"},
    "command_column": {"column": "goal_position"},
    "commands": {"topic": "/commands"},
    "foreign_file": {"file": "videos/a.csv"},
    "jump_trial": {"file": "jumps/a.csv"},
    "pull_up": {"file": "pulls.csv", "length": "120 mm"},
    "measured_damper": {"curve": "damper.csv"},
    "measured_spring": {"free_angle": "105 deg"},
}
# Further items of a list, for those that may not be the only one.
MORE = {"trial": ["other.csv"], "jump_trial": ["jump.csv"]}
ONLY_GAP = {"trial.leg"}  # its text says so
# What an example needs beside it, and what it stands instead of (None), in its own section.
BESIDE: dict[str, Tree] = {
    "fit.wanted": {"trials": None},
    "source.wanted": {"trials": None},
    "damper.curve": {"rate": None},
    "drive.kind": {"gain": None, "motor": MOTOR},
    **dict.fromkeys(("drive.duty_limit", "drive.current_limit", "drive.supply", "drive.source_resistance"), DRIVEN),
    "drive.integral_limit": {"integral_gain": "30 N*m/(rad*s)"},
    "drive.duty_steps": {**DRIVEN, "control_period": "1 ms"},
    "drive.motor": {"supply": "12 V", "gain": "2 1/rad"},
    "static.angles": {"supported": True},
    "measured_damper.leg": {"curve": None, "trials": ["trials/*.csv"]},
    "measured_damper.trials": {"curve": None, "leg": "rat.leg.yaml"},
    "measured_spring.rate_held": {"rate": "1 N*m/rad"},
    "measured_spring.rate_distance": {"rate": "1 N*m/rad"},
    "clock.unit": {"column": "t"},
    "column.zero_count": {"counts": 4096},
    "column.quaternion": {"column": None, "down": [1, 0, 0]},
    "column.axis": {"column": None, "quaternion": ["w", "x", "y", "z"], "down": [1, 0, 0]},
    "column.down": {"column": None, "quaternion": ["w", "x", "y", "z"]},
    "hopper_leg.crouch_lower": {"crouch": None},
    "laminate.bending": {"beam_rate": None},
    "laminate.links": {"reference_length": None, "link_mass": None, "beam_rate": None},
    "damper_choice.torque": {"speed": "10 rpm"},
    "damper_choice.speed": {"torque": "0.1 N*m"},
}


TABLES = {  # columns; the first rises, the others are 1
    "runs/a.csv": "time [s],voltage [V],current [A],speed [rad/s]",
    "stall.csv": "voltage [V],current [A],torque [N*m]",
    "free_speed.csv": "voltage [V],current [A],speed [rad/s]",
    "meter/a.csv": "time [s],current [A]",
    "video.csv": "time [s],height [m]",
}


def below(section: KeySection, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], KeySection]]:
    """Every section with its place: keys, 0 for the item of a list, ``knee`` for a joint."""
    yield path, section
    for key, inner in section.inner.items():
        end = {"mapping": (), "list": (0,), "by name": ("knee",)}[inner.how]
        yield from below(inner, (*path, key, *end))


EXAMPLES = [
    pytest.param(kind, path, section.name, row.name, row.example, id=f"{kind}:{'.'.join(map(str, (*path, row.name)))}")
    for kind, whole in KINDS.items()
    for path, section in below(whole)
    for row in rows(section)
    if row.example and not (f"{section.name}.{row.name}" in ONLY_GAP and kind != "gap")
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that the examples name."""
    found = tmp_path_factory.mktemp("examples")
    time = np.arange(0.0, 1.0, 0.01)
    angle = 105.0 + 20.0 * np.exp(-3.0 * time) * np.cos(12.0 * time)
    lines = [f"{t:.3f},{a:.4f},{a:.4f},{a:.4f}" for t, a in zip(time, angle, strict=True)]
    swing = "\n".join(["time [s],hip [deg],knee [deg],ankle [deg]", *lines, ""])
    for name in ("trials/a.csv", "other.csv", "rat/releases/a.csv", "videos/a.csv", "videos/b.csv"):
        (found / name).parent.mkdir(parents=True, exist_ok=True)
        (found / name).write_text(swing)
    for name in ("rat.leg.yaml", "nominal.leg.yaml", "rat/rat.leg.yaml", "dog/dog.leg.yaml", "long_arm.leg.yaml"):
        (found / name).parent.mkdir(parents=True, exist_ok=True)
        (found / name).write_text(yaml.safe_dump(DRIVEN_LEG, sort_keys=False))
    (found / "damper.csv").write_text("speed [rpm],torque [N*m]\n5,0.05\n10,0.08\n20,0.12\n")
    (found / "my_parts").mkdir()
    (found / "my_parts" / "a.csv").write_text(
        "part,vendor,max_torque [N*m],speed [rpm],direction,continuous\nD,V,0.1,10,both,yes\n"
    )
    (found / "bending.csv").write_text("deflection [deg],torque [N*m]\n0,0\n1,0.2\n2,0.41\n3,0.6\n")
    shutil.copytree(ROOT / "hopper" / "jumps", found / "jumps")
    shutil.copy(found / "jumps" / "12cm_150.csv", found / "jumps" / "a.csv")
    shutil.copy(ROOT / "hopper" / "pull-ups" / "12cm.csv", found / "pulls.csv")
    shutil.copy(found / "pulls.csv", found / "a.csv")
    shutil.copy(found / "jumps" / "a.csv", found / "jump.csv")
    shutil.copy(ROOT / "hopper" / "hopper.yaml", found / "hopper.yaml")
    for name, columns in TABLES.items():
        (found / name).parent.mkdir(exist_ok=True)
        values = [",".join([f"{0.01 * k:g}", *["1"] * columns.count(",")]) for k in range(1, 40)]
        (found / name).write_text("\n".join([columns, *values, ""]))
    return found


@cache
def catalogue() -> Catalogue:
    return Catalogue.load()


def read_design(path: Path) -> None:
    require_known_names(read_leg_project(path, open_catalogue=lambda paths: resolver(catalogue())), catalogue())


def read_wish(path: Path) -> None:
    require_known_wishes(read_part_request(path), catalogue())


def read_hopper(path: Path) -> None:
    from synth.api.hoppers import read_hopper

    read_hopper(path)


READERS: dict[str, Callable[[Path], object]] = {
    "leg": lambda path: synth.read_leg(path),
    "fit": lambda path: read_fit_project(path, resolve_part=resolver(catalogue())),
    "gap": lambda path: read_gap_project(path, resolve_part=resolver(catalogue())),
    "leg-design": read_design,
    "import": lambda path: read_import_project(path, resolve_part=resolver(catalogue())),
    "hopper-design": read_hopper,
    "gap-of-jumps": read_jump_gap,
    "hopper-motor": read_motor_runs,
    "hopper-pull-ups": read_pull_ups,
    "hopper-jumps": read_plate_jumps,
    "part-wish": read_wish,
}


def put(tree: Tree, path: tuple[Any, ...], section: KeySection, key: str, value: Any) -> None:
    """Write the value at its place, with sections on the way as they must be."""
    place: Any = tree
    for at, step in enumerate(path):
        inside = isinstance(place, dict)
        if step == "knee":
            place = place.setdefault("knee", {})
        elif inside:
            following = path[at + 1] if at + 1 < len(path) else None
            section = section.inner[step]
            base = deepcopy(SECTIONS.get(section.name, {}))
            if following == 0:
                if not isinstance(place.get(step), list) or not isinstance(place[step][0], dict):
                    place[step] = [base, *MORE.get(section.name, [])]
            elif following == "knee":
                made = {joint: deepcopy(base) for joint in ("hip", "knee", "ankle")} if section.name == "wanted" else {}
                place.setdefault(step, made or {"knee": base})
            elif not isinstance(place.get(step), dict):
                place[step] = base
                if section.name == "motor":
                    place.update(supply="12 V", gain="2 1/rad")
            place = place[step]
        else:
            place = place[step]
        if step == "wanted":
            tree.get("source", tree).pop("trials", None)
    place[key] = value
    name = section.name
    for beside, other in BESIDE.get(f"{name}.{key}", {}).items():
        if other is None:
            place.pop(beside, None)
        else:
            place[beside] = other


@pytest.mark.parametrize(("kind", "path", "section", "key", "example"), EXAMPLES)
def test_a_reader_takes_every_example(
    folder: Path, kind: str, path: tuple[Any, ...], section: str, key: str, example: str
) -> None:
    """`motor: N20 HP 210:1` stood beside a mapping, `without: [Lee Spring]` beside parts, a damper beside a spring."""
    tree: Tree = {"kind": kind_word(kind), **deepcopy(BASES[kind])}
    put(tree, path, KINDS[kind], key, yaml.safe_load(example))
    file = folder / f"{kind}.yaml" if kind != "leg" else folder / "one.leg.yaml"
    file.write_text(yaml.safe_dump(tree, sort_keys=False, allow_unicode=True))
    READERS[kind](file)
