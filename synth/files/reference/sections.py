"""Which schema class stands at which key of each kind of file; the classes themselves are the readers' own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from synth.files import (
    drive,
    gap_project,
    hopper_gap_project,
    hopper_project,
    hopper_recordings,
    import_project,
    leg_file,
    leg_project,
    part_wish,
    project_options,
    projects,
    static_points_file,
    tolerance,
    trial_list,
)

How = Literal["mapping", "list", "by name"]


@dataclass(frozen=True)
class Section:
    """A mapping of a file: ``name`` under which its texts stand, its class, and the sections at its keys.

    ``how`` : it stands there itself, in a list, or under names that the user chooses (joints').
    """

    name: str
    schema: type[Any]
    inner: Mapping[str, Section] = field(default_factory=dict)
    how: How = "mapping"


def _many(name: str, schema: type[Any], how: How, **inner: Section) -> Section:
    return Section(name, schema, inner, how)


_TIP = Section("tip_mass", trial_list.TipMass)
_TRIALS = _many("trial", trial_list.TrialEntry, "list", tip_mass=_TIP)
_TOLERANCE = Section("tolerance", tolerance.JointTolerance)
_FIT = Section("fit_options", project_options.FitOptions)
_MOTOR = Section("motor", drive.MotorKeys)
_LEG_JOINT = _many(
    "joint",
    leg_file._Joint,
    "list",
    link=Section("link", leg_file._Link),
    spring=Section("spring", leg_file._Spring),
    damper=Section("damper", leg_file._Damper),
    drive=Section("drive", drive.DriveKeys, {"motor": _MOTOR}),
)
_CHOICE = _many(
    "joint_choice",
    leg_project._Joint,
    "by name",
    spring=Section("spring_choice", project_options.SpringChoice),
    damper=Section("damper_choice", project_options.DamperChoice),
)
_SELECT = Section(
    "select",
    leg_project._Select,
    {"joints": _CHOICE, "tolerance": Section("part_tolerance", project_options.ToleranceOptions)},
)
_JUMP_TRIALS = _many("jump_trial", hopper_gap_project._Entry, "list")

# kind -> its file; `gap` of a jumping leg has a page of its own.
KINDS: dict[str, Section] = {
    "leg": Section("leg_file", leg_file._Leg, {"joints": _LEG_JOINT}),
    "fit": Section(
        "fit",
        projects._FitFile,
        {
            "trials": _TRIALS,
            "fit": _FIT,
            "tolerance": _TOLERANCE,
            "prior": Section("prior", project_options.RatePrior),
            "static": _many("static", static_points_file._Entry, "list"),
        },
    ),
    "gap": Section("gap", gap_project._GapFile, {"trials": _TRIALS, "tolerance": _TOLERANCE}),
    "leg-design": Section(
        "leg_design",
        leg_project._LegDesignFile,
        {
            "source": Section("source", leg_project._Source, {"trials": _TRIALS}),
            "scale": Section("scale", leg_project._Scale),
            "fit": _FIT,
            "tolerance": _TOLERANCE,
            "select": _SELECT,
            "dampers": _many("measured_damper", leg_project._Damper, "by name"),
            "cad": Section("cad", project_options.CadOptions),
            "measured": Section(
                "measured",
                leg_project._MeasuredParts,
                {"spring": _many("measured_spring", project_options.MeasuredSpring, "by name")},
            ),
        },
    ),
    "import": Section(
        "import",
        import_project._ImportFile,
        {
            "time": Section("clock", import_project._Clock),
            "joints": _many("column", import_project._Column, "by name"),
            "files": _many("foreign_file", import_project._Entry, "list"),
        },
    ),
    "hopper-design": Section(
        "hopper",
        hopper_project._HopperFile,
        {
            "leg": Section("hopper_leg", hopper_project.LegSection),
            "laminate": Section("laminate", hopper_project.LaminateSection),
            "flexures": Section("flexures", hopper_project.FlexureSection),
            "contact": Section("contact", hopper_project.ContactSection),
            "motors": Section("motors", hopper_project.MotorSection),
            "lengths": Section("lengths", hopper_project.LengthsSection),
            "tolerance": Section("hopper_tolerance", hopper_project.ToleranceSection),
            "parts": Section("hopper_parts", hopper_project.PartsSection),
        },
    ),
    "gap-of-jumps": Section(
        "jump_gap",
        hopper_gap_project._GapFile,
        {"trials": _JUMP_TRIALS, "tolerance": Section("jump_tolerance", hopper_gap_project.JumpTolerance)},
    ),
    "hopper-motor": Section("run_ups", hopper_recordings._MotorFile),
    "hopper-pull-ups": Section(
        "pull_ups", hopper_recordings._PullUpFile, {"trials": _many("pull_up", hopper_recordings._Trial, "list")}
    ),
    "hopper-jumps": Section("plate_jumps", hopper_recordings._JumpFile),
    "part-wish": Section(
        "part_wish",
        part_wish._WishFile,
        {
            "spring": Section("spring_choice", part_wish.SpringWished),
            "damper": Section("damper_choice", part_wish.DamperWished),
        },
    ),
}


def kind_word(kind: str) -> str:
    """What stands after ``kind:`` in such a file."""
    return "gap" if kind == "gap-of-jumps" else kind


def sections(section: Section) -> dict[str, Section]:
    """The section and all in it by their names, each once."""
    found = {section.name: section}
    for inner in section.inner.values():
        found |= sections(inner)
    return found
