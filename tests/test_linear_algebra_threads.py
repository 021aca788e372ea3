"""BLAS uses one thread while a task of ours runs, and afterwards as many as before."""

from __future__ import annotations

from threadpoolctl import threadpool_info, threadpool_limits

from camid.linear_algebra_threads import one_blas_thread


def _threads() -> list[int]:
    return [each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"]


def test_every_blas_is_limited_and_released() -> None:
    seen: list[int] = []

    @one_blas_thread()
    def task() -> None:
        import numpy as np  # noqa: F401
        import scipy.linalg  # noqa: F401

        seen.extend(_threads())

    with threadpool_limits(limits=2, user_api="blas"):
        task()
        after = _threads()
    assert len(seen) >= 2  # numpy's and scipy's
    assert set(seen) == {1}
    assert 2 in after
