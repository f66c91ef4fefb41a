"""The generated modules of a chain of links: their text, and the files on which their compiled code depends.

The files tell whether code is on disk before anything compiles; which code is used, ``numba_internals.KeptCode`` knows.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from synth.compiling import code_cache
from synth.compiling.modules import source_file, with_constant
from synth.compiling.reached_code import reached_by
from synth.swing import chain_source, stage_source
from synth.swing.effects import Effect
from synth.swing.lane_layout import Layout
from synth.swing.stage_rows import MOST_STAGED

PLAIN = ("chain", "plain")  # the modules that springs, linear dampers and gravity need
LAWS = ("chain", "torques", "bearing", "smooth", "friction")  # those that friction, drag and hardening need
LARGEST = ("integrator", "friction")  # longest to compile, the longest first
DRIVES = ("synth.drives.motor_law", "synth.drives.servo_law")
# Modules that the compiled integrator inlines; a change of one recompiles it.
CALLED = (
    "synth.swing.lane_layout", "synth.swing.explicit_pairs", "synth.swing.explicit_steps", "synth.swing.driven_steps",
    "synth.swing.turning_events", "synth.swing.turning_times", "synth.swing.lane_clocks",
    "synth.swing.effects.inlined", *DRIVES,
)  # fmt: skip


@dataclass(frozen=True)
class ModuleText:
    """A module to compile: its name, its text, and the files on which it depends."""

    name: str
    text: str
    depends_on: tuple[Path, ...]

    @property
    def parts(self) -> tuple[str, str, tuple[Path, ...]]:
        """Name, text and files, the arguments of ``code_cache.load``."""
        return self.name, self.text, self.depends_on

    def load(self) -> ModuleType:
        """Import the module; its functions compile only if their code is not on disk."""
        return code_cache.load(*self.parts)

    @property
    def on_disk(self) -> bool:
        """Whether its compiled code is on disk, or in this process."""
        return code_cache.on_disk(*self.parts)


def chain_modules(layout: Layout, effects: tuple[Effect, ...]) -> dict[str, ModuleText]:
    """Name -> module, for all modules of a chain of this layout; ``effects`` : in the order of ``layout.laws``."""
    imports = {effect.name: effect.module for effect in effects}
    files = tuple(source_file(module) for module in ("synth.compiling.trigonometry", *DRIVES))
    # Not the effects' files alone, which may take numbers and functions from others.
    reached = "".join(f"# {effect.name}: {reached_by(effect.function()).digest}\n" for effect in effects)
    integrator = source_file("synth.swing.chain_integrator").read_text(encoding="utf-8")
    smooth = with_constant(integrator, "WHOLE", False)
    plain = with_constant(with_constant(smooth, "EXTRA", False), "LINKS", layout.n)
    friction = source_file("synth.swing.friction_integrator").read_text(encoding="utf-8")
    called = tuple(map(source_file, CALLED))
    made = {
        "chain": ModuleText(f"chain{layout.n}", chain_source.right_hand_side(layout), files[:1]),
        "plain": ModuleText(f"plain{layout.n}", plain, called[:3]),
        "smooth": ModuleText("smooth", smooth, called[:3]),
        "torques": ModuleText("torques", chain_source.extra_torques(layout, imports) + reached, files),
        "bearing": ModuleText(f"bearing{layout.n}", chain_source.bearing_forces(layout), files[:1]),
        "integrator": ModuleText("integrator", integrator, called),
        "friction": ModuleText("friction", friction, called),
    }
    if layout.n <= MOST_STAGED:
        implicit = source_file("synth.swing.curve_integrator").read_text(encoding="utf-8")
        inlined = ("lane_layout", "stage_rows", "lane_clocks", "curve_clocks", "curve_bends")
        rows = tuple(source_file(f"synth.swing.{name}") for name in inlined)
        made["stages"] = ModuleText(f"stages{layout.n}", stage_source.stage_functions(layout), files[:1])
        made["curves"] = ModuleText("curves", implicit, rows)
    return made


def how_often(effects: tuple[Effect, ...]) -> str:
    """How often the code of these effects compiles, in words: where it cannot be stored, at each start."""
    obstacles = ((effect.name, reached_by(effect.function()).obstacle) for effect in effects)
    kept_from = [f"{name} uses {obstacle}" for name, obstacle in obstacles if obstacle]
    if not kept_from:
        return "once on this machine"
    return f"at each start, because code cannot be stored if {'; '.join(kept_from)}"
