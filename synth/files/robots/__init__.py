"""Robots described by other programs, as legs: one reader per format, and the choice of a planar chain."""
