"""The public library behind ``import synth`` and the command line. Each module answers one question."""
