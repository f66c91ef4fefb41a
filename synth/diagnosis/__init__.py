"""Why the built leg moves differently from the simulated one: where, which effect, its size, what to record next."""
