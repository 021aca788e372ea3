"""The same bytes from fresh clones in different folders, on one core and two, with any number of threads of BLAS."""

import os

from tests.faults.campaign import Budget, Count, Project, bench, camid, ended, progress
from tests.faults.together import contents

WAYS = [  # cores, threads of the linear algebra, processor that OpenBLAS would choose
    (1, "1", None),
    (2, "2", None),
    (2, "4", "Nehalem"),
]
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def variables(threads, kernel):
    return dict.fromkeys(THREADS, threads) | ({"OPENBLAS_CORETYPE": kernel} if kernel else {})


def campaign(project, reference, seconds, folder, random):
    """Counts of this campaign."""
    del seconds, random
    progress("determinism")
    workflow = Count(
        "other folder, cores, threads and kernels of BLAS", "the workflow in little, fresh clones", "the same bytes"
    )
    for number, (cores, threads, kernel) in enumerate(WAYS):
        if Budget.over(workflow):
            break
        clone = Project(folder / f"eine Kopie {number} · 二")
        clone.reset()
        code, printed = clone.run(cores=cores, environment=variables(threads, kernel))
        results = clone.results()
        different = [name for name in reference if results.get(name) != reference[name]]
        wrong = None if code == 0 and not different else f"{code}, {different}: {printed[-200:]}"
        workflow.add("same bytes", wrong)
    commands = Count("threads of BLAS", "`camid identify`, `camid diagnose`", "the same bytes")
    for command, output in (("identify", "model.yaml"), ("diagnose", "diagnosis")):
        found = []
        for threads in ("1", "2", "4"):
            # The same name in another folder: the report says the command that made it.
            work = bench(folder / f"work-{threads}-{command}")
            arguments = [command, "recording.csv", "--simulation", "S.yaml", "--output", output]
            code, printed = ended(camid(arguments, work, environment=variables(threads, None)))
            found.append(contents(work / output) if code == 0 else {"": printed})
            wrong = None if found[-1] == found[0] and code == 0 else f"{command}, {threads} threads: {printed[-200:]}"
            commands.add("same bytes", wrong)
    assert os.path.isdir(project.folder)
    return [workflow, commands]
