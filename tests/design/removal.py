"""Choosing without a part against the exchange listed for it: random projects, one part removed from each.

``PYTHONPATH=tests python -m design.removal COUNT [SEED]``. A project is a random leg of two links whose motion is
simulated from random releases with 0.05 deg of noise, a random part of the built-in springs and dampers and some that
are scaled at random, and random wishes. The property: without a part that stands at one joint, the result is at most
0.05 deg worse than the best single exchange for it that the full choice listed, by the error that the choice goes by;
and nothing ends in anything but a result or a message.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from synth.design.leg_design import LegDesign, design_leg
from synth.design.response import WantedRelease, WantedResponse
from synth.errors import UserError
from synth.files.leg_project import LegProject
from synth.files.output import write_csv
from synth.files.projects import read_leg_project
from synth.parts.catalogs import Catalogue
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

WORSE = 0.05  # deg
NOISE = np.radians(0.05)
TIME = np.linspace(0.0, 1.0, 61)
NAMES = ("hip", "knee")
PROJECT = """
kind: leg-design
source: {{leg: leg.yaml, trials: [release_*.csv]}}
scale: {{time: {time}}}
target: leg.yaml
select: {{joints: {{hip: {hip}, knee: {knee}}}}}
"""
LEG = """
kind: leg
name: random
joints:
"""
JOINT = (
    "  - {{name: {}, zero: {} deg, sign: {:+d}, link: {{length: {} m, mass: {} kg, com: {} m, inertia: {} kg*m^2}}}}\n"
)


@dataclass(frozen=True)
class Case:
    """One project and its outcome; errors in deg. ``listed`` None: nothing was listed in the part's place."""

    seed: int
    part: str
    outcome: str
    listed: float | None = None
    listed_nominal: float | None = None
    found: float | None = None
    found_nominal: float | None = None

    @property
    def worse(self) -> float:
        """By how much the result is worse than what was listed, deg; negative where it is better."""
        return -np.inf if self.listed is None or self.found is None else self.found - self.listed

    @property
    def holds(self) -> bool:
        """Whether the property holds."""
        return self.outcome == "told" or self.worse <= WORSE


def random_leg(generator: np.random.Generator) -> Leg:
    """Two links of 0.12 to 0.3 m with springs of 1.5 to 4 Hz and dampers about half critical."""
    joints = []
    outboard = 0.0
    for name in reversed(NAMES):
        length, mass = generator.uniform(0.12, 0.3), generator.uniform(0.1, 0.5)
        inertia = mass * length**2 / 12.0
        outboard += inertia + mass * (0.5 * length) ** 2
        rate = outboard * (2.0 * np.pi * generator.uniform(1.5, 4.0)) ** 2
        damping = 2.0 * generator.uniform(0.2, 0.8) * np.sqrt(rate * outboard)
        sign, zero = int(generator.choice([-1, 1])), float(np.radians(generator.choice([90.0, 180.0])))
        link = Link(round(length, 4), round(mass, 4), round(0.5 * length, 4), float(f"{inertia:.4g}"))
        rest = generator.uniform(-0.4, 0.4)
        joints.append(Joint(name, link, zero, sign, None, Spring(rate, zero + sign * rest), Damper(damping)))
        outboard += mass * length**2
    return Leg("random", tuple(reversed(joints)))


def write_project(folder: Path, seed: int) -> LegProject:
    """A random project in ``folder``."""
    generator = np.random.default_rng(seed)
    leg = random_leg(generator)
    (folder / "leg.yaml").write_text(
        LEG
        + "".join(
            JOINT.format(j.name, np.degrees(j.zero), j.sign, j.link.length, j.link.mass, j.link.com, j.link.inertia)
            for j in leg.joints
        )
    )
    releases = [
        WantedRelease(f"{k}", TIME, generator.uniform(-0.9, 0.9, 2), np.zeros(2), Conditions()) for k in range(3)
    ]
    for k, motion in enumerate(WantedResponse.of(leg, releases).motions):
        angles = np.degrees(leg.to_measured(motion) + generator.normal(0.0, NOISE, motion.shape))
        columns = {"time [s]": TIME, **{f"{n} [deg]": angles[:, j] for j, n in enumerate(NAMES)}}
        write_csv(folder / f"release_{k}.csv", columns)
    wishes = [
        "{}",
        "{spring: {make: true}}",
        "{spring: {rate_tolerance: 30 %, parallel: 2}, damper: {parallel: 2, ratios: [1, 2]}}",
        "{spring: {rate_tolerance: 20 %}}",
    ]
    hip, knee = generator.choice(wishes, 2)
    text = PROJECT.format(time=float(generator.choice([1.0, 1.0, 2.0])), hip=hip, knee=knee)
    (folder / "project.yaml").write_text(text)
    return read_leg_project(folder / "project.yaml")


def random_catalogue(seed: int) -> Catalogue:
    """The built-in springs and dampers that can be chosen, beside six and four more of each at random sizes."""
    generator = np.random.default_rng([seed, 1])
    whole = Catalogue.load()
    springs = [row for row in whole.springs if row.complete]
    dampers = [row for row in whole.dampers if row.complete]
    spring, damper = springs[0], dampers[0]
    assert spring.rate is not None
    assert damper.max_torque is not None
    more = [
        replace(spring, part=f"S{k}", rate=float(rate), file="random") for k, rate in enumerate(
            np.exp(generator.uniform(np.log(0.2), np.log(40.0), 6))
        )
    ]  # fmt: skip
    strong = [
        replace(damper, part=f"D{k}", max_torque=float(torque), file="random", curve_speed=(), curve_torque=())
        for k, torque in enumerate(np.exp(generator.uniform(np.log(0.05), np.log(3.0), 4)))
    ]
    return replace(whole, springs=(*springs, *more), dampers=(*dampers, *strong))


def parts_at_one_joint(design: LegDesign) -> list[tuple[str, int, str]]:
    """Kind, joint and part of every bought part that stands at one joint only."""
    found = [("damper", j, option.part) for j, option in enumerate(design.dampers.chosen)]
    found += [("spring", j, o.part) for j, o in enumerate(design.springs.chosen) if o.row is not None]
    parts = [part for _, _, part in found]
    return [item for item in found if parts.count(item[2]) == 1]


def listed_exchange(design: LegDesign, kind: str, joint: int, part: str) -> tuple[float, float] | None:
    """Expected and nominal error (deg) of the best exchange that was listed for a part and meets the wishes."""
    ranked = design.springs.ranked[joint] if kind == "spring" else design.dampers.ranked[joint]
    errors = [
        (option.expected, option.error)
        for option in ranked
        if option.part != part
        and not (kind == "spring" and (getattr(option, "outside", False) or getattr(option, "compared", False)))
    ]
    return None if not errors else tuple(np.degrees(min(errors)).tolist())  # type: ignore[return-value]


def case(seed: int) -> Case:
    """One project, in full and without a part."""
    with tempfile.TemporaryDirectory() as name:
        project, catalogue = write_project(Path(name), seed), random_catalogue(seed)
        try:
            full = design_leg(project, catalogue)
        except UserError as error:
            return Case(seed, "", "told", found=None) if str(error) else Case(seed, "", "silent")
        choices = parts_at_one_joint(full)
        if not choices:
            return Case(seed, "", "no part stands at one joint alone")
        kind, joint, part = choices[int(np.random.default_rng([seed, 2]).integers(len(choices)))]
        best = listed_exchange(full, kind, joint, part)
        without = replace(project, parts=replace(project.parts, without=(part,)))
        try:
            fewer = design_leg(without, catalogue)
        except UserError:
            return Case(seed, part, "told" if best is None else "refused what had been listed", *(best or ()))
        # On the draws that the list was judged with.
        expected = fewer.dampers.chosen[0].expected
        nominal = float(np.degrees(fewer.sets.chosen.error))
        return Case(seed, part, "made", *(best or (None, None)), float(np.degrees(expected)), nominal)


def main(count: int, seed: int) -> int:
    """Run and print what came of it; how many times the property did not hold."""
    cases = []
    for k in range(count):
        one = case(seed + k)
        cases.append(one)
        sys.stdout.write(f"{one} {one.worse:+.3f} deg {'' if one.holds else 'WORSE'}\n")
        sys.stdout.flush()
    made = [one for one in cases if one.listed is not None and one.found is not None]
    worst = max((one.worse for one in made), default=float("nan"))
    nominal = sum((one.found_nominal or 0.0) > (one.listed_nominal or 0.0) + WORSE for one in made)
    bad = sum(not one.holds and one.outcome != "no part stands at one joint alone" for one in cases)
    sys.stdout.write(
        f"{len(cases)} projects, {len(made)} with a listed exchange: worst {worst:+.3f} deg, {bad} do not hold; "
        f"by nominal parts {nominal} are more than {WORSE} deg worse\n"
    )
    return bad


if __name__ == "__main__":
    raise SystemExit(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1) > 0)
