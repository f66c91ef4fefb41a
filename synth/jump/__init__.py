"""The jumping leg's engine: a two-motor five-bar, its compiled jump, models of increasing detail, and its effects."""
