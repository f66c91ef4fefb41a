"""The dimensions from which a joint and a leg are drawn, in mm and degrees.

The drawings of the thesis' leg are lost, so every default is our own choice; the reason of its range is the last
argument of each field.
"""

from __future__ import annotations

import math
import re
from dataclasses import MISSING, dataclass, field

from synth.cad.fittings import DamperDimensions, EncoderDimensions, LoadDimensions, MountDimensions, PrintDimensions
from synth.cad.hardware import ShaftParts, shaft_parts, shaft_sizes
from synth.cad.limits import DimensionProblem, dimension, range_problems

STOP_MARGIN = 3.0  # deg past the wanted travel: printed flanks and a tongue's tilt in its bearings are off by about one
LEAST_STOP = 0.5  # deg past the wanted travel: the accuracy of a stop
COIL_TOLERANCE = 0.05  # turns; vendors hold the free position to 10 deg (0.028 turns) up to 10 coils
CLOSE_WOUND_PITCH = 1.03  # of the wire diameter: neighbouring coils just do not touch, for any spring index
_NAME = re.compile(r"\w(?:[\w .-]{0,58}[\w-])?")  # of every alphabet; it names columns and files


@dataclass(frozen=True)
class SpringDimensions:
    """A helical torsion spring of round wire with two straight arms tangent to the coil.

    ``coils`` is the catalogue's count. The solid has ``drawn_coils``, the nearest number that gives exactly
    ``included_angle`` (a catalogue's 7.17 coils at "120 deg" would give 118.8 deg).
    """

    wire_diameter: float = dimension(MISSING, 0.2, 12.0, "mm", "wire that is sold and that a hand winder bends")
    mean_diameter: float = dimension(MISSING, 1.0, 150.0, "mm", "a coil that fits on a leg's joint")
    coils: float = dimension(MISSING, 0.6, 60.0, "turns", "under 0.6 turns it is a bent wire, not a coil")
    included_angle: float = dimension(
        MISSING, 5.0, 355.0, "deg", "the arms of an unloaded spring must not lie on each other"
    )
    pitch: float | None = dimension(
        None, 0.2, 60.0, "mm", "axial advance per turn; left out it is 1.03 wire diameters, close wound"
    )
    free_arm: float | None = dimension(
        None,
        0.5,
        300.0,
        "mm",
        "from the tangent point to its seat, seen along the axis; left out: as short as it can be",
    )
    stiff_length: float | None = dimension(
        None, 1.0, 20000.0, "mm", "length of a straight beam with the designed stiffness: EI over the rate"
    )
    hand: str = "right"

    @property
    def radius(self) -> float:
        """Mean coil radius, mm."""
        return self.mean_diameter / 2

    @property
    def drawn_pitch(self) -> float:
        """Axial advance per turn, mm."""
        return CLOSE_WOUND_PITCH * self.wire_diameter if self.pitch is None else self.pitch

    @property
    def drawn_coils(self) -> float:
        """Coils for the exact included angle, nearest to the catalogue's count."""
        fraction = coil_fraction(self.included_angle)
        return round(self.coils - fraction) + fraction

    @property
    def hand_sign(self) -> int:
        """+1 for a right-hand helix, -1 for a left-hand one."""
        return 1 if self.hand == "right" else -1

    def problems(self, prefix: str = "") -> list[DimensionProblem]:
        """Every reason why this spring cannot be drawn."""
        found = range_problems(self, prefix)
        if self.hand not in ("right", "left"):
            found.append(DimensionProblem(prefix + "hand", self.hand, "'right' or 'left'", "the helix needs a sense"))
        if found:
            return found
        index = self.mean_diameter / self.wire_diameter
        if not 3.0 <= index <= 25.0:  # wider than Shigley's 4 to 12 (section 10-2): low indices crack, high ones tangle
            found.append(
                DimensionProblem(
                    prefix + "mean_diameter",
                    self.mean_diameter,
                    f"{3 * self.wire_diameter:.4g} to {25 * self.wire_diameter:.4g} mm",
                    "a spring index D/d under 3 cracks in winding, over 25 the coil does not hold its shape",
                )
            )
        angle = math.atan(self.drawn_pitch / (math.pi * self.mean_diameter))
        if self.drawn_pitch * math.cos(angle) < self.wire_diameter:
            found.append(
                DimensionProblem(
                    prefix + "pitch",
                    self.drawn_pitch,
                    f"at least {self.wire_diameter / math.cos(angle):.5g} mm",
                    "neighbouring coils would intersect, which no solid check detects",
                )
            )
        if abs(self.drawn_coils - self.coils) > COIL_TOLERANCE:
            found.append(
                DimensionProblem(
                    prefix + "coils",
                    self.coils,
                    f"within {COIL_TOLERANCE:g} turns of {self.drawn_coils:.4f}",
                    f"tangent arms at {self.included_angle:g} deg need a whole number plus "
                    f"{coil_fraction(self.included_angle):.4f} turns",
                )
            )
        return found


def coil_fraction(included_angle: float) -> float:
    """Fraction of a turn beyond whole coils for tangent arms at ``included_angle`` deg, in [0, 1).

    The arms leave at opposite ends of a whole turn, 180 deg apart; every further turn of the coil closes
    the angle between them: ``included = 180 - 360 * fraction`` (modulo 360).
    """
    return ((180.0 - included_angle) / 360.0) % 1.0


@dataclass(frozen=True)
class JointDimensions:
    """One joint with its distal link.

    Angles are those of the leg file, in degrees: measured angle ``a``; the lower link lies at the rotation
    ``sign * (a - zero_angle)`` from the upper link's continuation, counter-clockwise seen from +z.
    """

    name: str
    spring: SpringDimensions
    free_angle: float = dimension(
        MISSING,
        -720.0,
        720.0,
        "deg",
        "from there the spring's upper arm is turned to the travel, in most joints by at most 140 to 210 deg",
    )
    rest_angle: float = dimension(MISSING, -360.0, 360.0, "deg", "measured angle of the drawn pose")
    range: tuple[float, float] = (60.0, 160.0)
    zero_angle: float = dimension(180.0, -360.0, 360.0, "deg", "measured angle of the straight joint")
    sign: int = 1
    damper: DamperDimensions = field(default_factory=DamperDimensions)
    link_length: float = dimension(200.0, 20.0, 1500.0, "mm", "hinge axis to hinge axis")
    link_width: float = dimension(20.0, 6.0, 80.0, "mm", "outer diameter of the link's tube; 20 x 1.5 is stock")
    tube_wall: float = dimension(1.5, 0.5, 10.0, "mm", "of the link's tube")
    socket: float | None = dimension(
        None, 6.0, 200.0, "mm", "depth in which a half holds its tube; left out 1.2 diameters, so that it does not rock"
    )
    shaft_diameter: float = dimension(
        8.0, 3.0, 20.0, "mm", "of a stock rod; bearings and collars are listed for these; 8 carries a dog's leg"
    )
    seat_screw: float | None = dimension(
        None, 2.0, 8.0, "mm", "nominal size of the screws that clamp an arm; left out about the wire's diameter"
    )
    seat_length: float | None = dimension(
        None, 4.0, 80.0, "mm", "of an arm that is clamped; left out what its load asks of the print"
    )
    cap: float = dimension(4.0, 1.6, 20.0, "mm", "least thickness of the cap that clamps an arm")
    seat_travel: float = dimension(
        13.0, 0.0, 16.0, "deg", "either way, that the upper arm's seat can be turned; free angles are sold to 10 deg"
    )
    clearance: float = dimension(0.4, 0.1, 2.0, "mm", "per side between printed faces that move on each other")
    fit: float = dimension(0.1, 0.0, 0.5, "mm", "per side of a part that is pushed in and stays; printed holes shrink")
    wall: float = dimension(3.0, 1.2, 12.0, "mm", "printed wall; under 1.2 it is two lines wide")
    plate: float = dimension(6.0, 2.0, 25.0, "mm", "ears and floor plate; two walls, so the shaft has a seat")
    floor: float | None = dimension(
        None, 2.0, 60.0, "mm", "the lower half's floor, in which the shaft is pinned; left out it is a plate"
    )
    stops: tuple[float, float] | None = None  # measured deg at which the hard stops touch; None: STOP_MARGIN past range
    yields: tuple[float, float] | None = None  # measured deg at which the spring yields, if known
    upper_arm_angle: float = dimension(
        0.0, -360.0, 360.0, "deg", "measured-angle direction of the upper arm; 0: where the angle is measured from"
    )
    loads: LoadDimensions = field(default_factory=LoadDimensions)
    encoder: EncoderDimensions | None = None
    mount: MountDimensions | None = None
    springs: int = 1  # 2: a pair, one of each hand, mirrored at the tongue's floor
    closes: int = -1  # -1: the spring's arms close towards smaller measured angles; +1: towards larger ones

    @property
    def floor_thickness(self) -> float:
        """The lower half's floor, mm."""
        return self.plate if self.floor is None else self.floor

    @property
    def hardware(self) -> ShaftParts:
        """Bearings, collars, thrust washers and pins of the shaft's diameter."""
        return shaft_parts(self.shaft_diameter)

    @property
    def stop_angles(self) -> tuple[float, float]:
        """Measured angles, deg, at which the hard stops touch: the range for which the joint is drawn."""
        return self.stops if self.stops is not None else (self.range[0] - STOP_MARGIN, self.range[1] + STOP_MARGIN)

    @property
    def rests_free(self) -> bool:
        """Whether the free angle lies between the stops, so that the joint without a load comes to rest there."""
        return self.stop_angles[0] < self.free_angle < self.stop_angles[1]

    @property
    def filed_angle(self) -> float:
        """The measured angle (deg) of the files: the free angle, or the end of the travel next to it."""
        low, high = self.range
        return self.free_angle if self.rests_free else min(max(self.free_angle, low), high)

    @property
    def spring_torque(self) -> float:
        """Largest torque of all springs together from stop to stop, N*m; 0 if the rate is unknown."""
        turned = max(abs(angle - self.free_angle) for angle in self.stop_angles)
        return self.loads.spring_rate * math.radians(turned)

    @property
    def stop_torque(self) -> float:
        """Largest torque at a stop, N*m: of the springs, and of the damper at the joint's fastest speed."""
        return self.spring_torque + self.loads.damper_torque

    @property
    def socket_depth(self) -> float:
        """Depth of the tube's sockets, mm."""
        return 1.2 * self.link_width if self.socket is None else self.socket

    @property
    def arm_offset(self) -> float:
        """Offset of the lower half's arm shafts, deg; see :func:`arm_offset`."""
        return arm_offset(self.free_angle, self.spring.included_angle, self.upper_arm_angle, self.closes)

    @property
    def ends(self) -> tuple[float, float]:
        """The stops, measured deg: that with the arms closed most, then that with the arms open most."""
        low, high = self.stop_angles
        return (low, high) if self.closes < 0 else (high, low)

    def closing(self, measured_angle: float) -> float:
        """Closing of the spring's arms from the free angle to ``measured_angle``, deg."""
        return self.closes * (measured_angle - self.free_angle)

    def opening(self, measured_angle: float) -> float:
        """Rotation of the lower half from straight, deg, positive in the sense that opens the arms."""
        return -self.closes * (measured_angle - self.zero_angle)

    @property
    def opening_sign(self) -> int:
        """The sense in which the arms open, +1 counter-clockwise seen from +z."""
        return -self.closes * self.sign

    def rotation(self, measured_angle: float) -> float:
        """Rotation of the lower half from straight, deg, counter-clockwise positive seen from +z."""
        return self.sign * (measured_angle - self.zero_angle)

    def problems(self) -> list[DimensionProblem]:
        """Every dimension out of range in this joint, its spring and its damper."""
        prefix = f"{self.name}."
        found = range_problems(self, prefix)
        if not isinstance(self.name, str) or not _NAME.fullmatch(self.name):
            found.append(DimensionProblem("name", self.name, "letters, digits, space, _.-", "it names files"))
        if self.shaft_diameter not in shaft_sizes():
            sizes = ", ".join(f"{size:g}" for size in shaft_sizes())
            text = "a stock rod for which ball bearings, collars and thrust washers are listed"
            found.append(DimensionProblem(prefix + "shaft_diameter", self.shaft_diameter, f"one of {sizes} mm", text))
        if self.sign not in (1, -1):
            found.append(DimensionProblem(prefix + "sign", self.sign, "+1 or -1", "the sense of the measured angle"))
        if self.springs not in (1, 2):
            text = "a pocket on each side of the tongue holds one spring"
            found.append(DimensionProblem(prefix + "springs", self.springs, "1 or 2", text))
        if self.closes not in (1, -1):
            text = "the sense of the measured angle in which the spring's arms close"
            found.append(DimensionProblem(prefix + "closes", self.closes, "+1 or -1", text))
        found += self.spring.problems(prefix + "spring.") + self.damper.problems(prefix + "damper.")
        found += range_problems(self.loads, prefix + "loads.")
        found += self.encoder.problems(prefix + "encoder.") if self.encoder is not None else []
        found += self.mount.problems(prefix + "mount.") if self.mount is not None else []
        low, high = self.range
        # 300 deg: the stops and their lever take the rest of a turn.
        if not (math.isfinite(low) and math.isfinite(high) and low < high <= low + 300.0 - 2 * STOP_MARGIN):
            found.append(
                DimensionProblem(
                    prefix + "range", self.range, "low < high, at most 294 deg apart", "the joint's travel, deg"
                )
            )
        elif not low <= self.rest_angle <= high:
            found.append(
                DimensionProblem(
                    prefix + "rest_angle", self.rest_angle, f"{low:g} to {high:g} deg", "it lies in the joint's range"
                )
            )
        if not found:
            found += self._stop_problems()
        if not found and 2 * self.tube_wall >= self.link_width:
            found.append(
                DimensionProblem(
                    prefix + "tube_wall", self.tube_wall, f"under {self.link_width / 2:g} mm", "a tube is hollow"
                )
            )
        return found

    def _stop_problems(self) -> list[DimensionProblem]:
        """Stops within the wanted travel; yield is checked on the joint (``cad.travel``)."""
        (low, high), name = self.range, f"{self.name}.stops"
        first, last = self.stop_angles
        if not (
            math.isfinite(first) and math.isfinite(last) and first <= low - LEAST_STOP and last >= high + LEAST_STOP
        ):
            allowed = f"at most {low - LEAST_STOP:g} and at least {high + LEAST_STOP:g} deg"
            return [DimensionProblem(name, self.stops, allowed, "the wanted travel lies between the stops")]
        return []


@dataclass(frozen=True)
class LegDimensions:
    """A chain of joints, proximal to distal; the first upper half is the mount on the body."""

    name: str
    joints: tuple[JointDimensions, ...]
    tilt: float = dimension(0.0, -360.0, 360.0, "deg", "rotation of the whole base, counter-clockwise positive")
    printing: PrintDimensions = field(default_factory=PrintDimensions)

    def problems(self) -> list[DimensionProblem]:
        """Every dimension out of range in any joint, and repeated names."""
        found = range_problems(self) + self.printing.problems("printing.")
        if not 1 <= len(self.joints) <= 6:
            found.append(DimensionProblem("joints", len(self.joints), "1 to 6", "a leg is a chain of 1 to 6 links"))
        names = [joint.name for joint in self.joints]
        for name in sorted({name for name in names if names.count(name) > 1}):
            found.append(DimensionProblem("name", name, "a name used once", "each joint's files carry its name"))
        for joint in self.joints:
            found += joint.problems()
        found += [
            DimensionProblem(f"{joint.name}.mount", "a flange", "none", "only the first joint is mounted on the body")
            for joint in self.joints[1:]
            if joint.mount is not None
        ]
        return found


def arm_offset(free_angle: float, included_angle: float, upper_arm_angle: float = 0.0, closes: int = -1) -> float:
    """Direction of the lower arm, deg from its link's centre line, with the spring unloaded at the free angle.

    The upper arm runs along ``upper_arm_angle`` (0: the line from which the joint's angle is measured). At
    the free angle the angle between the arms is the spring's included angle, so the lower arm is turned from its
    link's centre line, towards smaller joint angles when positive, by
    ``free_angle - included_angle - upper_arm_angle``. Thesis section 4.2: ankle 139 - 120 = +19 deg,
    knee 111 - 120 = -9 deg. If larger angles close the arms (``closes`` +1), it is on the other side:
    ``free_angle + included_angle - upper_arm_angle``.
    """
    return free_angle + closes * included_angle - upper_arm_angle
