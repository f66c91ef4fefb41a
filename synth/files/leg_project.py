"""The project file of ``synth leg``: source motion, target links, and part choices."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from synth import units
from synth.errors import UserError
from synth.files.fit_words import FreeAngle, Release
from synth.files.leg_choices import SelectSection, read_joint_choices, read_parts_options
from synth.files.leg_file import PartResolver
from synth.files.measured_parts import (
    Entries,
    MeasuredDamper,
    read_measured_dampers,
    read_measured_springs,
)
from synth.files.named_files import InputFile, ProjectReader
from synth.files.names import mixed_files
from synth.files.project_options import (
    CadOptions,
    DamperShape,
    FitOptions,
    JointChoice,
    MeasuredSpring,
    PartsOptions,
)
from synth.files.schema import Because, Default
from synth.files.tolerance import Tolerance, of_links, read_tolerance
from synth.files.trial_list import Trial
from synth.files.validate import Title, gathering
from synth.files.wanted_section import WantedCharacteristics, read_wanted
from synth.files.yaml_lines import Key
from synth.swing.leg_model import Leg
from synth.swing.mechanics import froude_time_scale

# The user's catalogue files -> a function that looks up parts in them and in the built-in ones.
CatalogueOpener = Callable[[Sequence[Path]], PartResolver]
NO_MOTION = 'needs "trials" (recordings), or "wanted" (each joint\'s characteristics)'


@dataclass(frozen=True, eq=False)
class LegProject:
    """The input of ``synth leg``.

    Parameters
    ----------
    time_scale
        how many times slower the robot moves than the animal; ``dynamic_similarity``: it is the square root of
        the ratio of leg lengths instead of a number in the file.
    parts
        restrictions of the parts, and the allowed departure of the response.
    joints
        the choice for every joint of the target.
    dampers
        measured dampers by joint.
    measured_springs
        measurements of the available springs, by joint.
    defaults
        values that the file omits, for the report.
    tolerance
        uncertainty of the links in the source's and target's leg files, joint by joint.
    wanted
        characteristics of the source's motion instead of trials; ``wanted_shown`` the characteristics achieved,
        ``wanted_legs`` those that show them, and ``messages`` a sentence on each that differs, once
        ``fit.wanted_motion`` has made the trial.
    release
        ``free``: the driven beginning of the source's recordings is cut; ``recorded``: all samples are fitted.
    """

    path: Path
    name: str
    source: Leg
    trials: tuple[Trial, ...]
    time_scale: float
    dynamic_similarity: bool
    target: Leg
    free_angle: FreeAngle
    fit: FitOptions
    catalogs: tuple[Path, ...]
    joints: Mapping[str, JointChoice]
    dampers: Mapping[str, MeasuredDamper]
    cad: CadOptions
    defaults: tuple[Default, ...]
    inputs: tuple[InputFile, ...]
    parts: PartsOptions = field(default_factory=PartsOptions)
    measured_springs: Mapping[str, MeasuredSpring] = field(default_factory=dict)
    tolerance: Tolerance = field(default_factory=Tolerance)
    release: Release = "free"
    wanted: Mapping[str, WantedCharacteristics] = field(default_factory=dict)
    wanted_shown: Mapping[str, Any] = field(default_factory=dict)
    wanted_legs: tuple[Leg, ...] = ()
    messages: tuple[str, ...] = ()


@dataclass(frozen=True)
class _LegDesignFile:
    kind: str
    source: Annotated[Any, Field(examples=["{leg: rat/rat.leg.yaml, trials: [rat/releases/*.csv]}"])]
    target: Annotated[str, Field(examples=["dog/dog.leg.yaml"])]
    release: Annotated[Release, Because("the driven beginning of a recording is not free motion and is cut")] = "free"
    name: Title | None = None
    scale: Any = None
    free_angle: Annotated[
        FreeAngle, Because("the data decide whether each trial has its own"), Field(examples=["per_trial"])
    ] = "auto"
    fit: Any = None
    tolerance: Any = None
    select: Any = None
    dampers: Any = None
    cad: Any = None
    measured: Any = None


@dataclass(frozen=True)
class _SourceSection:
    leg: Annotated[str, Field(examples=["rat/rat.leg.yaml"])]
    trials: Entries | None = None
    wanted: Any = None


@dataclass(frozen=True)
class _Scale:
    time: Annotated[Any, Field(examples=["froude"]), Because("the motion keeps the animal's time scale")] = 1.0


def read_leg_project(path: str | Path, *, open_catalogue: CatalogueOpener | None = None) -> LegProject:
    """Read a project of kind ``leg-design`` with its legs and trials.

    Parameters
    ----------
    path
        the YAML file; everything that it names lies in its folder's tree.
    open_catalogue
        given the user's catalogue files, returns the function that looks up parts of a leg file, see ``read_leg``.

    Raises
    ------
    UserError
        With every mistake of the project, its legs, trials and curves.
    """
    reader = ProjectReader.open(path, "leg-design")
    written = reader.written
    file, select = reader.section(_LegDesignFile), reader.section(SelectSection, "select")
    catalogs = reader.matched(select.catalogs, ("select", "catalogs")) if select is not None else ()
    if open_catalogue is not None and not reader.problems:
        with gathering(reader.problems):
            reader.resolve_part = open_catalogue(catalogs)
    source, trials, wanted = _source(reader, written.get("source"))
    target = reader.leg(file.target, ("target",)) if file is not None else None
    scale = _time_scale(reader, source, target)
    if source is not None and target is not None and source.joint_names != target.joint_names:
        names = [", ".join(leg.joint_names) for leg in (source, target)]
        reader.refuse(
            f"the target's joints are {names[1]}, the source's {names[0]}; they must be the same", ("target",)
        )
    mixed = mixed_files(target.joint_names) if target is not None else None
    if mixed is not None:
        reader.refuse(mixed, ("target",))
    fit = reader.section(FitOptions, "fit")
    tolerance = read_tolerance(reader, target)
    parts = read_parts_options(reader, select, written.get("select"))
    joints = read_joint_choices(reader, select, target)
    dampers = read_measured_dampers(reader, written.get("dampers"), target)
    cad = with_damper_shapes(reader, reader.section(CadOptions, "cad"), target)
    measured = read_measured_springs(reader, target)
    reader.finish()
    assert file is not None
    assert source is not None
    assert target is not None
    assert fit is not None
    assert cad is not None
    assert tolerance is not None
    return LegProject(
        path=reader.document.path,
        name=file.name or target.name,
        source=source,
        trials=trials,
        time_scale=scale,
        dynamic_similarity=isinstance(written.get("scale"), dict) and written["scale"].get("time") == "froude",
        target=target,
        free_angle=file.free_angle,
        fit=fit,
        catalogs=catalogs,
        joints=joints,
        dampers=dampers,
        cad=cad,
        defaults=tuple(of_links(reader.defaults)),
        inputs=tuple(reader.inputs),
        parts=parts,
        measured_springs=measured,
        tolerance=tolerance,
        release=file.release,
        wanted=wanted,
    )


def with_damper_shapes(reader: ProjectReader, cad: CadOptions | None, target: Leg | None) -> CadOptions | None:
    """``cad: {dampers: {JOINT: {...}}}`` read and checked."""
    if cad is None or not cad.dampers:
        return cad
    place: Key = ("cad", "dampers")
    if target is not None:
        reader.known_joints(cad.dampers, target, place)
    found = {}
    for name, item in cad.dampers.items():
        shape = reader.entry(DamperShape, (*place, name), item)
        if shape is None:
            continue
        if name in cad.damper_shafts and shape.shaft_size is not None:
            reader.refuse("its shaft is given twice: here and under cad.damper_shafts; keep one", (*place, name))
        found[name] = shape
    return replace(cad, dampers=found)


def _source(
    reader: ProjectReader, value: Any
) -> tuple[Leg | None, tuple[Trial, ...], dict[str, WantedCharacteristics]]:
    if value is None:
        return None, (), {}  # reported by the file's own check
    section = reader.entry(_SourceSection, ("source",), value)
    name = value.get("leg") if isinstance(value, dict) else None
    leg = reader.leg(name, ("source", "leg")) if isinstance(name, str) else None
    if leg is None or section is None:
        return leg, (), {}
    if (section.trials is None) == (section.wanted is None):
        both = section.trials is not None
        reader.refuse('"trials" and "wanted" are both given; keep one' if both else NO_MOTION, ("source",))
        return leg, (), {}
    if section.trials is None:
        return leg, (), read_wanted(reader, section.wanted, leg, ("source", "wanted"))
    return leg, reader.trials(section.trials, leg, ("source", "trials")), {}


def _time_scale(reader: ProjectReader, source: Leg | None, target: Leg | None) -> float:
    """The time scale; 1 after a reported mistake."""
    section, key = reader.section(_Scale, "scale"), ("scale", "time")
    if section is None or (section.time == "froude" and (source is None or target is None)):
        return 1.0
    if section.time == "froude" and source is not None and target is not None:
        alike = froude_time_scale(source, target)
        if alike is None:
            weightless = (source if source.gravity == 0.0 else target).name
            reader.refuse(f'"froude" is not allowed: {weightless} has gravity 0; write a factor such as 2', key)
        return alike or 1.0
    if isinstance(section.time, str) and not any(sign.isdigit() for sign in section.time):
        reader.refuse(f'"{section.time}" is not allowed: write a factor such as 2, or froude', key)
        return 1.0
    with gathering(reader.problems, reader.document, key):
        factor = units.parse(section.time, "1")
        if not 1e-3 <= factor <= 1e3:
            raise UserError(f"{section.time} is not allowed: a factor between 0.001 and 1000, or froude")
        return factor
    return 1.0
