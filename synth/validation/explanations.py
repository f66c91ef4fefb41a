"""Sentences, made from computed figures, on why published spring and damper rates differ from ours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.fit.fit_result import FitResult
from synth.fit.ridge import RIDGE
from synth.remarks import joint_of, kind_of
from synth.validation.comparison_table import percent
from synth.validation.open_rates import inside_words, within_interval
from synth.validation.thesis_data import JOINTS

NEAR_DIFFERENCE = 0.1  # relative difference that needs no explanation
BOUND_SHARE = 0.005  # share of the search range; a rate closer to its bound counts as on it


def found_rates(result: FitResult) -> Array:
    """(2, 3) spring and damper rates of a fit; nan for a damper that was not estimated."""
    dampers = [joint.damper_rate.value if joint.damper_rate else np.nan for joint in result.joints.values()]
    return np.array([[joint.spring_rate.value for joint in result.joints.values()], dampers])


def ridge_sentence(fit: FitResult, joint: str) -> str | None:
    """The fit's sentence on a joint that it moved along a ridge (see ``fit.ridge``); None if it did not."""
    return next((text for text in fit.not_separable if kind_of(text) == RIDGE and joint_of(text) == joint), None)


def difference_sentences(published: Array, ours: FitResult, rms: Array, best: Array) -> list[str]:
    """A sentence for each joint on published rates (2, 3) against a fit.

    ``rms`` : (3,) rad, residual of the published rates. ``best`` : (3,) rad, of ours, from the same initial states.
    """
    messages = []
    for j, (name, joint) in enumerate(ours.joints.items()):
        assert joint.damper_rate is not None
        k, b = published[:, j]
        change = f"k {percent(joint.spring_rate.value / k)}, b {percent(joint.damper_rate.value / b)}"
        times = published[1, j] / published[0, j], joint.damper_rate.value / joint.spring_rate.value
        left = f"the RMS residual of the published pair is {np.degrees(rms[j]):.2f} deg, of ours "
        left += f"{np.degrees(best[j]):.2f} deg"
        both = within_interval(joint.spring_rate, k) and within_interval(joint.damper_rate, b)
        same = all(
            abs(np.log(e / p)) < NEAR_DIFFERENCE
            for e, p in ((joint.spring_rate.value, k), (joint.damper_rate.value, b))
        )
        soft = ridge_sentence(ours, name)
        if soft is not None:
            where = inside_words(ours, name, published[:, j])
            messages.append(
                f"{name}: {change} ({where}), but {soft.removeprefix(f'{name}: ')} {left[0].upper()}{left[1:]}."
            )
        elif same:
            messages.append(f"{name}: the same within {100 * NEAR_DIFFERENCE:.0f} % ({change}); {left}.")
        elif both:
            messages.append(
                f"{name}: {change}; both published rates lie inside our 90 % intervals, so these recordings do not "
                f"distinguish them from ours ({left})."
            )
        # B/k is a quotient of two rates: root of 2 times NEAR, rounded up.
        elif abs(np.log(times[1] / times[0])) < 1.5 * NEAR_DIFFERENCE:
            messages.append(
                f"{name}: {change}, but b/k is {times[1]:.3g} s against the published {times[0]:.3g} s: the recordings "
                f"determine the quotient, not the two rates; {left}."
            )
        elif rms[j] > (1 + NEAR_DIFFERENCE) * best[j]:
            messages.append(
                f"{name}: {change}; b/k {times[1]:.3g} s against {times[0]:.3g} s; {left}: the published pair fits "
                "worse."
            )
        else:
            messages.append(
                f"{name}: {change}; b/k {times[1]:.3g} s against {times[0]:.3g} s; {left}: both fit the angles equally "
                "well, but not the characteristics that the thesis compared."
            )
    return messages


def bound_sentences(rates: Array, lower: Array, upper: Array, whose: str) -> list[str]:
    """Sentences on rates (2, 3) that lie on a bound ``lower`` or ``upper`` (2, 3) of their search."""
    messages = []
    for row, symbol in enumerate("kb"):
        for j, name in enumerate(JOINTS):
            for end, word in ((lower[row, j], "lower"), (upper[row, j], "upper")):
                if abs(rates[row, j] / end - 1) < BOUND_SHARE:
                    messages.append(
                        f"{name}: {symbol} of {whose} lies on its {word} bound, {end:.4g}: the bound stopped the "
                        "search before its minimum."
                    )
    return messages


def median_text(values: Sequence[float]) -> str:
    """The median of relative errors in percent; a dash if there are none."""
    return f"{100 * float(np.median(values)):.0f} %" if len(values) else "–"
