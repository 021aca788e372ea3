"""The same bytes on other processors: what differs between the inner loops of BLAS, and what the workflow fixes."""

import os
import platform
import subprocess
import sys
from functools import cache
from io import StringIO

import pandas as pd
import pytest

from camid.workflow.arithmetic import reproducible_environment

pytestmark = pytest.mark.skipif(
    platform.machine() not in {"x86_64", "AMD64"}, reason="only x86-64 has several kernels to choose from"
)

ESTIMATES = """
import sys
import pandas as pd
from camid.chain.excitation import pseudo_random_binary_sequence
from camid.paper.datasets import noise_samples, sampling_period_outputs
from camid.paper.fig7_sampling_period.runs import identify_sampling_period
from camid.plotting import rounded

plant = {"static_gain": 1.0, "natural_frequency": 10.0, "damping": 0.1}
camera = {"hold": "zoh", "sensor": "camera", "shift": 0, "methods": ["srivc"]}
held = {"hold": "zoh", "sensor": "instant", "shift": 1, "methods": ["srivc"]}
sweep = {
    "start": 0.05, "stop": 0.25, "step": 0.1, "signal_to_noise_ratio": 10.0, "ratio_of": "power", "noise_samples": 2,
    "cases": {"camera": camera, "zoh": held},
}
excitation = pd.DataFrame({"u": pseudo_random_binary_sequence(9)})
outputs = sampling_period_outputs(excitation, plant, sweep)
noise = noise_samples(excitation, sweep, 20240501)
table = identify_sampling_period(outputs, noise, plant, sweep, sweep["cases"])
rounded(table).to_csv(sys.stdout, index=False)
"""


@cache
def estimates(**environment):
    """CSV of Fig. 7's estimates at three periods, by a fresh process with these variables set."""
    completed = subprocess.run(
        [sys.executable, "-c", ESTIMATES],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return completed.stdout


def test_kernels_of_blas_agree_to_more_digits_than_the_figure_shows():
    """Errors in per cent of the coefficient, and their standard deviations: 1e-4 percentage points."""
    ours = reproducible_environment()
    first, second = (
        pd.read_csv(StringIO(estimates(**ours | {"OPENBLAS_CORETYPE": core}))) for core in ("Haswell", "Nehalem")
    )
    assert len(first) >= 6
    assert first["converged"].all()
    assert second["converged"].all()
    for parameter in ("b0", "a1", "a0"):
        for quantity in ("error", "standard_deviation"):
            column = f"{quantity}_{parameter}"
            assert (first[column] - second[column]).abs().max() < 1e-4


def test_the_workflow_fixes_the_kernels():
    """Another choice in the reader's environment changes no byte of what the workflow computes."""
    ours = reproducible_environment()
    assert ours["OPENBLAS_CORETYPE"] == "Haswell"
    usual = estimates(**ours)
    assert usual.count("\n") >= 7
    again = estimates.__wrapped__  # a process of its own
    assert again(**{"OPENBLAS_CORETYPE": "Nehalem", "OPENBLAS_NUM_THREADS": "2", **ours}) == usual


def test_compiled_code_is_for_one_kind_of_processor():
    """Sums in compiled code follow the length of the processor's vectors."""
    import llvmlite.binding
    from numba.core.registry import cpu_target

    from camid.compiled import COMMON_FEATURES, COMMON_TARGET

    if not all(llvmlite.binding.get_host_cpu_features().get(feature) for feature in COMMON_FEATURES):
        pytest.skip("this processor is older than the common target")
    assert cpu_target.target_context.codegen().magic_tuple()[1:] == (COMMON_TARGET, "")
