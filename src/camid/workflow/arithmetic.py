"""The environment in which the last digits of a result do not depend on the processor.

BLAS and numpy choose their inner loops by the processor when they are loaded, and each choice adds up in another order.
The last digits of a table, and the coordinates in a PDF, would be those of the machine that made them.
"""

from __future__ import annotations

import platform

# OpenBLAS: the loops that every x86-64 processor with AVX2 has (Intel since 2013, AMD since 2015); one thread, because
# threads share out a sum. numpy: none of the loops that only processors with AVX-512 have.
X86_64 = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"}
ONE_THREAD_OF_LINEAR_ALGEBRA = {f"{library}_NUM_THREADS": "1" for library in ("MKL", "OMP", "OPENBLAS")}


def reproducible_environment() -> dict[str, str]:
    """Variables to set before numpy is imported.

    Returns
    -------
    dict of str to str
        :mod:`camid.compiled` compiles for one kind of processor itself. On processors that are not x86-64 the digits
        are their own; they agree as tests/workflow/test_arithmetic.py says.
    """
    return {**(X86_64 if platform.machine() in {"x86_64", "AMD64"} else {}), **ONE_THREAD_OF_LINEAR_ALGEBRA}
