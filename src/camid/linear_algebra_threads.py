"""One thread for the library of linear algebra (BLAS), as long as a task of ours runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Decorator or ``with`` block within which BLAS uses one thread; afterwards as many as before.

    Our matrices have a few tens of columns: BLAS divides them all the same, and its threads, which wait in a loop,
    take the cores from the simulations that run at the same time. One thread also keeps the last digits the same
    whatever ``OMP_NUM_THREADS`` says. The limit holds for the whole process, as BLAS knows no other.
    """
    import scipy.linalg  # noqa: F401 - brings a BLAS of its own, which can only be limited once it is there

    with threadpool_limits(limits=1, user_api="blas"):
        yield
