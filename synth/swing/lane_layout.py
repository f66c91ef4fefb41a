"""Where each quantity lies in the compiled chain's workspace: one flat array (n_row, 16), a lane a column.

One array with row numbers known when compiled is what lets LLVM prove that stores do not touch loads, and so
turn the whole right-hand side into vector instructions. Every block has room for the longest chain, so that the rows
are the same for every number of links and what is generic in that number is compiled once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

LANES = 16  # trajectories that step together; 8 is unrolled by LLVM and stays scalar, 32 gains nothing
CURVE_POINTS = 12  # points of a damper's torque-speed curve
MOST_LINKS = 7  # a leg has at most six; an effect may add one. All ones in binary: masked by it, n cannot be negative
MOST_MEMORIES = 8 * MOST_LINKS  # of effects that are on at once
ROOMS = 19  # arrays of a state's size that the integrator works in
# Doubles of the integrator's own array: states and memories in each of its rooms.
WORKING = ROOMS * (2 * MOST_LINKS + MOST_MEMORIES) * LANES

# What is wrong with a known torque: share too much, N m too much, s too late (in the workspace less the first lane's).
DRIVE = ("torque_gain", "torque_offset", "torque_delay")
# What a servo does, see ``drives.servo_law``: in the order of its arguments, then by how much its command comes late.
SERVO = (
    "servo_gain", "servo_damping_gain", "servo_dead_band", "servo_duty_limit", "servo_open_duty", "servo_strength",
    "servo_back_emf", "servo_torque_limit", "servo_sag", "servo_delay",
)  # fmt: skip
SIGNALS = ("command", "supply", "enabled")  # of a servo, at the moment: rad on q, V, 1 or 0
FIRST_LAW = 2  # of the switches: damper curves, servos, then a switch an effect
_ONE_A_JOINT = (
    "rotation", "rate", "acceleration", "extra_torque", "spring_rate", "rest", "damper_rate",
    "free",  # 1 free, 0 locked
    "own_inertia",  # what turns with the joint itself; 1 where it is locked, which keeps its row of the matrix regular
    *DRIVE,
    *SERVO,
    *SIGNALS,
    "drive_torque",  # of the servo, on q
)  # fmt: skip
_FOR_EFFECTS = (
    "damper_torque",  # resisting, of rate and curve together
    "length", "carried_mass",  # of all that hangs from the joint
    "first_moment",  # of the link and of what hangs from it, about the joint
    "bearing_force",
)  # fmt: skip


@dataclass(frozen=True)
class LaneLaw:
    """An effect's compiled torque as the layout sees it: its name, number of parameters, whether it has memory."""

    name: str
    n_parameter: int
    memory: bool = False
    uses_drive: bool = False  # the servo's torque is given to it in place of the bearing force


@dataclass(frozen=True)
class Layout:
    """Row numbers for a chain of ``n`` links; ``laws`` in compiled order."""

    n: int
    laws: tuple[LaneLaw, ...] = ()

    @cached_property
    def blocks(self) -> dict[str, tuple[int, int]]:
        """Block name -> (first row, number of rows), in the order in which they lie."""
        sizes = dict.fromkeys(_ONE_A_JOINT, MOST_LINKS)
        sizes |= {"inertia": MOST_LINKS * (MOST_LINKS + 1) // 2, "gravity": MOST_LINKS, "tilt": 1, "weight": 1}
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
        """The rows of a block that a chain of ``n`` links uses; not for blocks of several parameters a joint."""
        first, size = self.blocks[block]
        if block == "inertia":
            return slice(first, first + self.n * (self.n + 1) // 2)
        return slice(first, first + size * self.n // MOST_LINKS if size >= MOST_LINKS else first + size)

    def parameter_rows(self, law: str, parameter: int) -> slice:
        """The rows (n) of one parameter of a law."""
        first = self.row(law, parameter * MOST_LINKS)
        return slice(first, first + self.n)

    @cached_property
    def n_row(self) -> int:
        """Rows of the whole workspace."""
        first, size = list(self.blocks.values())[-1]
        return first + size

    def inertia_row(self, i: int, j: int) -> int:
        """Row of the inertia coefficient of links i <= j."""
        return self.row("inertia", i * self.n - i * (i - 1) // 2 + (j - i))

    def states(self, memories: Sequence[tuple[str, int]] = ()) -> tuple[list[int], list[int]]:
        """Rows of the state and of its time derivative: rotations, rates, then ``memories`` (law, joint)."""
        n = self.n
        state = [self.row(block, j) for block in ("rotation", "rate") for j in range(n)]
        derivative = [self.row(block, j) for block in ("rate", "acceleration") for j in range(n)]
        state += [self.row(f"{law} memory", j) for law, j in memories]
        derivative += [self.row(f"{law} memory rate", j) for law, j in memories]
        return state, derivative
