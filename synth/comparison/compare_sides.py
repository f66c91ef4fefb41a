"""Compare sides: the result, its JSON and its table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import synth
from synth.arrays import Array
from synth.comparison.overlay import Difference, OverlaidMotion, Overlay, chosen_starts, differences, is_read, overlaid
from synth.comparison.shown_characteristics import UNITS, JointAlone, Shown, alone, shown
from synth.comparison.side import MODEL, ComparedMotion, Side
from synth.errors import UserError
from synth.files.validate import near
from synth.remarks import noted, remarks_json
from synth.swing.leg_model import Leg
from synth.swing.readings import stated_readings
from synth.units import quantity, significant

FORMAT = "synth/compare/1"
UNEQUAL = 1.0  # deg, distance of two starts that is worth a note: ten times a usual sensor's noise
FEWEST, MOST = 2, 8  # sides; more curves make a picture unreadable


@dataclass(frozen=True)
class Comparison:
    """Compared sides, with angles in the first side's measured convention.

    ``starts_of``: the side that provides the starts; ``reference``: the side that the others are compared with;
    ``characteristics``, ``alone``: one entry per side.
    """

    sides: tuple[Side, ...]
    reference: int
    starts_of: str
    overlays: tuple[Overlay, ...]
    differences: tuple[Difference, ...]
    characteristics: tuple[Shown, ...]
    alone: tuple[Mapping[str, JointAlone], ...]
    inputs: Mapping[str, str]

    @property
    def clock(self) -> str:
        """The words for the time of the overlaid motions."""
        return "time / time scale" if any(side.pace != 1.0 for side in self.sides) else "time"

    @property
    def leg(self) -> Leg:
        """The leg whose zeros and signs define the angles."""
        return self.sides[0].leg

    def off_reference(self, place: int) -> Difference | None:
        """The difference between a side and the reference; None for the reference itself."""
        for found in self.differences:
            if {found.a, found.b} == {place, self.reference} and place != self.reference:
                return found
        return None

    def as_json(self) -> dict[str, Any]:
        """The content of ``compare.json``."""
        return {
            "format": FORMAT,
            "joints": list(self.leg.joint_names),
            "reference": self.sides[self.reference].name,
            "starts_of": self.starts_of,
            "sides": [self._side_json(place) for place in range(len(self.sides))],
            "starts": [self._start_json(overlay) for overlay in self.overlays],
            "differences": [self._difference_json(found) for found in self.differences],
            **remarks_json(warnings(self)),
            "inputs": dict(self.inputs),
            "versions": {"synth": synth.__version__},
        }

    def _side_json(self, place: int) -> dict[str, Any]:
        side, off = self.sides[place], self.off_reference(place)
        written = {
            "name": side.name,
            "source": side.source,
            "kind": side.kind,
            "leg": side.leg.name,
            "recordings": len(side.motions),
            "joints": {name: joint.as_json() for name, joint in side.joints.items()},
            "characteristics": {
                name: {key: spread.as_json(UNITS[key]) for key, spread in found.items()}
                for name, found in self.characteristics[place].joints.items()
            },
            "alone": {name: found.as_json() for name, found in self.alone[place].items()},
            "stated": [{"what": figure.what, "value": dict(figure.value)} for figure in side.stated],
        }
        if side.pace != 1.0 or any(other.pace != 1.0 for other in self.sides):
            written["pace"] = quantity(side.pace, "1")
        if side.stretch != 1.0:
            written["slowed"] = quantity(side.stretch, "1")
        if off is not None:
            written["off_reference"] = self._difference_json(off)
        return written

    def _start_json(self, overlay: Overlay) -> dict[str, Any]:
        start, leg = overlay.start, self.leg
        angles, rates = leg.to_measured(start.start), leg.sign * start.rate
        return {
            "name": start.name,
            "angle": {n: quantity(float(v), "deg") for n, v in zip(leg.joint_names, angles, strict=True)},
            "rate": {n: quantity(float(v), "deg/s") for n, v in zip(leg.joint_names, rates, strict=True)},
            **start.conditions.as_json(leg.joint_names),
            "recordings": {
                side.name: _recording_json(motion)
                for side, motion in zip(self.sides, overlay.motions, strict=True)
                if motion is not None and motion.recording
            },
            "left_out": {side.name: why for side, why in zip(self.sides, overlay.why, strict=True) if why},
        }

    def _difference_json(self, found: Difference) -> dict[str, Any]:
        names = self.leg.joint_names
        return {
            "of": self.sides[found.b].name,
            "from": self.sides[found.a].name,
            "basis": found.basis,
            "starts": found.starts,
            "rms": {n: quantity(float(v), "deg") for n, v in zip(names, found.rms, strict=True) if np.isfinite(v)},
            **({"overall": quantity(found.overall, "deg")} if np.isfinite(found.overall) else {}),
        }


def _recording_json(motion: OverlaidMotion) -> dict[str, Any]:
    away = motion.away
    angle, rate, distance = (0.0,) * 3 if away is None else (away.angle.max(), away.rate.max(), away.distance)
    return {
        "file": motion.recording,
        "starts_away": quantity(float(angle), "deg"),
        "starts_away_in_rate": quantity(float(rate), "deg/s"),
        "starts_away_together": quantity(float(distance), "deg"),
    }


def compare(
    sides: Sequence[Side],
    *,
    reference: str | None = None,
    stretch: Mapping[str, float] | None = None,
    starts: Sequence[ComparedMotion] = (),
    inputs: Mapping[str, str] | None = None,
) -> Comparison:
    """Compare sides.

    Parameters
    ----------
    reference
        the side to compare with; None: the first recorded one, else the first.
    stretch
        side -> factor by which its motion is slowed down, such as an animal's to a larger robot's time scale; it
        replaces the side's own.
    starts
        common starts of all legs; None: see ``chosen_starts``.

    Raises
    ------
    UserError : fewer than two sides or more than eight, or an unknown name.
    """
    if not FEWEST <= len(sides) <= MOST:
        text = f"{len(sides)} sides given; {FEWEST} to {MOST} can be compared"
        raise UserError(f"{text} (PATH#VIEW takes one view of a result)")
    names = [side.name for side in sides]
    for name in [*(stretch or {}), *([reference] if reference is not None else [])]:
        if name not in names:
            raise UserError(f'"{name}" is not a side{near(name, names)}')
    slowed = (replace(side, stretch=(stretch or {}).get(side.name, side.stretch)) for side in sides)
    found = tuple(side.in_convention(sides[0].leg) for side in slowed)
    place = names.index(reference) if reference is not None else _first_recorded(found)
    starts_of, taken = chosen_starts(found, starts)
    overlays = overlaid(found, taken)
    return Comparison(
        found,
        place,
        starts_of,
        overlays,
        differences(found, overlays),
        shown(found, overlays),
        tuple(alone(side.leg) if side.kind == MODEL else {} for side in found),
        inputs or {},
    )


def warnings(found: Comparison) -> list[str]:
    """Limits of the comparison."""
    messages = [*_as_fitted(found), *_unread(found.sides), *_outside_the_family(found.sides), *_bare(found.sides)]
    for place, side in enumerate(found.sides):
        other = side.other_convention(found.leg)
        if other:
            text = f"{side.name}: its file counts {', '.join(other)} from another zero or in the other sense; "
            messages.append(noted(f"{text}all angles here are as {found.sides[0].name} counts them, free angles too"))
        off = found.off_reference(place)
        if off is not None and off.starts < len(found.overlays):
            missing = len(found.overlays) - off.starts
            reasons = {o.why[place] or o.why[found.reference] for o in found.overlays}
            why = next((reason for reason in sorted(reasons) if reason), "")
            text = f"{side.name} and {found.sides[found.reference].name} share {off.starts or 'none'} of "
            text += f"{len(found.overlays)} starts" if len(found.overlays) > 1 else "one start"
            messages.append(f"{text}; {missing} {'are' if missing > 1 else 'is'} left out: {why}")
        away = [m.away for o in found.overlays if (m := o.motions[place]) is not None and m.away is not None]
        farthest = np.degrees(max((each.distance for each in away), default=0.0))
        if farthest > UNEQUAL:
            text = f"{side.name}: its recordings start up to {farthest:.1f} deg from the common start, "
            messages.append(f"{text}angle and speed together; this is part of their difference")
        driven = sum(motion.driven for motion in side.motions)
        if driven:
            text = f"{side.name}: {driven} of {len(side.motions)} recordings are driven by a known torque or a servo; "
            messages.append(f"{text}these are no releases and show no rise time, damping ratio or overshoot")
        own = found.characteristics[place].own
        if own:
            text = f"{side.name} shares no release with the other sides: its rise time, damping ratio and the like are "
            messages.append(f"{text}those of its own {f'{own} recordings' if own > 1 else 'recording'}")
        if side.leg.effects and side.kind == MODEL:
            messages.append(f"{side.name}: includes effects of its base: {', '.join(side.leg.effects)}")
    return messages


def _as_fitted(found: Comparison) -> list[str]:
    """A note on sides that are overlaid as they were fitted to the recordings."""
    sides = [side for side in found.sides if any(side.as_fitted_to(each.start) is not None for each in found.overlays)]
    if not sides:
        return []
    scaled = " at its time scale" if any(side.pace != 1.0 for side in sides) else ""
    names = ", ".join(side.name for side in sides)
    text = f"{names}: overlaid as fitted to the recordings{scaled}, with the fit's own start and free angle in each"
    return [noted(text)]


def _unread(sides: Sequence[Side]) -> list[str]:
    """A note on legs whose stated errors of encoders are left out of the comparison."""
    left = {
        side.name: dict.fromkeys(f"{each.effect.name} at {side.leg.joint_names[each.joint]}" for each in errors)
        for side in sides
        if side.kind == MODEL and not is_read(side, sides) and (errors := stated_readings(side.leg))
    }
    if not left:
        return []
    told = "; ".join(f"{name}: {', '.join(errors)}" for name, errors in left.items())
    return [noted(f"true motions are compared, without the errors of encoders that leg files state ({told})")]


def _bare(sides: Sequence[Side]) -> list[str]:
    """A note on wanted legs whose links are not yet those of the design."""
    bare = [side for side in sides if side.bare]
    if not bare:
        return []
    names = bare[0].leg.joint_names
    text = f"{', '.join(side.name for side in bare)}: links as in the target's file ({_masses(bare[0].leg)})"
    heavier = [side for side in sides if side.kind == MODEL and not side.bare and side.leg.joint_names == names]
    told = [f"{side.name} has {_masses(side.leg)}" for side in heavier if _masses(side.leg) != _masses(bare[0].leg)]
    text += "".join(f"; {each}" for each in told)
    return [f"{text}. synth leg adds the joints' parts to the links, which then need stronger springs and dampers"]


def _masses(leg: Leg) -> str:
    return ", ".join(f"{joint.name} {significant(1e3 * joint.link.mass, 3)} g" for joint in leg.joints)


def _outside_the_family(sides: Sequence[Side]) -> list[str]:
    """Sides beside those of several time scales, whose motion is not brought to the same time."""
    family = {side.source for side in sides if side.pace != 1.0}
    names = [side.name for side in sides if family and side.source not in family and side.stretch == 1.0]
    if not names:
        return []
    text = f"{', '.join(names)}: overlaid in its own time, and the family of time scales in that of the starts"
    return [f"{text}; --stretch '{names[0]}=0.5' overlays one that moves half as fast"]


def _first_recorded(sides: Sequence[Side]) -> int:
    return next((place for place, side in enumerate(sides) if side.motions), 0)


def response_columns(found: Comparison, overlay: Overlay) -> dict[str, Array]:
    """One start's motions as a table, degrees in the first side's convention; empty cells where a side has none."""
    leg, columns = found.leg, {"time [s]": overlay.start.time}
    for j, name in enumerate(leg.joint_names):
        for side, motion in zip(found.sides, overlay.motions, strict=True):
            if motion is not None:
                columns[f"{name} {side.name} [deg]"] = np.degrees(leg.to_measured(motion.rotation)[:, j])
    return columns


TIMES = {"pace": "its own time over that of the overlay", "slowed": "for the comparison"}
TABLE = ("side", "joint", "quantity", "unit", "value", "low", "high", "basis")


def table_columns(found: Comparison) -> dict[str, list[Any]]:
    """The table: one row per side, joint and quantity; ``basis`` defines ``low`` and ``high``."""
    rows: list[tuple[Any, ...]] = []
    document = found.as_json()
    for side in document["sides"]:
        rows += [_row(side, "", key, side[key], basis) for key, basis in TIMES.items() if key in side]
        for joint, values in side["joints"].items():
            rows += [_row(side, joint, key, value, _basis(value))
                     for key, value in values.items() if isinstance(value, dict)]  # fmt: skip
            rows += [(side["name"], joint, key, "", value, None, None, "stated")
                     for key, value in values.items() if isinstance(value, str)]  # fmt: skip
        for joint, values in side["alone"].items():
            rows += [_row(side, joint, f"alone_{key}", value, "linear, other joints held")
                     for key, value in values.items()]  # fmt: skip
        for joint, values in side["characteristics"].items():
            rows += [(side["name"], joint, key, value["unit"], value["value"], value["least"], value["most"],
                      f"median and ends of {value['motions']} motions") for key, value in values.items()]  # fmt: skip
        off = side.get("off_reference")
        if off:
            basis = f"{off['basis']}, {off['starts']} starts"
            rows += [_row(side, joint, "rms_off_reference", value, basis) for joint, value in off["rms"].items()]
            if "overall" in off:
                rows.append(_row(side, "all", "rms_off_reference", off["overall"], basis))
        rows += [
            _row(side, "", figure["what"], figure["value"], "as its own result states") for figure in side["stated"]
        ]
    return {title: list(column) for title, column in zip(TABLE, zip(*rows, strict=True), strict=True)}


def _row(side: Mapping[str, Any], joint: str, key: str, value: Mapping[str, Any], basis: str) -> tuple[Any, ...]:
    low, high = value.get("interval90") or (None, None)
    known = None if value.get("unknown") else value["value"]
    return side["name"], joint, key, value["unit"], known, low, high, basis


def _basis(value: Mapping[str, Any]) -> str:
    """Where a joint's value is from; an unknown one has no value in the table."""
    if value.get("unknown"):
        return "unknown: its 90 % interval spans a full turn"
    return "90 % interval" if value.get("interval90") else "stated"
