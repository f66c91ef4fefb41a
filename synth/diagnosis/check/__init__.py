"""What recordings can tell of a leg before anything is fitted to them (``synth gap --check``)."""
