"""Dry friction, independent of speed, with sticking: a bristle that bends by ``presliding`` before it slides."""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Shape, positive, size
from synth.swing.effects.inlined import bristle, held, inlined

PRESLIDING = 0.0  # rad: friction sets in at once unless a recording shows the deflection
PRESLIDING_PRIOR = positive(6e-4, 0.8, 1e-4, 1e-2)  # rad, of real bearings and gears
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
def torque(rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, friction, presliding):  # type: ignore[no-untyped-def]
    """Friction torque with the bristle's bend (-1..1) as memory; at rest it balances any torque below ``friction``."""
    change = bristle(rate, memory, presliding)
    return -friction * held(memory, change, presliding), change


def start(deflection, friction, presliding):  # type: ignore[no-untyped-def]
    """Bristles at the release: straight."""
    return 0.0 * deflection


EFFECT = Effect(
    name="coulomb_friction",
    meaning="dry friction, constant in speed",
    phrase="has dry friction",
    formula="-torque s, s = z + (2e-4 rad / presliding) 1 ms dz/dt within -1 .. 1,\n"
    "dz/dt = (1.005 w - |w| z) / presliding up to |z| = 1;\n"
    "presliding below 2e-4 rad: it reverses at once, and holds with s = x (3 - x^2) / 2, x = z + 1 ms dz/dt,\n"
    "dz/dt = w / 2e-4 rad up to |z| = 1",
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
    ),
    strengths=("torque",),
    shapes=(
        Shape(("torque", "presliding"), {}, ({}, {"presliding": 2e-3})),
        Shape(("torque",), {}, ({},), ("servo", "motor")),  # gears of servos stick without any elastic deflection
    ),
)
