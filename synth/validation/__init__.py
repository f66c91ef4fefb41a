"""Reproduction of E. Krnacik's thesis and of a jumping-leg study: published numbers beside ours.

The thesis is reproduced from the laboratory's own recordings.
"""
