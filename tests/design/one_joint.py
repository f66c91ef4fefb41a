"""A leg of one joint with a wanted swing, designed: a knee of 250 mm and 0.5 kg that rests at 170 deg."""

from __future__ import annotations

from pathlib import Path

from synth.api.designs import design as design_of
from synth.design.leg_design import LegDesign

LEG = """kind: leg
name: one joint
gravity: 9.81 m/s^2
joints:
  - name: knee
    zero: 180 deg
    sign: +1
    link: {{length: 250 mm, mass: 0.5 kg, com: 100 mm, inertia: 4e-3 kg*m^2}}{range}
"""
PROJECT = """kind: leg-design
name: one joint
source: {{leg: one.leg.yaml, wanted: {{knee: {{rest: 170 deg, amplitude: {amplitude} deg, damping_ratio: 0.1,
                                               damped_frequency: {frequency} Hz}}}}}}
target: one.leg.yaml
select: {{joints: {{knee: {{spring: {{{spring}}}}}}}}}
"""


def designed(
    folder: Path,
    spring: str = "make: true",
    *,
    amplitude: float = 40,
    frequency: float = 4,
    between: tuple[float, float] | None = None,
    solids: bool = True,
) -> LegDesign:
    """The design with this ``spring:``; amplitude in deg, frequency in Hz; ``between``: the stated range, deg."""
    stated = "" if between is None else f"\n    range: [{between[0]} deg, {between[1]} deg]"
    (folder / "one.leg.yaml").write_text(LEG.format(range=stated))
    project = folder / "leg-design.yaml"
    project.write_text(PROJECT.format(spring=spring, amplitude=amplitude, frequency=frequency))
    return design_of(project, solids=solids).design
