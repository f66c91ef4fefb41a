"""Warnings on a joint's spring: its seat, limits that the joint's travel passes, values to measure."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, pi, radians
from typing import TYPE_CHECKING

from synth.design.choose_springs import SpringOption, WantedTravel
from synth.design.spring_hands import hand_warnings
from synth.files.project_options import SpringChoice
from synth.remarks import decisive, noted
from synth.spring.bought_spring import PassedLimit, breaks_early, opened_too_far, vendor_limits

if TYPE_CHECKING:
    from synth.cad import JointDimensions

BEAR_IT = (
    "Have one wound (make: true), allow other rates or several in parallel (rate_tolerance, parallel), add a table "
    "under select.catalogs, or give the joint a smaller range."
)
LAST_LONGER = (
    "State the full turns that it must last (cycles), so that only springs that last them are taken, or give the joint "
    "a smaller range."
)
LAST_RESORT = "; it is taken because no bought spring that meets the constraints bears this joint's travel"


def sense_warning(joint: str, travel: WantedTravel) -> list[str]:
    """A warning if the travel would open a spring seated as in the thesis, so that the other seat is drawn."""
    if not travel.turned_round:
        return []
    return [
        f"{joint}: its spring turns {degrees(travel.winding):.0f} deg towards larger measured angles and only "
        f"{degrees(travel.opening):.0f} deg the other way. A torsion spring must be loaded in the winding direction, "
        "so it is seated the other way round: larger angles close its arms, and its arm offset is the free angle "
        "plus the included angle"
    ]


def _without_remarks(option: SpringOption) -> SpringOption:
    """The option without the remarks on its row."""
    assert option.row is not None
    return replace(option, row=replace(option.row, derived=()))


def spring_warnings(joint: str, option: SpringOption, choice: SpringChoice) -> list[str]:
    """Warnings on a bought spring: limits that the travel passes, or values that must be measured first."""
    if option.row is not None and option.row.derived:
        return [
            f"{joint}: {option.part} is {option.row.status}",
            *spring_warnings(joint, _without_remarks(option), choice),
        ]
    why = "" if choice.part is not None else LAST_RESORT
    warnings = [decisive(f"{joint}: {option.part} {each.text}{why}", BEAR_IT) for each in option.passed]
    known = {each.reason for each in option.passed}
    drawn = [each for each in _passed_as_drawn(option, choice) if each.reason not in known]
    warnings += [decisive(f"{joint}: {option.part} {each.text}", BEAR_IT) for each in drawn]
    if option.row is not None:
        warnings += _life_warnings(joint, option, choice)
    return [*warnings, *hand_warnings(joint, option)]


def _passed_as_drawn(option: SpringOption, choice: SpringChoice) -> list[PassedLimit]:
    """The limits that a bought spring passes with the arms of its drawn joint, in the seat in which it is drawn."""
    if option.row is None or option.check is None:
        return []
    found = opened_too_far(option.check), breaks_early(option.check, choice.cycles)
    return [each for each in found if each is not None]


def _life_warnings(joint: str, option: SpringOption, choice: SpringChoice) -> list[str]:
    """That a bought spring may break early where no number of turns is required, or that this cannot be told."""
    check = option.check
    if check is None:
        return [f"{joint}: it is not known where {option.part} yields, nor how long it lasts: {option.unchecked}"]
    if choice.cycles is not None:
        return []
    if check.life is None:
        unknown = f"no fatigue data are known for {check.material} wire"
        return [noted(f"{joint}: it is not known how long {option.part} lasts: {unknown}")]
    return [decisive(f"{joint}: {option.part} {check.short_life}", LAST_LONGER)] if check.short_life else []


def stop_warnings(joint: str, option: SpringOption, dimensions: JointDimensions) -> list[str]:
    """Notes on a bought spring that bears the motion, but passes a vendor's limit where a drawn stop ends its travel.

    Its yield is looked after by the stops themselves, see ``drawn_travel``.
    """
    if option.row is None or option.passed:
        return []
    stop = dimensions.ends[0]
    wound = radians(max(dimensions.closing(stop), 0.0))
    return [
        noted(f"{joint}: turned to its stop at {stop:.1f} deg, {option.part} {each.text}")
        for each in vendor_limits(option.row, wound)
    ]


def wound_turns(joint: str, free_angle: float, travel: tuple[float, float]) -> list[str]:
    """That a spring is unloaded a turn or more beyond the travel (low, high); all rad. Of a joint that is not drawn."""
    beyond = max(travel[0] - free_angle, free_angle - travel[1])
    if beyond < 2.0 * pi:
        return []
    text = (
        f"{joint}: its spring is unloaded {degrees(beyond):.0f} deg beyond the joint's travel, so it must be wound up "
        f"by {beyond / (2.0 * pi):.1f} turns in assembly, and the angle between its arms does not tell how far it is "
        "wound. No joint that is drawn here does that"
    )
    return [decisive(text, f"Take a stiffer spring: state its rate or part under select.joints.{joint}.spring.")]


def wanted_rate_note(joint: str, option: SpringOption, damper: str, fitted: float, choice: SpringChoice) -> list[str]:
    """Why the wanted rate is not the ``fitted`` one (N m/rad), if they differ by more than a bought spring may."""
    if choice.part is not None or abs(option.asked / fitted - 1.0) <= choice.rate_tolerance:
        return []
    if option.held:
        text = (
            f"{joint}: the fit to the recordings with {damper} gives a spring of {fitted:.3g} N*m/rad, which would be "
            "unloaded farther away than the joint as drawn can wind it up: it is put in unloaded, and its upper arm is "
            f"then turned to the travel. The wanted rate is held to {option.asked:.3g}, the least that can be; "
            "--no-cad, for joints of your own, does not limit it"
        )
        return [noted(text)]
    return [
        noted(
            f"{joint}: the wanted spring rate is {option.asked:.3g} N*m/rad, with which the simulated leg moves as "
            f"wanted with {damper}; the fit to the recordings with this damper gives {fitted:.3g}. They differ where "
            "the motion depends little on the rate, and parts are chosen by the motion"
        )
    ]
