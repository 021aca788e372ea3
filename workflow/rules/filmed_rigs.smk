# Rendered clips of rigs with something concealed: does it come out of tracking, joining and diagnosing?

FILMED_RIGS = config["concealed"]["filmed_rigs"]


rule filmed_rigs_diagnoses:
    output:
        f"results/filmed_rigs/{FILMED_RIGS['seed']}/{CONCEALED_SHARD}.parquet",
    log:
        "results/logs/filmed_rigs_diagnoses_{shard}_of_{shards}.log",
    params:
        code=script_code(
            "filmed_rigs_diagnoses.py",
            "camid.__main__",
            "camid.cli.track",
            "camid.cli.join",
            "camid.cli.diagnose",
        ),
        seed=FILMED_RIGS["seed"],
        clips=FILMED_RIGS["clips"],
    message:
        "Filming and diagnosing rigs, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/filmed_rigs_diagnoses.py"


rule filmed_rigs:
    input:
        diagnoses=expand(
            f"results/filmed_rigs/{FILMED_RIGS['seed']}/{CONCEALED_SHARD}.parquet",
            shard=range(FILMED_RIGS["shards"]),
            shards=FILMED_RIGS["shards"],
        ),
        working_copy=BIRTH_MARK,
    output:
        markdown="paper_figs/filmed_rigs.md",
        clips="paper_figs/filmed_rigs.csv",
    log:
        "results/logs/filmed_rigs.log",
    params:
        code=script_code("filmed_rigs.py"),
        seed=FILMED_RIGS["seed"],
        clips=FILMED_RIGS["clips"],
    message:
        "Holding what was found in filmed rigs against what was put in."
    script:
        "../scripts/filmed_rigs.py"
