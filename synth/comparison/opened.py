"""Open the sides of a comparison from result folders, projects, legs and recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import degrees
from typing import Any

from synth.comparison.recorded_sides import followed_by_fit, from_fit, from_gap, from_trials
from synth.comparison.side import (
    MODEL,
    RECORDED,
    ComparedJoint,
    ComparedMotion,
    FollowedMotion,
    Side,
    StatedFigure,
    joints_of,
)
from synth.comparison.side_source import Source
from synth.errors import Problem, UserError
from synth.files.gap_project import read_gap_project
from synth.files.leg_file import PartResolver, read_leg
from synth.files.made_in_code import in_code
from synth.files.projects import read_fit_project
from synth.files.result_values import read_design, read_fit, read_result
from synth.files.trial_in_code import checked_trials
from synth.files.trial_list import read_trials
from synth.swing.leg_model import Leg

Opener = Callable[[Source, PartResolver], list[Side]]


def open_sides(
    sources: Sequence[Source],
    resolve_part: PartResolver,
    *,
    leg: Leg | None = None,
    time_scales: Sequence[float] = (),
) -> list[Side]:
    """Every requested side, in order.

    Parameters
    ----------
    leg
        leg of recordings without one; None: the first leg among the other arguments.
    time_scales
        for leg-design projects: the wanted leg at each of these time scales as well.

    Raises
    ------
    UserError
        If a source cannot be read, legs have different joints, recordings have no leg, or ``leg`` is given and
        there are none.
    """
    if leg is not None and not any(source.kind == "trials" for source in sources):
        text = f"the leg {leg.name} is given for recordings (--leg), but no argument is a recording without a leg: "
        raise UserError(f"{text}results, projects and leg files have their own; leave it out")
    sides: list[list[Side]] = [[] for _ in sources]
    for place, source in enumerate(sources):
        if source.kind == "leg-design project":
            from synth.comparison.time_scales import scaled_sides

            sides[place] = scaled_sides(source, time_scales)
        elif source.kind != "trials":
            sides[place] = OPENERS[source.kind](source, resolve_part)
    known = leg or next((side.leg for found in sides for side in found), None)
    for place, source in enumerate(sources):
        if source.kind == "trials":
            if known is None:
                text = "recordings need a leg that defines their angles: --leg FILE.leg.yaml"
                raise UserError(Problem(text, source.written))
            sides[place] = [_trials(source, known)]
    every = [side for found in sides for side in found]
    _require_same_joints(every)
    _require_own_names(every)
    return every


def _leg(source: Source, resolve_part: PartResolver) -> list[Side]:
    leg = read_leg(source.path, resolve_part=resolve_part)
    return [Side(source.named("leg"), source.written, MODEL, leg, joints_of(leg), reads=True)]


def _trials(source: Source, leg: Leg) -> Side:
    folder, pattern = (source.path, "*.csv") if source.path.is_dir() else (source.path.parent, source.path.name)
    if source.trials:
        trials = checked_trials(source.trials, leg, in_code(source.path), own_legs=True)
    else:
        trials = tuple(read_trials([pattern], folder, leg))
    motions = from_trials(leg, trials)
    return Side(source.named("recorded"), source.written, RECORDED, leg, {}, motions)


def _fit(source: Source, resolve_part: PartResolver) -> list[Side]:
    folder = source.path
    fit = read_fit(folder / "fit.json")
    leg = read_leg(folder / "fitted.leg.yaml", resolve_part=resolve_part)
    stated = tuple(StatedFigure(f"{name}: residual RMS", value) for name, value in fit["rms"].items())
    motions = from_fit(folder, leg, fit, "responses/source", "measured")

    def fitted(view: str) -> Side:
        followed = followed_by_fit(folder, leg, fit, motions)
        return replace(_model(source, view, leg, fit["joints"], stated), followed=followed)

    return _asked(source, recorded=lambda view: _recorded(source, view, leg, motions), fitted=fitted)


def _gap(source: Source, resolve_part: PartResolver) -> list[Side]:
    folder = source.path
    gap = read_result(folder / "gap.json", "gap", ("gap", "trials"))
    explained = read_leg(folder / "diagnosed.leg.yaml", resolve_part=resolve_part)
    if "designed" in source.views and not (folder / "designed.leg.yaml").is_file():
        text = "has no designed.leg.yaml; run synth gap again, or append #recorded,explained to the folder"
        raise UserError(Problem(text, str(folder)))
    figures = gap["gap"]

    def of(key: str, what: str) -> tuple[StatedFigure, ...]:
        return (StatedFigure(f"RMS error on the scored recordings, {what}", figures[key]),) if key in figures else ()

    def designed(view: str) -> Side:
        leg = read_leg(folder / "designed.leg.yaml", resolve_part=resolve_part)
        return _model(source, view, leg, {}, of("as_designed", "as designed"), reads=True)

    def recorded(view: str) -> Side:
        return Side(
            source.named(view), source.written, RECORDED, explained, {}, from_gap(folder, explained, gap),
            of("noise_floor", "the sensors' noise"),
        )  # fmt: skip

    after = of("after", "explained")
    return _asked(source, recorded=recorded, designed=designed,
                  explained=lambda view: _model(source, view, explained, {}, after, reads=True))  # fmt: skip


def _design(source: Source, resolve_part: PartResolver) -> list[Side]:
    folder = source.path
    design = read_design(folder / "design.json")
    wanted = read_leg(folder / "wanted.leg.yaml", resolve_part=resolve_part)
    built = read_leg(folder / "built.leg.yaml", resolve_part=resolve_part)
    target, response = design["stages"]["target"], design["response"]
    scale = float(design["settings"]["time_scale"]["value"])
    slow = from_fit(folder, wanted, target, "responses/target", "animal")
    motions = tuple(motion.stretched(1.0 / scale) for motion in slow)
    stated = [StatedFigure("predicted RMS from the wanted motion, nominal parts", response["wanted_to_built"]["rms"])]
    for key, what in (("forecast", "with tolerances"), ("forecast_free_angles_measured", "free angles measured")):
        if response.get(key):
            stated.append(StatedFigure(f"predicted RMS, {what}", response[key]["expected"]))

    def shown(view: str) -> Side:
        side = _model(source, view, built, {}, tuple(stated))
        return replace(
            side, joints={name: _with_parts(side.joints[name], design["joints"][name]) for name in side.joints}
        )

    return _asked(source, animal=lambda view: replace(_recorded(source, view, wanted, motions), stretch=scale),
                  wanted=lambda view: _model(source, view, wanted, target["joints"], ()), built=shown)  # fmt: skip


def _with_parts(joint: ComparedJoint, written: Mapping[str, Any]) -> ComparedJoint:
    """A built joint with its bought or wound part."""
    spring, damper = written["spring"], written["damper"]
    make = spring.get("make")
    part = _wound(make) if make else spring.get("part") or ""
    count = int((make or spring).get("count") or 1)
    part = f"{count} x {part}" if part and count > 1 else part
    laws = {"curve": "measured curve", "linear": ""}
    law = laws.get(str(damper.get("law")), f"{damper.get('law')} curve") if damper.get("law") else joint.damper_law
    return replace(joint, spring_part=part, damper_part=str(damper.get("arrangement") or ""), damper_law=law)


def _wound(make: Mapping[str, Any]) -> str:
    """How a spring is wound, with the coils of its body as the bill of materials counts them."""
    wire, coils = make["wire_diameter"], make["body_coils"]["value"]
    return f"wind {wire['value']:.4g} {wire['unit']} {make['material']}, {coils:.4g} coils"


def _fit_project(source: Source, resolve_part: PartResolver) -> list[Side]:
    """A project that is fitted here, within seconds."""
    from synth.batch.one_fit import fit_project, ready

    project = ready(read_fit_project(source.path, resolve_part=resolve_part))
    motions = from_trials(project.project.leg, project.project.trials)

    def fitted(view: str) -> Side:
        result = fit_project(project)
        known = {name: joint.as_json() for name, joint in result.joints.items()}
        stated = tuple(
            StatedFigure(f"{name}: residual RMS", {"value": degrees(value), "unit": "deg"})
            for name, value in result.rms.items()
        )
        own = {trial.name: result.leg.to_rotation(trial.fitted) for trial in result.trials}
        followed = (FollowedMotion(motion, own[motion.name]) for motion in motions if motion.name in own)
        side = _model(source, view, result.leg, known, stated)
        return replace(side, followed=tuple(followed) if result.free_angle == "per_trial" else ())

    leg = project.project.leg
    return _asked(source, fitted=fitted,
                  recorded=lambda view: _recorded(source, view, leg, motions))  # fmt: skip


def _gap_project(source: Source, resolve_part: PartResolver) -> list[Side]:
    """The recordings and the designed leg, without a diagnosis."""
    project = read_gap_project(source.path, resolve_part=resolve_part)
    own = tuple(trial for trial in project.trials if trial.leg is None)
    motions = from_trials(project.leg, own)
    return _asked(
        source,
        recorded=lambda view: _recorded(source, view, project.leg, motions),
        designed=lambda view: _model(source, view, project.leg, {}, (), reads=True),
    )


OPENERS: Mapping[str, Opener] = {
    "leg": _leg,
    "fit": _fit,
    "gap": _gap,
    "design": _design,
    "fit project": _fit_project,
    "gap project": _gap_project,
}


def _asked(source: Source, **views: Callable[[str], Side]) -> list[Side]:
    """The requested views; others are not computed."""
    return [views[view](view) for view in source.views]


def _recorded(source: Source, view: str, leg: Leg, motions: tuple[ComparedMotion, ...]) -> Side:
    return Side(source.named(view), source.written, RECORDED, leg, {}, motions)


def _model(
    source: Source,
    view: str,
    leg: Leg,
    known: Mapping[str, Mapping[str, Any]],
    stated: tuple[StatedFigure, ...],
    *,
    reads: bool = False,
) -> Side:
    return Side(source.named(view), source.written, MODEL, leg, joints_of(leg, known), stated=stated, reads=reads)


def _require_same_joints(sides: Sequence[Side]) -> None:
    first = sides[0]
    for side in sides[1:]:
        if side.leg.joint_names != first.leg.joint_names:
            text = f"its joints are {', '.join(side.leg.joint_names)}; those of {first.source} are "
            text += f"{', '.join(first.leg.joint_names)}: only legs with the same joints can be compared"
            raise UserError(Problem(text, side.source))


def _require_own_names(sides: Sequence[Side]) -> None:
    names = [side.name for side in sides]
    for side in sides:
        if names.count(side.name) > 1:
            path = side.source.partition("=")[2] or side.source
            text = f'two sides are called "{side.name}"; name them: new={path}'
            raise UserError(Problem(text, side.source))
