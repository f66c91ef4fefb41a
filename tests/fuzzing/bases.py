"""Small projects of every kind, run in a second or two, that the fuzzer changes."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from hopper.recorded import jumped, pulled
from motion.importers.simulated_leg import PARTS, RATE, angles, pixels, points
from swing.effects.test_users_own import MAGNET
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIME = np.arange(0.0, 0.8, 0.01)
LEG = Leg(
    "small",
    (
        Joint("hip", Link(0.25, 0.6, 0.11, 4e-3), 0.4, 1, None, Spring(6.0, 0.5), Damper(0.08)),
        Joint("knee", Link(0.22, 0.35, 0.09, 2e-3), 2.0, -1, None, Spring(1.5, 1.8), Damper(0.015)),
    ),
)
LEG_TEXT = """kind: leg
name: small
gravity: 9.81 m/s^2
tilt: 0 deg
joints:
  - name: hip
    zero: 22.9183 deg
    sign: +1
    range: [-60 deg, 120 deg]
    link: {length: 250 mm, mass: 0.6 kg, com: 110 mm, inertia: 4e-3 kg*m^2}
    spring: {rate: 6 N*m/rad, free_angle: 28.6479 deg}
    damper: {rate: 0.08 N*m*s/rad}
  - name: knee
    zero: 114.592 deg
    sign: -1
    link: {length: 220 mm, mass: 0.35 kg, com: 90 mm, inertia: 2e-3 kg*m^2}
    spring: {rate: 1.5 N*m/rad, free_angle: 103.132 deg}
    damper: {rate: 0.015 N*m*s/rad}
    effects:
      - coulomb_friction: {torque: 0.002 N*m}
"""
FIT = """kind: fit
leg: small.leg.yaml
trials:
  - trials/a.csv
  - {file: trials/b.csv, tip_mass: 5 g}
  - {file: trials/c.csv, held_out: true}
free_angle: auto
fit: {method: least_squares, cost: trajectory, weight: noise, intervals: sensitivities, seed: 3}
prior: {spring: 30 %}
static:
  - {angles: {hip: 40 deg, knee: 100 deg}, torque: {hip: 0.2 N*m}, torque_error: 0.1 N*m}
"""
GAP = """kind: gap
leg: small.leg.yaml
trials:
  - trials/a.csv
  - {file: trials/b.csv, tilt: 2 deg}
  - {file: trials/c.csv, held_out: true}
tolerance: {length: 0.5 %, mass: 1 %, com: 1 %, inertia: 2 %, spring: 3 %, damper: 5 %, free_angle: 0.5 deg}
seed: 1
"""
DESIGN = """kind: leg-design
name: small design
source:
  leg: small.leg.yaml
  trials: [trials/*.csv]
scale: {time: 1.5}
target: robot.leg.yaml
fit: {method: least_squares, cost: trajectory, weight: amplitude}
select:
  joints:
    hip: {spring: {make: true, wire: music}, damper: {direction: both, travel: 360 deg}}
    knee: {spring: {rate_tolerance: 5 %, included_angle: 120 deg, max_outer_diameter: 1.25 in}}
cad: {shaft_diameter: 8 mm, clearance: 0.4 mm, wall: 3 mm, bed: [320 mm, 132 mm, 154 mm]}
"""
HOPPER = """kind: hopper-design
name: laminate leg
model: D
motors: {use: ["N20 HP 6V 150:1"], supply: 6 V, gearbox: warn}
lengths: {least: 100 mm, most: 120 mm, step: 10 mm}
leg: {hip_spacing: 30 mm, structure_mass: 17.9 g, bending: upper, crouch: 39.0 deg, extended: 10 deg}
laminate: {reference_length: 120 mm, link_mass: 3 g, beam_rate: 14.0224 N*m/rad}
flexures: {rate: 0.0229183 N*m/rad, damping: 0.00025 N*m*s/rad}
contact: {stiffness: 10000 N/m, dissipation: 5 s/m, friction: 0.7}
objectives: [clearance, relative_height]
choose: clearance
"""
HOPPER_GAP = """kind: gap
leg: hopper.yaml
motor: "N20 HP 6V 150:1"
length: 120 mm
trials:
  - jumps/a.csv
  - pull-ups/a.csv
  - {file: jumps/b.csv, length: 120 mm, held_out: true}
tolerance: {damper: 15 %, motor: 2 %, ground: 30 %}
"""
IMPORT = """kind: import
leg: rat.leg.yaml
files: [videos/*.csv]
points: [{parts}]
frame_rate: 250 Hz
release: keep
"""
MOT = b"""kind: import
leg: rat.leg.yaml
files: [a.mot]
joints:
  hip: {column: hip_flexion_r, zero: 0 deg, sign: +1}
  knee: {column: knee_angle_r, zero: 0 deg, sign: +1}
  ankle: {column: ankle_angle_r, zero: -20 deg, sign: -1}
release: keep
"""
RAT = """kind: leg
name: rat
joints:
  - {name: hip, zero: 90 deg, sign: +1, link: {length: 29 mm, mass: 13 g, com: 13 mm, inertia: 1e-6 kg*m^2}}
  - {name: knee, zero: 180 deg, sign: +1, link: {length: 41 mm, mass: 9 g, com: 15 mm, inertia: 1.5e-6 kg*m^2}}
  - {name: ankle, zero: 180 deg, sign: -1, link: {length: 33 mm, mass: 2 g, com: 16 mm, inertia: 2e-7 kg*m^2}}
"""
WISH = """kind: part-wish
spring: {rate: 2.2 N*m/rad, rate_tolerance: 10 %, included_angle: 120 deg, max_outer_diameter: 1.25 in, parallel: 2}
damper: {torque: 0.1 N*m, speed: 10 rpm, ratios: [1, 1.5]}
catalogs: [parts/*.csv]
"""
CATALOGUE = """part,vendor,material,included_angle [deg],rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],coils [1]
A1,Shop,music wire,120,2.26,3.2,30.2,5.17
H2,Shop,music wire,120,1.13,3.2,30.2,10.17
B3,Other,stainless,90,2.3,4.0,60,6.25
"""
PLAIN = {"small.leg.yaml": LEG_TEXT}


@dataclass(frozen=True)
class Base:
    """A project: files by name, and the command that runs it, ``{out}`` standing for what it is to write.

    ``slow`` : it runs for many seconds, so that it is mostly only checked. ``options`` : that a case may add.
    """

    name: str
    files: dict[str, bytes]
    command: tuple[str, ...]
    slow: bool = False
    options: tuple[tuple[str, ...], ...] = ()


def table(header: str, values: np.ndarray) -> bytes:
    """A CSV."""
    return "\n".join([header, *(",".join(f"{cell:.7g}" for cell in row) for row in values), ""]).encode()


def swings(folder: str = "trials") -> dict[str, bytes]:
    """Three releases of the leg with noise."""
    generator = np.random.default_rng(5)
    found = {}
    for name, away in (("a", (0.5, 0.6)), ("b", (-0.4, 0.5)), ("c", (0.3, -0.5))):
        rotation = simulate(LEG, LEG.rest + np.array(away), [0.0, 0.0], TIME)
        measured = np.degrees(LEG.to_measured(rotation)) + generator.normal(0.0, 0.1, (len(TIME), 2))
        found[f"{folder}/{name}.csv"] = table("time [s],hip [deg],knee [deg]", np.column_stack([TIME, measured]))
    return found


def driven() -> dict[str, bytes]:
    """One with a known torque, denser than the angles."""
    found = swings()
    rows = found["trials/a.csv"].decode().splitlines()
    dense = ["time [s],hip [deg],knee [deg],knee torque [N*m]"]
    for k, row in enumerate(rows[1:]):
        dense += [f"{row},{0.01 * (k % 3):g}", f"{0.01 * k + 0.004:g},,,{0.01 * (k % 5):g}"]
    return found | {"trials/a.csv": "\n".join([*dense[:-1], ""]).encode()}


def run_ups() -> dict[str, bytes]:
    """Three run-ups of a motor, in closed form without inductance: speed rises exponentially."""
    found, time = {}, np.arange(0.0, 0.8, 2e-3)
    generator = np.random.default_rng(2)
    for volt in (2.0, 4.0, 6.0):
        speed = (volt / 1.75e-3 / 150.0) * 0.9 * (1.0 - np.exp(-time / 0.05))
        current = (volt - 1.75e-3 * 150.0 * speed) / 3.9
        values = np.column_stack([time, np.full_like(time, volt), current, speed])
        values[:, 1:] *= 1.0 + generator.normal(0.0, 1e-3, (len(time), 3))
        found[f"runs/{volt:g}.csv"] = table("time [s],voltage [V],current [A],speed [rad/s]", values)
    return found


def jumps() -> dict[str, bytes]:
    """Jumps and a pull-up of the jumping leg."""
    return {
        "jumps/a.csv": table("time [s],ground force [N],upper link [rad]", jumped(seed=1)),
        "jumps/b.csv": table("time [s],ground force [N],upper link [rad]", jumped(seed=2)),
        "pull-ups/a.csv": table("time [s],hip torque [N*m],upper link [rad]", pulled()),
    }


def video() -> bytes:
    """Tracked points as DeepLabCut writes them."""
    places = pixels(points(angles()[1]))
    lines = [
        ",".join(["scorer", *["DLC"] * (3 * len(PARTS))]),
        ",".join(["bodyparts", *[part for part in PARTS for _ in range(3)]]),
        ",".join(["coords", *["x", "y", "likelihood"] * len(PARTS)]),
    ]
    for k, frame in enumerate(np.asarray(places).reshape(len(places), -1, 2)):
        lines.append(",".join([str(k), *(f"{x:.3f},{y:.3f},0.99" for x, y in frame)]))
    return "\n".join([*lines, ""]).encode()


def captured() -> bytes:
    """Points in the plane z = 0, y up, in mm, as TRC."""
    places = 1e3 * points(angles()[1])
    labels = "\t".join(f"{part}\t\t" for part in PARTS)
    axes = "\t".join(f"X{k}\tY{k}\tZ{k}" for k in range(1, len(PARTS) + 1))
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        f"{RATE:g}\t{RATE:g}\t{len(places)}\t{len(PARTS)}\tmm",
        f"Frame#\tTime\t{labels}",
        f"\t\t{axes}",
        "",
    ]
    for k, frame in enumerate(places):
        cells = (f"{x:.3f}\t{y:.3f}\t0.0" for x, y in frame)
        lines.append("\t".join([str(k + 1), f"{k / RATE:.4f}", *cells]))
    return "\n".join([*lines, ""]).encode()


def logged() -> bytes:
    """Angles as JSON, a list of records with the time."""
    time, measured = angles()
    titles = ("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    rows = (dict(zip(titles, map(float, (t, *row)), strict=True)) for t, row in zip(time, measured, strict=True))
    return json.dumps({"logger": 7, "rows": list(rows)}).encode()


@cache
def bases() -> tuple[Base, ...]:
    """Every kind of project, and every command that reads a file."""
    leg = {"small.leg.yaml": LEG_TEXT.encode()}
    robot = LEG_TEXT.replace("name: small", "name: robot").replace("250 mm", "300 mm").encode()
    hopper = {"hopper.yaml": HOPPER.encode()} | jumps()
    dry = (("--dry-run",),)
    fitted = (("--method", "piecewise"), ("--cost", "transient"), ("--weight", "equal"), ("--intervals", "bootstrap"))
    time, measured = angles()
    plain = table("time [s],hip [deg],knee [deg],ankle [deg]", np.column_stack([time, measured]))
    mot = (Path(__file__).parents[1] / "motion" / "importers" / "data" / "degrees.mot").read_bytes()
    rat = {"rat.leg.yaml": RAT.encode()}
    wanted = b"gear_ratio: 150\nruns: [runs/*.csv]\n"
    pulls = b"kind: hopper-pull-ups\ndesign: hopper.yaml\nbody_mass: 36.9 g\n"
    pulls += b"trials: [{file: pull-ups/a.csv, length: 120 mm}]\n"
    plate = b'kind: hopper-jumps\ndesign: hopper.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\njumps: [jumps/*.csv]\n'
    table_of_parts = {"parts/mine.csv": CATALOGUE.encode()}
    out = ("--out", "{out}")
    imported = IMPORT.replace("{parts}", ", ".join(PARTS)).encode()
    marked = IMPORT.replace("{parts}", ", ".join(PARTS)).replace("csv", "trc")
    marked = marked.replace("frame_rate: 250 Hz", "plane: [x, y]").encode()
    spring = ("spring", "--rate", "2 N*m/rad", "--travel", "60 deg", *out)
    return (
        Base("fit", leg | {"fit.yaml": FIT.encode()} | swings(), ("fit", "fit.yaml", *out), False, dry + fitted),
        Base("fit driven", leg | {"fit.yaml": FIT.encode()} | driven(), ("fit", "fit.yaml", *out), False, dry),
        Base("folder", {f"legs/{k}/{name}": data for k in "ab" for name, data in (leg | {"fit.yaml": FIT.encode()}
             | swings()).items()}, ("fit", "legs", *out), True, (("--workers", "1"), *dry)),
        Base("gap", leg | {"gap.yaml": GAP.encode()} | swings(), ("gap", "gap.yaml", *out), True, dry),
        Base("gap driven", leg | {"gap.yaml": GAP.encode()} | driven(), ("gap", "gap.yaml", *out), True, dry),
        Base("effect", leg | {"gap.yaml": GAP.encode(), "mine.py": MAGNET.encode()} | swings(),
             ("gap", "gap.yaml", "--effect", "mine.py", *out), True, dry),
        Base("leg", leg | {"robot.leg.yaml": robot, "design.yaml": DESIGN.encode()} | swings(),
             ("leg", "design.yaml", "--no-cad", "--no-cache", *out), True,
             (*dry, ("--vendor", "Shop"), ("--system", "inch"), ("--without", "6597K21"))),
        Base("hopper", hopper, ("hopper", "hopper.yaml", "--no-cad", *out), False, dry),
        Base("motor", {"motor.yaml": b"kind: hopper-motor\n" + wanted} | run_ups(), ("hopper", "motor.yaml", *out)),
        Base("pull-ups", hopper | {"pulls.yaml": pulls}, ("hopper", "pulls.yaml", *out)),
        Base("plate jumps", hopper | {"plate.yaml": plate}, ("hopper", "plate.yaml", *out)),
        Base("hopper gap", hopper | {"gap.yaml": HOPPER_GAP.encode()}, ("gap", "gap.yaml", *out), True, dry),
        Base("import", rat | {"import.yaml": imported, "videos/a.csv": video()},
             ("import", "import.yaml", *out), False, dry),
        Base("import csv", rat | {"a.csv": plain}, ("import", "a.csv", "--leg", "rat.leg.yaml", *out), False,
             (*dry, ("--release", "free"), ("--frame-rate", "250 Hz"))),
        Base("import mot", rat | {"import.yaml": MOT, "a.mot": mot}, ("import", "import.yaml", *out), False, dry),
        Base("import trc", rat | {"import.yaml": marked, "videos/a.trc": captured()},
             ("import", "import.yaml", *out), False, dry),
        Base("import json", rat | {"a.json": logged()},
             ("import", "a.json", "--leg", "rat.leg.yaml", *out), False, dry),
        Base("catalogue", table_of_parts, ("catalog", "check", "parts/mine.csv")),
        Base("catalogue list", table_of_parts, ("catalog", "list", "torsion_springs", "--catalog", "parts/mine.csv")),
        Base("catalogue part", {}, ("catalog", "show", "6597K21")),
        Base("wish", table_of_parts | {"knee.yaml": WISH.encode()}, ("catalog", "show", "knee.yaml")),
        Base("spring", {}, ("spring", "--rate", "2 N*m/rad", "--travel", "60 deg", "--json", "{out}.json"), False,
             (("--coils", "5.25"), ("--cycles", "1e5"), ("--legs", "axial"), ("--included-angle", "90 deg"),
              ("--arbor", "12 mm"), ("--system", "metric"), ("--objective", "life"), ("--closes", "clockwise"))),
        Base("spring drawn", {}, spring, True),
        Base("init", {}, ("init", "fit", "{out}")),
    )  # fmt: skip
