"""Rehearsal: causes planted in a user's own leg and trials, and diagnosed by processes that cannot know them."""
