"""The gap of a jumping leg: what recorded jumps and pull-ups show that the design does not have."""
