"""The keys of a leg file: what each holds, with its range, and the checks across them."""

from __future__ import annotations

from math import radians
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from synth import units
from synth.errors import Problem, UserError
from synth.files import drive_columns
from synth.files.drive import DriveKeys
from synth.files.names import name_fault, same_file
from synth.files.validate import FileModel, Quantity, Title, refusal
from synth.files.yaml_lines import Document

TURNS = radians(720.0)  # no joint's angle lies beyond two turns
MANY_TURNS = radians(36_000.0)  # but one that turns on, whose recordings count a hundred turns
COM_LIMIT = 5.0  # link lengths; a counterweight may lie outside the link, but not farther
GYRATION_LIMIT = 5.0  # link lengths, of a link's radius of gyration about its centre of mass: a rod has 0.29

# Of a link: beyond any crane's boom. A slip of a power of ten there overflowed in the sums of inertias.
LONGEST, HEAVIEST = 1e3, 1e6  # m, kg

_TAKEN = ("time", "base", "all", drive_columns.SUPPLY)
ENDINGS = (" velocity", " torque", *drive_columns.SUFFIXES)  # of columns with other quantities of a joint


class LinkKeys(FileModel):
    length: Annotated[float, Quantity("m", above=0, most=LONGEST)]
    mass: Annotated[float, Quantity("kg", above=0, most=HEAVIEST)]
    com: Annotated[float, Quantity("m")]
    inertia: Annotated[float, Quantity("kg*m^2", above=0)]
    includes: Literal["none", "joint"] = "joint"
    com_across: Annotated[float, Quantity("m")] = 0.0


class SpringKeys(FileModel):
    rate: Annotated[float, Quantity("N*m/rad", least=0)] | None = None
    free_angle: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)]
    part: Title | None = None

    @model_validator(mode="after")
    def _complete(self) -> SpringKeys:
        if self.rate is None and self.part is None:
            raise refusal('"rate" is missing: write it, for example rate: 23.7 N*m/rad, or name a catalogue part')
        return self


class DamperKeys(FileModel):
    rate: Annotated[float, Quantity("N*m*s/rad", least=0)] | None = None
    curve: str | None = None
    part: Title | None = None

    @model_validator(mode="after")
    def _complete(self) -> DamperKeys:
        if self.rate is not None and self.curve is not None:
            raise refusal('"rate" and "curve" are both given; keep one')
        if self.rate is None and self.curve is None and self.part is None:
            raise refusal('needs "rate" (1.29 N*m*s/rad), "curve" (a CSV) or "part" (a catalogue row)')
        return self


class JointKeys(FileModel):
    name: Annotated[str, Field(examples=["hip"])]
    zero: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)]
    sign: Annotated[int, Field(examples=["+1"])]
    range: (
        Annotated[
            list[Annotated[float, Quantity("rad", least=-MANY_TURNS, most=MANY_TURNS)]],
            Field(min_length=2, max_length=2),
        ]
        | None
    ) = None
    link: Annotated[LinkKeys, Field(examples=["{length: 200 mm, mass: 740 g, com: 91 mm, inertia: 3.5e-3 kg*m^2}"])]
    armature: Annotated[float, Quantity("kg*m^2", least=0)] = 0.0
    spring: SpringKeys | None = None
    damper: DamperKeys | None = None
    drive: DriveKeys | None = None
    effects: list[dict[str, dict[str, Any]]] | None = None

    @field_validator("name")
    @classmethod
    def _name(cls, name: str) -> str:
        fault = name_fault(name)
        if fault is not None:
            raise refusal(f'"{name[:60]}" cannot be a joint\'s name: it {fault}')
        if name in _TAKEN or name.endswith(ENDINGS):
            raise refusal(f'"{name}" cannot be a joint\'s name: it has another meaning in these files')
        return name

    @field_validator("sign")
    @classmethod
    def _sign(cls, sign: int) -> int:
        if sign not in (1, -1):
            raise refusal(f"{sign} is not allowed: write +1 if the angle grows counter-clockwise, else -1")
        return sign

    @field_validator("range")
    @classmethod
    def _range(cls, ends: list[float] | None) -> list[float] | None:
        if ends is not None and not ends[0] < ends[1]:
            raise refusal("the range must go from the smaller angle to the larger: [60 deg, 150 deg]")
        return ends


class LegKeys(FileModel):
    kind: str
    name: Annotated[Title, Field(examples=["dog hind leg"])]
    gravity: Annotated[float, Quantity("m/s^2", least=0, most=1000)] = 9.81
    tilt: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)] = 0.0
    # Joints are checked individually, so that one mistake does not hide those of other joints.
    joints: Annotated[list[Any], Field(min_length=1, max_length=6)]
    effects: list[dict[str, dict[str, Any]]] | None = None  # of the base


def check_across(document: Document, problems: list[Problem]) -> None:
    """Checks across fields: names used twice, a centre of mass far from its link."""
    joints = document.value.get("joints")
    names: dict[str, int | None] = {}
    for index, joint in enumerate(joints if isinstance(joints, list) else []):
        if not isinstance(joint, dict):
            continue
        name, key = joint.get("name"), ("joints", index, "name")
        if isinstance(name, str) and name in names:
            problems.append(document.problem(f'"{name}" is used twice{_first(names[name])}; rename one', key))
        elif isinstance(name, str):
            alike = same_file(names, name)
            if alike is not None:
                line = "" if names[alike] is None else f" (line {names[alike]})"
                text = f'"{name}" and "{alike}"{line} would share their files; rename one'
                problems.append(document.problem(text, key))
            names[name] = document.line(key)
        link = joint.get("link")
        for com, whence in (("com", "its joint"), ("com_across", "its line")):
            if not (isinstance(link, dict) and {com, "length"} <= link.keys()):
                continue
            try:
                ratio = abs(units.parse(link[com], "m")) / units.parse(link["length"], "m")
            except (UserError, ZeroDivisionError):
                continue  # reported by the field itself
            if ratio > COM_LIMIT:
                text = f"{link[com]} is {ratio:.3g} lengths of the link away from {whence}; check the unit"
                problems.append(document.problem(text, ("joints", index, "link", com)))
        if isinstance(link, dict) and {"inertia", "mass", "length"} <= link.keys():
            try:
                inertia, mass = units.parse(link["inertia"], "kg*m^2"), units.parse(link["mass"], "kg")
                ratio = (inertia / mass) ** 0.5 / units.parse(link["length"], "m")
            except (UserError, ArithmeticError, TypeError):
                continue  # reported by the field itself
            if isinstance(ratio, float) and ratio > GYRATION_LIMIT:
                text = f"{link['inertia']} is the inertia of {link['mass']} at {ratio:.3g} lengths of the link; check "
                text += "the units of inertia, mass and length"
                problems.append(document.problem(text, ("joints", index, "link", "inertia")))


def _first(line: int | None) -> str:
    """Where a name was used before; a leg made in code has no lines."""
    return "" if line is None else f" (first in line {line})"
