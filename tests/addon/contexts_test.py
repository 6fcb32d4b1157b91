"""Native contexts are shared if they may be, kept for the next user, and thrown away after an error."""

from dataclasses import replace

import numpy as np
import pytest

from paradesc import bridge
from paradesc.bridge import ParadescError, abi
from paradesc.core import contexts, job, stream

DEVICE = "software"


@pytest.fixture(autouse=True)
def none_idle():
    """Begins and ends every test without idle contexts."""
    contexts.close_idle()
    yield
    contexts.close_idle()
    assert contexts.POOL.used == []


def settings():
    """Settings that compute quickly."""
    return job.Settings(options=bridge.Options(samples=32, buffer_size=128, radius=0.08), backend=DEVICE)


def idle():
    """The contexts that nobody uses."""
    return list(contexts.POOL.idle.values())


def test_a_context_is_used_again_and_computes_the_same(sphere):
    first = job.run(sphere, settings())
    (kept,) = idle()
    again = job.run(sphere, settings())
    assert idle() == [kept]
    assert np.array_equal(first.values["mean_curvature"], again.values["mean_curvature"])


def test_two_at_once_have_a_context_each_unless_they_share_one():
    own, other = (contexts.Lease(DEVICE, -1) for _ in range(2))
    shared, partner = (contexts.Lease(DEVICE, -1, shared=True) for _ in range(2))
    assert len({id(lease.context) for lease in (own, other, shared)}) == 3
    assert partner.context is shared.context
    shared.close()
    assert partner.context not in idle()
    for lease in (partner, own, other):
        lease.close()
    assert len(idle()) == 1


def test_another_device_is_another_context():
    with contexts.Lease(DEVICE, -1) as one, contexts.Lease("reference", -1) as other:
        assert one is not other
    assert len(idle()) == 2


def test_a_memory_limit_holds_for_its_own_context_alone(sphere):
    with pytest.raises(ParadescError, match="memory limit"):
        job.run(sphere, replace(settings(), memory_limit=1000))
    assert np.isfinite(job.run(sphere, settings()).values["mean_curvature"]).all()


def test_streams_share_a_context_and_leave_it_to_each_other(sphere):
    moved = replace(sphere, positions=sphere.positions * np.float32(2))
    expected = job.run(moved, settings()).values["mean_curvature"]
    with stream.Stream(sphere, settings(), shared=True) as one:
        one.compute(sphere.positions)
        with stream.Stream(moved, settings(), shared=True) as other:
            assert len(contexts.POOL.used) == 1
            assert np.array_equal(other.compute(moved.positions).values["mean_curvature"], expected)
        one.compute(sphere.positions)
        assert one.made == 1


def test_cancelling_keeps_the_context_and_any_other_error_ends_it(sphere):
    with pytest.raises(ParadescError) as caught:
        job.run(sphere, settings(), lambda _stage, _fraction: False)
    assert caught.value.status == abi.STATUS_CANCELLED
    assert len(idle()) == 1

    def interrupt(_stage, _fraction):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        job.run(sphere, settings(), interrupt)
    assert idle() == []


def test_a_context_that_failed_is_not_shared_any_more():
    first = contexts.Lease(DEVICE, -1, shared=True)
    first.failed(ParadescError(abi.STATUS_OUT_OF_MEMORY, "Out of memory."))
    second = contexts.Lease(DEVICE, -1, shared=True)
    assert second.context is not first.context
    first.close(), first.close()
    assert idle() == []
    second.close()
    assert len(idle()) == 1
