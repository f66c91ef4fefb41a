"""The openings of the pages, one module each; ``reports.opening`` defines an opening."""
