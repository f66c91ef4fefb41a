"""Checks of a leg's model by closed forms, statics, conservation and another engine (``synth check``)."""
