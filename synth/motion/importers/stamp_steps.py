"""Steps of the clock by which a robot's messages are stamped, found by the clock of the log, and taken out.

A computer's clock is set while it records (NTP, PTP), a driver or a simulator starts anew, a replay begins again: the
stamps jump, and the logging times run on. Sorted by their stamps, two stretches of the motion would be shuffled into
one another; with a step ahead the record would have a gap that the motion has not.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.remarks import decisive

LEAST_PERIODS = 5.0  # of the messages, of a step: messages that come late or in another order are less off
AROUND = 50  # messages before and after a step, whose usual delays tell its size
LEAST_AROUND = 3  # messages on either side, without which a late message and a step look alike
SAME = 0.25  # share of a step by which the delays before and after it must agree with it
TOLD = 3  # steps that a sentence tells


def without_steps(stamp: Array, logged: Array, notes: list[str], topic: str) -> Array:
    """Stamps (n,) s of messages without the steps of their clock; ``notes`` are added to.

    Parameters
    ----------
    stamp, logged : (n,) s, stamps, nan where there is none, and logging times.
    """
    order = np.argsort(logged, kind="stable")
    order = order[np.isfinite(stamp[order])]
    steady, delay = stamp[order], logged[order] - stamp[order]
    if len(order) < 2 * LEAST_AROUND:
        return stamp
    between, shift = np.diff(steady), np.diff(delay)
    period = float(np.median(between[between > 0.0])) if (between > 0.0).any() else 0.0
    jumps = (np.abs(between - period) > LEAST_PERIODS * period) & (np.abs(shift) > LEAST_PERIODS * period)
    # After a pause of the messages stamps jump as the log does, which is no step of a clock.
    jumps &= np.abs(shift) > 0.5 * np.abs(between - period)
    found = []
    edges = np.flatnonzero(jumps).tolist()
    for k in edges:
        before, after = delay[max(0, k + 1 - AROUND) : k + 1], delay[k + 1 : k + 1 + AROUND]
        if min(len(before), len(after)) < LEAST_AROUND:
            continue
        size = float(np.median(after) - np.median(before))
        if abs(size - shift[k]) <= SAME * abs(shift[k]):
            found.append((k, size))
    if not found:
        return stamp
    for k, size in found:
        steady[k + 1 :] += size
    made = stamp.copy()
    made[order] = steady
    notes.append(_sentence(found, steady - steady[0], topic))
    return made


def _sentence(found: list[tuple[int, float]], time: Array, topic: str) -> str:
    """What was taken out: ``found`` holds the message before each step, and the time (s) that its delay rises by."""
    places = [
        f"at {time[k + 1]:.3g} s {'back' if size > 0.0 else 'ahead'} by {abs(size):.4g} s" for k, size in found[:TOLD]
    ]
    more = f" and {len(found) - TOLD} times more" if len(found) > TOLD else ""
    return decisive(
        f"the clock that stamps the messages of {topic} steps {', '.join(places)}{more}, while the log's clock runs "
        "on: the steps are taken out by the logging times",
        "Look whether the computer's clock was set, or a replay began again, while this was recorded.",
    )
