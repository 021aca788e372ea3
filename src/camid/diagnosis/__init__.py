"""Diagnosis: detect → locate → screen → fit → decide → report.

:mod:`camid.diagnosis.run` says in which ways a recording is looked at, and :mod:`camid.diagnosis.decided` in what order
things happen in each. They begin with a ``setting``; ``search`` finds names, ``pruning`` drops those that do not hold,
``residual`` tests what is left, ``laws`` learns what has no name, ``conclusion`` makes a diagnosis of it all, and
``report`` shows it.
"""
