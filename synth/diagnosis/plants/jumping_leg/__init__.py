"""The gap of a jumping leg: effects in recorded jumps and pull-ups that the design lacks."""
