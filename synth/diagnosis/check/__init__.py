"""What recordings can show of a leg, before any fit (``synth gap --check``)."""
