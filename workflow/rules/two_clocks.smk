# Clips and drive logs on two clocks, made by code that shares nothing with the tool: are stated uncertainties true?

TWO_CLOCKS = config["concealed"]["two_clocks"]


rule two_clocks_errors:
    output:
        f"results/two_clocks/{TWO_CLOCKS['seed']}/{CONCEALED_SHARD}.parquet",
    log:
        "results/logs/two_clocks_errors_{shard}_of_{shards}.log",
    params:
        code=script_code("two_clocks_errors.py", "camid.commands.join"),
        seed=TWO_CLOCKS["seed"],
        pairs=TWO_CLOCKS["pairs"],
    message:
        "Joining clips and drive logs, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/two_clocks_errors.py"


rule two_clocks:
    input:
        errors=expand(
            f"results/two_clocks/{TWO_CLOCKS['seed']}/{CONCEALED_SHARD}.parquet",
            shard=range(TWO_CLOCKS["shards"]),
            shards=TWO_CLOCKS["shards"],
        ),
        working_copy=BIRTH_MARK,
    output:
        markdown="paper_figs/two_clocks.md",
        coverage="paper_figs/two_clocks.csv",
    log:
        "results/logs/two_clocks.log",
    params:
        code=script_code("two_clocks.py"),
        seed=TWO_CLOCKS["seed"],
        pairs=TWO_CLOCKS["pairs"],
    message:
        "Holding the stated uncertainties of two clocks against the truth."
    script:
        "../scripts/two_clocks.py"
