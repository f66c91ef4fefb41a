"""Where each quantity lies in the compiled chain's workspace: one flat array (n_row, 16), a lane a column.

One array with row numbers known when compiled is what lets LLVM prove that stores do not touch loads, and so
turn the whole right-hand side into vector instructions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

LANES = 16  # trajectories that step together; 8 is unrolled by LLVM and stays scalar, 32 gains nothing
CURVE_POINTS = 12  # points of a damper's torque-speed curve


@dataclass(frozen=True)
class Layout:
    """Row numbers for a chain of ``n`` links; ``effects`` are (name, number of parameters) in compiled order."""

    n: int
    effects: tuple[tuple[str, int], ...] = ()

    @cached_property
    def blocks(self) -> dict[str, tuple[int, int]]:
        """Block name -> (first row, number of rows), in the order in which they lie."""
        n = self.n
        sizes = {
            "rotation": n,
            "rate": n,
            "acceleration": n,
            "extra_torque": n,
            "spring_rate": n,
            "rest": n,
            "damper_rate": n,
            "free": n,  # 1 free, 0 locked
            "inertia": n * (n + 1) // 2,
            "gravity": n,
            "tilt": 1,
            "curve_speed": CURVE_POINTS * n,
            "curve_slope": CURVE_POINTS * n,
        }
        sizes |= {name: count * n for name, count in self.effects}
        blocks, row = {}, 0
        for name, size in sizes.items():
            blocks[name] = (row, size)
            row += size
        return blocks

    def row(self, block: str, index: int = 0) -> int:
        """Row of one entry of a block."""
        return self.blocks[block][0] + index

    def rows(self, block: str) -> slice:
        """All rows of a block."""
        first, size = self.blocks[block]
        return slice(first, first + size)

    @property
    def n_row(self) -> int:
        """Rows of the whole workspace."""
        first, size = list(self.blocks.values())[-1]
        return first + size

    def inertia_row(self, i: int, j: int) -> int:
        """Row of the inertia coefficient of links i <= j."""
        return self.row("inertia", i * self.n - i * (i - 1) // 2 + (j - i))
