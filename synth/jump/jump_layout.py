"""Layout of the compiled workspace of a jump: one flat array (n_row, 16), a lane per column."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

LANES = 16  # lanes, as of the swinging chain: four registers of AVX2, two of AVX-512


@dataclass(frozen=True)
class JumpLayout:
    """Rows for ``n`` rigid pieces per side, of which number ``knee`` begins the lower link.

    State: hips' height, ``n`` angles (the last follows from the closure and is stored for the springs), the hips'
    speed, ``n - 1`` rates, winding current, electrical energy taken.
    """

    n: int
    knee: int

    @cached_property
    def rows(self) -> dict[str, tuple[int, int]]:
        """Block -> (first row, rows)."""
        n = self.n
        sizes = {
            "height": 1, "angle": n, "speed": 1, "rate": n - 1, "current": 1, "energy": 1,
            "derivative": 2 * n + 3,
            "own_slope": n,  # of the accelerations over the motor's rate; follows the derivative, see ``jump_step``
            # outputs of the right-hand side beside the derivative
            "normal": 1, "foot": 1, "foot_speed": 1, "com_speed": 1, "com": 1, "gear_torque": 1, "drawn": 1, "bend": 1,
            # parameters
            "alive": 1, "length": n, "inertia": n * (n + 1) // 2, "moment": n,
            "mass": 1, "half_spacing": 1, "gravity": 1,
            "beam": n - 1, "hip_rate": 1, "knee_rate": 1, "foot_rate": 1, "joint_damping": 1,
            "hip_rest": 1, "knee_rest": 1, "foot_rest": 1,
            "stop": 1, "stop_rate": 1, "stop_dissipation": 1,
            "linear_torque": 1, "torque_slope": 1, "linear_current": 1, "current_slope": 1,
            "voltage": 1, "resistance": 1, "inverse_inductance": 1, "back_emf": 1, "torque_constant": 1,
            "rotor_inertia": 1, "friction": 1, "viscous": 1, "driving": 1, "braking": 1, "reverse_speed": 1,
            "contact_stiffness": 1, "contact_damping": 1, "contact_dissipation": 1, "may_pull": 1,
        }  # fmt: skip
        found, row = {}, 0
        for name, size in sizes.items():
            found[name] = (row, size)
            row += size
        return found

    def row(self, block: str, index: int = 0) -> int:
        """Row of one entry of a block."""
        return self.rows[block][0] + index

    def block(self, block: str) -> slice:
        """Rows of a block."""
        first, size = self.rows[block]
        return slice(first, first + size)

    @property
    def n_state(self) -> int:
        """Rows of the state, which come first."""
        return 2 * self.n + 3

    @property
    def n_row(self) -> int:
        """Rows of the whole workspace."""
        first, size = list(self.rows.values())[-1]
        return first + size

    def inertia_row(self, i: int, j: int) -> int:
        """Row of A_ij, i <= j."""
        return self.row("inertia", i * self.n - i * (i - 1) // 2 + (j - i))


# Pieces per side and the first one of the lower link, by bending model.
LAYOUTS = {"none": JumpLayout(2, 1), "upper": JumpLayout(3, 2), "all": JumpLayout(4, 2)}
