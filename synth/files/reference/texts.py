"""What each key means, by section and key; a test fails where a key has no text or a text no key."""

from __future__ import annotations

from synth.files.reference import design_texts, fit_texts, hopper_texts, leg_texts

KIND_TEXTS: dict[str, tuple[str, str]] = {
    "leg": ("a planar leg: links, joints, springs and dampers", "every project that names it"),
    "fit": ("springs, dampers and free angles from recordings", "`synth fit`"),
    "gap": ("why a built leg swings otherwise than designed", "`synth gap`"),
    "leg-design": ("a leg of parts that moves as an animal's does", "`synth leg`"),
    "import": ("recordings of other programs as trials of a leg", "`synth import`"),
    "hopper-design": ("motor, ratio and link length of a jumping leg", "`synth hopper`"),
    "gap-of-jumps": ("why a built leg jumps otherwise than designed", "`synth gap`"),
    "hopper-motor": ("run-ups of a motor, from which its constants are found", "`synth hopper`"),
    "hopper-pull-ups": ("inverted pull-ups, from which the joints' damping is found", "`synth hopper`"),
    "hopper-jumps": ("jumps on a force plate, against which each model is held", "`synth hopper`"),
    "part-wish": ("a joint's wish, for which fitting parts are listed", "`synth catalog show`"),
}

SECTION_TEXTS: dict[str, str] = {
    **leg_texts.SECTIONS,
    **fit_texts.SECTIONS,
    **design_texts.SECTIONS,
    **hopper_texts.SECTIONS,
}

TEXTS: dict[str, str] = {**leg_texts.KEYS, **fit_texts.KEYS, **design_texts.KEYS, **hopper_texts.KEYS}
