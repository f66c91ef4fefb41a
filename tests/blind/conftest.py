"""The generator's engine imports nothing of the program: its compiled code is kept on disk from here."""

from __future__ import annotations

from synth.compiling.compiled import keep_code_of
from synth.planting import bodies, engine, torque_laws

keep_code_of(bodies, torque_laws, engine)
