"""The project file of ``synth leg``: an animal's motion, the robot's links, and what to choose from."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from synth import units
from synth.errors import UserError
from synth.files.curve import read_curve
from synth.files.fit_words import FreeAngle
from synth.files.leg_file import PartResolver
from synth.files.named_files import InputFile, ProjectReader
from synth.files.names import mixed_files
from synth.files.paths import inside
from synth.files.project_options import (
    CadOptions,
    DamperChoice,
    DamperShape,
    FitOptions,
    JointChoice,
    MeasuredSpring,
    PartsOptions,
    Release,
    SpringChoice,
    ToleranceOptions,
    Turn,
)
from synth.files.schema import Because, Default, read_section
from synth.files.tolerance import Tolerance, of_links, read_tolerance
from synth.files.trial_list import Trial
from synth.files.validate import Title, gathering
from synth.files.wanted_section import WantedCharacteristics, read_wanted
from synth.files.yaml_lines import Key
from synth.swing.leg_model import DamperCurve, Leg

# The user's catalogue files -> what looks parts up in them and in the built-in ones.
CatalogueOpener = Callable[[Sequence[Path]], PartResolver]
WIRE = "music"
NO_MOTION = 'needs "trials" (recordings), or "wanted" (each joint\'s characteristics)'
Entries = Annotated[list[Any], Field(min_length=1, examples=["[trials/*.csv]"])]
Names = Annotated[list[str], Field(examples=["[Lee Spring]"])]


@dataclass(frozen=True)
class MeasuredDamper:
    """What was measured of a joint's damper: its ``curve``, or drops of ``leg`` with that damper alone."""

    part: str | None
    curve: DamperCurve | None
    leg: Leg | None
    trials: tuple[Trial, ...]


@dataclass(frozen=True, eq=False)
class LegProject:
    """What ``synth leg`` is to do.

    Parameters
    ----------
    time_scale
        how many times slower the robot moves than the animal; ``dynamic_similarity`` where it is the square root of
        the ratio of leg lengths rather than a number of the file's.
    parts
        which parts may be chosen at all, and how near the response is wished.
    joints
        what to choose, for every joint of the target.
    dampers
        measured dampers by joint.
    measured_springs
        what was measured of the springs in hand, by joint.
    defaults
        what the file leaves out, for the report.
    tolerance
        what the source's and the target's leg files leave open of their links, joint by joint.
    wanted
        characteristics of the source's motion, in the place of trials; ``wanted_shown`` what comes of them, and
        ``said`` a sentence on each that comes out otherwise, once ``fit.wanted_motion`` has made the trial.
    release
        ``free``: what something drives at first in the source's recordings is cut; ``recorded``: all is fitted.
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
    said: tuple[str, ...] = ()


@dataclass(frozen=True)
class _LegDesignFile:
    kind: str
    source: Annotated[Any, Field(examples=["{leg: rat/rat.leg.yaml, trials: [rat/releases/*.csv]}"])]
    target: Annotated[str, Field(examples=["dog/dog.leg.yaml"])]
    release: Annotated[Release, Because("what a hand or a muscle drives at first is no free swing and is cut")] = "free"
    name: Title | None = None
    scale: Any = None
    free_angle: Annotated[FreeAngle, Because("the data decide whether each trial has its own")] = "auto"
    fit: Any = None
    tolerance: Any = None
    select: Any = None
    dampers: Any = None
    cad: Any = None
    measured: Any = None


@dataclass(frozen=True)
class _MeasuredParts:
    spring: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class _Source:
    leg: Annotated[str, Field(examples=["rat/rat.leg.yaml"])]
    trials: Entries | None = None
    wanted: Any = None


@dataclass(frozen=True)
class _Scale:
    time: Annotated[Any, Because("the motion is taken at the animal's own pace")] = 1.0


@dataclass(frozen=True)
class _Select:
    catalogs: Annotated[list[str], Because("the built-in catalogues only", "none")] = field(default_factory=list)
    joints: dict[str, Any] = field(default_factory=dict)
    vendors: Names = field(default_factory=list)
    without: Names = field(default_factory=list)
    system: Literal["inch", "metric"] | None = None
    within: Annotated[Turn, Because("a tenth of what a leg's joints commonly swing")] = PartsOptions.within
    tolerance: Any = None


@dataclass(frozen=True)
class _Joint:
    spring: Any = None
    damper: Any = None


@dataclass(frozen=True)
class _Damper:
    part: Title | None = None
    curve: str | None = None
    leg: str | None = None
    trials: Entries | None = None
    locked: list[str] = field(default_factory=list)


def read_leg_project(path: str | Path, *, open_catalogue: CatalogueOpener | None = None) -> LegProject:
    """Read a project of kind ``leg-design`` with its legs and trials.

    Parameters
    ----------
    path
        the YAML file; everything that it names lies in its folder's tree.
    open_catalogue
        given the user's catalogue files, returns what looks up parts that a leg file names, see ``read_leg``.

    Raises
    ------
    UserError
        With every mistake of the project, its legs, trials and curves.
    """
    reader = ProjectReader.open(path, "leg-design")
    written = reader.written
    file, select = reader.section(_LegDesignFile), reader.section(_Select, "select")
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
    parts = _parts(reader, select, written.get("select"))
    joints = _joints(reader, select, target)
    dampers = _dampers(reader, written.get("dampers"), target)
    cad = _with_dampers(reader, reader.section(CadOptions, "cad"), target)
    measured = _measured_springs(reader, target)
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


def _with_dampers(reader: ProjectReader, cad: CadOptions | None, target: Leg | None) -> CadOptions | None:
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


def _measured_springs(reader: ProjectReader, target: Leg | None) -> dict[str, MeasuredSpring]:
    """``measured: {spring: {JOINT: {free_angle, rate}}}``: of the springs in hand."""
    section = reader.section(_MeasuredParts, "measured")
    if section is None or target is None:
        return {}
    place: Key = ("measured", "spring")
    reader.known_joints(section.spring, target, place)
    found = {}
    for name, item in section.spring.items():
        measured = reader.entry(MeasuredSpring, (*place, name), item)
        if measured is None or name not in target.joint_names:
            continue
        if measured.free_angle is None and measured.rate is None:
            reader.refuse('needs "free_angle", "rate" or both', (*place, name))
            continue
        found[name] = measured
    return found


def _source(
    reader: ProjectReader, value: Any
) -> tuple[Leg | None, tuple[Trial, ...], dict[str, WantedCharacteristics]]:
    if value is None:
        return None, (), {}  # said by the file's own check
    section = reader.entry(_Source, ("source",), value)
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
    """The factor of time; 1 where a mistake was noted."""
    section = reader.section(_Scale, "scale")
    if section is None or (section.time == "froude" and (source is None or target is None)):
        return 1.0
    if section.time == "froude" and source is not None and target is not None:
        return sqrt(target.total_length / source.total_length)
    key: Key = ("scale", "time")
    if isinstance(section.time, str) and not any(sign.isdigit() for sign in section.time):
        reader.refuse(f'"{section.time}" is not allowed: write a factor such as 2, or froude', key)
        return 1.0
    with gathering(reader.problems, reader.document, key):
        factor = units.parse(section.time, "1")
        if not 1e-3 <= factor <= 1e3:
            raise UserError(f"{section.time} is not allowed: a factor between 0.001 and 1000, or froude")
        return factor
    return 1.0


def _parts(reader: ProjectReader, select: _Select | None, written: Any) -> PartsOptions:
    """What holds for the parts of every joint."""
    if select is None:
        return PartsOptions()
    value = written.get("tolerance") if isinstance(written, dict) else None
    key: Key = ("select", "tolerance")
    tolerance = read_section(ToleranceOptions, reader.document, key, reader.problems, reader.defaults, value)
    return PartsOptions(
        tuple(select.vendors), tuple(select.without), select.system, select.within, tolerance or ToleranceOptions()
    )


def _joints(reader: ProjectReader, select: _Select | None, target: Leg | None) -> dict[str, JointChoice]:
    """A choice for every joint of the target, whether the file names it or not."""
    if select is None:
        return {}
    document, problems, defaults = reader.document, reader.problems, reader.defaults
    place: Key = ("select", "joints")
    if target is not None:
        reader.known_joints(select.joints, target, place)
    result: dict[str, JointChoice] = {}
    for name in target.joint_names if target is not None else select.joints:
        key = (*place, name)
        joint = reader.entry(_Joint, key, select.joints.get(name))
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
    """What contradicts itself."""
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
                f"no spring fits: it asks for more than {units.write(least, 'mm')}, less than {units.write(most, 'mm')}"
            )
            reader.refuse(text, (*key, f"min_{what}"))


def _dampers(reader: ProjectReader, value: Any, target: Leg | None) -> dict[str, MeasuredDamper]:
    if value is None or target is None:
        return {}
    if not isinstance(value, dict):
        reader.refuse(f"{value!r} is not allowed: a mapping {{joint: {{...}}}} is needed", ("dampers",))
        return {}
    reader.known_joints(value, target, ("dampers",))
    result: dict[str, MeasuredDamper] = {}
    for name, item in value.items():
        key: Key = ("dampers", name)
        damper = reader.entry(_Damper, key, item)
        if damper is not None and name in target.joint_names:
            measured = _measured(reader, damper, name, key)
            if measured is not None:
                result[name] = measured
    return result


def _measured(reader: ProjectReader, damper: _Damper, joint: str, key: Key) -> MeasuredDamper | None:
    drops = [name for name in ("leg", "trials") if getattr(damper, name) is not None]
    if damper.curve is not None and drops:
        reader.refuse(f'"curve" and "{drops[0]}" are both given; keep the table or the drops', key)
        return None
    if damper.curve is not None:
        with gathering(reader.problems, reader.document, (*key, "curve")):
            path = inside(reader.folder, damper.curve)
            curve = read_curve(path)
            reader.note(path)
            return MeasuredDamper(damper.part, curve, None, ())
        return None
    if damper.leg is None or damper.trials is None:
        text = 'needs "curve" (a CSV of speed and torque), or "leg" and "trials" (drops with that damper alone)'
        reader.refuse(text, key)
        return None
    leg = reader.leg(damper.leg, (*key, "leg"))
    if leg is None:
        return None
    if joint not in leg.joint_names:
        reader.refuse(f'"{joint}" is no joint of {leg.name}', (*key, "leg"))
        return None
    reader.known_joints(dict.fromkeys(damper.locked), leg, (*key, "locked"))
    if joint in damper.locked:
        reader.refuse(f"{joint} is locked in its own drops: nothing would be seen of its damper", (*key, "locked"))
        return None
    if not set(damper.locked) <= set(leg.joint_names):
        return None
    trials = reader.trials(damper.trials, leg, (*key, "trials"), damper.locked)
    return MeasuredDamper(damper.part, None, leg, trials)
