"""A joint's drive as a simulator's servo: a controller linear in angle and speed, a limit, a brake, a delay.

By the sources of ``drives.servo_law`` the law outside its dead band, with a constant supply and continuous control, is

    torque = cut(limit(stiffness (command - angle) - damping rate) - braking rate)

with ``stiffness`` = gain strength supply and so on, so that a simulator's position servo and joint damper follow it.
Effects of the drive are in these numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, inf

from synth.drives.servo import UNLIMITED, Servo
from synth.swing.effects import effect_named
from synth.swing.lane_layout import SERVO
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Joint, Leg
from synth.units import significant

# Effects that are in a servo's numbers, and therefore in every file with these numbers.
IN_SERVO = ("command_delay", "current_limit", "torque_constant", "servo_gain", "winding_resistance")
AS_GOOD_AS_UNLIMITED = 1e-3 * UNLIMITED  # N m: above any real limit, below UNLIMITED times an effect's factor


@dataclass(frozen=True)
class DriveTerms:
    """A joint's drive: ``control`` : its input, in the sense of q.

    ``stiffness`` N m/rad of a position servo (0 where a voltage is the input), ``volt`` N m/V of that input,
    ``damping`` N m s/rad of the controller, at most ``limit`` N m; ``braking`` N m s/rad of the winding; both together
    at most ``cut`` N m; ``delay`` s of the input. ``lost`` : features that these numbers lack.
    """

    control: str
    stiffness: float
    volt: float
    damping: float
    limit: float
    braking: float
    cut: float
    delay: float
    lost: tuple[str, ...] = ()

    @property
    def in_words(self) -> str:
        """Its numbers, for formats without a servo."""
        way = f"{self.volt:.4g} N*m/V" if self.volt else f"{self.stiffness:.4g} N*m/rad"
        limit = f", at most {min(self.limit, self.cut):.4g} N*m" if min(self.limit, self.cut) < inf else ""
        slow = f"damping {self.damping:.4g} and braking {self.braking:.4g} N*m*s/rad"
        return f"{way}, {slow}{limit}, {self.delay:.3g} s late"


def lightened(joint: Joint) -> str:
    """What no simulator holds of a late winding whose joint has no rotor to take it from; empty without."""
    if joint.with_rotor >= 0.0:
        return ""
    return f"of the drive: {-joint.with_rotor:.3g} kg*m^2 by which its winding's lag lightens the joint"


def drive_terms(leg: Leg) -> list[DriveTerms | None]:
    """The drive of each joint; None without a servo or a known voltage. The supply is the stated one."""
    held = [{name: x for name, x in joint.effects.items() if effect_named(name).way == "drive"} for joint in leg.joints]
    joints = [replace(joint, effects=effects) for joint, effects in zip(leg.joints, held, strict=True)]
    servo = LegLanes.of(replace(leg, joints=tuple(joints), effects={})).servo_numbers()[:, :, 0]
    return [
        _terms(joint.drive, dict(zip(SERVO, servo[:, j].tolist(), strict=True)))
        if isinstance(joint.drive, Servo)
        else None
        for j, joint in enumerate(joints)
    ]


def _terms(drive: Servo, found: dict[str, float]) -> DriveTerms:
    supply = drive.supply if drive.motor is not None else 1.0
    strength = found["servo_strength"]
    volts = bool(found["servo_open_duty"])
    limit = found["servo_duty_limit"] * strength * supply
    cut = found["servo_torque_limit"]
    lost = []
    if found["servo_dead_band"] > 0.0:
        lost.append(f"its dead band of {found['servo_dead_band']:.3g} rad")
    if found["servo_integral_gain"] > 0.0:
        lost.append("its integral gain; here it sags under its load")
    if found["servo_command_rate"] > 0.0:
        lost.append(f"the limit of its command's rate, {significant(degrees(found['servo_command_rate']), 3)} deg/s")
    if found["servo_sag"] > 0.0:
        lost.append("the sag of its supply; the supply is constant here")
    if cut < AS_GOOD_AS_UNLIMITED and found["servo_back_emf"] > 0.0:
        lost.append("the torque limit on the braking of its winding; here it limits the torque of the controller alone")
    # A held duty is half a period late on average, as a winding's current is late by its lag.
    hold = 0.5 * found["servo_period"]
    if hold > 0.0:
        steps = f" and the {found['servo_duty_steps']:.0f} steps of its duty" if found["servo_duty_steps"] else ""
        lost.append(f"its control steps of {2e3 * hold:.3g} ms{steps}; here it acts all the time, half a step later")
    return DriveTerms(
        control="voltage, V" if volts else "rotation that is commanded, rad",
        stiffness=0.0 if volts else found["servo_gain"] * strength * supply,
        volt=strength if volts else 0.0,
        damping=(found["servo_damping_gain"] - hold * found["servo_gain"]) * strength * supply,
        limit=limit if limit < AS_GOOD_AS_UNLIMITED else inf,
        braking=found["servo_back_emf"],
        cut=cut if cut < AS_GOOD_AS_UNLIMITED else inf,
        delay=found["servo_delay"] + hold,
        lost=tuple(lost),
    )
