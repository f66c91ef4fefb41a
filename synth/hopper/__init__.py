"""The study of the jumping leg: motors from a catalogue, sweep, choice, identification, comparison with experiments."""
