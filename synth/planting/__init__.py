"""Legs with causes planted in them, simulated by an engine of their own: what a diagnosis is tried on.

Shares nothing with the diagnosing engine, neither equations nor the forms of the effects; imports nothing of ``synth``.
Who uses it may keep its compiled code on disk (``synth.compiling.compiled.keep_code_of``).
"""
