"""What each key means, by section and key; a test fails where a key has no text or a text no key."""

from __future__ import annotations

from synth.files.reference import design_texts, fit_texts, hopper_texts, leg_texts

KIND_TEXTS: dict[str, tuple[str, str]] = {
    "leg": ("a planar leg: links, joints, springs and dampers", "every project that names it"),
    "fit": ("springs, dampers and free angles from recordings", "`synth fit`"),
    "gap": ("why a built leg swings differently from its design", "`synth gap`"),
    "leg-design": ("a leg of parts that moves like an animal's", "`synth leg`"),
    "import": ("recordings of other programs as trials of a leg", "`synth import`"),
    "hopper-design": ("motor, ratio and link length of a jumping leg", "`synth hopper`"),
    "gap-of-jumps": ("why a built leg jumps differently from its design", "`synth gap`"),
    "hopper-motor": ("run-ups of a motor, to estimate its constants", "`synth hopper`"),
    "hopper-pull-ups": ("inverted pull-ups, to estimate the joints' damping", "`synth hopper`"),
    "hopper-jumps": ("jumps on a force plate, to compare with each model", "`synth hopper`"),
    "part-wish": ("a joint's requirements, for a list of fitting parts", "`synth catalog show`"),
}

SECTION_TEXTS: dict[str, str] = {
    **leg_texts.SECTIONS,
    **fit_texts.SECTIONS,
    **design_texts.SECTIONS,
    **hopper_texts.SECTIONS,
}

TEXTS: dict[str, str] = {**leg_texts.KEYS, **fit_texts.KEYS, **design_texts.KEYS, **hopper_texts.KEYS}
