"""Code generation and compilation: source text, cached machine code, and numba building blocks of both plants."""
