"""Comparison of legs: parameters, parts, characteristics, and motion from the same start."""
