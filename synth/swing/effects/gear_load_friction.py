"""Dry friction of a gear, which grows with the torque that the drive transmits through it."""

from __future__ import annotations

from synth.swing.effects.coulomb_friction import PRESLIDING_PARAMETER
from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, positive, size
from synth.swing.effects.inlined import bristle, held, inlined, stribeck_share
from synth.swing.effects.winding_heating import REFERENCE


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation,
    rate,
    deflection,
    spring_rate,
    damper_rate,
    damper_torque,
    drive,
    memory,
    unloaded,
    share,
    backdriven,
    fall,
    speed,
    presliding,
):
    """The bristle of Coulomb friction with a constant and a load-dependent level, both falling with speed."""
    load = max(share + (backdriven if drive * rate < 0.0 else 0.0), 0.0)  # load takes no friction away
    level = (unloaded + load * abs(drive)) * stribeck_share(rate, speed, fall)
    change = bristle(rate, memory, presliding)
    return -level * held(memory, change, presliding), change


def start(deflection, unloaded, share, backdriven, fall, speed, presliding):  # type: ignore[no-untyped-def]
    """Bristles at the release: straight."""
    return 0.0 * deflection


EFFECT = Effect(
    name="gear_friction",
    former=("gear_load_friction",),
    meaning="dry friction of a gear, which grows with the drive's torque",
    phrase="has gear friction that grows with the drive's torque",
    formula="-s (torque + max(0, share + backdriven [where the load drives the motor]) |T|) "
    "(1 - fall + fall exp(-(w/speed)^2)), T the drive's torque, s as of coulomb_friction",
    source="Duclusaud et al., BAM, arXiv 2410.08650, models M3 (share), M4 (fall) and M5 (directions apart)",
    way="torque",
    memory=True,
    kin="bristle",
    bristle="presliding",
    uses_drive="as it is",
    by_drive=("share", "backdriven"),
    needs=("servo", "motor", "recorded current"),
    parameters=(
        # At the torque that logs hold, a fifth of the natural one, no larger than the part that grows with it: else it
        # is dry friction with some load's part. At the natural torque, a stall, dry friction once passed for this.
        Parameter(
            "torque",
            "N*m",
            0.0,
            Prior(0.0, 0.5 * REFERENCE, lower=0.0, upper=REFERENCE),
            of="share",
            meaning="friction without load",
        ),
        Parameter(
            "share", "1", 0.0, size(0.3), natural=False, meaning="friction per unit of the drive's torque", form="share"
        ),
        Parameter(
            "backdriven",
            "1",
            0.0,
            Prior(0.0, 0.2),
            natural=False,
            meaning="additional share when the load drives the motor",
        ),
        Parameter(
            "fall", "1", 0.0, Prior(0.6, 0.25, lower=0.0, upper=1.0), natural=False, meaning="share lost at speed"
        ),
        Parameter("speed", "rad/s", 1.0, positive(0.3, 1.0, upper=1.0), off=1.0, meaning="speed over which it falls"),
        PRESLIDING_PARAMETER,
    ),
    stated=("share", "torque", "backdriven", "fall", "speed"),
    strengths=("torque", "share", "backdriven"),
    shapes=(
        Shape(("share",), {}, ({"share": 0.1}, {"share": 0.3})),
        Shape(("share", "torque"), {}, ({"share": 0.2, "torque": 0.2},)),
        Shape(("share", "torque", "fall", "speed"), {}, ({"share": 0.2, "torque": 0.2, "fall": 0.5, "speed": 0.3},)),
        Shape(("share", "torque", "backdriven"), {}, ({"share": 0.2, "torque": 0.2, "backdriven": 0.05},)),
    ),
)
