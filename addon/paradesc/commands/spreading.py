"""Spreads the assets of a library over this machine's processes or Dask's workers; yields them as they are done.

Nothing is planned here: the pool and Dask decide who takes which asset. Never imports bpy.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING

from ..bridge import ParadescError, abi
from . import assets
from .assets import Done, Work
from .common import EXIT_FAILED

if TYPE_CHECKING:
    from distributed import Client

# Dask's scheduler keeps state for each known task, so only so many tasks are submitted at a time.
WINDOW = 2000
# Seconds without an answer until a scheduler counts as absent.
CONNECTING = 10
# Seconds between two checks whether the run has to stop.
PATIENCE = 0.1
DIED = "The process that computed it was ended from outside, perhaps because memory was short; try --workers 1."
DIED_ON_WORKERS = "Every Dask worker that computed it was ended, perhaps because memory was short."

# A function that is called while no asset is done; it raises if the run has to stop.
Check = Callable[[], None]


def cores() -> int:
    """The number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def in_blender() -> bool:
    """Returns whether this is the Blender executable, whose Python cannot start worker processes."""
    blender = sys.modules.get("bpy")
    return blender is not None and bool(blender.app.binary_path)


# ---- This machine


def on_processes(work: Work, names: list[str], workers: int, check: Check) -> Iterator[Done]:
    """Computes assets in separate processes; one that dies does not affect other assets."""
    left = dict.fromkeys(names)
    while left:
        try:
            for done in pooled(work, list(left), workers, check):
                del left[done.row["file"]]
                yield done
        except BrokenProcessPool:
            for name in list(left)[: 4 * workers]:  # one by one, so that an asset that ends its process is known
                del left[name]
                yield alone(work, name, check)


def alone(work: Work, name: str, check: Check) -> Done:
    """Computes one asset in a process of its own."""
    try:
        (done,) = pooled(work, [name], 1, check)
    except BrokenProcessPool:
        return ended(work, name, DIED)
    return done


def pooled(work: Work, names: list[str], workers: int, check: Check) -> Iterator[Done]:
    """Computes assets in a pool, nearly in their order. Raises BrokenProcessPool if a process dies.

    At most four times as many assets as processes are under way, so an asset that ends its process is among so many of
    the first that are left.
    """
    others = set(multiprocessing.active_children())
    # Not forked: the native library may have threads, which a fork would lose in the middle of their work.
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), begin)
    try:
        for _, future in windowed(partial(pool.submit, assets.measure, work), names, 2 * workers, check):
            yield future.result()
    except BaseException:
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def begin() -> None:
    """Begins a process of the pool. It leaves Ctrl-C to the main one, which ends it, and ends if that is killed.

    Files are written whole, so no half file is left.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=end_with, args=(multiprocessing.parent_process(),), daemon=True).start()


def end_with(main: multiprocessing.Process) -> None:
    """Waits until the main process ends, and ends this one."""
    main.join()
    os._exit(EXIT_FAILED)


def windowed(
    submit: Callable[[str], Future], names: list[str], window: int, check: Check
) -> Iterator[tuple[str, Future]]:
    """Submits names while earlier ones finish, with at most window of them under way; yields what has finished."""
    waiting = iter(names)
    running = {submit(name): name for name in islice(waiting, window)}
    while running:
        done, _ = wait(running, PATIENCE, FIRST_COMPLETED)
        check()
        for future in done:
            running.update({submit(name): name for name in islice(waiting, 1)})
            yield running.pop(future), future


def ended(work: Work, name: str, sentence: str) -> Done:
    """The row of an asset whose process died, which is also written."""
    row = {"file": name, "content_hash": None, "settings_key": work.key}
    row = assets.failed(row, sentence, EXIT_FAILED)
    assets.write_row(work, row)
    return Done(row, True)


# ---- Dask


def connected(address: str) -> "Client":
    """Dask's scheduler at this address, or that of a scheduler file, which ends in .json."""
    try:
        from distributed import Client
    except ImportError as error:
        sentence = "Dask is not installed here; pip install paradesc[farms]."
        raise ParadescError(abi.STATUS_UNSUPPORTED, sentence) from error
    try:
        where = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
        return Client(**where, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError) as error:
        sentence = f'There is no Dask scheduler at "{address}" ({error}); start one with dask scheduler.'
        raise ParadescError(abi.STATUS_UNSUPPORTED, sentence) from error


def on_dask(work: Work, names: list[str], client: "Client", check: Check) -> Iterator[Done]:
    """Computes assets on Dask's workers, which must find the folders at the same paths. Dask repeats a lost asset."""
    executor = client.get_executor(pure=False)  # a new run computes again, instead of getting results of an earlier one
    try:
        for name, future in windowed(partial(executor.submit, assets.measure, work), names, WINDOW, check):
            yield result_of(work, name, future)
    finally:
        executor.shutdown(wait=False)


def result_of(work: Work, name: str, future: Future) -> Done:
    """The result of a worker; if every worker that tried the asset died, a row that says so."""
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return ended(work, name, DIED_ON_WORKERS)
    except ImportError as error:
        sentence = f"A Dask worker cannot import this package ({error}); install the same version there."
        raise ParadescError(abi.STATUS_UNSUPPORTED, sentence) from error
    except CancelledError as error:
        sentence = "The connection to the Dask scheduler was lost; what is done is kept, so run this again."
        raise ParadescError(abi.STATUS_UNKNOWN, sentence) from error
