# Constants of physical plants, on rigs made by code that shares nothing with the tool: are stated uncertainties true?

PHYSICAL_RIGS = config["concealed"]["physical_rigs"]
PHYSICAL_TABLES = ["estimates", "undetermined"]


rule physical_rigs_estimates:
    output:
        **{
            table: f"results/physical_rigs/{PHYSICAL_RIGS['seed']}/{CONCEALED_SHARD}/{table}.parquet"
            for table in PHYSICAL_TABLES
        },
    log:
        "results/logs/physical_rigs_estimates_{shard}_of_{shards}.log",
    params:
        code=script_code("physical_rigs_estimates.py", "camid.commands.identify"),
        seed=PHYSICAL_RIGS["seed"],
        seeds=PHYSICAL_RIGS["seeds"],
    message:
        "Estimating constants of physical rigs, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/physical_rigs_estimates.py"


rule physical_rigs:
    input:
        **{
            table: expand(
                f"results/physical_rigs/{PHYSICAL_RIGS['seed']}/{CONCEALED_SHARD}/{table}.parquet",
                shard=range(PHYSICAL_RIGS["shards"]),
                shards=PHYSICAL_RIGS["shards"],
            )
            for table in PHYSICAL_TABLES
        },
        working_copy=BIRTH_MARK,
    output:
        markdown="paper_figs/physical_rigs.md",
        coverage="paper_figs/physical_rigs.csv",
    log:
        "results/logs/physical_rigs.log",
    params:
        code=script_code("physical_rigs.py"),
        seed=PHYSICAL_RIGS["seed"],
        seeds=PHYSICAL_RIGS["seeds"],
    message:
        "Holding the stated uncertainties of physical constants against the truth."
    script:
        "../scripts/physical_rigs.py"
