"""Build and check seeded random joints, each in a separate process: ``make fuzz``.

A third of the designs is drawn from the whole declared ranges. A third is close to a valid joint. A third is like that
with two dimensions drawn from the whole range. This covers refusals, solids and the border between them. Every design
must end as

CHECKED   every gate passed, or
REFUSED   with the name of a dimension: before anything is built, or by a gate on strength or printing that names it.

Any other outcome is a failure:

STOPPED   a gate on geometry failed; nothing wrong is exported, but no dimension is named either,
CRASHED   an exception, TIMEOUT a hang (by the processor's time: a busy machine fails no joint), DIED a process that
          crashed in the CAD kernel.

The report is ``fuzz.json`` (every case with its seed) and a table by tag; the exit status is 1 after any failure.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import resource
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from synth.cad import (
    AdapterDimensions,
    DamperDimensions,
    DimensionError,
    EncoderDimensions,
    JointDimensions,
    LoadDimensions,
    MountDimensions,
    SpringDimensions,
    clear_upper_arm_angle,
)
from synth.cad.dimensions import coil_fraction
from synth.cad.fitting_problems import least_bolt_circle, least_encoder_circle
from synth.cad.hardware import shaft_sizes
from synth.cad.limits import limit_of

REFUSING = ("strength:", "print:")  # gates whose text names the dimension to change
PAIRS = 0.25  # share of the designs with two springs
TURNED = 0.25  # share of the designs whose springs close towards larger angles
ODD = 0.25  # share of the designs of ``anywhere`` whose shaft is not a stock size
WAITING = 20.0  # times the limit, by the clock: a process that neither ends nor works hangs
FAILURES = ("STOPPED", "CRASHED", "TIMEOUT", "DIED")


def _within(generator: random.Random, family: type, **fixed: Any) -> dict[str, Any]:
    """Random values for all ranged fields of a dimension class: uniform, log-uniform if the range is wide."""
    values = dict(fixed)
    for item in fields(family):
        if item.name in values or not item.metadata:
            continue
        limit = limit_of(family, item.name)
        if item.type in ("int", int):
            values[item.name] = generator.randint(int(limit.low), int(limit.high))
        elif limit.low > 0 and limit.high / limit.low > 5:
            values[item.name] = limit.low * (limit.high / limit.low) ** generator.random()
        else:
            values[item.name] = generator.uniform(limit.low, limit.high)
    return values


def anywhere(generator: random.Random) -> JointDimensions:
    """A joint with each dimension anywhere in its declared range; the few dependent ones are drawn together."""
    angle = generator.uniform(10.0, 350.0)
    coils = generator.randint(1, 12) + coil_fraction(angle)
    wire = 0.2 * 60.0 ** generator.random()
    spring = SpringDimensions(
        wire, wire * generator.uniform(2.5, 26.0), coils, angle, hand=generator.choice(["right", "left"])
    )
    zero = generator.choice([180.0, 90.0, 0.0])
    low = generator.uniform(-170.0, 100.0)
    high = low + generator.uniform(5.0, 160.0)
    rest = generator.uniform(low, high)
    drawn = _within(
        generator, JointDimensions, free_angle=generator.uniform(low, high), rest_angle=rest, zero_angle=zero,
        upper_arm_angle=0.0, floor=None, seat_screw=None, seat_length=None, socket=None,
    )  # fmt: skip
    damper = DamperDimensions(**_within(generator, DamperDimensions, travel=None))  # which changes no solid
    if drawn["link_width"] > ODD * limit_of(JointDimensions, "link_width").high:  # most shafts are stock
        drawn["shaft_diameter"] = _stock(drawn["shaft_diameter"])
    return JointDimensions(
        name="fuzz", spring=spring, range=(low, high), sign=generator.choice([1, -1]), damper=damper, **drawn
    )


def around(generator: random.Random) -> JointDimensions:
    """A joint with the proportions of a valid one, each optional part with some probability."""
    wire = generator.uniform(0.8, 5.0)
    angle = generator.uniform(60.0, 200.0)
    spring = SpringDimensions(
        wire, wire * generator.uniform(5.0, 12.0), generator.randint(2, 9) + coil_fraction(angle), angle,
        hand=generator.choice(["right", "left"]),
    )  # fmt: skip
    inner = spring.mean_diameter - wire
    shaft = _stock(max(3.0, min(16.0, inner * generator.uniform(0.35, 0.75))))
    zero = 180.0
    free = zero - generator.uniform(20.0, 110.0)
    low, high = free - generator.uniform(2.0, 45.0), free + generator.uniform(2.0, 45.0)
    width = generator.uniform(14.0, 30.0)
    body = max(shaft * 2.2 + 8.0, generator.uniform(20.0, 50.0))
    bolt = max(2.2, generator.uniform(2.0, 4.5))
    own = generator.uniform(4.0, 10.0)
    damper = DamperDimensions(
        body, generator.uniform(8.0, 30.0), body + bolt + generator.uniform(3.0, 10.0), generator.randint(2, 6), bolt,
        AdapterDimensions(own, 2 * own, 2 * shaft) if generator.random() < 0.4 else None,
    )  # fmt: skip
    encoder = EncoderDimensions(magnet_diameter=max(1.0, min(4.0, shaft - 1.0)))
    joint = JointDimensions(
        name="fuzz",
        spring=spring,
        free_angle=free,
        rest_angle=generator.uniform(low, high),
        range=(low, high),
        zero_angle=zero,
        sign=generator.choice([1, -1]),
        damper=damper,
        link_length=300.0,
        link_width=width,
        tube_wall=1.5,
        shaft_diameter=shaft,
        seat_travel=generator.choice([0.0, 12.0, 15.0]),
        clearance=generator.uniform(0.2, 0.8),
        fit=generator.uniform(0.05, 0.2),
        wall=generator.uniform(1.6, 5.0),
        plate=generator.uniform(4.0, 12.0),
        loads=LoadDimensions(generator.uniform(0.0, 3.0), generator.uniform(0.0, 0.2)),
        encoder=encoder if generator.random() < 0.5 else None,
        mount=MountDimensions() if generator.random() < 0.3 else None,
    )
    if joint.encoder is not None:
        circle = max(joint.encoder.bolt_circle, least_encoder_circle(joint) + 0.5)
        joint = replace(joint, encoder=replace(joint.encoder, bolt_circle=circle))
    return replace(joint, damper=replace(damper, bolt_circle=max(damper.bolt_circle, least_bolt_circle(joint) + 0.5)))


def _stock(diameter: float) -> float:
    """The largest stock rod diameter up to ``diameter`` mm, or the smallest stock diameter."""
    return max((size for size in shaft_sizes() if size <= diameter), default=shaft_sizes()[0])


def stretched(generator: random.Random) -> JointDimensions:
    """A joint of ``around`` with two of its dimensions drawn anywhere."""
    joint, wild = around(generator), anywhere(generator)
    names = ("shaft_diameter", "seat_screw", "clearance", "fit", "wall", "plate", "link_width", "cap", "damper",
             "floor", "encoder", "range", "seat_length")  # fmt: skip
    for name in generator.sample(names, 2):
        if name == "seat_screw":
            joint = replace(joint, seat_screw=generator.uniform(2.0, 8.0))
        elif name == "seat_length":
            joint = replace(joint, seat_length=generator.uniform(4.0, 40.0))
        elif name == "floor":
            joint = replace(joint, floor=generator.uniform(2.0, 60.0))
        elif name == "encoder":
            joint = replace(joint, encoder=EncoderDimensions(**_within(generator, EncoderDimensions)))
        elif name == "range":
            low = joint.rest_angle - generator.uniform(0.0, 90.0)
            joint = replace(joint, range=(low, joint.rest_angle + generator.uniform(0.5, 90.0)))
        else:
            joint = replace(joint, **{name: getattr(wild, name)})
    return joint


def design(seed: int) -> JointDimensions:
    """The design of a seed, of the three kinds in turn; shares of them have two springs or reversed springs."""
    generator = random.Random(seed)
    drawn = (around, stretched, anywhere)[seed % 3](generator)
    if drawn.mount is not None and generator.random() < 0.5:
        drawn = replace(drawn, mount=MountDimensions(**_within(generator, MountDimensions)))
    springs = 2 if generator.random() < PAIRS else 1
    return replace(drawn, springs=springs, closes=1 if generator.random() < TURNED else -1)


def outcome(dimensions: JointDimensions) -> dict[str, Any]:
    """Build and check one joint; returns its tag and a description."""
    from synth.cad.checks import check_joint
    from synth.cad.joint import build_joint

    try:
        dimensions = replace(dimensions, upper_arm_angle=clear_upper_arm_angle(dimensions))
        joint = build_joint(dimensions)
    except DimensionError as error:
        named = [problem.dimension for problem in error.problems]
        if not all(name and problem.reason for name, problem in zip(named, error.problems, strict=True)):
            return {"tag": "CRASHED", "what": "a refusal without a name", "text": str(error)}
        return {"tag": "REFUSED", "what": named[0].removeprefix("fuzz."), "text": str(error).splitlines()[0]}
    failed = [check for check in check_joint(joint) if not check.passed]
    if not failed:
        return {"tag": "CHECKED", "what": "", "text": ""}
    wrong = [check for check in failed if not check.name.startswith(REFUSING)]
    worst = (wrong or failed)[0]
    return {"tag": "STOPPED" if wrong else "REFUSED", "what": worst.name, "text": str(worst)}


def _child(seed: int, path: Path, limit: float, work: Callable[[JointDimensions], dict[str, Any]]) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), resource.RLIM_INFINITY))
    signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    try:
        found = work(design(seed))
    except Exception as error:  # any exception is a failure to report
        found = {"tag": "CRASHED", "what": type(error).__name__, "text": str(error)[:500]}
    path.write_text(json.dumps(found))
    os._exit(0)


def run(seeds: list[int], folder: Path, workers: int, limit: float) -> dict[int, dict[str, Any]]:
    """Outcomes by seed; each design has a forked process, at most ``workers`` at a time.

    ``limit`` : seconds of the processor after which a process is killed, and ``WAITING`` times as long by the clock.
    """
    waiting, running, results = list(seeds), {}, {}
    while waiting or running:
        while waiting and len(running) < workers:
            seed = waiting.pop(0)
            process = os.fork()
            if process == 0:
                _child(seed, folder / f"{seed}.json", limit, outcome)
            running[process] = (seed, time.monotonic())
        for process, (seed, start) in list(running.items()):
            done, status = os.waitpid(process, os.WNOHANG)
            path, spent = folder / f"{seed}.json", time.monotonic() - start
            if not done and spent > WAITING * limit:
                os.kill(process, signal.SIGKILL)
                os.waitpid(process, 0)
                found: dict[str, Any] = {"tag": "TIMEOUT", "what": f"{limit:g} s", "text": ""}
            elif not done:
                continue
            elif os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU:
                found = {"tag": "TIMEOUT", "what": f"{limit:g} s", "text": ""}
            elif path.exists():
                found = json.loads(path.read_text())
            else:
                found = {"tag": "DIED", "what": f"status {status}", "text": ""}
            path.unlink(missing_ok=True)
            results[seed] = {**found, "seconds": round(spent, 2)}
            if len(results) % 20 == 0:
                tags = Counter(item["tag"] for item in results.values())
                so_far = ", ".join(f"{count} {tag}" for tag, count in tags.most_common())
                print(f"{len(results)} of {len(seeds)}: {so_far}", file=sys.stderr, flush=True)
            del running[process]
        time.sleep(0.01)
    return results


def report(results: dict[int, dict[str, Any]]) -> str:
    """A table by tag and named dimension, and each failure with its seed."""
    counts = Counter((found["tag"], found["what"]) for found in results.values())
    tags = Counter(found["tag"] for found in results.values())
    lines = [f"{len(results)} designs: " + ", ".join(f"{count} {tag}" for tag, count in tags.most_common())]
    lines += [f"  {count:4d}  {tag:8s} {what}" for (tag, what), count in sorted(counts.items(), key=lambda i: -i[1])]
    lines += [
        f"seed {seed}: {found['tag']}: {found['text'] or found['what']}"
        for seed, found in sorted(results.items())
        if found["tag"] in FAILURES
    ]
    return "\n".join(lines)


def main() -> int:
    """Run the designs of seeds SEED to SEED + COUNT - 1."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--limit", type=float, default=120.0, help="processor seconds a design may take")
    parser.add_argument("--to", type=Path, default=Path("build/fuzz"))
    arguments = parser.parse_args()
    import cadquery  # noqa: F401  # once, before the processes are forked

    import synth.cad.checks  # noqa: F401

    arguments.to.mkdir(parents=True, exist_ok=True)
    seeds = list(range(arguments.seed, arguments.seed + arguments.count))
    results = run(seeds, arguments.to, arguments.workers, arguments.limit)
    ordered = {str(seed): results[seed] for seed in seeds}
    (arguments.to / "fuzz.json").write_text(json.dumps(ordered, indent=1) + "\n")
    print(report(results))
    return int(any(found["tag"] in FAILURES for found in results.values()))


if __name__ == "__main__":
    sys.exit(main())
