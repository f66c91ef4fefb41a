"""Layout of the compiled chain's workspace: one array (n_row, 16) with one column per lane.

With one array and row numbers that are known at compile time, LLVM can prove that stores and loads do not overlap and
vectorises the whole right-hand side. Every block has room for the longest chain, so row numbers do not depend on the
number of links, and code that is generic in that number compiles once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

LANES = 16  # trajectories with common steps; LLVM unrolls 8 into scalar code, 32 is not faster
PLACE = (1 << 48) - 1  # mask that excludes negative indices; wrap-around indexing would need a gather instruction
CURVE_POINTS = 12  # points of a damper's torque-speed curve
MOST_LINKS = 7  # six of a leg, and one that an effect adds. Binary 111: a mask that excludes negative n
# Times that the force in a bearing is found from the accelerations, which its friction changes: without that friction,
# then with it. Each multiplies the error by what friction changes of the force. Where a knee rubs with a tenth of
# its spring's torque one is off by 3.3 % of the friction's effect, two by 0.3 %; a third costs half as much again.
LOAD_PASSES = 2
MOST_MEMORIES = 8 * MOST_LINKS  # of effects that are on at the same time
ROOMS = 20  # arrays of the size of a state that the integrator uses
# Number of doubles of the integrator's own blocks, which stand before the workspace in one array.
WORKING = ROOMS * (2 * MOST_LINKS + MOST_MEMORIES) * LANES

# Errors of a known torque: gain (share), offset N m, delay s (in the workspace: minus the first lane's delay).
DRIVE = ("torque_gain", "torque_offset", "torque_delay")
# Parameters of a servo: of its duty and of its winding in the order of ``drives.servo_law``'s arguments, the delay of
# its command, its control steps: period and first of them (s; period 0: continuous), steps of its duty (0: none),
# the conductance of its winding on the leg's common source, 1/ohm (0: not fed by it), the limit of its command's rate,
# rad/s (0: none), and gain and limit of its integral.
DUTY = ("servo_gain", "servo_damping_gain", "servo_dead_band", "servo_duty_limit")
WINDING = ("servo_strength", "servo_back_emf", "servo_sag")
CONTROL = ("servo_period", "servo_phase", "servo_duty_steps")
SERVO = (
    *DUTY, "servo_open_duty", "servo_strength", "servo_back_emf", "servo_torque_limit", "servo_sag", "servo_delay",
    *CONTROL, "servo_conductance", "servo_command_rate", "servo_integral_gain", "servo_integral_limit",
)  # fmt: skip
# What a servo controls, on q: its joint's rotation, with the next hinge's if its encoder sits behind a gear's play (1;
# else 0), times one more than the scale error, plus the offset.
CONTROLLED = ("controlled_beyond", "controlled_scale", "controlled_offset")
# The law of a servo's integral, a memory as those of effects are, and its numbers in the order of ``integral_change``.
INTEGRAL = "servo integral"
INTEGRAL_LAW = ("servo_dead_band", "servo_integral_gain", "servo_integral_limit")
SIGNALS = ("command", "supply", "enabled")  # of a servo at the current time: rad on q, V, 1 or 0
# Index of the servos' switch; its value where some duty is held between control steps, else 1; and what is added where
# a common source has a resistance.
SERVOS, HOLDING, SHARING = 1, 2, 2
# Of a common source: its resistance, ohm; its drop, V; what its joints draw at that drop, times the resistance, V; and
# the slope by which that differs from the drop.
SOURCE = ("source", "source_drop", "source_drawn", "source_slope")
FIRST_LAW = 2  # index of the first effect's switch, after those of damper curves and servos
_ONE_A_JOINT = (
    "rotation", "rate", "acceleration", "extra_torque", "spring_rate", "rest", "damper_rate",
    "free",  # 1 free, 0 locked
    "own_inertia",  # armature and rotor; 1 for a locked joint, which keeps the mass matrix regular
    *DRIVE,
    *SERVO,
    *SIGNALS,
    *CONTROLLED,
    "sine", "cosine",  # of the link's angle from straight down, see ``chain_source.link_directions``
    "known_torque",  # recorded, with the lane's errors, on q
    "drive_torque",  # of the servo, or known, on q
    "duty",  # of a servo on a common source
    # Of a servo whose command's rate is limited: its limited command when it last changed course, when that was, the
    # command that it approaches; the line by which it counts until it changes course again, its start (rad) and slope
    # (rad/s); an interval in which that line stands for a bent one (s, see ``driven_steps``).
    "slew_from", "slew_since", "slew_goal", "slew_shown", "slew_slope", "slew_short",
    f"{INTEGRAL} memory", f"{INTEGRAL} memory rate",  # duty, and its rate of change
    "held_duty", "next_control",  # of a servo with control steps: its duty, and the time of its next look, s
)  # fmt: skip
_FOR_EFFECTS = (
    "damper_torque",  # resisting torque of rate and curve
    "length", "carried_mass",  # mass of all links outboard of the joint
    # Of the link and of all links outboard of it, about the joint, along the link and across it.
    "first_moment", "moment_across",
    "bearing_force",
    "spring_laws", "damper_laws",  # torques on q of the laws that belong to spring and damper
)  # fmt: skip
UsesDrive = Literal["", "as it is", "warms its winding"]


@dataclass(frozen=True)
class LaneLaw:
    """An effect's compiled torque in the layout: name, number of parameters, whether it has a memory.

    ``part`` : "spring" or "damper", of whose torque it is a share without a memory; otherwise empty. ``play`` : index
    of the parameter that is the gap between the joint and these parts, -1 for none; behind it is the memory.
    """

    name: str
    n_parameter: int
    memory: bool = False
    uses_drive: UsesDrive = ""  # its argument is the servo's torque instead of the bearing force
    part: str = ""
    play: int = -1


@dataclass(frozen=True)
class Layout:
    """Row numbers for a chain of ``n`` links; ``laws`` in compiled order."""

    n: int
    laws: tuple[LaneLaw, ...] = ()

    @cached_property
    def blocks(self) -> dict[str, tuple[int, int]]:
        """Block name -> (first row, number of rows), in the order of the rows."""
        sizes = dict.fromkeys(_ONE_A_JOINT, MOST_LINKS)
        sizes |= {"inertia": MOST_LINKS * (MOST_LINKS + 1) // 2, "inertia_across": MOST_LINKS * (MOST_LINKS - 1) // 2}
        sizes |= {"gravity": MOST_LINKS, "gravity_across": MOST_LINKS, "tilt": 1, "weight": 1}
        sizes |= dict.fromkeys(SOURCE, 1)
        sizes |= dict.fromkeys(_FOR_EFFECTS, MOST_LINKS) | {"factors": MOST_LINKS * (MOST_LINKS + 3) // 2}
        for law in self.laws:
            sizes[law.name] = law.n_parameter * MOST_LINKS
            if law.memory:
                sizes[f"{law.name} memory"] = sizes[f"{law.name} memory rate"] = MOST_LINKS
        sizes |= {"curve_speed": CURVE_POINTS * MOST_LINKS, "curve_slope": CURVE_POINTS * MOST_LINKS}
        blocks, row = {}, 0
        for name, size in sizes.items():
            blocks[name] = (row, size)
            row += size
        return blocks

    def row(self, block: str, index: int = 0) -> int:
        """Row of one entry of a block."""
        return self.blocks[block][0] + index

    def rows(self, block: str) -> slice:
        """The rows of a block that a chain of ``n`` links uses; not for blocks of several parameters per joint."""
        first, size = self.blocks[block]
        if block == "inertia":
            return slice(first, first + self.n * (self.n + 1) // 2)
        return slice(first, first + size * self.n // MOST_LINKS if size >= MOST_LINKS else first + size)

    def parameter_rows(self, law: str, parameter: int) -> slice:
        """The n rows of one parameter of a law."""
        first = self.row(law, parameter * MOST_LINKS)
        return slice(first, first + self.n)

    @cached_property
    def n_row(self) -> int:
        """Rows of the whole workspace."""
        first, size = list(self.blocks.values())[-1]
        return first + size

    @cached_property
    def n_plain(self) -> int:
        """Rows, the first ones, that hold all of a leg with springs, linear dampers and gravity only."""
        return self.row("tilt") + 1

    def inertia_row(self, i: int, j: int) -> int:
        """Row of the inertia coefficient of links i <= j."""
        return self.row("inertia", i * self.n - i * (i - 1) // 2 + (j - i))

    def across_row(self, i: int, j: int) -> int:
        """Row of the inertia coefficient of links i < j that is due to centres of mass beside the lines of links."""
        return self.row("inertia_across", i * self.n - i * (i + 1) // 2 + (j - i - 1))

    def memories(self, of: Sequence[tuple[str, int]]) -> tuple[list[int], list[int]]:
        """Rows of memories (law, joint), and of their time derivatives."""
        return [self.row(f"{law} memory", j) for law, j in of], [self.row(f"{law} memory rate", j) for law, j in of]
