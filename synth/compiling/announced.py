"""Whom a computation tells that it compiles: only then is it known that the code is needed, and the user waits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager

_listeners: list[Callable[[str], AbstractContextManager[None]]] = []


@contextmanager
def told_to(stage: Callable[[str], AbstractContextManager[None]]) -> Iterator[None]:
    """Within the block ``stage`` is entered, with what is compiled, while a computation compiles."""
    _listeners.append(stage)
    try:
        yield
    finally:
        _listeners.remove(stage)


@contextmanager
def announced(text: str) -> Iterator[None]:
    """A compilation: the innermost listener is told."""
    with ExitStack() as stack:
        if _listeners:
            stack.enter_context(_listeners[-1](text))
        yield
