# Further proofs: recordings by authors who have read the documentation alone.

AUTHORS = ["second_author", "undeclared_loops"]
AUTHOR_TABLES = ["scores", "parameters", "weights"]


rule author_scores:
    output:
        **{
            table: f"results/{{author}}/{{seed}}/{CONCEALED_SHARD}/{table}.parquet"
            for table in AUTHOR_TABLES
        },
    log:
        "results/logs/{author}_scores_{seed}_{shard}_of_{shards}.log",
    wildcard_constraints:
        author="|".join(AUTHORS),
    params:
        code=script_code("other_author_scores.py", "camid.cli.diagnose"),
        number=lambda wildcards: config["concealed"][wildcards.author]["recordings"],
    message:
        "Diagnosing and scoring recordings of {wildcards.author}, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/other_author_scores.py"


for author in AUTHORS:

    rule:
        name:
            author
        input:
            **{
                table: expand(
                    f"results/{author}/{config['concealed'][author]['seed']}/{CONCEALED_SHARD}/{table}.parquet",
                    shard=range(config["concealed"][author]["shards"]),
                    shards=config["concealed"][author]["shards"],
                )
                for table in AUTHOR_TABLES
            },
            working_copy=BIRTH_MARK,
        output:
            markdown=f"paper_figs/{author}.md",
            quantities=f"paper_figs/{author}.csv",
        log:
            f"results/logs/{author}.log",
        params:
            code=script_code("other_author.py"),
            author=author,
            seed=config["concealed"][author]["seed"],
            number=config["concealed"][author]["recordings"],
        message:
            f"Holding what the recordings of {author} show against the targets of the first proof."
        script:
            "../scripts/other_author.py"
