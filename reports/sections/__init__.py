"""The sections of a page, one module each; ``reports.page`` puts them in order."""
