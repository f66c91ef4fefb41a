"""The library: what ``import synth`` offers, and what the command line calls. Each module holds one question."""
