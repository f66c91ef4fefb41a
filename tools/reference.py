"""Write docs/reference and docs/effects.md (`make reference`).

docs/reference has a page and a JSON Schema for each kind of file, from the schema classes. docs/effects.md has every
effect with its formula, parameters and source, from the effects.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from synth.estimation.parameters import PlantEffect
from synth.files.reference.pages import pages
from synth.jump.effects import motor_effects
from synth.swing.effects import Effect, registered

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "reference"
EFFECTS = FOLDER.parent / "effects.md"
HEAD = """<!-- made from synth/swing/effects and synth/jump/effects by `make reference` -->

# Effects

What `synth gap` looks for. `effects:` of a joint in a leg file may hold those of the swinging leg, such as
`- coulomb_friction: {torque: 0.05 N*m}`, but for those that say which number of the file to change instead; those of
its base stand in `effects:` beside `joints:`. A parameter in brackets has a usual value and may be left out.
"""


def effects_page() -> str:
    """The page's text: a section per plant, an entry per effect."""
    plants = (("Swinging leg", registered()), ("Jumping leg", motor_effects()))
    return "\n".join([HEAD, *(f"## {title}\n\n{_entries(effects)}" for title, effects in plants)])


def _entries(effects: Iterable[PlantEffect]) -> str:
    text = []
    for effect in sorted(effects, key=lambda one: one.name):
        text += [f"### {effect.name}", f"{effect.meaning[0].upper()}{effect.meaning[1:]}.", ""]
        text += ["```", effect.formula, "```", "| parameter | unit | meaning |", "|---|---|---|"]
        for one in effect.parameters:
            name = f"`{one.name}`" if one.default is None else f"[`{one.name}`]"
            text.append(f"| {name} | {'' if one.unit == '1' else one.unit} | {one.meaning} |")
        if isinstance(effect, Effect):
            text += _place(effect)
        text += ["", f"*{effect.source}.*", ""]
    return "\n".join(text)


def _place(effect: Effect) -> list[str]:
    """Lines that say where a leg file has it, if not in ``effects:`` of a joint."""
    if effect.way == "leg":
        return ["", f"In a leg file: change {effect.changes}."]
    return ["", "In a leg file: in `effects:` beside `joints:`."] if effect.where == "base" else []


def main() -> None:
    """Write every page; remove pages of kinds that no longer exist."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    made = pages()
    for path in FOLDER.iterdir():
        if path.name not in made:
            path.unlink()
    for name, text in made.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    EFFECTS.write_text(effects_page(), encoding="utf-8")
    print(f"{len(made)} files in {FOLDER}, and {EFFECTS}")


if __name__ == "__main__":
    main()
