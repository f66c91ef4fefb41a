"""The schema class of each key of each kind of file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from synth.files import (
    drive,
    gap_project,
    hopper_gap_project,
    hopper_recordings,
    hopper_sections,
    import_mapping,
    import_project,
    leg_choices,
    leg_keys,
    leg_project,
    measured_parts,
    next_command,
    part_request,
    project_options,
    projects,
    static_points_file,
    tolerance,
    trial_list,
    wanted_section,
)

How = Literal["mapping", "list", "by name"]


@dataclass(frozen=True)
class KeySection:
    """A mapping of a file: ``name`` of its texts, its class, and the sections at its keys.

    ``how`` : as a mapping, in a list, or under names chosen by the user (joints').
    """

    name: str
    schema: type[Any]
    inner: Mapping[str, KeySection] = field(default_factory=dict)
    how: How = "mapping"


def _many(name: str, schema: type[Any], how: How, **inner: KeySection) -> KeySection:
    return KeySection(name, schema, inner, how)


_TIP = KeySection("tip_mass", trial_list.TipMass)
_INPUT = KeySection("input_column", import_project._InputColumn)
_COMMAND = KeySection("command_column", import_project._CommandColumn)
_TRIALS = _many("trial", trial_list.TrialEntry, "list", tip_mass=_TIP)
_TOLERANCE = KeySection("tolerance", tolerance.JointTolerance)
_FIT = KeySection("fit_options", project_options.FitOptions)
_WANTED = _many("wanted", wanted_section.WantedCharacteristics, "by name")
_MOTOR = KeySection("motor", drive.MotorKeys)
_LEG_JOINT = _many(
    "joint",
    leg_keys.JointKeys,
    "list",
    link=KeySection("link", leg_keys.LinkKeys),
    spring=KeySection("spring", leg_keys.SpringKeys),
    damper=KeySection("damper", leg_keys.DamperKeys),
    drive=KeySection("drive", drive.DriveKeys, {"motor": _MOTOR}),
)
_CHOICE = _many(
    "joint_choice",
    leg_choices.JointSection,
    "by name",
    spring=KeySection("spring_choice", project_options.SpringChoice),
    damper=KeySection("damper_choice", project_options.DamperChoice),
)
_SELECT = KeySection(
    "select",
    leg_choices.SelectSection,
    {"joints": _CHOICE, "tolerance": KeySection("part_tolerance", project_options.ToleranceOptions)},
)
_NEXT_COMMAND = KeySection(
    "next_command",
    next_command.NextCommandKeys,
    {"limits": _many("command_limits", next_command.JointLimits, "by name")},
)
_JUMP_TRIALS = _many("jump_trial", hopper_gap_project._JumpEntry, "list")

# kind -> its file; `gap` of a jumping leg has a page of its own.
KINDS: dict[str, KeySection] = {
    "leg": KeySection("leg_file", leg_keys.LegKeys, {"joints": _LEG_JOINT}),
    "fit": KeySection(
        "fit",
        projects._FitFile,
        {
            "trials": _TRIALS,
            "wanted": _WANTED,
            "fit": _FIT,
            "tolerance": _TOLERANCE,
            "prior": KeySection("prior", project_options.RatePrior),
            "static": _many("static", static_points_file._PointEntry, "list"),
        },
    ),
    "gap": KeySection(
        "gap",
        gap_project._GapFile,
        {"trials": _TRIALS, "tolerance": _TOLERANCE, "next_command": _NEXT_COMMAND},
    ),
    "leg-design": KeySection(
        "leg_design",
        leg_project._LegDesignFile,
        {
            "source": KeySection("source", leg_project._SourceSection, {"trials": _TRIALS, "wanted": _WANTED}),
            "scale": KeySection("scale", leg_project._Scale),
            "fit": _FIT,
            "tolerance": _TOLERANCE,
            "select": _SELECT,
            "dampers": _many("measured_damper", measured_parts.DamperSection, "by name"),
            "cad": KeySection("cad", project_options.CadOptions),
            "measured": KeySection(
                "measured",
                measured_parts.MeasuredPartsSection,
                {"spring": _many("measured_spring", project_options.MeasuredSpring, "by name")},
            ),
        },
    ),
    "import": KeySection(
        "import",
        import_project._ImportFile,
        {
            "time": KeySection("clock", import_project._Clock),
            "joints": KeySection(
                "column",
                import_project._Column,
                dict.fromkeys(import_mapping.DRIVEN, _INPUT) | {"command": _COMMAND},
                "by name",
            ),
            "supply": _INPUT,
            "commands": _many("commands", import_project._Commands, "list"),
            "files": _many("foreign_file", import_project._FileEntry, "list"),
        },
    ),
    "hopper-design": KeySection(
        "hopper",
        hopper_sections.HopperFile,
        {
            "leg": KeySection("hopper_leg", hopper_sections.LegSection),
            "laminate": KeySection("laminate", hopper_sections.LaminateSection),
            "flexures": KeySection("flexures", hopper_sections.FlexureSection),
            "contact": KeySection("contact", hopper_sections.ContactSection),
            "motors": KeySection("motors", hopper_sections.MotorSection),
            "lengths": KeySection("lengths", hopper_sections.LengthsSection),
            "tolerance": KeySection("hopper_tolerance", hopper_sections.ToleranceSection),
            "parts": KeySection("hopper_parts", hopper_sections.PartsSection),
        },
    ),
    "gap-of-jumps": KeySection(
        "jump_gap",
        hopper_gap_project._HopperGapFile,
        {"trials": _JUMP_TRIALS, "tolerance": KeySection("jump_tolerance", hopper_gap_project.JumpTolerance)},
    ),
    "hopper-motor": KeySection("run_ups", hopper_recordings._MotorFile),
    "hopper-pull-ups": KeySection(
        "pull_ups", hopper_recordings._PullUpFile, {"trials": _many("pull_up", hopper_recordings._Trial, "list")}
    ),
    "hopper-jumps": KeySection("plate_jumps", hopper_recordings._JumpFile),
    "part-wish": KeySection(
        "part_wish",
        part_request._RequestFile,
        {
            "spring": KeySection("spring_choice", part_request.RequestedSpring),
            "damper": KeySection("damper_choice", part_request.RequestedDamper),
        },
    ),
}


def kind_word(kind: str) -> str:
    """The word after ``kind:`` in such a file."""
    return "gap" if kind == "gap-of-jumps" else kind


def sections(section: KeySection) -> dict[str, KeySection]:
    """The section and all nested ones by name, once each."""
    found = {section.name: section}
    for inner in section.inner.values():
        found |= sections(inner)
    return found
