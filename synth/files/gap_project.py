"""The project file of ``synth gap``, with the nominal leg and the trials of the built one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import radians
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field
from pydantic_core import PydanticCustomError

from synth.errors import Problem, UserError
from synth.files.leg_file import PartResolver
from synth.files.made_in_code import check_values, in_code, number_fault, with_hint
from synth.files.named_files import InputFile, ProjectReader
from synth.files.next_command import NextCommand, read_next_command
from synth.files.schema import Default, Written
from synth.files.tolerance import Tolerance as Tolerance
from synth.files.tolerance import check_tolerance, read_tolerance
from synth.files.trial_list import Trial
from synth.files.validate import Quantity, Title, gathering, near, raise_if_any
from synth.files.yaml_lines import Document
from synth.swing.leg_model import Damper, Leg, Spring
from synth.units import write

NOISE = Quantity("rad", above=0, most=radians(10))  # a sensor that scatters more shows no swing
Angle = Annotated[float, Quantity("rad", least=0, most=radians(90))]


@dataclass(frozen=True)
class _GapFile:
    kind: str
    leg: Annotated[str, Field(examples=["nominal.leg.yaml"])]
    trials: Annotated[list[Any], Field(min_length=1, examples=["[trials/*.csv]"])]
    tolerance: Any = None
    noise: Annotated[
        Any, Field(examples=["{knee: 0.02 deg}"]), Written("mapping of quantities, one key per joint", NOISE)
    ] = None
    accuracy: Annotated[Angle, Field(examples=["0.3 deg"])] = 0.0
    next_command: Any = None
    name: Title | None = None
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0


@dataclass(frozen=True, eq=False)
class GapProject:
    """The input of ``synth gap``: the ``leg`` as designed, and ``trials`` of the built leg.

    Every joint of ``leg`` has a spring and a damper; one that the file omits has rate 0 and is listed in
    ``defaults``, as are omitted tolerances. ``noise`` : joint -> known RMS noise of its sensor,
    rad; ``accuracy`` rad: a smaller gap does not matter, 0 if not given; ``next_command`` : limits of a suggestion.
    """

    path: Path
    name: str
    leg: Leg
    trials: tuple[Trial, ...]
    tolerance: Tolerance
    seed: int
    defaults: tuple[Default, ...]
    inputs: tuple[InputFile, ...]
    noise: Mapping[str, float] = field(default_factory=dict)
    accuracy: float = 0.0
    next_command: NextCommand = field(default_factory=NextCommand)


def check_in_code(project: GapProject) -> None:
    """Check the tolerance, noise, accuracy and seed that code may have set in a project, as its file is checked.

    Raises
    ------
    UserError
        With every value that is not allowed.
    """
    place, problems = in_code(project.path), list[Problem]()
    check_tolerance(project.tolerance, place, problems)
    given = {"kind": "gap", "leg": "in code", "trials": ["in code"], "seed": project.seed}
    check_values(_GapFile, {**given, "accuracy": project.accuracy}, place, (), problems)
    _check_noise(project, place, problems)
    raise_if_any(problems)


def _check_noise(project: GapProject, place: Document, problems: list[Problem]) -> None:
    """Check the noise that code may have set."""
    names = project.leg.joint_names
    for joint, value in project.noise.items():
        key, fault = ("noise", str(joint)), number_fault(value, NOISE.unit)
        if joint not in names:
            problems.append(place.problem(f'"{joint}" is no joint of {project.leg.name}{near(joint, names)}', key))
        elif fault:
            problems.append(place.problem(fault, key))
        else:
            try:
                NOISE.read(write(float(value), NOISE.shown))
            except PydanticCustomError as error:
                problems.append(with_hint(place.problem(error.message(), key)))


def read_gap_project(path: str | Path, *, resolve_part: PartResolver | None = None) -> GapProject:
    """Read a project of kind ``gap`` with its leg and trials.

    Parameters
    ----------
    path
        the YAML file; everything that it names lies in its folder's tree.
    resolve_part
        looks up catalogue parts that the leg file names, see ``read_leg``.

    Raises
    ------
    UserError
        With every mistake of the project, the leg and the trials.
    """
    reader = ProjectReader.open(path, "gap", resolve_part)
    file = reader.section(_GapFile)
    leg, trials = reader.leg_and_trials(other_legs=True)
    tolerance = read_tolerance(reader, leg)
    noise = _noise(reader, None if file is None else file.noise, leg)
    wanted = read_next_command(reader, None if file is None else file.next_command, leg)
    if leg is not None:
        leg = _with_rates(leg, reader)
        trials = tuple(t if t.leg is None else replace(t, leg=_with_rates(t.leg, reader)) for t in trials)
    reader.finish()
    assert file is not None
    assert leg is not None
    assert tolerance is not None
    defaults, inputs = tuple(reader.defaults), tuple(reader.inputs)
    path, name = reader.document.path, file.name or leg.name
    return GapProject(
        path, name, leg, trials, tolerance, file.seed, defaults, inputs, noise, file.accuracy, next_command=wanted
    )


def _noise(reader: ProjectReader, written: Any, leg: Leg | None) -> dict[str, float]:
    """Joint -> RMS noise of its sensor, rad, from ``noise: {knee: 0.02 deg}``."""
    if written is None:
        return {}
    if not isinstance(written, Mapping):
        reader.refuse(f"{written!r} is no mapping of joints: write noise: {{{_one(leg)}: 0.02 deg}}", ("noise",))
        return {}
    if leg is not None:
        reader.known_joints(written, leg, ("noise",))
    found = {}
    for joint, value in written.items():
        try:
            found[str(joint)] = NOISE.read(value)
        except PydanticCustomError as error:
            reader.refuse(error.message(), ("noise", str(joint)))
    return found


def _one(leg: Leg | None) -> str:
    return leg.joint_names[-1] if leg is not None else "knee"


def with_rates(leg: Leg) -> tuple[Leg, tuple[Default, ...]]:
    """The leg with a spring and a damper at every joint, of rate 0 if the file gives none, and these defaults.

    Raises
    ------
    UserError
        For a leg with none at all: it was probably written for ``synth fit``, which estimates them, and
        all effects of springs and dampers would count as unmodelled.
    """
    if all(joint.spring is None and joint.damper is None and joint.drive is None for joint in leg.joints):
        names = ", ".join(leg.joint_names)
        text = f"no joint of {leg.name} ({names}) has a spring or a damper; the designed leg is needed, with the "
        text += 'springs and dampers of the simulation. A joint that swings freely has "damper: {rate: 0 N*m*s/rad}"'
        raise UserError(text)
    joints, defaults = [], []
    for joint in leg.joints:
        if joint.spring is None:
            reason = "the leg file gives no spring: the design has none"
            defaults.append(Default(f"{leg.name}: {joint.name}.spring", "0 N*m/rad", reason))
            joint = replace(joint, spring=Spring(0.0, joint.zero))
        if joint.damper is None:
            reason = "the leg file gives no damper: the design has none, and any drag is an effect"
            defaults.append(Default(f"{leg.name}: {joint.name}.damper", "0 N*m*s/rad", reason))
            joint = replace(joint, damper=Damper(rate=0.0))
        joints.append(joint)
    return replace(leg, joints=tuple(joints)), tuple(defaults)


def _with_rates(leg: Leg, reader: ProjectReader) -> Leg:
    """``with_rates`` with its defaults recorded and its refusal reported."""
    with gathering(reader.problems, reader.document, ("leg",)):
        leg, defaults = with_rates(leg)
        reader.defaults += defaults
    return leg
