# Many noise seeds at every period of Fig. 7: in shards, as many as its settings say, so that two cores or a
# cluster work side by side. `ablations` takes few seeds; the target `monte_carlo` takes all of them.

MONTE_CARLO = SETTINGS["monte_carlo"]


SHARD = "results/monte_carlo/{seeds}_seeds/{shard}_of_{shards}.parquet"


rule monte_carlo_shard:
    output:
        SHARD,
    log:
        "results/logs/monte_carlo_{seeds}_{shard}_of_{shards}.log",
    wildcard_constraints:
        seeds=r"\d+",
        shard=r"\d+",
        shards=r"\d+",
    cache: True
    params:
        **calls("compute.py", "ablations.monte_carlo.runs.compute_numbered_shard"),
        # The cache between workflows knows parameters but no wildcards: without these all shards would be one to it.
        seeds=lambda wildcards: int(wildcards.seeds),
        shard=lambda wildcards: int(wildcards.shard),
        shards=lambda wildcards: int(wildcards.shards),
        settings={"signal_to_noise_ratio": MONTE_CARLO["signal_to_noise_ratio"]},
        shared={
            **{
                section: config[section] for section in ["plant", "excitation", "seed"]
            },
            "sampling_period_sweep": selected(
                "sampling_period_sweep", "start", "stop", "step"
            ),
        },
    message:
        "Fitting shard {wildcards.shard} of {wildcards.shards} with {wildcards.seeds} noise seeds per period."
    script:
        "../scripts/compute.py"


rule monte_carlo_runs:
    input:
        shards=expand(
            SHARD,
            seeds=MONTE_CARLO["seeds"],
            shard=range(MONTE_CARLO["shards"]),
            shards=MONTE_CARLO["shards"],
        ),
    output:
        "results/ablations/monte_carlo.parquet",
    log:
        "results/logs/monte_carlo_runs.log",
    params:
        code=script_code("monte_carlo_runs.py"),
    message:
        "Adding up the shards of the Monte Carlo."
    script:
        "../scripts/monte_carlo_runs.py"


use rule monte_carlo_runs as monte_carlo_all_runs with:
    input:
        shards=expand(
            SHARD,
            seeds=MONTE_CARLO["all_seeds"],
            shard=range(MONTE_CARLO["all_shards"]),
            shards=MONTE_CARLO["all_shards"],
        ),
    output:
        "results/monte_carlo/all.parquet",
    log:
        "results/logs/monte_carlo_all_runs.log",


rule monte_carlo:
    input:
        runs=rules.monte_carlo_all_runs.output[0],
    output:
        png="paper_figs/monte_carlo.png",
        csv="paper_figs/monte_carlo.csv",
        quantities="paper_figs/monte_carlo_quantities.csv",
        conclusion="paper_figs/monte_carlo.txt",
    log:
        "results/logs/monte_carlo.log",
    params:
        ablation="monte_carlo",
        title="Errors over the Cramér–Rao bound, all noise seeds",
        code=ablation_code("monte_carlo"),
    message:
        "Drawing: errors over the Cramér–Rao bound, all noise seeds."
    script:
        "../scripts/draw_ablation.py"
