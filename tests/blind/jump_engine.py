"""Jumps and pull-ups of a driven leg by MuJoCo, with other functional forms than the library's effects.

The five-bar is two chains whose feet a ``connect`` constraint joins. Gear friction is MuJoCo's own dry friction, which
truly sticks; damping is a power of the rate; the supply has a capacitor behind its resistance; the torque constant
falls with the current; the gear's loss grows with speed; the ground stiffens as it gives; the foot slides by a bristle
with a higher friction at rest. It shares nothing with the tested engine.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_models import MODELS
from synth.jump.mujoco_model import mjcf

Array = NDArray[np.float64]
STEP = 1e-4  # s
EVERY = 2  # steps a sample
FLIGHT = 0.04  # s after takeoff that are still recorded
CAPACITY_TIME = 1e-3  # s, of the supply's capacitor behind its resistance
DAMPING_POWER, DAMPING_RATE = 0.8, 12.0  # rad/s at which the power law has the linear one's torque
BRISTLE = 3e-4  # m, that the foot gives before it slides
AT_REST = 1.15  # friction at rest over that while sliding
SOFTER = 0.2  # N, at which the soft ground's stiffness has doubled, over its own stiffness' deflection


@dataclass(frozen=True)
class JumpTruth:
    """The true leg: the design's quantities with their errors, and effects that the design lacks (0: absent)."""

    leg: HopperLeg
    motor: Motor
    contact: Contact
    effects: dict[str, float] = field(default_factory=dict)

    def get(self, name: str) -> float:
        """Size of an effect."""
        return self.effects.get(name, 0.0)


@dataclass(frozen=True)
class JumpConditions:
    """Of one trial."""

    supply: float
    payload: float = 0.0
    lean: float = 0.0
    crouch: float = 0.0  # rad beyond the design's


class _Rig:
    """One leg in MuJoCo with all forces besides springs and inertia."""

    def __init__(self, truth: JumpTruth, conditions: JumpConditions, hung: bool) -> None:
        self.truth, self.conditions = truth, conditions
        text = self._document(hung)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.n = (sum(name.startswith("r") for name in self._names()) - 1) or 1
        self.feet = [self.model.site(f"foot_{side}").id for side in "rl"]
        self.bristle = 0.0
        self.normal = 0.0
        self.slid: float | None = None
        self._jacobian = [np.zeros((3, self.model.nv)) for _ in range(2)]

    def _names(self) -> list[str]:
        return [self.model.joint(i).name for i in range(self.model.njnt)]

    def _document(self, hung: bool) -> str:
        truth, motor = self.truth, self.truth.motor
        text = mjcf(truth.leg, motor, truth.contact, MODELS["A"], "same", STEP)
        text = re.sub(r"<actuator>.*</actuator>", '<actuator><motor joint="r0"/><motor joint="l0"/></actuator>', text)
        body = truth.leg.structure_mass + 2 * motor.mass
        loaded = f'mass="{body + self.conditions.payload!r}"'
        text = text.replace(f'mass="{body!r}" diaginertia="1e-5 1e-5 1e-5"',
                            f'{loaded} diaginertia="{truth.leg.body_inertia!r} {truth.leg.body_inertia!r} '
                            f'{truth.leg.body_inertia!r}"')  # fmt: skip
        if hung:
            text = text.replace(f'gravity="0 0 {-truth.leg.gravity!r}"', f'gravity="0 0 {truth.leg.gravity!r}"')
            text = text.replace("<worldbody>", '<worldbody><site name="overhead" pos="0 0 0"/>')
            pin = '<connect site1="foot_r" site2="overhead" solref="1e-4 1" solimp="0.9999 0.9999 0.001 0.5 2"/>'
            return text.replace("</equality>", f"{pin}</equality>")
        rub = motor.gear_ratio * (motor.friction + self.truth.get("gear_friction.torque")) * motor.driving_efficiency
        own = motor.reflected_inertia * motor.driving_efficiency
        for side in "rl":
            text = text.replace(f'name="{side}0" type="hinge"',
                                f'name="{side}0" type="hinge" armature="{own!r}" frictionloss="{rub!r}"')  # fmt: skip
        if self.conditions.lean:
            rail = '<joint name="rail" type="slide" axis="0 0 1" />'
            assert rail in text
            free = '<joint name="x" type="slide" axis="1 0 0"/><joint name="pitch" type="hinge" axis="0 -1 0"/>'
            text = text.replace(rail, rail + free)
        return text

    def at(self, joint: str) -> int:
        """Address of a joint among positions and rates alike: all have one."""
        return int(self.model.joint(joint).qposadr[0])

    def place(self, upper: float) -> None:
        """Links at this angle of the upper one, the weight on the foot."""
        leg, lean = self.truth.leg, self.conditions.lean
        b = leg.lower_angle(upper)
        chain = [upper] * self.knee + [-b] * (self.pieces - self.knee)
        for i, turn in enumerate(np.diff(chain, prepend=0.0)):
            self.data.qpos[self.at(f"r{i}")], self.data.qpos[self.at(f"l{i}")] = turn, -turn
        height = leg.height(upper)
        self.data.qpos[self.at("rail")] = height * math.cos(lean)
        if lean:
            self.data.qpos[self.at("x")] = -height * math.sin(lean)
            self.data.qpos[self.at("pitch")] = lean

    @property
    def knee(self) -> int:
        """Piece that begins the lower link."""
        return 1 if self.truth.leg.bending == "none" else 2

    @property
    def pieces(self) -> int:
        """Of one side."""
        return {"none": 2, "upper": 3, "all": 4}[self.truth.leg.bending]

    def sink(self) -> None:
        """Lower the body until the ground bears the weight."""
        weight = float(mujoco.mj_getTotalmass(self.model)) * self.truth.leg.gravity
        low, high = 0.0, 0.02
        for _ in range(60):
            depth = 0.5 * (low + high)
            low, high = (depth, high) if self._ground(depth, 0.0) < weight else (low, depth)
        self.data.qpos[self.at("rail")] -= depth

    def _ground(self, depth: float, speed: float) -> float:
        """N from penetration and its rate: Hunt and Crossley's contact on a spring that stiffens, without mass."""
        contact, soft = self.truth.contact, self.truth.get("ground_compliance.stiffness")
        if depth <= 0.0:
            return 0.0
        force = contact.stiffness * depth
        if soft:
            low, high = 0.0, force
            for _ in range(30):  # F / k_contact + give(F) = depth
                force = 0.5 * (low + high)
                give = force / soft / (1.0 + SOFTER * force)
                low, high = (force, high) if force / contact.stiffness + give < depth else (low, force)
        return max(0.0, force * (1.0 + contact.dissipation * speed))

    def passive(self, _: object, data: mujoco.MjData) -> None:
        """Stop, damping, a spring beside the hips, and the ground, at each stage of a step."""
        truth, leg = self.truth, self.truth.leg
        for side, out in (("r", 1.0), ("l", -1.0)):
            hip, knee = self.at(f"{side}0"), self.at(f"{side}{self.knee}")
            past = max(0.0, leg.extended - out * data.qpos[hip])
            rate = data.qvel[hip]
            data.qfrc_passive[hip] += out * leg.stop_rate * past * max(0.0, 1.0 - leg.stop_dissipation * out * rate)
            data.qfrc_passive[hip] -= self._damping(rate) + truth.get("hip_spring") * data.qpos[hip]
            data.qfrc_passive[knee] -= self._damping(data.qvel[knee])
        chain = [(self.at(f"{side}{i}"), sign) for side, sign in (("l", 1.0), ("r", -1.0)) for i in range(self.pieces)]
        spread = self._damping(sum(sign * data.qvel[k] for k, sign in chain))
        for k, sign in chain:
            data.qfrc_passive[k] -= sign * spread
        if self.normal >= 0.0:
            self._contact(data)

    def _damping(self, rate: float) -> float:
        own = self.truth.leg.flexures.damping * rate
        more = self.truth.get("joint_damping.damping")
        return own + more * DAMPING_RATE * math.copysign((abs(rate) / DAMPING_RATE) ** DAMPING_POWER, rate)

    def _contact(self, data: mujoco.MjData) -> None:
        jacobian, other = self._jacobian
        mujoco.mj_jacSite(self.model, data, jacobian, None, self.feet[0])
        mujoco.mj_jacSite(self.model, data, other, None, self.feet[1])
        along = 0.5 * (jacobian + other)
        depth = -0.5 * float(data.site_xpos[self.feet[0], 2] + data.site_xpos[self.feet[1], 2])
        self.normal = self._ground(depth, -float(along[2] @ data.qvel))
        data.qfrc_passive[:] += along[2] * self.normal
        if self.conditions.lean:
            friction = self.truth.get("ground_slip.friction") or self.truth.contact.friction
            speed, place = float(along[0] @ data.qvel), 0.5 * float(sum(data.site_xpos[f, 0] for f in self.feet))
            if self.slid is None:
                self.slid = place
            bent = np.clip(place - self.slid, -BRISTLE, BRISTLE)
            self.bristle = float(bent)
            grip = friction * (AT_REST if abs(speed) < 0.02 else 1.0)
            pull = -grip * self.normal * bent / BRISTLE - 0.3 * speed * (self.normal > 0.0)
            data.qfrc_passive[:] += along[0] * pull

    def settle_bristle(self) -> None:
        """After a step: the part that the bristle cannot follow slides."""
        place = 0.5 * float(sum(self.data.site_xpos[f, 0] for f in self.feet))
        if self.slid is None or self.normal <= 0.0:
            self.slid = place
        else:
            self.slid = float(np.clip(self.slid, place - BRISTLE, place + BRISTLE))


@dataclass
class _Drive:
    """Both motors' windings on one supply, and the gears."""

    truth: JumpTruth
    supply: float
    current: tuple[float, float] = (0.0, 0.0)
    terminal: float = math.nan

    def __post_init__(self) -> None:
        self.terminal = self.supply

    def torques(self, rates: tuple[float, float]) -> tuple[float, float]:
        """Torques on the upper links, inward positive, from their inward rates; one step on."""
        motor, get = self.truth.motor, self.truth.get
        inductance = motor.inductance + get("winding_inductance.inductance")
        currents, torques = [], []
        limit = get("current_limit") * motor.stall_current
        for current, rate in zip(self.current, rates, strict=True):
            share = get("torque_constant.share") * (0.7 + 0.6 * abs(current) / motor.stall_current)
            before = current
            steady = (
                self.terminal - motor.back_emf_constant * (1.0 + share) * motor.gear_ratio * rate
            ) / motor.resistance
            current = steady + (current - steady) * math.exp(-STEP * motor.resistance / inductance)
            if limit:
                current = min(current, limit)
            currents.append(current)
            loss = get("gear_friction.loss") * (0.85 + 0.3 * math.tanh(abs(rate) / (0.5 * motor.no_load_speed)))
            efficiency = motor.driving_efficiency * (1.0 - loss)
            middle = 0.5 * (before + current)  # of the step, through which the torque is kept
            drive = motor.gear_ratio * (
                motor.back_emf_constant * (1.0 + share) * middle - motor.viscous * motor.gear_ratio * rate
            )
            torques.append(drive * (efficiency if drive * rate >= 0.0 else 1.0 / motor.back_efficiency))
        self.current = currents[0], currents[1]
        resistance = get("voltage_sag.resistance")
        if resistance:
            sagging = self.supply - resistance * sum(currents)
            self.terminal = sagging + (self.terminal - sagging) * math.exp(-STEP / CAPACITY_TIME)
        return torques[0], torques[1]


def jump(truth: JumpTruth, conditions: JumpConditions, duration: float = 0.2) -> dict[str, Array]:
    """Channels at every ``EVERY`` steps: time, upper link, ground force, current, supply, pitch, foot slide."""
    rig = _Rig(truth, conditions, hung=False)
    rig.place(truth.leg.start + conditions.crouch)
    rig.sink()
    drive = _Drive(truth, conditions.supply)
    r0, l0 = rig.at("r0"), rig.at("l0")
    rows, lifted = [], math.inf
    with _acting(rig):
        mujoco.mj_forward(rig.model, rig.data)
        first = float(sum(rig.data.site_xpos[f, 0] for f in rig.feet)) / 2
        for k in range(int(duration / STEP)):
            data = rig.data
            foot = sum(float(data.site_xpos[f, 2]) for f in rig.feet) / 2
            if k % EVERY == 0:
                slide = sum(float(data.site_xpos[f, 0]) for f in rig.feet) / 2 - first
                pitch = float(data.qpos[rig.at("pitch")]) if conditions.lean else 0.0
                told = (rig.normal, sum(drive.current), drive.terminal, pitch, slide)
                rows.append((k * STEP, float(data.qpos[r0]), *told))
            if foot > 1e-3:
                lifted = min(lifted, k * STEP)
            if k * STEP > lifted + FLIGHT or data.qpos[rig.at("rail")] < 0.01:
                break
            torque = drive.torques((-float(data.qvel[r0]), float(data.qvel[l0])))
            data.ctrl[:] = -torque[0], torque[1]
            mujoco.mj_step(rig.model, data)
            if conditions.lean:
                rig.settle_bristle()
    names = ("time", "upper link", "ground force", "current", "supply", "pitch", "foot slide")
    found: dict[str, Array] = dict(zip(names, np.array(rows).T, strict=True))
    return found


def pull_up(truth: JumpTruth, torque: float, duration: float = 0.5) -> dict[str, Array]:
    """Time, upper link and one motor's torque (outward) of a leg hung by its foot; 1 kHz."""
    rig = _Rig(truth, JumpConditions(truth.motor.voltage), hung=True)
    rig.normal = -1.0  # no ground
    rig.place(math.radians(15.0))
    r0 = rig.at("r0")
    rows = []
    with _acting(rig):
        mujoco.mj_forward(rig.model, rig.data)
        for k in range(int(duration / STEP)):
            pull = torque * (0.6 + 0.4 * math.sin(6.0 * math.pi * k * STEP))
            rig.data.ctrl[:] = pull, -pull
            if k % 10 == 0:
                rows.append((k * STEP, float(rig.data.qpos[r0]), pull))
            if rig.data.qpos[r0] > 0.9 * truth.leg.largest_crouch:
                break
            mujoco.mj_step(rig.model, rig.data)
    found: dict[str, Array] = dict(zip(("time", "upper link", "hip torque"), np.array(rows).T, strict=True))
    return found


class _acting:
    """The forces besides springs and inertia, within the block; MuJoCo has one callback per process."""

    def __init__(self, rig: _Rig) -> None:
        self.rig = rig

    def __enter__(self) -> None:
        self.warned = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(lambda _: None)
        mujoco.set_mjcb_passive(self.rig.passive)

    def __exit__(self, *_: object) -> None:
        mujoco.set_mjcb_passive(None)
        mujoco.set_mju_user_warning(self.warned)
