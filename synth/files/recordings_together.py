"""Comparison of a project's recordings: one whose clock or columns differ from the others is refused by name.

Each such file is well-formed, but a common fit would have a large error that its intervals do not show.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from math import degrees, exp, log, radians

import numpy as np

from synth.arrays import Array, Mask, finite_median
from synth.errors import Problem
from synth.pace import own_paces
from synth.sampling import usual_step
from synth.units import factor, header

SHORTEST_STEP, LONGEST_STEP = 1e-7, 0.5  # s, usual sample step; 1 Hz is the slowest supported motion
ANOTHER_CLOCK = 100.0  # times the others' step, from which the paces of the motions are compared
# Times as fast as in the others, up to which a motion may be the same leg's: locked joints and tip masses change it by
# a few times, a wrong unit of time by 60 at least.
ALIKE_PACE = 10.0
LEAST = 3  # recordings needed to identify a different one
ANOTHER_UNIT = "Is the time in another unit?"
IN_HEADER, IN_CODE = "Then say so in the header", "In code it is in s"
UNITS = ("ns", "us", "ms", "s", "min", "h")  # of clocks
USUAL_STEP = 0.01  # s, of cameras and servos: of several units that a clock may have, the one nearest to it is named
# Times that a wrong unit makes a clock slower, and the units meant and written.
WRONG_UNITS = {1e3: ("s", "ms"), 1e6: ("s", "us"), 1e9: ("s", "ns"), 60.0: ("min", "s"), 3600.0: ("h", "s")}
FAR, NEARER = radians(15.0), 3.0  # from the others' usual angles; times nearer with two columns exchanged


def clock_problem(time: Array, name: str, title: str = "time [s]") -> Problem | None:
    """Faults of a recording's clock (n,) s by itself: implausible sample steps."""
    fault = clock_fault(time)
    remedy = fitting_unit(time, header(title)[1])
    return Problem(f"{fault}. {ANOTHER_UNIT} {IN_HEADER}{remedy}", name, 1, title) if fault else None


def clock_fault(time: Array, known: Mask | None = None) -> str:
    """What is wrong with a clock (n,) s by itself; empty if nothing is.

    ``known`` : (n, n_channel) True where a channel has a sample; None: in every row.
    """
    steps = np.diff(time)
    if steps.min() >= SHORTEST_STEP and steps.max() <= LONGEST_STEP:
        return ""  # without the median, which takes longer
    step = float(np.median(steps)) if known is None else usual_step(time, known)
    if SHORTEST_STEP <= step <= LONGEST_STEP:
        return ""
    return f"the samples are {step:.2g} s apart; a limb is recorded every {SHORTEST_STEP:g} s to {LONGEST_STEP:g} s"


def fitting_unit(time: Array, written: str) -> str:
    """The end of a sentence: the unit with which a clock (n,) s, written in another one, has a usual step; or empty."""
    step = float(np.median(np.diff(time))) / factor(written, "s")
    steps = {unit: step * factor(unit, "s") for unit in UNITS}
    usable = {unit: value for unit, value in steps.items() if USUAL_STEP / ANOTHER_CLOCK <= value <= LONGEST_STEP}
    if not usable:
        return ""
    unit = min(usable, key=lambda each: abs(log(usable[each] / USUAL_STEP)))
    return f": with time [{unit}] they would be {usable[unit]:.2g} s apart"


def check_together(
    names: Sequence[str],
    times: Sequence[Array],
    angles: Sequence[Array],
    joints: Sequence[str],
    conditions: Sequence[Hashable] = (),
    *,
    in_code: bool = False,
) -> list[Problem]:
    """Recordings whose clock or columns do not match the others of the project.

    Parameters
    ----------
    times : (n,) s of each; angles : (n, n_joint) rad of each, nan where missing.
    conditions : of each; a tilted or loaded leg rests elsewhere, so columns are compared under the same conditions
        only. Empty: all are alike.
    in_code : arrays instead of files, for the messages.
    """
    groups: dict[Hashable, list[int]] = {}
    for index in range(len(names)):
        groups.setdefault(conditions[index] if conditions else None, []).append(index)
    problems = clocks_together(names, times, angles, in_code=in_code)
    for group in groups.values():
        problems += _exchanged([names[i] for i in group], [angles[i] for i in group], joints)
    return [replace(problem, line=None) for problem in problems] if in_code else problems


def clocks_together(
    names: Sequence[str],
    times: Sequence[Array],
    values: Sequence[Array],
    *,
    in_code: bool = False,
) -> list[Problem]:
    """Recordings whose step and motion are much slower, or much faster, than the others'.

    A camera's step may be hundreds of times that of an encoder: a clock is wrong only if the motion seems as slow too.
    Where no channel moves above its noise, the step alone decides.

    Parameters
    ----------
    times : (m,) s of each; values : (m, n_channel) of each, the same channels in all, nan where one has no sample.
    """
    known = [np.isfinite(each) for each in values]
    steps = np.array([usual_step(time, each) for time, each in zip(times, known, strict=True)])
    if len(steps) < 2:
        return []
    usual = float(np.median(steps)) if len(steps) >= LEAST else float(steps.min())
    far = np.maximum(steps / usual, usual / steps) >= ANOTHER_CLOCK
    if not far.any():
        return []
    paces = [own_paces(time, each) for time, each in zip(times, values, strict=True)]
    others = [pace for pace, other in zip(paces, far.tolist(), strict=True) if not other]
    problems = []
    for i in np.flatnonzero(far).tolist():
        slower = _times_slower(paces[i], others)
        if slower is None or max(slower, 1.0 / slower) > ALIKE_PACE:
            text = _clock_text(float(steps[i]), usual, slower, in_code=in_code)
            if len(steps) < LEAST:
                text += "; of two recordings it may also be the other whose time is wrong"
            problems.append(Problem(text, names[i], 1, "time"))
    return problems


def with_equal_channels(tables: Sequence[Mapping[str, Array]]) -> tuple[list[Array], list[Array]]:
    """Times (m,) s and values (m, n_channel) of recordings by column, nan where one has no such column."""
    channels = list(dict.fromkeys(name for table in tables for name in table if name != "time"))
    empty = [np.full(len(table["time"]), np.nan) for table in tables]
    values = [
        np.column_stack([table.get(name, none) for name in channels]) for table, none in zip(tables, empty, strict=True)
    ]
    return [table["time"] for table in tables], values


def _times_slower(pace: Array, others: Sequence[Array]) -> float | None:
    """How many times slower channels of ``pace`` (n,) s move than the ``others``'; None if that cannot be told.

    The channel that differs least decides: a wrong clock slows all of them.
    """
    ratios = [log(ratio) for other in others if (ratio := _nearest_to_one(pace / other)) is not None]
    return exp(float(np.median(ratios))) if ratios else None


def _nearest_to_one(ratios: Array) -> float | None:
    known = ratios[np.isfinite(ratios)]
    return float(known[np.argmin(np.abs(np.log(known)))]) if len(known) else None


def _clock_text(step: float, usual: float, slower: float | None, *, in_code: bool) -> str:
    """The message on a recording's ``step`` s beside the ``usual`` one; ``slower`` as of ``_times_slower``."""
    apart = f"{_times(step / usual)} times {'' if step > usual else 'less than '}"
    text = f"its samples are {step:.3g} s apart, {apart}the step of the other recordings ({usual:.3g} s), and "
    if slower is None:
        text += "no motion above the noise tells whether its time is right. If it is, leave out rows of the denser "
        text += f"recordings, until the steps differ less than {ANOTHER_CLOCK:.0f} times"
    else:
        text += f"its motion is {_times(slower)} times as {'slow' if slower > 1.0 else 'fast'} as theirs"
    return f"{text}. {ANOTHER_UNIT} {_other_unit(step, slower or step / usual, in_code=in_code)}"


def _times(ratio: float) -> str:
    """A ratio, or its reciprocal if below one, with three digits."""
    return f"{float(f'{max(ratio, 1.0 / ratio):.3g}'):.0f}"


def _other_unit(step: float, slower: float, *, in_code: bool) -> str:
    """The unit, beside the one written, with which a clock of ``step`` s, ``slower`` times too slow, is right."""
    larger = slower < 1.0
    times = min(WRONG_UNITS, key=lambda each: abs(log(max(slower, 1.0 / slower) / each)))
    then = f"they would be {step * times if larger else step / times:.3g} s apart"
    if in_code:
        return f"{IN_CODE}: {'multiplied' if larger else 'divided'} by {times:.0f}, {then}"
    meant, written = WRONG_UNITS[times] if larger else WRONG_UNITS[times][::-1]
    text = f"With one {times:.0f} times {'larger' if larger else 'smaller'} in its header, such as [{meant}] for "
    return f"{text}[{written}], {then}"


def _exchanged(names: Sequence[str], angles: Sequence[Array], joints: Sequence[str]) -> list[Problem]:
    """Recordings whose usual angles match the others' after exchanging two columns."""
    if len(names) < LEAST or len(joints) < 2:
        return []
    with np.errstate(all="ignore"):
        own = np.array([[finite_median(one[:, j]) for j in range(one.shape[1])] for one in angles])
    usual = np.array([finite_median(of_joint) for of_joint in own.T])
    problems = []
    for name, one in zip(names, own, strict=True):
        away = _apart(one, usual)
        if away < FAR:
            continue
        pairs = list(combinations(range(len(joints)), 2))
        swapped = [_apart(_with_exchange(one, pair), usual) for pair in pairs]
        if swapped and min(swapped) < away / NEARER:
            first, second = (joints[j] for j in pairs[int(np.argmin(swapped))])
            text = f"the columns of {first} and {second} look exchanged: its angles lie {degrees(away):.0f} deg from "
            text += f"those of the other recordings, and {degrees(min(swapped)):.0f} deg with the two exchanged"
            problems.append(Problem(text, name, 1))
    return problems


def _apart(one: Array, usual: Array) -> float:
    """Largest distance of any joint, rad."""
    return float(np.nanmax(np.abs(one - usual)))


def _with_exchange(one: Array, pair: tuple[int, int]) -> Array:
    swapped = one.copy()
    swapped[list(pair)] = one[list(pair[::-1])]
    return swapped
