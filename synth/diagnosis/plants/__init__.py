"""One adapter per plant: trials, candidates, tolerances, predictions, messages."""
