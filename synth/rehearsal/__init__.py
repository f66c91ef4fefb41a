"""Rehearsal: causes planted in a user's own leg and trials, diagnosed by processes that cannot read the answers."""
