"""Arguments of the library beside a project: each is checked and overrides the project, or is refused."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from synth.errors import Problem, UserError
from synth.files.project_options import RatePrior
from synth.files.projects import prior_faults
from synth.files.schema import Default
from synth.files.tolerance import JointTolerance, Tolerance
from synth.files.trial_list import Trial
from synth.files.validate import near, raise_if_any
from synth.swing.leg_model import Leg


def refuse_trials(trials: Sequence[Trial], path: Path, function: str) -> None:
    """Refuse trials given beside a project, which has its own.

    Raises
    ------
    UserError
    """
    if trials:
        text = f"the project has its own trials, and {len(trials)} more are given beside it; name them in its file, or "
        raise_if_any([Problem(f"{text}give a leg instead of the project: synth.{function}(leg, trials)", str(path))])


def recordings_of(trials: object, function: str) -> tuple[Trial, ...]:
    """The trials given beside a leg.

    Raises
    ------
    UserError
        If there is none, or something else is among them.
    """
    how = f'synth.{function}(leg, synth.read_trials(["trials/*.csv"], leg))'
    found = tuple(trials) if isinstance(trials, Iterable) and not isinstance(trials, str) else (trials,)
    for trial in found:
        if not isinstance(trial, Trial):
            raise UserError(f"{trial!r:.80} is no recording that was read, but a {type(trial).__name__}: {how}")
    if not found:
        raise UserError(f"no recording is given beside the leg: {how}")
    return found


def require_path(path: object, example: str) -> None:
    """Refuse what is no file's name; ``example`` : the call with one, without ``synth.``.

    Raises
    ------
    UserError
    """
    if not isinstance(path, str | PathLike):
        raise UserError(f"{path!r:.80} is no file's name: synth.{example}")
    if not str(path).strip():
        raise UserError(f"the file's name is empty: synth.{example}")


def require_project(what: object, function: str) -> None:
    """Refuse what is neither a project's file nor a leg.

    Raises
    ------
    UserError
    """
    if not isinstance(what, (str, Path)):
        text = f"{what!r:.80} is neither a project's file nor a leg: synth.{function}('project.yaml'), or "
        raise UserError(f"{text}synth.{function}(leg, trials)")
    require_path(what, f"{function}('project.yaml')")


def require_fields(given: Mapping[str, object], of: type[Any], path: Path, key: str) -> None:
    """Refuse names that are no field of a dataclass of options.

    Raises
    ------
    UserError
        With every such name, and a similar one.
    """
    known = [item.name for item in fields(of)]
    unknown = [name for name in given if name not in known]
    raise_if_any([Problem(f'"{name}" is not allowed{near(name, known)}', str(path), key=key) for name in unknown])


def require_known(tolerance: Tolerance, leg: Leg, path: Path) -> None:
    """Refuse tolerances of a joint that the leg does not have, or of an unknown quantity.

    Raises
    ------
    UserError
        With every such name.
    """
    quantities, problems = [item.name for item in fields(JointTolerance)], []
    for name, own in tolerance.joints.items():
        key = f"tolerance.{name}"
        if name not in leg.joint_names:
            text = f'"{name}" is no joint of {leg.name}{near(name, leg.joint_names)}'
            problems.append(Problem(text, str(path), key=key))
        for quantity in own:
            if quantity not in quantities:
                text = f'"{quantity}" has no tolerance{near(quantity, quantities)}'
                problems.append(Problem(text, str(path), key=f"{key}.{quantity}"))
    raise_if_any(problems)


def require_values(prior: RatePrior, leg: Leg, path: Path) -> None:
    """Refuse a prior on a value that no joint of the leg has.

    Raises
    ------
    UserError
    """
    raise_if_any([Problem(text, str(path), key=f"prior.{key}") for key, text in prior_faults(prior, leg)])


def not_overridden(defaults: Sequence[Default], keys: Container[str]) -> tuple[Default, ...]:
    """The defaults of a project's file of which neither section nor key is among the overridden ``keys``."""
    return tuple(
        default for default in defaults if default.key.partition(".")[0] not in keys and default.key not in keys
    )
