# Rigs whose first recording leaves several names, made by code that shares nothing with the tool: does `camid design` help?

DESIGNED_EXPERIMENT = config["concealed"]["designed_experiment"]


rule designed_experiment_diagnoses:
    output:
        f"results/designed_experiment/{DESIGNED_EXPERIMENT['seed']}/{CONCEALED_SHARD}.parquet",
    log:
        "results/logs/designed_experiment_diagnoses_{shard}_of_{shards}.log",
    params:
        code=script_code(
            "designed_experiment_diagnoses.py",
            "camid.commands.design",
            "camid.commands.diagnose",
        ),
        seed=DESIGNED_EXPERIMENT["seed"],
        rigs=DESIGNED_EXPERIMENT["rigs"],
    message:
        "Designing second experiments, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/designed_experiment_diagnoses.py"


rule designed_experiment:
    input:
        rows=expand(
            f"results/designed_experiment/{DESIGNED_EXPERIMENT['seed']}/{CONCEALED_SHARD}.parquet",
            shard=range(DESIGNED_EXPERIMENT["shards"]),
            shards=DESIGNED_EXPERIMENT["shards"],
        ),
        tolerances="config/tolerances.yaml",
        working_copy=BIRTH_MARK,
    output:
        markdown="paper_figs/designed_experiment.md",
        png="paper_figs/designed_experiment.png",
        csv="paper_figs/designed_experiment.csv",
        shares="paper_figs/designed_experiment_shares.csv",
    log:
        "results/logs/designed_experiment.log",
    params:
        code=script_code("designed_experiment.py"),
        seed=DESIGNED_EXPERIMENT["seed"],
        rigs=DESIGNED_EXPERIMENT["rigs"],
    message:
        "Holding designed experiments against repetitions."
    script:
        "../scripts/designed_experiment.py"
