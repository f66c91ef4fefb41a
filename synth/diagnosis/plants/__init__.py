"""One adapter a plant: its trials, candidates, tolerances, predictions, and what it says of them."""
