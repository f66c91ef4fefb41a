"""Calls that several processes share, some of which need what others have found."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol


@dataclass(frozen=True)
class SideCall:
    """``function(*arguments)``, importable by name. ``place``: the number of its process, None: the first free one."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    place: int | None = None

    @property
    def needs(self) -> list[int]:
        """The numbers of the calls whose results are among its arguments."""
        return [each.call for each in self.arguments if isinstance(each, ResultOf)]

    def given(self, found: Callable[[int], Any]) -> SideCall:
        """The call with the results of others in place; ``found``: a call's result by its number."""
        if not self.needs:
            return self
        filled = (found(each.call) if isinstance(each, ResultOf) else each for each in self.arguments)
        return replace(self, arguments=tuple(filled))

    def carried_out(self) -> Any:
        """Its result, worked out here."""
        return self.function(*self.arguments)


@dataclass(frozen=True)
class ResultOf:
    """Among a call's arguments: the result of an earlier one, by its number in the list."""

    call: int


class Answering(Protocol):
    """A process that carries out calls."""

    def answer(self, call: SideCall) -> tuple[bool, Any] | None:
        """Whether the function returned, and its result or what it raised; None: what it raised cannot be sent."""


def here(calls: Sequence[SideCall]) -> list[Any]:
    """The calls' results, all worked out here."""
    values: list[Any] = []
    for call in calls:
        values.append(call.given(values.__getitem__).carried_out())
    return values


class SharedCalls:
    """Calls that several processes share: each takes those of its own place first, then those of none.

    A place beyond the processes that are left is one of theirs. A call that needs another's result waits for it, while
    its process works on later ones. ``drop``: called with a process that has ended.
    """

    def __init__(self, calls: Sequence[SideCall], drop: Callable[[Any], None]) -> None:
        self._calls, self._drop = calls, drop
        self._left = set(range(len(calls)))
        self._changed = threading.Condition()
        self._count, self._lost = 1, False
        self._found: dict[int, tuple[bool, Any] | None] = {}

    @property
    def left(self) -> int:
        """Number of calls that no process has taken, or whose process has ended."""
        return len(self._left)

    def work_in(self, processes: Sequence[Answering]) -> None:
        """Let the processes take calls until none is left or all have ended; one that ends is dropped."""
        self._count, self._lost = len(processes), False
        threads = [threading.Thread(target=self.work, args=(k, each), daemon=True) for k, each in enumerate(processes)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def work(self, number: int, process: Answering) -> None:
        """Take calls until none is left."""
        while (index := self._next(number)) is not None:
            try:
                answer = process.answer(self._calls[index].given(self._result))
            except (EOFError, OSError):  # the process has ended
                with self._changed:
                    self._left.add(index)
                    self._lost = True
                    self._changed.notify_all()
                self._drop(process)
                return
            except Exception as error:  # a call or an answer that cannot be sent is a bug of ours, raised to the caller
                answer = False, error
            self._keep(index, answer)

    def _result(self, index: int) -> Any:
        found = self._found[index]
        assert found is not None  # else no call that needs it is taken, see ``_keep``
        return found[1]

    def _keep(self, index: int, answer: tuple[bool, Any] | None) -> None:
        """Keep a call's answer; where there is no result, it is also that of the calls that need one."""
        with self._changed:
            self._found[index] = answer
            self._left.discard(index)
            if answer is None or not answer[0]:
                for needing in [k for k in self._left if index in self._calls[k].needs]:
                    self._keep(needing, answer)
            self._changed.notify_all()

    def _next(self, number: int) -> int | None:
        """A call for the process with this number, as soon as there is one.

        None: there will be none, or only after the places of a process that has ended are shared out again.
        """
        with self._changed:
            while mine := [k for k in sorted(self._left) if self._is_for(number, self._calls[k].place)]:
                ready = [k for k in mine if all(need in self._found for need in self._calls[k].needs)]
                if ready:
                    index = min(ready, key=lambda k: (self._calls[k].place is None, k))
                    self._left.discard(index)
                    return index
                if self._lost:
                    return None
                self._changed.wait()
            return None

    def _is_for(self, number: int, place: int | None) -> bool:
        return place is None or place % self._count == number

    def results(self) -> list[Any]:
        """In the order of the calls; what no process could answer is done here."""
        values: list[Any] = []
        for index, call in enumerate(self._calls):
            found = self._found.get(index)
            passed, value = found or (True, call.given(values.__getitem__).carried_out())
            if not passed:
                raise value
            values.append(value)
        return values
