"""The runs of a sweep on an existing dask.distributed cluster.

Every thread of a dask worker has a supervised process of its own (`workers.Worker`), so that a crashing unit costs
the cluster nothing and rows have the same bits as at home, on like machines. A dask worker that is lost takes its runs
with it; the scheduler gives them to others. Foreign FMUs must be found under the same path everywhere.
"""

from __future__ import annotations

import contextlib
import importlib
import pickle
import queue
import threading
import uuid
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

from towage.errors import TowageError
from towage.sweeps.workers import LOOK, Setup, Task, Worker

if TYPE_CHECKING:
    from towage.sweeps.row import Row

AHEAD = 3
"""Runs handed out for each thread of the cluster: one is done, the others hide the way there."""
TRIES = 3
"""Times that a run is handed out again because its dask workers died."""
ANSWER = 10.0
"""Longest wait for the scheduler, s."""
_local = threading.local()
_workers: dict[str, list[Worker]] = {}


def run_on_dask(setup: Setup, tasks: Sequence[Task], address: str) -> Iterator[Row | None]:
    """As `run_here`, on the cluster whose scheduler is at ``address``. Raises `TowageError` without a cluster, and for a
    run that was lost `TRIES` times."""
    try:
        distributed: Any = importlib.import_module("distributed")
    except ImportError as error:
        raise TowageError(f"--dask needs dask.distributed ({error}): pip install 'towage[cluster]'") from error
    try:
        client = distributed.Client(address, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError) as error:
        raise TowageError(f"no dask scheduler answers at {address}: {error}") from error
    shared, sweep = pickle.dumps(setup), uuid.uuid4().hex
    left, given, tries = iter(tasks), dict[Any, Task](), dict[int, int]()
    ended = queue.SimpleQueue[Any]()

    def hand_out(task: Task) -> None:
        """Give a run to the scheduler, under a key of its own."""
        tries[task.index] = tries.get(task.index, 0) + 1
        key = f"towage-{sweep}-{task.index}-{tries[task.index]}"
        future = client.submit(work, sweep, shared, task, pure=False, key=key)
        given[future] = task
        future.add_done_callback(ended.put)

    with client:
        try:
            ahead = AHEAD * max(1, sum(client.nthreads().values()))
            for task in islice(left, ahead):
                hand_out(task)
            while given:
                try:
                    future = ended.get(timeout=LOOK)
                except queue.Empty:
                    yield None
                    continue
                task = given.pop(future)
                if future.status == "finished":
                    yield future.result()
                    for following in islice(left, 1):
                        hand_out(following)
                elif tries[task.index] < TRIES:
                    hand_out(task)
                else:
                    reason = future.exception(timeout=ANSWER) if future.status == "error" else future.status
                    raise TowageError(
                        f"run {task.index} was lost {TRIES} times on the cluster ({reason}): see the logs of its workers, "
                        "then continue with --resume"
                    )
        finally:
            with contextlib.suppress(Exception):  # a cluster that is gone has nothing to clear away
                client.cancel(list(given), force=True)
                client.run(release, sweep)


def work(sweep: str, shared: bytes, task: Task) -> Row:
    """On a dask worker: the row of one run of a sweep, whose setup is ``shared``."""
    if getattr(_local, "sweep", None) != sweep:
        if hasattr(_local, "worker"):
            _local.worker.close()
        _local.sweep, _local.worker = sweep, Worker(pickle.loads(shared))
        _workers.setdefault(sweep, []).append(_local.worker)
    row: Row = _local.worker.run(task)
    return row


def release(sweep: str) -> None:
    """On a dask worker: end the processes that stand ready for a sweep. Runs under way there end with them."""
    for worker in _workers.pop(sweep, []):
        worker.stop()
