"""What all tests have in common."""

from __future__ import annotations

import os

from synth.threads import LIBRARIES

# As every command does before numpy is loaded: threads of the linear algebra only wait for each other here.
for name in LIBRARIES:
    os.environ.setdefault(name, "1")
