"""Generated and compiled code: source text, its cache on disk, and the numba building blocks of both plants."""
