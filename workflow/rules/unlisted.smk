# Rigs under laws outside the catalogue, made by code that shares nothing with the tool: what is learned of them?
# A smaller run, or another seed: snakemake -c2 unlisted --config unlisted_recordings=40 unlisted_seed=12345

UNLISTED = config["concealed"]["unlisted"]
for key in ["seed", "recordings"]:
    UNLISTED[key] = int(config.get(f"unlisted_{key}", UNLISTED[key]))


rule unlisted_answers:
    output:
        # A shard holds other cases if there are more of them.
        f"results/unlisted/{UNLISTED['seed']}/{UNLISTED['recordings']}/{CONCEALED_SHARD}.parquet",
    log:
        "results/logs/unlisted_answers_{shard}_of_{shards}.log",
    params:
        code=script_code(
            "unlisted_answers.py",
            "camid.commands.diagnose",
            "camid.commands.identify",
            "camid.commands.simulate",
        ),
        seed=UNLISTED["seed"],
        recordings=UNLISTED["recordings"],
    message:
        "Diagnosing rigs under unlisted laws, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/unlisted_answers.py"


rule unlisted:
    input:
        answers=expand(
            f"results/unlisted/{UNLISTED['seed']}/{UNLISTED['recordings']}/{CONCEALED_SHARD}.parquet",
            shard=range(UNLISTED["shards"]),
            shards=UNLISTED["shards"],
        ),
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/unlisted.png",
            category="Proof",
            labels={"figure": "unlisted", "of": "Laws outside the catalogue"},
        ),
        csv="paper_figs/unlisted.csv",
        markdown="paper_figs/unlisted.md",
    log:
        "results/logs/unlisted.log",
    params:
        code=script_code("unlisted.py"),
        seed=UNLISTED["seed"],
        recordings=UNLISTED["recordings"],
    message:
        "Holding what was learned of unlisted laws against the truth."
    script:
        "../scripts/unlisted.py"
