# The sealed proof: recordings with a concealed effect are made and sealed, diagnosed blindly, then revealed and scored.
# The set `sample` is part of `check`; the target `concealed` takes the set `full`.

CONCEALED = {name: config["concealed"][name] for name in ["full", "sample"]}
if "concealed_seed" in config:
    CONCEALED["full"]["seed"] = int(config["concealed_seed"])
# The seed is part of every path, so that nothing of another seed is ever taken for this one's.
CONCEALED_FOLDER = "results/concealed/{set}/{seed}"
CONCEALED_SHARD = "{shard}_of_{shards}"
# The longest chain of jobs begins first, or it would keep one core busy when all else is done.
CONCEALED_PRIORITY = 1
# Figure → the table that it shows, and its title.
CONCEALED_FIGURES = {
    "confusion_matrix": ("scores", "What was concealed and what was named"),
    "strength": ("scores", "Detection, naming and placing against strength"),
    "recovered_share": (
        "scores",
        "Share of the error recovered on held-out recordings",
    ),
    "weights": ("weights", "Stated weights against the frequency of being right"),
    "run_time": ("run_times", "Run time of a diagnosis"),
}


# Wildcards of all shards of a set, and what its last step writes.
CONCEALED_SHARDS = {
    name: {
        "set": name,
        "seed": chosen["seed"],
        "shard": range(chosen["shards"]),
        "shards": chosen["shards"],
    }
    for name, chosen in CONCEALED.items()
}
CONCEALED_SCORES = {
    name: {
        table: f"results/concealed/{name}/{chosen['seed']}/{table}.parquet"
        for table in ["scores", "parameters", "weights", "run_times"]
    }
    for name, chosen in CONCEALED.items()
}


wildcard_constraints:
    set="full|sample",
    seed=r"\d+",
    shard=r"\d+",
    shards=r"\d+",


rule concealed_salt:
    output:
        f"{CONCEALED_FOLDER}/salt",
    log:
        "results/logs/concealed_salt_{set}_{seed}.log",
    priority: CONCEALED_PRIORITY
    message:
        "Drawing the salt of the seals."
    script:
        "../scripts/concealed_salt.py"


rule concealed_recordings:
    input:
        salt=rules.concealed_salt.output[0],
    output:
        recordings=directory(f"{CONCEALED_FOLDER}/recordings/{CONCEALED_SHARD}"),
        held_out=directory(f"{CONCEALED_FOLDER}/held_out/{CONCEALED_SHARD}"),
        truths=directory(f"{CONCEALED_FOLDER}/truths/{CONCEALED_SHARD}"),
        seals=f"{CONCEALED_FOLDER}/seals/{CONCEALED_SHARD}.csv",
    log:
        "results/logs/concealed_recordings_{set}_{seed}_{shard}_of_{shards}.log",
    priority: CONCEALED_PRIORITY
    params:
        code=script_code("concealed_recordings.py"),
        number=lambda wildcards: CONCEALED[wildcards.set]["recordings"],
    message:
        "Making and sealing concealed recordings, shard {wildcards.shard} of {wildcards.shards} ({wildcards.set})."
    script:
        "../scripts/concealed_recordings.py"


# No truth and no held-out recording is an input here.
rule concealed_diagnoses:
    input:
        recordings=rules.concealed_recordings.output.recordings,
        seals=rules.concealed_recordings.output.seals,
    output:
        diagnoses=directory(f"{CONCEALED_FOLDER}/diagnoses/{CONCEALED_SHARD}"),
        run_times=f"{CONCEALED_FOLDER}/run_times/{CONCEALED_SHARD}.csv",
    log:
        "results/logs/concealed_diagnoses_{set}_{seed}_{shard}_of_{shards}.log",
    priority: CONCEALED_PRIORITY
    params:
        code=script_code("concealed_diagnoses.py", "camid.cli.diagnose"),
    message:
        "Diagnosing blindly, shard {wildcards.shard} of {wildcards.shards} ({wildcards.set})."
    script:
        "../scripts/concealed_diagnoses.py"


# The shards of the diagnoses share the cores; what took long beside another is timed again with all of them.
rule concealed_slowest:
    input:
        recordings=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/recordings/{CONCEALED_SHARD}",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        diagnoses=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/diagnoses/{CONCEALED_SHARD}",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        run_times=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/run_times/{CONCEALED_SHARD}.csv",
            **CONCEALED_SHARDS[wildcards.set],
        ),
    output:
        f"{CONCEALED_FOLDER}/slowest.csv",
    log:
        "results/logs/concealed_slowest_{set}_{seed}.log",
    threads: 2
    params:
        code=script_code("concealed_slowest.py"),
        asked=lambda wildcards: CONCEALED[wildcards.set].get("times", True),
    message:
        "Timing the slowest diagnoses again, one at a time ({wildcards.set})."
    script:
        "../scripts/concealed_slowest.py"


# No truth is opened before the last diagnosis of the set is made.
rule concealed_reveal:
    input:
        all_diagnoses=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/diagnoses/{CONCEALED_SHARD}",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        salt=rules.concealed_salt.output[0],
        recordings=rules.concealed_recordings.output.recordings,
        held_out=rules.concealed_recordings.output.held_out,
        truths=rules.concealed_recordings.output.truths,
        seals=rules.concealed_recordings.output.seals,
        diagnoses=rules.concealed_diagnoses.output.diagnoses,
    output:
        scores=f"{CONCEALED_FOLDER}/revealed/{CONCEALED_SHARD}/scores.parquet",
        parameters=f"{CONCEALED_FOLDER}/revealed/{CONCEALED_SHARD}/parameters.parquet",
        weights=f"{CONCEALED_FOLDER}/revealed/{CONCEALED_SHARD}/weights.parquet",
    log:
        "results/logs/concealed_reveal_{set}_{seed}_{shard}_of_{shards}.log",
    params:
        code=script_code("concealed_reveal.py"),
    message:
        "Opening the seals and scoring, shard {wildcards.shard} of {wildcards.shards} ({wildcards.set})."
    script:
        "../scripts/concealed_reveal.py"


rule concealed_scores:
    input:
        scores=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/revealed/{CONCEALED_SHARD}/scores.parquet",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        parameters=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/revealed/{CONCEALED_SHARD}/parameters.parquet",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        weights=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/revealed/{CONCEALED_SHARD}/weights.parquet",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        run_times=lambda wildcards: expand(
            f"{CONCEALED_FOLDER}/run_times/{CONCEALED_SHARD}.csv",
            **CONCEALED_SHARDS[wildcards.set],
        ),
        slowest=rules.concealed_slowest.output[0],
    output:
        scores=f"{CONCEALED_FOLDER}/scores.parquet",
        parameters=f"{CONCEALED_FOLDER}/parameters.parquet",
        weights=f"{CONCEALED_FOLDER}/weights.parquet",
        run_times=f"{CONCEALED_FOLDER}/run_times.parquet",
    log:
        "results/logs/concealed_scores_{set}_{seed}.log",
    params:
        code=script_code("concealed_scores.py"),
        number=lambda wildcards: CONCEALED[wildcards.set]["recordings"],
    message:
        "Collecting the scores of all shards ({wildcards.set})."
    script:
        "../scripts/concealed_scores.py"


for name, (table, title) in CONCEALED_FIGURES.items():

    rule:
        name:
            f"concealed_{name}"
        input:
            **{table: CONCEALED_SCORES["full"][table]},
            working_copy=BIRTH_MARK,
        output:
            png=f"paper_figs/concealed_{name}.png",
            csv=f"paper_figs/concealed_{name}.csv",
        log:
            f"results/logs/concealed_{name}.log",
        params:
            **calls("draw.py", f"proof.figures.{name}.draw"),
        message:
            f"Drawing: {title}."
        script:
            "../scripts/draw.py"


rule concealed:
    input:
        **CONCEALED_SCORES["full"],
        figures=expand(
            "paper_figs/concealed_{name}.{format}",
            name=CONCEALED_FIGURES,
            format=["png", "csv"],
        ),
        seals=expand(
            f"{CONCEALED_FOLDER}/seals/{CONCEALED_SHARD}.csv",
            **CONCEALED_SHARDS["full"],
        ),
        salt=expand(f"{CONCEALED_FOLDER}/salt", **CONCEALED_SHARDS["full"])[0],
        working_copy=BIRTH_MARK,
    output:
        seals="paper_figs/concealed_seals.csv",
        markdown="paper_figs/concealed.md",
        quantities="paper_figs/concealed_quantities.csv",
        parameters="paper_figs/concealed_parameters.csv",
    log:
        "results/logs/concealed.log",
    params:
        code=script_code("concealed.py"),
        seed=CONCEALED["full"]["seed"],
        configured="concealed_seed" not in config,
        number=CONCEALED["full"]["recordings"],
    message:
        "Holding what the sealed proof measured against its targets."
    script:
        "../scripts/concealed.py"


rule concealed_sample:
    input:
        **CONCEALED_SCORES["sample"],
        working_copy=BIRTH_MARK,
    output:
        png=report(
            "paper_figs/concealed_sample.png",
            caption="../report/concealed.rst",
            category="Diagnosis",
            labels={"figure": "concealed sample", "of": "past the paper"},
        ),
        csv="paper_figs/concealed_sample.csv",
        quantities="results/concealed/quantities.csv",
    log:
        "results/logs/concealed_sample.log",
    params:
        code=script_code("concealed_sample.py", "camid.proof.figures.sample"),
    message:
        "Drawing: a small sample of the sealed proof."
    script:
        "../scripts/concealed_sample.py"
