"""The swinging leg's engine: a planar chain of links, its compiled equations of motion, and its effects."""
