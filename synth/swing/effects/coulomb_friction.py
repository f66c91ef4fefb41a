"""Dry friction, independent of speed, with sticking: a bristle that bends by ``presliding`` before it slides.

Where grease or a soft liner carries the joint, it creeps under a torque that true dry friction would hold. The foot of
the bristle then slips at ``creep`` times its bend (-1..1): below that speed the torque falls with speed as that of a
smoothed sign does. Trials show it by where a joint comes to rest: at its spring's rest, not within a band about it.
The bristle lags behind by ``presliding / creep``. A damping by as much time cancels that lag: at the presliding that
holds, a swing is that of the smoothed sign ``x (3 - x^2) / 2``, ``x = w / creep``, within 1e-7 rad.
"""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Shape, positive, size
from synth.swing.effects.inlined import BRISTLE_DAMPING, LEAST_PRESLIDING, bristle, held, inlined

PRESLIDING = 0.0  # rad: friction sets in at once unless a recording shows the deflection
PRESLIDING_PRIOR = positive(6e-4, 0.8, 1e-4, 1e-2)  # rad, of real bearings and gears
# s, the longest damping of a creeping bristle: more makes the joint stiff to integrate; and rad/s, so as not to divide.
CREEP_DAMPING, LEAST_CREEP = 0.01, 1e-9
PRESLIDING_PARAMETER = Parameter(  # of every effect with a bristle
    "presliding",
    "rad",
    PRESLIDING,
    PRESLIDING_PRIOR,
    off=PRESLIDING,
    natural=False,
    meaning="elastic deflection before it slides: friction torque over initial stiffness",
)


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation,
    rate,
    deflection,
    spring_rate,
    damper_rate,
    damper_torque,
    force,
    memory,
    friction,
    presliding,
    creep,
):
    """Friction torque with the bristle's bend (-1..1) as memory; at rest it balances any torque below ``friction``."""
    change = bristle(rate - creep * memory, memory, presliding)
    slow = min(CREEP_DAMPING, LEAST_PRESLIDING / max(creep, LEAST_CREEP)) / BRISTLE_DAMPING
    return -friction * held(memory, change * (max(slow, 1.0) if creep > 0.0 else 1.0), presliding), change


def start(deflection, friction, presliding, creep):  # type: ignore[no-untyped-def]
    """Bristles at the release: straight."""
    return 0.0 * deflection


EFFECT = Effect(
    name="coulomb_friction",
    meaning="dry friction, constant in speed",
    phrase="has dry friction",
    formula="-torque s, s = z + (2e-4 rad / presliding) 1 ms dz/dt within -1 .. 1,\n"
    "dz/dt = (1.005 w - |w| z) / presliding up to |z| = 1;\n"
    "presliding below 2e-4 rad: it reverses at once, and holds with s = x (3 - x^2) / 2, x = z + 1 ms dz/dt,\n"
    "dz/dt = w / 2e-4 rad up to |z| = 1;\n"
    "with creep, w - creep z in place of w in dz/dt, and 2e-4 rad / creep, at most 10 ms, in place of 1 ms:\n"
    "with a presliding of 2e-4 rad s = x (3 - x^2) / 2, x = w / creep within -1 .. 1, from a creep of 0.02 rad/s on",
    source="Coulomb 1785; presliding: Dahl, TOR-158 (1968), dz/dt = (w - |w| z) / presliding, with 1.005 to slide at "
    "last; dz/dt in the torque: sigma_1 of LuGre, Canudas de Wit, Olsson, Astrom & Lischinsky, IEEE TAC 40 (1995) "
    "419; holding: Prandtl's element, ZAMM 8 (1928) 85",
    way="torque",
    linear=True,
    memory=True,
    kin="bristle",
    bristle="presliding",
    parameters=(
        Parameter("torque", "N*m", prior=size(0.1), meaning="friction torque while sliding"),
        PRESLIDING_PARAMETER,
        Parameter(
            "creep",
            "rad/s",
            0.0,
            positive(0.02, 1.0, 1e-3, 0.5),
            off=0.0,
            natural=False,
            meaning="speed below which it creeps instead of sticking; 0: it sticks",
            label="creep speed",
        ),
    ),
    stated=("torque", "creep"),
    strengths=("torque",),
    shapes=(
        Shape(("torque", "presliding"), {}, ({}, {"presliding": 2e-3})),
        # Held at the presliding from which the motion is smooth, without reversals at once.
        Shape(("torque", "creep"), {"presliding": LEAST_PRESLIDING}, ({}, {"creep": 0.1}), richer=True, explains=True),
        Shape(("torque",), {}, ({},), ("servo", "motor")),  # gears of servos stick without any elastic deflection
    ),
)
