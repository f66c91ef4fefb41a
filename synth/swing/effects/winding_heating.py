"""A motor whose winding warms under load: its resistance grows, and with it the drive weakens."""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, positive
from synth.swing.effects.inlined import inlined

USUAL, SPREAD = 60.0, 1.0  # s and natural logarithm: windings of small motors warm within 20 s to 3 min
# RMS of a drive's torque over its largest: 0.41 and 0.19 in logs of the XL330 and STS3250 (BAM, arXiv 2410.08650), 0.14
# to 0.25 in simulated rigs. At the largest, a stall, many a winding would burn, so a rise is not stated for that.
REFERENCE = 0.2
MOST_HEATING = 1.5  # a copper winding's resistance has grown by half at 150 K; twice as much burns it


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, drive, memory, rise, reference, time
):
    """No torque of its own, and the growth of the memory, that of the winding's resistance, which the current heats.

    The servo's law takes its winding with that growth, so that ``drive``, N m, is that of the warm winding: a source's
    resistance stays, and where the controller limits the current nothing is lost until it no longer flows.
    """
    share = drive / reference
    return 0.0, (rise * share * share * (1.0 + max(memory, 0.0)) - memory) / time


def start(deflection, rise, reference, time):  # type: ignore[no-untyped-def]
    """Each trial begins as warm as the leg file's resistance is."""
    return 0.0 * deflection


EFFECT = Effect(
    name="winding_heating",
    meaning="a motor's winding warms under load, and its resistance grows",
    phrase="has a motor that warms and weakens",
    formula="winding's resistance R (1 + z), time dz/dt = rise (T / reference)^2 (1 + z) - z, T the drive's torque",
    source="one thermal mass: Hughes & Drury, Electric Motors and Drives, 4th ed., section 11.3; copper 0.39 %/K",
    way="torque",
    memory=True,
    uses_drive="warms its winding",
    needs=("time to warm",),  # a motor, in logs of ``chain_candidates.LEAST_WARMING_TIME`` s
    parameters=(
        Parameter(
            "rise",
            "1",
            prior=Prior(0.0, 0.3, lower=0.0, upper=MOST_HEATING),
            natural=False,
            meaning="growth of the resistance in the end if the reference torque is held",
        ),
        Parameter("reference", "N*m", off=1.0, above=0.0, meaning="torque of the drive for which the rise is stated"),
        Parameter("time", "s", USUAL, positive(USUAL, SPREAD, 5.0, 600.0), off=USUAL, natural=False,
                  meaning="time constant of warming"),
    ),
    stated=("rise", "reference", "time"),
    strengths=("rise",),
    shapes=(
        Shape(("rise", "time"), {"reference": REFERENCE}, ({"rise": 0.2, "time": 30.0}, {"rise": 0.3, "time": 120.0})),
    ),
)  # fmt: skip
