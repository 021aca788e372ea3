# The second proof: recordings by an author who has read the documentation alone.

SECOND = config["concealed"]["second_author"]
SECOND_TABLES = ["scores", "parameters", "weights"]


rule second_author_scores:
    output:
        **{
            table: f"results/second_author/{SECOND['seed']}/{CONCEALED_SHARD}/{table}.parquet"
            for table in SECOND_TABLES
        },
    log:
        "results/logs/second_author_scores_{shard}_of_{shards}.log",
    params:
        code=script_code("second_author_scores.py", "camid.cli.diagnose"),
        seed=SECOND["seed"],
        number=SECOND["recordings"],
    message:
        "Diagnosing and scoring recordings of the second author, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/second_author_scores.py"


rule second_author:
    input:
        **{
            table: expand(
                f"results/second_author/{SECOND['seed']}/{CONCEALED_SHARD}/{table}.parquet",
                shard=range(SECOND["shards"]),
                shards=SECOND["shards"],
            )
            for table in SECOND_TABLES
        },
        working_copy=BIRTH_MARK,
    output:
        markdown="paper_figs/second_author.md",
        quantities="paper_figs/second_author.csv",
    log:
        "results/logs/second_author.log",
    params:
        code=script_code("second_author.py"),
        seed=SECOND["seed"],
        number=SECOND["recordings"],
    message:
        "Holding what the second proof measured against the targets of the first."
    script:
        "../scripts/second_author.py"
