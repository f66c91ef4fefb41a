"""The one spring rate that is wanted at a joint with its damper, and the springs for it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace

from synth.design.choose_dampers import DamperChoiceMade
from synth.design.choose_springs import SpringOption, SpringSource, spring_options
from synth.design.response import WantedResponse
from synth.errors import CannotBeHad
from synth.swing.leg_model import Leg


def wanted_rates(wanted: WantedResponse, fitted: Leg, dampers: DamperChoiceMade) -> list[tuple[float, float]]:
    """Each joint's wanted rate (N m/rad) with the damper chosen first, and the other estimate of it.

    Of the rate tuned to this damper and the one that was fitted with it, the one with which the leg moves nearer to the
    wanted motion. Tuning ends near where it starts, and the fit is to the recordings: neither is always the nearer.
    ``fitted``: the leg with these dampers and the springs fitted with them.
    """
    rates, legs = [], []
    for j, (joint, damper) in enumerate(zip(fitted.joints, dampers.chosen, strict=True)):
        assert joint.spring is not None
        rates.append((joint.spring.rate, (damper.spring or joint.spring).rate))
        for rate in rates[-1]:
            changed = replace(joint, spring=replace(joint.spring, rate=rate))
            joints = (*fitted.joints[:j], changed, *fitted.joints[j + 1 :])
            legs.append(wanted.at_rest_like_wanted(replace(fitted, joints=joints)))
    errors = wanted.overall(legs).reshape(-1, 2)
    return [pair[::-1] if second < first else pair for pair, (first, second) in zip(rates, errors, strict=True)]


def springs_for(
    source: SpringSource, rates: tuple[float, float]
) -> tuple[list[SpringOption], Mapping[str, int], list[str]]:
    """The springs for one wanted rate, as ``spring_options``: tolerance, reasons and notes refer to it alone.

    It is the first of the ``rates`` (N m/rad); where a bought spring is required and none has it, the second.

    Raises
    ------
    UserError : a bought spring is required and none meets the constraints with either.
    """
    try:
        return spring_options(source, rates[0], lasting=False)
    except CannotBeHad:
        with suppress(CannotBeHad):
            return spring_options(source, rates[1], lasting=False)
        raise
