"""The leg file: read into ``synth.swing.leg_model.Leg`` and written back."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from synth import units
from synth.errors import Problem, UserError
from synth.files.curve import read_curve, write_curve
from synth.files.drive import drive_text
from synth.files.leg_keys import DamperKeys, JointKeys, LegKeys, SpringKeys, check_across
from synth.files.output import write_text
from synth.files.paths import inside
from synth.files.validate import ROUNDED, check_kind, check_part, gathering, near, raise_if_any
from synth.files.yaml_lines import Document, Key, load
from synth.swing.drive_needs import BY_TRIALS, drive_needs, lacking, needs_by_file
from synth.swing.effects import OWN_EFFECTS, Effect, registered
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring

# (kind, part) -> a spring's rate in N m/rad, or the damper; UserError where the catalogue has no such part.
PartResolver = Callable[[Literal["spring", "damper"], str], float | Damper]


def read_leg(
    path: str | Path,
    *,
    resolve_part: PartResolver | None = None,
    effects: Sequence[Effect] | None = None,
    opened: Callable[[Path], object] | None = None,
) -> Leg:
    """Read a leg file.

    Parameters
    ----------
    path
        the ``*.leg.yaml``; curve files must lie below its folder.
    resolve_part
        gives the rate of a spring, or the damper, by its catalogue part number; without it a
        ``part`` needs its ``rate`` (or ``curve``) beside it.
    effects
        the effects that a joint may list; None: all registered ones. Changes of a number that the file gives
        anyway (a link's mass, the free angle, the tilt) are not effects here.
    opened
        called with the path of every file that the leg file names and that was read: the results depend on it too.

    Raises
    ------
    UserError
        With every mistake of the file.
    """
    document = load(path)
    check_kind(document, "leg")
    problems: list[Problem] = []
    curve_of = _curve_file(document, opened)
    leg = leg_of(document, problems, resolve_part=resolve_part, effects=effects, curve_of=curve_of)
    problems.sort(key=lambda problem: problem.line or 0)
    raise_if_any(problems)
    assert leg is not None
    return leg


def leg_of(
    document: Document,
    problems: list[Problem],
    *,
    resolve_part: PartResolver | None = None,
    effects: Sequence[Effect] | None = None,
    curve_of: Callable[[str], DamperCurve] | None = None,
) -> Leg | None:
    """The leg that a document describes; mistakes go to ``problems``, and the result is then None.

    ``curve_of`` : gives a damper's curve by its name; None: from a file in the document's folder.
    """
    before = len(problems)
    file = check_part(LegKeys, document, document.value, (), problems)
    raw = document.value.get("joints")
    reader = _Reader(document, resolve_part, effects, problems, curve_of or _curve_file(document))
    items = list(enumerate(raw[:6])) if isinstance(raw, list) else []
    joints = [reader.joint(item, ("joints", index)) for index, item in items]
    base = reader.effects(document.value.get("effects"), ("effects",), where="base")
    check_across(document, problems)
    reader.require_drives(joints)
    if file is None or len(problems) > before:
        return None
    return Leg(file.name, tuple(joint for joint in joints if joint is not None), file.gravity, file.tilt, base)


def _curve_file(document: Document, opened: Callable[[Path], object] | None = None) -> Callable[[str], DamperCurve]:
    """Reads a curve's file, which must lie below the document's folder, and tells ``opened`` its path."""

    def read(name: str) -> DamperCurve:
        path = inside(document.path.parent, name)
        curve = read_curve(path)
        if opened is not None:
            opened(path)
        return curve

    return read


def write_leg(leg: Leg, path: str | Path, *, effects: Sequence[Effect] | None = None) -> None:
    """Write a leg file that ``read_leg`` restores; a damper's curve goes to a separate CSV.

    Angles are written in degrees, lengths in mm, to 15 digits: exact to 1e-14 relative.

    Raises
    ------
    UserError : its folder is missing or cannot be written, or the path is a folder; nothing is written.
    """
    import yaml

    path = Path(path)
    _require_writable(path)
    specifications = _allowed(effects)
    joints = []
    for number, joint in enumerate(leg.joints, start=1):
        link = joint.link
        item: dict[str, Any] = {
            "name": joint.name,
            "zero": units.write(joint.zero, "deg"),
            "sign": int(joint.sign),
        }
        if joint.range is not None:
            item["range"] = [units.write(end, "deg") for end in joint.range]
        item["link"] = {
            "length": units.write(link.length, "mm"),
            "mass": units.write(link.mass, "kg"),
            "com": units.write(link.com, "mm"),
            **({"com_across": units.write(link.com_across, "mm")} if link.com_across else {}),
            "inertia": units.write(link.inertia, "kg*m^2"),
            **({"includes": link.includes} if link.includes != "joint" else {}),
        }
        if joint.armature:
            item["armature"] = units.write(joint.armature, "kg*m^2")
        if joint.spring is not None:
            rate, free_angle = units.write(joint.spring.rate, "N*m/rad"), units.write(joint.spring.free_angle, "deg")
            item["spring"] = {"rate": rate, "free_angle": free_angle} | _part(joint.spring.part)
        if joint.damper is not None:
            item["damper"] = _damper_text(joint.damper, path, number, joint.name)
        if joint.drive is not None:
            item["drive"] = drive_text(joint.drive)
        if joint.effects:
            item["effects"] = [_effect_text(name, joint.effects[name], specifications[name]) for name in joint.effects]
        joints.append(item)
    head = {"kind": "leg", "name": leg.name, "gravity": units.write(leg.gravity, "m/s^2")}
    whole = {**head, "tilt": units.write(leg.tilt, "deg"), "joints": joints}
    if leg.effects:
        whole["effects"] = [_effect_text(name, leg.effects[name], specifications[name]) for name in leg.effects]
    text = yaml.safe_dump(whole, sort_keys=False, default_flow_style=None, allow_unicode=True, width=1000)
    write_text(path, text)


def _require_writable(path: Path) -> None:
    """Refuse a path at which no file can be written."""
    if not path.parent.is_dir():
        raise UserError(Problem(f'no folder "{path.parent}": make it, or write elsewhere', str(path)))
    if path.is_dir():
        raise UserError(Problem("is a folder: add the file's name", str(path)))
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise UserError(Problem("may not be written", str(path)))


def _allowed(effects: Sequence[Effect] | None) -> dict[str, Effect]:
    return {effect.name: effect for effect in _known(effects) if effect.way != "leg"}


def _known(effects: Sequence[Effect] | None) -> Sequence[Effect]:
    return registered() if effects is None else effects


def _elsewhere(name: str, where: str, known: Sequence[Effect]) -> str:
    """Where what an effect changes is written, for one that a place cannot hold; empty if there is no such effect."""
    for effect in known:
        if effect.name == name and effect.way == "leg":
            return f"change {effect.changes or 'the number itself'} instead: this effect is another value of that"
        if effect.name == name and effect.where != where:
            return "write it in `effects:` " + ("beside `joints:`" if where == "joint" else "of a joint")
    return ""


def _part(part: str | None) -> dict[str, str]:
    return {} if part is None else {"part": part}


def _damper_text(damper: Damper, path: Path, number: int, joint: str) -> dict[str, str]:
    if damper.rate is not None:
        return {"rate": units.write(damper.rate, "N*m*s/rad")} | _part(damper.part)
    if damper.curve is None:
        raise ValueError(f"the damper of {joint} has neither a rate nor a curve")
    stem = path.name.removesuffix(".yaml").removesuffix(".leg")
    # The number distinguishes joints whose names differ only in characters that a file name leaves out.
    curve = path.with_name(f"{stem}_{number}_{re.sub(r'[^A-Za-z0-9_-]', '_', joint)}_damper.csv")
    write_curve(damper.curve, curve)
    return {"curve": curve.name} | _part(damper.part)


def _effect_text(name: str, values: Mapping[str, float], specification: Effect) -> dict[str, dict[str, str]]:
    unit = {parameter.name: parameter.unit for parameter in specification.parameters}
    return {name: {parameter: units.write(value, unit[parameter]) for parameter, value in values.items()}}


@dataclass(frozen=True)
class _Reader:
    """Converts checked fields into model objects; continues after a mistake to report all."""

    document: Document
    resolve_part: PartResolver | None
    given: Sequence[Effect] | None
    problems: list[Problem]
    curve_of: Callable[[str], DamperCurve]
    stated: list[tuple[Key, Effect, Mapping[str, float]]] = field(default_factory=list)  # effects, where they stand

    @cached_property
    def specifications(self) -> Mapping[str, Effect]:
        """The effects by name; read when a leg has some, because their laws load the compiler."""
        return _allowed(self.given)

    @cached_property
    def renamed(self) -> Mapping[str, str]:
        """Former name -> name."""
        return {former: effect.name for effect in _known(self.given) for former in effect.former}

    def joint(self, value: object, key: Key) -> Joint | None:
        raw_effects = value.get("effects") if isinstance(value, dict) else None
        effects = self.effects(raw_effects, (*key, "effects"))
        joint = check_part(JointKeys, self.document, value, key, self.problems)
        if joint is None:
            return None
        given = joint.link
        link = Link(given.length, given.mass, given.com, given.inertia, given.includes, given.com_across)
        span = (joint.range[0], joint.range[1]) if joint.range is not None else None
        spring = self.spring(joint.spring, (*key, "spring")) if joint.spring is not None else None
        damper = self.damper(joint.damper, (*key, "damper")) if joint.damper is not None else None
        drive = None
        if joint.drive is not None:
            with gathering(self.problems, self.document, (*key, "drive")):
                drive = joint.drive.drive()
        return Joint(joint.name, link, joint.zero, joint.sign, span, spring, damper, effects, joint.armature, drive)

    def spring(self, spring: SpringKeys, key: Key) -> Spring | None:
        rate: object = spring.rate
        if rate is None and spring.part is not None:
            rate = self.resolve("spring", spring.part, (*key, "part"))
        return Spring(rate, spring.free_angle, spring.part) if isinstance(rate, float) else None

    def damper(self, damper: DamperKeys, key: Key) -> Damper | None:
        if damper.rate is not None:
            return Damper(rate=damper.rate, part=damper.part)
        if damper.curve is not None:
            with gathering(self.problems, self.document, (*key, "curve")):
                return Damper(curve=self.curve_of(damper.curve), part=damper.part)
            return None
        found = self.resolve("damper", damper.part or "", (*key, "part"))
        return found if isinstance(found, Damper) else None

    def resolve(self, kind: Literal["spring", "damper"], part: str, key: Key) -> float | Damper | None:
        if self.resolve_part is None:
            rate = "rate" if kind == "spring" else "rate or curve"
            self.refuse(f'no catalogue is available to look up "{part}": write its {rate} beside it', key)
            return None
        with gathering(self.problems, self.document, key):
            found = self.resolve_part(kind, part)
            if not isinstance(found, float if kind == "spring" else Damper):
                raise TypeError(f"the catalogue gave {found!r} for the {kind} {part!r}")
            return found
        return None

    def effects(self, items: object, key: Key, where: str = "joint") -> dict[str, dict[str, float]]:
        """Effects of one joint, or of the base, from the raw list."""
        result: dict[str, dict[str, float]] = {}
        for index, item in enumerate(items if isinstance(items, list) else []):
            for written, parameters in item.items() if isinstance(item, dict) else ():
                place: Key = (*key, index, written)
                name = self.renamed.get(written, written)
                possible = [known.name for known in self.specifications.values() if known.where == where]
                if name not in possible:
                    there = _elsewhere(name, where, _known(self.given))
                    more = f"; {there}" if there else f" ({OWN_EFFECTS}){near(name, possible)}"
                    self.refuse(f'"{name}" is no effect that a {where} can hold{more}', place)
                elif name in result:
                    self.refuse("is given twice; keep one", place)
                elif isinstance(parameters, dict):
                    result[name] = self.parameters(parameters, self.specifications[name], place)
                    self.stated.append((place, self.specifications[name], result[name]))
        return result

    def require_drives(self, joints: Sequence[Joint | None]) -> None:
        """Refuse effects of a drive, motor or supply which no joint of theirs has, whatever the trials are.

        Not where a joint or its drive has a mistake of its own: it may be the drive that they need.
        """
        given = self.document.value.get("joints")
        read = [joint for joint in joints if joint is not None]
        if not self.stated or len(read) < len(joints) or not isinstance(given, list):
            return
        if any(joint.drive is None and raw.get("drive") is not None for joint, raw in zip(read, given, strict=False)):
            return
        drives = [joint.drive for joint in read]
        at = [needs_by_file(drives, j) for j in range(len(read))]
        for place, effect, values in self.stated:
            there = at[int(place[1])] if place[0] == "joints" else set().union(*at)
            missing = lacking(drive_needs(effect, values), there | BY_TRIALS)
            if missing:
                whose = read[int(place[1])].name if place[0] == "joints" else "the leg"
                text = f'"{effect.name}" needs {missing}, which {whose} lacks; state that in `drive:`, or leave the '
                self.refuse(text + "effect out", place)

    def parameters(self, given: dict[str, object], effect: Effect, key: Key) -> dict[str, float]:
        known = {parameter.name: parameter for parameter in effect.parameters}
        result: dict[str, float] = {}
        for name, value in given.items():
            if name not in known:
                self.refuse(f'"{name}" is no parameter of {effect.name}{near(name, list(known))}', (*key, name))
                continue
            with gathering(self.problems, self.document, (*key, name)):
                result[name] = units.parse(value, known[name].unit)
                if wanted := known[name].wanted(result[name]):
                    raise UserError(f"{value} is not allowed: it must be {wanted}")
        for parameter in effect.parameters:
            if parameter.default is None and parameter.name not in given:
                example = units.MEANINGS.get(parameter.unit, ("", f"1 {parameter.unit}"))[1]
                self.refuse(f'"{parameter.name}" is missing: write it, for example {example}', key)
        self.require_together(given, result, effect, key)
        return result

    def require_together(
        self, given: Mapping[str, object], read: Mapping[str, float], effect: Effect, key: Key
    ) -> None:
        """Refuse parameters that cannot be together: none of those of which one is needed, or ends that cross."""
        if effect.any_of and given.keys().isdisjoint(effect.any_of):
            unit = effect.parameters[effect.index(effect.any_of[0])].unit
            example = units.MEANINGS.get(unit, ("", f"1 {unit}"))[1]
            names = " or ".join(f'"{name}"' for name in effect.any_of)
            self.refuse(f"{names} is missing: write one or more, for example {effect.any_of[0]}: {example}", key)
        for low, high in pairwise(effect.ascending):
            if low in read and high in read and read[low] - read[high] > ROUNDED * abs(read[low]):
                text = f"{given[high]} is not allowed: it must be at least {low}, which is {given[low]}"
                self.refuse(text, (*key, high))

    def refuse(self, text: str, key: Key) -> None:
        self.problems.append(self.document.problem(text, key))
