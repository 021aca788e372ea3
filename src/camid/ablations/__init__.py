"""What lies past the paper, one question per folder; ``snakemake -c2 ablation_<folder>`` answers it.

The workflow finds a new ablation by its folder; docs/adding_an_ablation.md says what else it takes. Every folder holds

- ``runs.py``: ``compute(settings, shared)``, the runs as a DataFrame, from the folder's settings and the sections of
  ``config/config.yaml`` that ``ablation.yaml`` names; ``quantities(table)``, the numbers that are quoted and guarded,
  as name → (value, unit); ``conclusion(value)``, the answer in one or two sentences, made from those numbers;
- ``drawing.py``: ``draw(table)``, the figure and the numbers that it shows;
- ``settings.yaml`` and ``settings.schema.yaml``: the numbers of the ablation, and what they may be;
- ``tolerances.yaml``: what ``snakemake -c2 check`` holds its numbers against;
- ``ablation.yaml``: ``title`` of the figure and ``uses``, the sections of ``config/config.yaml`` that it is given;
  ``category`` of the report where it is not ``Ablations``; ``own_rules: true`` where a file of rules makes its runs.

The modules beside the folders hold what several ablations share.
"""
