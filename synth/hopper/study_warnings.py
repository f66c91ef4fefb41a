"""What to warn of in a study: voltage, gearbox limits, missing intervals, lengths at an edge."""

from __future__ import annotations

from collections import Counter

import numpy as np

from synth.hopper.hopper_tolerances import startable
from synth.hopper.motors import estimates_of
from synth.hopper.study import Study
from synth.jump.hopper_leg import LOCKED, lower_angles
from synth.jump.outcomes import CROSSED, LANDED_AGAIN, OUT_OF_REACH, TOO_STIFF
from synth.remarks import Remark, decisive, noted

MOST_VOLTAGE = 1.5  # times the rated one, an assumption: makers state no limit in the catalogues' sources


def _without_interval(found: Study) -> list[str]:
    """How many designs jump for which an interval was asked but could not be found, and why."""
    sweep = found.sweep
    asked = sweep.status == LANDED_AGAIN
    if not sweep.problem.with_intervals:
        shown = np.zeros_like(asked)
        shown[[*found.front, *([] if found.best is None else [found.best])]] = True
        asked &= shown & (sweep.problem.model.engine == "lanes")
    missing = asked & np.isnan(found.low)
    if not missing.any():
        return []
    stuck = np.zeros_like(missing)
    for m in np.unique(sweep.motor[missing]):
        own = np.flatnonzero(missing & (sweep.motor == m))
        problem = sweep.problem
        can = startable(problem.leg, problem.motors[m], problem.tolerances[m], sweep.length[own])
        stuck[own] = ~can.all(axis=1)
    texts = []
    if bent := int(stuck.sum()):
        why = "at an end of the crouch's tolerance their lower links are level and lock, or the leg is at its stop"
        texts.append(f"{bent} designs have no interval: {why}")
    if stiff := int((missing & ~stuck).sum()):
        why = "at a tolerance's end they are too stiff to simulate, or go through their stop"
        texts.append(f"{stiff} designs have no interval: {why}")
    return texts


def _at_an_edge(found: Study, best: int) -> list[str]:
    """That the chosen length is the last of the sweep, or the last whose crouch the links reach."""
    sweep, lengths = found.sweep, found.project.lengths
    n = len(lengths)
    if n <= 2:
        return []
    place, first = best % n, best - best % n
    reached = np.flatnonzero(sweep.status[first : first + n] != OUT_OF_REACH)
    texts: list[str] = []
    for end, beyond, word, other in ((reached[0], -1, "shortest", "shorter"), (reached[-1], 1, "longest", "longer")):
        if place != end:
            continue
        if not 0 <= place + beyond < n:
            texts.append(Remark(
                f"the chosen length is the {word} of the sweep: the optimum may lie beyond",
                remedy=f"Widen `lengths` to compare {other} legs too.",
            ))  # fmt: skip
            continue
        lower = np.degrees(lower_angles(found.project.leg, np.array([lengths[place], lengths[place + beyond]])))
        if lower[1] <= np.degrees(LOCKED):
            why = f"{other} legs cannot start from it"
        else:  # also if they do not reach at all
            why = f"{np.degrees(LOCKED) - lower[0]:.1f} deg before the lower links lock"
        texts.append(Remark(
            f"the chosen length is the {word} in reach, set by the crouch: {why}; the optimum may lie beyond",
            remedy=f"Write another `crouch` under leg to compare {other} legs too.",
        ))  # fmt: skip
    return texts


def _torques_at_their_end(found: Study, best: int) -> list[str]:
    """That the upper 90 % end of the choice's gear torque, or of designs that ``stop`` lets through, is too large."""
    over, texts = found.over_limit_at_end, list[str]()
    where = "peak_gear_torque_high of designs.csv"
    if over[best]:
        torque, high = found.sweep.values["peak_gear_torque"][best], found.torque_ends[1, best]
        texts.append(Remark(
            f"the chosen design: its gear carries {torque:.3f} N*m in the push, but {high:.3f} N*m at the 90 % end "
            f"of its tolerances, above the gearbox's {found.best_motor.torque_limit:.3f} N*m", "decide",
            remedy=f"Choose a design whose {where} is below the limit, or a stronger gearbox.",
        ))  # fmt: skip
    if found.project.gearbox == "stop" and over.any():
        of = int(found.sweep.feasible("stop").sum())
        texts.append(Remark(
            f"gearbox: stop judges the nominal torque: at the 90 % end of the tolerances {int(over.sum())} of {of} "
            "feasible designs exceed their gearbox's limit", remedy=f"See {where}.",
        ))  # fmt: skip
    return texts


def overvoltage_sentence(found: Study) -> str:
    """A sentence on motors whose supply is far above their rated voltage; empty if there are none."""
    supply = found.project.motor_options.supply
    rated = [row.voltage for row in found.rows if supply and row.voltage and supply > MOST_VOLTAGE * row.voltage]
    if not rated:
        return ""
    of = f"{min(rated):g} V" if min(rated) == max(rated) else f"{min(rated):g} to {max(rated):g} V"
    count = len(found.rows)
    whose = f"{len(rated)} of the {count} motors" if count > 1 else found.rows[0].part
    return (
        f"the supply of {supply:g} V is more than {MOST_VOLTAGE:g} times the rated voltage ({of}) of {whose}: winding, "
        "brushes and gear wear out fast"
    )


def unknown_limits(found: Study) -> list[str]:
    """That gear torques are held against no limit, because none is known: of all motors, or of the chosen one."""
    sweep, stop = found.sweep, found.project.gearbox == "stop"
    which = sweep.without_limit()
    motors = [int(m) for m in np.unique(sweep.motor[which])]
    chosen = found.best is not None and bool(which[found.best])
    if not motors or not (stop or chosen):
        return []
    pushed = float(sweep.values["peak_gear_torque"][found.best]) if chosen else 0.0
    own = f"the gear of {found.best_motor.name} carries {pushed:.3f} N*m in the push" if chosen else ""
    if not stop:
        text = f"the chosen design: {own}, held against no limit: its catalogue row states none"
    else:
        families = Counter(" ".join(word for word in found.rows[m].same_motor if word) for m in motors)
        names = ", ".join(name if count == 1 else f"{name} ({count} ratios)" for name, count in families.items())
        count = len(found.rows)
        whose = f"{len(motors)} of the {count} motors, whose catalogue rows state" if count > 1 else (
            "the motor, whose catalogue row states"
        )  # fmt: skip
        text = f"gearbox: stop cannot hold back {whose} no torque_limit: {names}"
        text += f"; among them the chosen one: {own}" if chosen else ""
    remedy = (
        "Write the maker's permissible momentary torque as `torque_limit [N*m]` into a row of your own catalogue "
        "(motors: catalogs), or leave these motors out of `use`."
    )
    return [Remark(text, "decide" if stop else "check", remedy)]


def warnings_of(found: Study) -> list[str]:
    """The most important warnings."""
    sweep = found.sweep
    texts: list[str] = []
    if hot := overvoltage_sentence(found):
        texts.append(decisive(hot))
    texts += unknown_limits(found)
    if stiff := int((sweep.status == TOO_STIFF).sum()):
        texts.append(f"{stiff} of {len(sweep.status)} designs are too stiff to simulate and count as not jumping")
    if crossed := int((sweep.status == CROSSED).sum()):
        texts.append(Remark(
            f"{crossed} of {len(sweep.status)} designs go through the leg's stop until their knees cross, which no leg "
            f"can, and count as not jumping: the motors bend the stop of {found.project.leg.stop_rate:g} N*m/rad, "
            "or the links, too far", "decide" if found.best is None else "check",
            remedy="State the leg's own stop (leg: stop_rate) and stiffer links, or choose weaker motors.",
        ))  # fmt: skip
    texts += _without_interval(found)
    if found.best is None:
        if (sweep.status == LANDED_AGAIN).any():
            way_out = "choose a stronger gearbox, a lower supply, or motors: {gearbox: warn}"
            texts.append(decisive(f"{found.none_because}: {way_out}"))
        elif not crossed:
            why = "every motor that can be simulated is too weak or too slow for this leg; the height is zero"
            texts.append(decisive(f"no design lifts off: {why}"))
        return texts
    row = found.rows[sweep.motor[found.best]]
    if limit := sweep.limit_text(found.best):
        way_out = "motors: {gearbox: stop} leaves such designs out"
        texts.append(decisive(f"the chosen design: {limit}; the gear may break ({way_out})"))
    texts += _torques_at_their_end(found, found.best)
    if found.breaks_after_takeoff:
        limit_of = f"the gearbox's {found.best_motor.torque_limit:.3f} N*m"
        texts.append(Remark(
            f"the chosen design: after takeoff, at the leg's stop, its gear carries {found.torque_after_takeoff:.3f} "
            f"N*m, above {limit_of}; designs are judged by the push alone, and the stop's stiffness is an assumption",
            "decide",
            remedy="Give the leg a softer stop (leg: stop_rate, stop_dissipation), or switch the motors off before it.",
        ))  # fmt: skip
    texts += [f"{row.part}: {text}" for text in estimates_of(row, found.project.motor_options)]
    texts += _at_an_edge(found, found.best)
    texts += [noted(text) for text in found.ladder_notes.values()]
    return texts
