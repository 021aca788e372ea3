# Rigs under laws outside the catalogue, made by code that shares nothing with the tool: what is learned of them?
# A smaller run, or another seed: snakemake -c2 unlisted --config unlisted_recordings=40 unlisted_seed=12345

UNLISTED = config["concealed"]["unlisted"]
for key in ["seed", "recordings"]:
    UNLISTED[key] = int(config.get(f"unlisted_{key}", UNLISTED[key]))


# A case is the same whatever the number of cases: answers of a smaller run are part of a larger one.
UNLISTED_SPANS = [
    (first, min(first + UNLISTED["span"], UNLISTED["recordings"]) - 1)
    for first in range(0, UNLISTED["recordings"], UNLISTED["span"])
]


rule unlisted_answers:
    output:
        f"results/unlisted/{UNLISTED['seed']}/{{first}}_to_{{last}}.parquet",
    log:
        "results/logs/unlisted_answers_{first}_to_{last}.log",
    wildcard_constraints:
        first=r"\d+",
        last=r"\d+",
    params:
        code=script_code(
            "unlisted_answers.py",
            "camid.commands.diagnose",
            "camid.commands.identify",
            "camid.commands.simulate",
        ),
        seed=UNLISTED["seed"],
    message:
        "Diagnosing rigs under unlisted laws, {wildcards.first} to {wildcards.last}."
    script:
        "../scripts/unlisted_answers.py"


rule unlisted:
    input:
        answers=[
            f"results/unlisted/{UNLISTED['seed']}/{first}_to_{last}.parquet"
            for first, last in UNLISTED_SPANS
        ],
        tolerances="config/tolerances.yaml",
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
