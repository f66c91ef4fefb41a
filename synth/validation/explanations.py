"""Why a published pair of rates differs from ours, in sentences made from computed figures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import Estimate
from synth.fit.fit_result import FitResult
from synth.validation.comparison_table import percent
from synth.validation.thesis_data import JOINTS

NEAR = 0.1  # relative difference that needs no word
ON_BOUND = 0.005  # of the box, nearer than which a rate counts as on its bound


def found_rates(result: FitResult) -> Array:
    """(2, 3) spring and damper rates of a fit whose dampers were sought."""
    dampers = [joint.damper_rate.value if joint.damper_rate else np.nan for joint in result.joints.values()]
    return np.array([[joint.spring_rate.value for joint in result.joints.values()], dampers])


def inside(estimate: Estimate, value: float) -> bool:
    """Whether a number lies within the estimate's interval."""
    return estimate.low is not None and estimate.high is not None and estimate.low <= value <= estimate.high


def softened(fit: FitResult, joint: str) -> str | None:
    """The fit's own sentence on a joint that it moved down a ridge, where the recordings leave one."""
    start = f"{joint}: of the springs and dampers that fit alike"
    return next((text for text in fit.not_separable if text.startswith(start)), None)


def apart(published: Array, ours: FitResult, rms: Array, best: Array) -> list[str]:
    """A sentence for each joint: published rates (2, 3) against a fit.

    ``rms`` (3,) rad: what the published rates leave; ``best`` (3,) rad: what ours leave, both with the same starts.
    """
    said = []
    for j, (name, joint) in enumerate(ours.joints.items()):
        assert joint.damper_rate is not None
        k, b = published[:, j]
        change = f"k {percent(joint.spring_rate.value / k)}, b {percent(joint.damper_rate.value / b)}"
        times = published[1, j] / published[0, j], joint.damper_rate.value / joint.spring_rate.value
        left = f"the published pair leaves {np.degrees(rms[j]):.2f} deg at the {name}, ours {np.degrees(best[j]):.2f}"
        both = inside(joint.spring_rate, k) and inside(joint.damper_rate, b)
        same = all(abs(np.log(e / p)) < NEAR for e, p in ((joint.spring_rate.value, k), (joint.damper_rate.value, b)))
        soft = softened(ours, name)
        if soft is not None:
            said.append(f"{name}: {change}, but {soft.removeprefix(f'{name}: ')} {left[0].upper()}{left[1:]}.")
        elif same:
            said.append(f"{name}: the same within {100 * NEAR:.0f} % ({change}); {left}.")
        elif both:
            said.append(
                f"{name}: {change}, and both published rates lie inside our 90 % intervals: these recordings do not "
                f"tell them apart ({left})."
            )
        elif abs(np.log(times[1] / times[0])) < 1.5 * NEAR:
            said.append(
                f"{name}: {change}, but b/k is {times[1]:.3g} s against the published {times[0]:.3g} s: the recordings "
                f"fix the quotient and not the pair; {left}."
            )
        elif rms[j] > (1 + NEAR) * best[j]:
            said.append(f"{name}: {change}; b/k {times[1]:.3g} s against {times[0]:.3g} s; {left}: it follows less.")
        else:
            said.append(
                f"{name}: {change}; b/k {times[1]:.3g} s against {times[0]:.3g} s; {left}: as near as makes no "
                "difference to angles, though not to the characteristics by which the thesis judged."
            )
    return said


def on_bounds(rates: Array, lower: Array, upper: Array, whose: str) -> list[str]:
    """Sentences on rates (2, 3) that stopped at an end of their range."""
    said = []
    for row, symbol in enumerate("kb"):
        for j, name in enumerate(JOINTS):
            for end, word in ((lower[row, j], "lower"), (upper[row, j], "upper")):
                if abs(rates[row, j] / end - 1) < ON_BOUND:
                    said.append(
                        f"{name}: {symbol} of {whose} lies on its {word} bound, {end:.4g}: the search was stopped, not "
                        "satisfied."
                    )
    return said


def median_text(values: Sequence[float]) -> str:
    """A median as a share."""
    return f"{100 * float(np.median(values)):.0f} %" if len(values) else "–"
