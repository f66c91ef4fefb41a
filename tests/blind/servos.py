"""Servo-driven legs, the causes withheld: ``python -m blind.servos --seed 5000 --count 40 --to build/blind-servos``.

As ``python -m blind.rigs``, with legs of one and two links that follow commands: a fine encoder, one main cause (or
two, or none, or one outside the library) that leaves 40 to 250 floors after the tolerances took what they can, three
small ones of 3 to 12 % of it, a mass two or three tolerances off. A cause within the tolerances, as a motor constant
4 % off where 3 % are stated, is none by the rules of ``gap``.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

from blind.asked import Asked
from blind.best_size import best_size
from blind.rigs import check, mixed
from blind.servo_engine import COLUMNS, Array, Rig, follow, shown_as

MAIN = (40.0, 250.0)  # floors, of a main cause
SMALL = (0.03, 0.12)  # of the main cause's gap
SMALL_ONES = 3  # beside the main cause
FLOOR = (2.5e-5, 1e-4)  # rad RMS of the encoder: 0.0015 to 0.006 deg
LENGTH, RATE = 4.0, 200.0  # s and samples a second of a log
MASS_TOLERANCE = 0.01
# Standard deviations that the project states, by column; the diagnosis takes a number as off by at most ``MOST_OFF``.
TOLERANCES = {
    "length": 0.005,
    "mass": MASS_TOLERANCE,
    "com": 0.01,
    "inertia": 0.02,
    "constant": 0.03,
    "resistance": 0.03,
}
MOST_OFF = 2.5
DOMINATES = 0.5  # of the gap, most that is left without the main cause
ALIKE = 0.1  # of the main cause's gap: another single cause that leaves less is as right
VARIED = 3  # kinds of a log's command: sines, ramps, steps
BOTH_WAYS = ("servo_gain", "torque_constant", "winding_resistance")  # causes that can be more and less
CLOSE, MOST_HALVINGS = 0.02, 12  # relative tolerance of a wanted gap, in at most so many steps
ATTEMPTS = 60
Change = Callable[[Rig, int, float], Rig]  # rig, joint, size 0..1


def _put(name: str, most: float) -> Change:
    return lambda rig, j, size: rig.changed(j, **{name: float(rig.joints[j, COLUMNS.index(name)]) + most * size})


def _scale(name: str, most: float) -> Change:
    return lambda rig, j, size: rig.changed(
        j, **{name: float(rig.joints[j, COLUMNS.index(name)]) * math.exp(most * size)}
    )


def _limit(rig: Rig, j: int, size: float) -> Rig:
    """From four times the current that holds the leg level down to one that hardly does."""
    return rig.changed(j, current=_holding(rig, j) * math.exp(math.log(4.0) - size * math.log(4.0 / 0.5)))


def _stribeck(rig: Rig, j: int, size: float) -> Rig:
    most = 0.4 * _level(rig, j)
    return rig.changed(j, dry=0.35 * most * size, rest=0.65 * most * size, speed=0.4, power=1.5)


# Where the recorded angle and the controller's are read: the encoder on the output, a second one there, on the rotor.
ENCODERS = ((1.0, 1.0), (1.0, 0.0), (0.0, 0.0))


def _gear_play(rig: Rig, j: int, size: float) -> Rig:
    """Up to 8 deg; the encoders' places are drawn by the digits of the link's length, which sizes do not change."""
    read, controlled = ENCODERS[int(float(rig.joints[j, 0]) * 1e9) % len(ENCODERS)]
    return rig.changed(j, play=0.14 * size, read_beyond=read, controlled_beyond=controlled)


LIBRARY: dict[str, Change] = {
    "gear_friction": lambda rig, j, size: rig.changed(j, of_motor=0.5 * size, of_load=0.03 * size),
    "coulomb_friction": lambda rig, j, size: rig.changed(j, dry=0.4 * _level(rig, j) * size),
    "stribeck_friction": _stribeck,
    "viscous_damping": lambda rig, j, size: rig.changed(j, viscous=0.3 * _level(rig, j) * size),
    "current_limit": _limit,
    "command_delay": _put("delay", 0.08),
    "command_rate_limit": lambda rig, j, size: rig.changed(j, rate=80.0 * math.exp(-5.8 * size)),
    "dead_band": _put("dead", 0.1),
    "servo_gain": _scale("gain", -0.9),
    "torque_constant": _scale("constant", 0.7),
    "winding_resistance": _scale("resistance", 0.9),
    "voltage_sag": lambda rig, j, size: Rig(rig.joints, rig.source + 3.0 * rig.joints[0, 8] * size),
    "gear_play": _gear_play,
    # Of the servo's own encoder, which it controls by.
    "encoder_offset": _put("shift", 0.2),
    "encoder_scale": _put("scaled", 0.2),
    "armature": lambda rig, j, size: rig.changed(
        j, rotor=float(rig.joints[j, 12]) + 3.0 * _level(rig, j) / 30.0 * size
    ),
}
OUTSIDE: dict[str, Change] = {
    "cogging": lambda rig, j, size: rig.changed(j, cogging=0.8 * _level(rig, j) * size, cogs=11.0),
    "integral": lambda rig, j, size: rig.changed(j, integral=float(rig.joints[j, 4]) * 6.0 * size),
    "smoothed_command": lambda rig, j, size: rig.changed(j, smooth=0.15 * size),
}


def _level(rig: Rig, j: int) -> float:
    """N m that hold the leg level at a joint."""
    a, b = rig.joints[0], rig.joints[-1]
    far = float(b[1] * b[2])
    if len(rig.joints) == 1 or j == 1:
        return 9.81 * far
    return 9.81 * float(a[1] * a[2] + b[1] * a[0]) + 9.81 * far


def _holding(rig: Rig, j: int) -> float:
    return _level(rig, j) / float(rig.joints[j, 7])


class NotApplicable(Exception):
    """A rig that cannot show the cause."""


@dataclass(frozen=True)
class Setup:
    """The design, the supply, and commands (m, n) a log; the last quarter only score."""

    design: Rig
    supply: float
    commands: tuple[Array, ...]

    @property
    def times(self) -> Array:
        """(m,) s."""
        return np.arange(0.0, LENGTH, 1.0 / RATE)

    @property
    def held_out(self) -> range:
        """Places of the logs that only score."""
        return range(len(self.commands) - len(self.commands) // 4, len(self.commands))

    def moved(self, rig: Rig) -> Array:
        """(k, m, n) rad, every log."""
        found = np.stack([follow(rig, self.times, command, self.supply) for command in self.commands])
        if not np.all(np.isfinite(found)) or np.abs(found).max() > 6.0:
            raise NotApplicable("the rig runs away")
        return found


def _setup(rng: np.random.Generator) -> Setup:
    n = int(rng.choice([1, 2]))
    joints, supply = np.zeros((n, len(COLUMNS))), float(rng.choice([7.4, 12.0]))
    for j in range(n):
        length, mass = rng.uniform(0.08, 0.2), rng.uniform(0.1, 0.5) / (1.0 + j)
        com = rng.uniform(0.5, 0.95) * length
        joints[j, :4] = length, mass, com, mass * length**2 / 12.0
        joints[j, 15:17] = 1.0, 1.0
    design = Rig(joints, 0.0)
    for j in range(n):
        stall = rng.uniform(3.0, 6.0) * _level(design, j)
        free = rng.uniform(6.0, 12.0)  # rad/s
        constant = supply / free
        resistance = constant * supply / stall
        inertia = _level(design, j) / 9.81 * float(joints[:, 0].sum())
        joints[j, 4:13] = (
            rng.uniform(1.5, 5.0), 0.0, 1.0, constant, resistance, 1e9, 0.0, 0.0, rng.uniform(0.3, 2.0) * inertia
        )  # fmt: skip
    return Setup(Rig(joints, 0.0), supply, tuple(_command(rng, n, k) for k in range(8)))


def _command(rng: np.random.Generator, n: int, k: int) -> Array:
    """A log's command: sums of sines, ramps, steps, in turn."""
    t = np.arange(0.0, LENGTH, 1.0 / RATE)
    made = []
    for _ in range(n):
        size = rng.uniform(0.5, 1.1)
        if k % 3 == 0:
            shape = np.sin(2 * np.pi * rng.uniform(0.3, 0.8) * t) + 0.4 * np.sin(2 * np.pi * rng.uniform(1.0, 2.5) * t)
        elif k % 3 == 1:
            shape = 2.0 / np.pi * np.arcsin(np.sin(np.pi * t / rng.uniform(0.8, 2.5)))
        else:
            places = rng.uniform(-1.0, 1.0, 6)
            places[0] = 0.0
            shape = places[np.minimum((t / (LENGTH / 6.0)).astype(int), 5)]
        made.append(size * shape / 1.2)
    return np.stack(made, axis=1)


def _rms(a: Array) -> float:
    return float(np.sqrt(np.mean(a**2)))


@dataclass(frozen=True)
class Absorbed:
    """Changes of the logs by wrong parameters within their tolerances, to first order.

    ``columns`` (k, m, n, p) rad, for one standard deviation of each number.
    """

    columns: Array

    @classmethod
    def of(cls, setup: Setup, still: Array) -> Absorbed:
        """Of every number of every joint."""
        made = []
        for j in range(len(setup.design.joints)):
            for name, width in TOLERANCES.items():
                off = float(setup.design.joints[j, COLUMNS.index(name)]) * (1.0 + width)
                made.append(setup.moved(setup.design.changed(j, **{name: off})) - still)
        return cls(np.stack(made, axis=-1))

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        """The orthogonal and the triangular factor of all logs' columns."""
        q, r = np.linalg.qr(self.columns.reshape(-1, self.columns.shape[-1]))
        return q, r

    def rest(self, gap: Array) -> float:
        """Rad RMS left of a ``gap`` (k, m, n) of all logs."""
        q, r = self._factors
        seen = q.T @ gap.reshape(-1)
        missed = seen - r @ lsq_linear(r, seen, (-MOST_OFF, MOST_OFF)).x
        return math.sqrt(max(float(np.sum(gap**2) - seen @ seen + missed @ missed), 0.0) / gap.size)

    def rest_of(self, gap: Array, places: Sequence[int]) -> float:
        """Rad RMS left of a ``gap`` (k, m, n) of the logs at ``places``, fitted to the others."""
        learnt = [k for k in range(len(gap)) if k not in places]
        q, r = np.linalg.qr(self.columns[learnt].reshape(-1, self.columns.shape[-1]))
        left = gap - self.columns @ lsq_linear(r, q.T @ gap[learnt].reshape(-1), (-MOST_OFF, MOST_OFF)).x
        return _rms(left[places])


def _sized(
    setup: Setup, still: Array, change: Change, j: int, wanted: float, absorbed: Absorbed | None = None
) -> float:
    """Size at which a change of the design moves the logs by ``wanted`` rad RMS; raises where it cannot.

    ``absorbed`` : with it, what is left after the tolerances took what they can.
    """

    def gap(size: float) -> float:
        moved = setup.moved(change(setup.design, j, size)) - still
        return _rms(moved) if absorbed is None else absorbed.rest(moved)

    low, high, under, over = 0.0, 1.0, -wanted, gap(1.0) - wanted
    if over < 0.0:
        raise NotApplicable("too weak")
    for _ in range(MOST_HALVINGS):
        if min(-under, over) < CLOSE * wanted:
            break
        middle = 0.5 * (low + high)
        left = gap(middle) - wanted
        low, high, under, over = (middle, high, left, over) if left < 0.0 else (low, middle, under, left)
    return high


def make_case(seed: int, number: int, kind: str, effect: str, out: Path) -> tuple[str, dict[str, Any]]:
    """Make and write one rig; its folder's name and answer."""
    rng = np.random.default_rng([seed, number, 0x5E])
    for _ in range(ATTEMPTS):
        try:
            return _attempt(rng, seed, number, kind, effect, out)
        except (NotApplicable, FloatingPointError):
            continue
    raise RuntimeError(f"{kind} {effect}: no rig in {ATTEMPTS} attempts")


def _attempt(
    rng: np.random.Generator, seed: int, number: int, kind: str, effect: str, out: Path
) -> tuple[str, dict[str, Any]]:
    setup = _setup(rng)
    floor = math.exp(rng.uniform(*np.log(FLOOR)))
    level = floor * math.exp(rng.uniform(*np.log(MAIN)))
    still, rig, n = setup.moved(setup.design), setup.design, len(setup.design.joints)
    absorbed = Absorbed.of(setup, still)
    main: list[tuple[str, int]] = []
    names = [] if kind == "none" else [effect]
    if kind == "two":
        names.append(str(rng.choice(sorted(set(LIBRARY) - {effect}))))
    for name in names:
        j, change = int(rng.integers(0, n)), {**LIBRARY, **OUTSIDE}[name]
        rig = change(rig, j, _sized(setup, still, change, j, level * rng.uniform(0.8, 1.0), absorbed))
        main.append((name, j))
    alone = setup.moved(rig)
    small = []
    for name in rng.permutation(sorted(set(LIBRARY) - {name for name, _ in main})).tolist():
        if len(small) == SMALL_ONES:
            break
        j, part = int(rng.integers(0, n)), level * math.exp(rng.uniform(*np.log(SMALL)))
        try:
            rig = LIBRARY[name](rig, j, _sized(setup, still, LIBRARY[name], j, part))
        except NotApplicable:
            continue
        small.append((name, j))
    off, j = float(rng.choice([-1.0, 1.0]) * rng.uniform(2.0, 3.0)), int(rng.integers(0, n))
    rig = rig.changed(j, mass=float(rig.joints[j, 1]) * (1.0 + off * MASS_TOLERANCE))
    whole = setup.moved(rig)
    scored = list(setup.held_out)
    before, left = absorbed.rest_of(whole - still, scored), absorbed.rest_of(whole - alone, scored)
    if kind in ("single", "two") and left > DOMINATES * before:
        raise NotApplicable("no main cause")
    if left > SMALL_ONES * SMALL[1] * level:
        # A limit sized on the design alone takes more beside a larger motor constant than each of two main causes did.
        raise NotApplicable("small causes that are a large one together: a torque limit that no longer holds the leg")
    alike = [other for name, j in main for other in shown_as(name, j, n)[1:]]
    also = _alike(setup, still, alone, main, absorbed) if kind == "single" else []
    alike += [shown for name, j in also for shown in shown_as(name, j, n)]
    label = [f"joint{k + 1}" for k in range(n)] + ["base"]
    answer = {
        "kind": kind,
        "effects": [{"effect": seen, "joint": label[k]} for name, j in main for seen, k in shown_as(name, j, n)[:1]],
        "small": [{"effect": seen, "joint": label[k]} for name, j in small for seen, k in shown_as(name, j, n)],
        "numbers_called": [["link_mass", label[j]], ["link_inertia", label[j]]],
        "alike": [[name, label[k]] for name, k in alike],
        "noise_floor_deg": math.degrees(floor),
        "before_deg": math.degrees(math.hypot(before, floor)),
        "best_possible_deg": math.degrees(math.hypot(min(left, before), floor)),
    }
    name = f"servo_{seed}_{number:03d}"
    _write(rng, setup, whole, floor, label[:n], out / name)
    return name, answer


def _alike(
    setup: Setup,
    still: Array,
    target: Array,
    main: list[tuple[str, int]],
    absorbed: Absorbed,
    among: Collection[tuple[str, int]] | None = None,
) -> list[tuple[str, int]]:
    """Other single causes, all or ``among`` these, that at their best size leave less than ``ALIKE`` of the main gap.

    The best size is found on one log of each kind, which takes most of a case's time; all logs then count.
    """
    few = Setup(setup.design, setup.supply, setup.commands[:VARIED])
    little = Absorbed(absorbed.columns[:VARIED])
    part, gap = little.rest((target - still)[:VARIED]), absorbed.rest(target - still)
    found: list[tuple[str, int]] = []
    for name, change in LIBRARY.items():
        for j in range(len(setup.design.joints)):
            if (name, j) == main[0] or (among is not None and (name, j) not in among):
                continue
            if name == "voltage_sag" and (j or main[0][0] == name):  # one for all joints
                continue

            def left(size: float, change: Change = change, j: int = j) -> float:
                try:
                    return little.rest(few.moved(change(setup.design, j, size)) - target[:VARIED])
                except NotApplicable:
                    return 1e3

            size, least = best_size(left, name in BOTH_WAYS, 0.5 * part)
            if least < 2.0 * ALIKE * part:
                all_left = absorbed.rest(setup.moved(change(setup.design, j, size)) - target)
                found += [(name, j)] if all_left < ALIKE * gap else []
    return found


def _write(rng: np.random.Generator, setup: Setup, whole: Array, floor: float, label: list[str], folder: Path) -> None:
    """The leg as designed and the logs, in the public formats."""
    folder.mkdir(parents=True)
    lines = ["kind: leg", f"name: {folder.name}", "joints:"]
    for name, p in zip(label, setup.design.joints.tolist(), strict=True):
        lines += [
            f"  - name: {name}",
            "    zero: 0 deg",
            "    sign: +1",
            f"    link: {{length: {p[0]:.9g} m, mass: {p[1]:.9g} kg, com: {p[2]:.9g} m, inertia: {p[3]:.9g} kg*m^2}}",
            f"    armature: {p[12]:.9g} kg*m^2",
            f"    drive: {{kind: servo, gain: {p[4]:.9g} 1/rad, supply: {setup.supply} V,"
            f" motor: {{torque_constant: {p[7]:.9g} N*m/A, resistance: {p[8]:.9g} ohm}}}}",
        ]
    (folder / "leg.yaml").write_text("\n".join(lines) + "\n")
    entries = []
    for k, command in enumerate(setup.commands):
        read = whole[k] + floor * rng.standard_normal(whole[k].shape)
        table = np.column_stack([setup.times, np.degrees(read), np.degrees(command)])
        header = ",".join(["time [s]", *[f"{x} [deg]" for x in label], *[f"{x} command [deg]" for x in label]])
        np.savetxt(folder / f"log_{k + 1}.csv", table, "%.7g", ",", header=header, comments="")
        entries.append(f"  - {{file: log_{k + 1}.csv, held_out: {str(k in setup.held_out).lower()}}}")
    told = {"constant": "torque_constant"}
    tolerance = ", ".join(f"{told.get(name, name)}: {100.0 * width:g} %" for name, width in TOLERANCES.items())
    (folder / "gap.yaml").write_text(
        "\n".join(["kind: gap", "leg: leg.yaml", f"tolerance: {{{tolerance}}}", "trials:", *entries]) + "\n"
    )


def plan(seed: int, count: int) -> list[tuple[int, str, str]]:
    """Like ``rigs.mixed``, with the causes of a servo."""
    return mixed(np.random.default_rng([seed, 0x5E5]), count, LIBRARY, OUTSIDE)


def one(seed: int, task: tuple[int, str, str], out: Path) -> tuple[str, dict[str, Any]]:
    """Make and write one rig; its folder's name and answer."""
    return make_case(seed, *task, out)


def main(words: Sequence[str] | None = None) -> int:
    asked = Asked.of(words, "blind.servos", __doc__)
    return check(asked, "blind-servos", plan(asked.seed, asked.count), one)


if __name__ == "__main__":
    sys.exit(main())
