"""Test cases for the diagnosis: legs with planted causes, simulated by an independent engine.

The package shares neither equations nor the forms of the effects with the diagnosing engine and imports nothing of
``synth``. Its users can store its compiled code on disk with ``synth.compiling.compiled.keep_code_of``.
"""
