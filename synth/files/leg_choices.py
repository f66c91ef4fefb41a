"""The section ``select`` of a leg design: catalogues, and what each joint's spring and damper must meet."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from pydantic import Field

from synth import units
from synth.files.named_files import ProjectReader
from synth.files.project_options import (
    DamperChoice,
    Deviation,
    JointChoice,
    PartsOptions,
    SpringChoice,
    ToleranceOptions,
)
from synth.files.schema import Because, Default, read_section
from synth.files.spring_words import System
from synth.files.yaml_lines import Key
from synth.swing.leg_model import Leg

WIRE = "music"
Names = Annotated[list[str], Field(examples=["[Lee Spring]"])]


@dataclass(frozen=True)
class SelectSection:
    catalogs: Annotated[list[str], Because("the built-in catalogues only", "none")] = field(default_factory=list)
    joints: dict[str, Any] = field(default_factory=dict)
    vendors: Names = field(default_factory=list)
    without: Names = field(default_factory=list)
    system: System | None = None
    within: Annotated[Deviation, Because("a tenth of a leg's common joint amplitude")] = PartsOptions.within
    tolerance: Any = None


@dataclass(frozen=True)
class JointSection:
    spring: Any = None
    damper: Any = None


def read_parts_options(reader: ProjectReader, select: SelectSection | None, written: Any) -> PartsOptions:
    """Options of the parts of all joints."""
    if select is None:
        return PartsOptions()
    value = written.get("tolerance") if isinstance(written, dict) else None
    key: Key = ("select", "tolerance")
    tolerance = read_section(ToleranceOptions, reader.document, key, reader.problems, reader.defaults, value)
    return PartsOptions(
        tuple(select.vendors), tuple(select.without), select.system, select.within, tolerance or ToleranceOptions()
    )


def read_joint_choices(
    reader: ProjectReader, select: SelectSection | None, target: Leg | None
) -> dict[str, JointChoice]:
    """The choice for every joint of the target, whether the file names it or not."""
    if select is None:
        return {}
    document, problems, defaults = reader.document, reader.problems, reader.defaults
    place: Key = ("select", "joints")
    if target is not None:
        reader.known_joints(select.joints, target, place)
    result: dict[str, JointChoice] = {}
    for name in target.joint_names if target is not None else select.joints:
        key = (*place, name)
        joint = reader.entry(JointSection, key, select.joints.get(name))
        if joint is None:
            continue
        spring = read_section(SpringChoice, document, (*key, "spring"), problems, defaults, joint.spring)
        damper = read_section(DamperChoice, document, (*key, "damper"), problems, defaults, joint.damper)
        if spring is not None and damper is not None:
            _check_spring(reader, spring, (*key, "spring"))
            if spring.make is not False and spring.part is None and spring.wire is None:
                spring = replace(spring, wire=WIRE)
                defaults.append(Default(f"select.joints.{name}.spring.wire", WIRE, "the strongest common spring wire"))
            result[name] = JointChoice(spring, damper)
    return result


def _check_spring(reader: ProjectReader, spring: SpringChoice, key: Key) -> None:
    """Report contradictory keys."""
    if spring.make and spring.part is not None:
        reader.refuse('"make" and "part" are both given; keep one', key)
    if spring.wire is not None and spring.make is False:
        reader.refuse('"wire" is for a spring to wind, and make is false', (*key, "wire"))
    for least, most, what in (
        (spring.min_outer_diameter, spring.max_outer_diameter, "outer_diameter"),
        (spring.min_body_length, spring.max_body_length, "body_length"),
        (spring.min_wire_diameter, spring.max_wire_diameter, "wire_diameter"),
        (spring.min_inner_diameter, spring.max_outer_diameter, "inner_diameter"),
    ):
        if least is not None and most is not None and least >= most:
            text = (
                f"no spring fits: the limits are above {units.write(least, 'mm')} and below {units.write(most, 'mm')}"
            )
            reader.refuse(text, (*key, f"min_{what}"))
