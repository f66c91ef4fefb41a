"""A leg as designed beside recordings of the built one: which effect is missing, how sure, and how far it helps."""

from pathlib import Path

import synth

EXAMPLE = Path(synth.__file__).parent / "examples" / "gap"  # what `synth init gap` copies

found = synth.gap(EXAMPLE / "gap.yaml")
print(found.verdict, "-", found.headline)
print(found.to_frame().head(4).to_string(index=False))

# The nominal leg with the explanation in: simulate with it, or write it to a file.
friction = {joint.name: dict(joint.effects) for joint in found.diagnosed.joints}
print(friction)
