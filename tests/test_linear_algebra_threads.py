"""BLAS uses one thread while a task of ours runs, and afterwards as many as before."""

import pytest
import scipy.linalg  # noqa: F401 - numpy and scipy bring a BLAS each
from threadpoolctl import threadpool_info, threadpool_limits

import camid
from tests.support.mass_on_spring import record, simulation


def threads():
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


@pytest.mark.parametrize("task", [camid.identify, camid.select_order, camid.diagnose])
def test_every_blas_is_limited_and_released(task):
    seen = []
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        task(record(count=400), simulation(), progress=lambda _: seen.extend(threads()))
        after = threads()
    assert set(before) == {2}
    assert set(seen) == {1}
    assert after == before
