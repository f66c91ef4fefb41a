"""The project file of ``synth fit``, with its leg and trials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from synth.errors import Problem
from synth.files.fit_words import FreeAngle, Laws, Release
from synth.files.leg_file import PartResolver
from synth.files.leg_project import LegProject, read_leg_project
from synth.files.made_in_code import check_section, check_values, in_code
from synth.files.named_files import InputFile, ProjectReader
from synth.files.project_options import FitOptions, RatePrior
from synth.files.schema import Because, Default
from synth.files.static_points_file import StaticPoint, read_static_points
from synth.files.tolerance import Tolerance, check_tolerance, of_links, read_tolerance
from synth.files.trial_list import Trial
from synth.files.validate import Title, raise_if_any
from synth.files.wanted_section import WantedCharacteristics, read_wanted
from synth.swing.leg_model import Leg

__all__ = ["FitProject", "LegProject", "read_fit_project", "read_leg_project"]

NO_MOTION = (
    '"trials" is missing: write it, for example trials: [trials/*.csv], or state characteristics under "wanted:"'
)


@dataclass(frozen=True)
class _FitFile:
    kind: str
    leg: Annotated[str, Field(examples=["rat.leg.yaml"])]
    free_angle: Annotated[
        FreeAngle, Because("the data decide whether each trial has its own"), Field(examples=["per_trial"])
    ] = "auto"
    release: Annotated[Release, Because("the driven beginning of a recording is not free motion and is cut")] = "free"
    laws: Annotated[
        Laws, Because("dry friction, quadratic damping or a cubic spring is added where it explains the motion")
    ] = "auto"
    trials: Annotated[list[Any] | None, Field(min_length=1, examples=["[trials/*.csv]"])] = None
    wanted: Any = None
    name: Title | None = None
    fit: Any = None
    tolerance: Any = None
    prior: Any = None
    static: Any = None


@dataclass(frozen=True, eq=False)
class FitProject:
    """The input of ``synth fit``.

    ``prior`` None: values in the leg file are only starting points. ``defaults``: values that the file omits.
    ``static``: poses in which the leg was held still, see ``static_points``. ``tolerance``: uncertainty of the
    leg file's links. ``wanted``: joint -> characteristics of a motion instead of trials. ``release``: ``free``:
    the driven beginning is cut; ``recorded``: all samples are fitted. ``laws``: ``auto``: dry friction, quadratic
    damping or a cubic spring is added where it explains the motion; ``linear``: never.
    """

    path: Path
    name: str
    leg: Leg
    trials: tuple[Trial, ...]
    free_angle: FreeAngle
    fit: FitOptions
    prior: RatePrior | None
    defaults: tuple[Default, ...]
    inputs: tuple[InputFile, ...]
    static: tuple[StaticPoint, ...] = ()
    tolerance: Tolerance = field(default_factory=Tolerance)
    release: Release = "free"
    wanted: Mapping[str, WantedCharacteristics] = field(default_factory=dict)
    laws: Laws = "auto"


def read_fit_project(path: str | Path, *, resolve_part: PartResolver | None = None) -> FitProject:
    """Read a project of kind ``fit`` with its leg and trials.

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
    reader = ProjectReader.open(path, "fit", resolve_part)
    document, written = reader.document, reader.written
    file = reader.section(_FitFile)
    fit = reader.section(FitOptions, "fit")
    prior = None
    if written.get("prior") is not None:
        prior = reader.entry(RatePrior, ("prior",), written["prior"])
    leg, trials = reader.leg_and_trials()
    wanted = read_wanted(reader, written["wanted"], leg) if "wanted" in written else {}
    if ("wanted" in written) == ("trials" in written):
        text = '"trials" and "wanted" are both given; keep one' if "wanted" in written else NO_MOTION
        reader.refuse(text, ("wanted",) if "wanted" in written else ())
    if leg is not None and prior is not None:
        for key, text in prior_faults(prior, leg):
            reader.refuse(text, ("prior", key))
    static: tuple[StaticPoint, ...] = ()
    if leg is not None and "static" in written:
        static = read_static_points(written["static"], leg, document, ("static",), reader.problems)
    tolerance = read_tolerance(reader, leg)
    reader.finish()
    assert file is not None
    assert tolerance is not None
    assert leg is not None
    assert fit is not None
    defaults, inputs = tuple(of_links(reader.defaults)), tuple(reader.inputs)
    name = file.name or leg.name
    return FitProject(
        document.path, name, leg, trials, file.free_angle, fit, prior, defaults, inputs, static, tolerance,
        file.release, wanted, file.laws,
    )  # fmt: skip


def check_in_code(project: FitProject) -> None:
    """Check what code may have set in a project, as its file is checked.

    Raises
    ------
    UserError
        With every word and number that is not allowed.
    """
    place, problems = in_code(project.path), list[Problem]()
    words = {name: getattr(project, name) for name in ("free_angle", "release", "laws")}
    check_values(_FitFile, {"kind": "fit", "leg": "in code", **words}, place, (), problems)
    check_section(FitOptions, project.fit, place, ("fit",), problems)
    if project.prior is not None:
        check_section(RatePrior, project.prior, place, ("prior",), problems)
    check_tolerance(project.tolerance, place, problems)
    raise_if_any(problems)


def prior_faults(prior: RatePrior, leg: Leg) -> list[tuple[str, str]]:
    """Key and text of each value that the prior is on and no joint of the leg has."""
    has_spring = any(joint.spring is not None for joint in leg.joints)
    has_damper = any(joint.damper is not None and joint.damper.rate is not None for joint in leg.joints)
    return [
        (key, f"no joint of {leg.name} has a {what} in its file that a prior could rest on")
        for key, asked, given, what in (
            ("spring", prior.spring, has_spring, "spring"),
            ("free_angle", prior.free_angle, has_spring, "spring"),
            ("damper", prior.damper, has_damper, "damper rate"),
        )
        if asked is not None and not given
    ]
