"""Tasks on a Dask cluster. ``distributed`` is an optional package and is imported only here.

If a worker dies, the scheduler gives its tasks to another one. Results return to the client, which alone
writes them in a fixed order. The output is therefore identical to that of a single machine.
"""

from __future__ import annotations

import logging
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from synth.batch.task_outcome import TaskOutcome, differences, performed
from synth.errors import Problem, UserError
from synth.files.program_versions import versions

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD = 2  # tasks per thread that are sent in advance
CONNECT = 10.0  # s to reach the scheduler: a choice; a wrong address is reported while the user still watches
FIRST_WORKER = 30.0  # s until a worker must have appeared: a choice; a starting worker first imports numpy and numba
OPTION = "--scheduler"


class Cluster:
    """A connection to a scheduler whose workers have the same program and packages; see ``connected``."""

    def __init__(self, client: Client, address: str) -> None:
        self._client, self._address = client, address

    @property
    def threads(self) -> int:
        """Number of tasks that currently run in parallel.

        Raises
        ------
        UserError : the scheduler is gone.
        """
        try:
            return max(1, int(sum(self._client.nthreads().values())))
        except (OSError, ValueError, RuntimeError):  # a closed client raises different errors, depending on its state
            raise self._gone() from None

    def _gone(self) -> UserError:
        text = "the scheduler is gone. Finished results are kept: repeat the command later, or without --scheduler"
        return UserError(Problem(text, self._address))

    def run(
        self, function: Callable[[Any], Any], calls: Iterable[tuple[str, Any]]
    ) -> Iterator[tuple[str, TaskOutcome]]:
        """Run ``function(argument)`` for each ``(key, argument)``; yields results as they finish.

        Raises
        ------
        UserError : the scheduler is gone, or a worker has other versions.
        """
        from distributed import as_completed

        rest, wanted, run = iter(calls), versions(), uuid.uuid4().hex
        keys: dict[Future, str] = {}
        completed = as_completed(loop=self._client.loop)

        def send() -> None:
            while len(keys) < AHEAD * self.threads and (call := next(rest, None)) is not None:
                name = f"synth-{run}-{call[0]}"
                with warnings.catch_warnings():
                    warnings.filterwarnings("ignore", message="Sending large graph")  # large recordings are expected
                    future = self._client.submit(performed, function, call[1], wanted, key=name, pure=False)
                keys[future] = call[0]
                completed.add(future)

        try:
            send()
            while keys:
                future = next(completed)
                if future.status in ("lost", "pending"):  # the worker died with the result: another one runs it again
                    completed.add(future)
                    continue
                yield keys.pop(future), self._ended(future)
                future.release()
                send()
        finally:
            with suppress(Exception):
                self._client.cancel(list(keys), force=True)

    def _ended(self, future: Future) -> TaskOutcome:
        from distributed import KilledWorker

        if future.status == "finished":
            ended = future.result()
            assert isinstance(ended, TaskOutcome)
            if ended.other:
                raise UserError(Problem(f"a worker has {ended.other}; {SAME}", self._address))
            return ended
        if future.status != "error":
            raise self._gone()
        error = future.exception()
        if isinstance(error, KilledWorker):
            text = "every worker that ran it died, probably for lack of memory; try it alone"
            return TaskOutcome(problems=(Problem(text),))
        raise UserError(Problem(f"a worker cannot run this program's tasks ({error}); {SAME}", self._address))


SAME = "scheduler, workers and this program need the same versions, so that the numbers do not depend on the worker"


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """A connection to the scheduler at ``address``.

    Raises
    ------
    UserError : ``distributed`` is not installed, nothing answers, there is no worker, or versions differ.
    """
    try:
        from distributed import Client
    except ImportError:
        text = "needs the package distributed, which is not installed here: pip install 'limb-synth[cluster]'"
        raise UserError(Problem(text, key=OPTION)) from None
    # Its warnings about lost connections and workers are replaced by our own messages.
    for name in ("tornado", "asyncio", *logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            client = Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, TypeError, ImportError) as error:
            known = isinstance(error, OSError)
            why = f"nothing answers there within {CONNECT:.0f} s" if known else str(error)
            text = f"no Dask scheduler at {address}: {why}. Start one with: dask scheduler; its address has the form"
            raise UserError(Problem(f"{text} tcp://HOST:8786", key=OPTION)) from None
    try:
        _require_workers(client, address)
        yield Cluster(client, address)
    finally:
        with warnings.catch_warnings(), suppress(TimeoutError, OSError):
            warnings.simplefilter("ignore")
            client.close(timeout=5)


def _require_workers(client: Client, address: str) -> None:
    """Check for at least one worker, and equal versions everywhere."""
    try:
        client.wait_for_workers(1, timeout=FIRST_WORKER)
    except TimeoutError:
        text = f"the scheduler has no worker after {FIRST_WORKER:.0f} s; start one with: dask worker {address}"
        raise UserError(Problem(text, key=OPTION)) from None
    problems = [Problem(f"{who} has {other}; {SAME}", key=OPTION) for who, other in _others(client)]
    if problems:
        raise UserError(problems)


def _others(client: Client) -> Iterator[tuple[str, str]]:
    """Members of the cluster with other versions than this process."""
    found = client.get_versions()
    here = found["client"]["packages"]["distributed"]
    everyone = {"the scheduler": found["scheduler"]}
    everyone |= {f"the worker at {address}": about for address, about in sorted(found["workers"].items())}
    for who, about in everyone.items():
        if (there := about["packages"]["distributed"]) != here:
            yield who, f"distributed {there} instead of {here}"
            return  # no further query is possible
    wanted = versions()
    for address, has in sorted(client.run(versions, on_error="return").items()):
        if isinstance(has, ModuleNotFoundError):
            yield f"the worker at {address}", f"no limb-synth {wanted['synth']} ({has})"
        elif isinstance(has, BaseException):
            raise has
        elif other := differences(wanted, has):
            yield f"the worker at {address}", other
