"""What lies past the paper, one question a module; ``snakemake -c2 ablation_<module>`` answers it.

Every module has

- ``compute(settings, shared)``: the runs as a DataFrame, from its section of ``config/ablations.yaml`` and the sections
  of ``config/config.yaml`` that ``workflow/rules/ablations.smk`` names for it;
- ``quantities(table)``: the numbers that are quoted and guarded, as name → (value, unit);
- ``conclusion(value)``: the answer in one or two sentences, made from those numbers, name → value.

The module of the same name in :mod:`camid.figures.ablations` draws the table.
"""
