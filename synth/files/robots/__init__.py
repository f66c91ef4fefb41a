"""Robots that other programs describe, as legs: a reader a format, and the choice of a planar chain."""
