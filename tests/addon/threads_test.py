"""Two Python threads at once give the same bits as one alone, each with a context of its own; work side by side."""

import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

from paradesc import bridge
from paradesc.bridge import ParadescError
from paradesc.core import threads
from shapes import as_arrays, cube_sphere

OPTIONS = bridge.Options(radius=0.1, samples=32, buffer_size=256)
NAMES = ["mean_curvature", "shape_index"]


def values(arrays, backend, start=None):
    """Both descriptors, computed three times with a new context."""
    with bridge.Context(backend) as context, context.mesh(arrays) as mesh:
        if start is not None:
            start.wait(60)
        for _ in range(3):
            with mesh.compute(NAMES, OPTIONS) as field:
                found = [field.values(name) for name in NAMES]
    return np.array(found)


@pytest.mark.parametrize("backend", ["reference", "software"])
def test_two_threads_with_two_contexts_give_what_one_gives(backend):
    arrays = as_arrays(*cube_sphere(6))
    try:
        alone = values(arrays, backend)
    except bridge.ParadescError as error:
        pytest.skip(error.sentence)
    start = Barrier(2)
    with ThreadPoolExecutor(2) as pool:
        both = list(pool.map(lambda _: values(arrays, backend, start), range(2)))
    for found in both:
        assert found.tobytes() == alone.tobytes()


def test_results_of_work_side_by_side_are_in_order_and_come_from_several_threads():
    found = threads.side_by_side(lambda number: (number * number, threading.get_ident()), range(200))
    assert [square for square, _ in found] == [number * number for number in range(200)]
    assert threads.side_by_side(len, []) == []


def test_work_side_by_side_ends_at_the_first_error():
    begun = []

    def work(number):
        begun.append(number)
        if number == 3:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        threads.side_by_side(work, range(100_000))
    assert len(begun) < 100_000


def test_work_side_by_side_ends_where_python_does():
    def work(_number):
        for cancel in list(threads._running.values()):
            cancel()
        time.sleep(0.001)

    if os.cpu_count() > 1:
        with pytest.raises(ParadescError, match="Cancelled"):
            threads.side_by_side(work, range(1000))
