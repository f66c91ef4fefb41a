"""The models against closed forms, statics, conservation and another engine, for one user's leg (``synth check``)."""
