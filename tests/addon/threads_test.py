"""Two Python threads at once, each with a context of its own on the same arrays, give the same bits as one alone."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

from paradesc import bridge
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
