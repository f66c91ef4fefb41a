"""Legs side by side: parameters, parts, characteristics, and their motion from the same start."""
