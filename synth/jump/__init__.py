"""The jumping leg's engine: a two-motor five-bar, its compiled jump, models of growing truth, and its effects."""
