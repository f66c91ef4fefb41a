"""The jumping leg: a two-motor five-bar, models of growing truth, motors from a catalogue, sweep, identification."""
