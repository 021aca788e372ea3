# What the figures say in numbers, the paper's claims, and the comparison with the stored tolerances.


rule claims:
    input:
        excitation=rules.excitation.output[0],
        marker_trajectory=rules.marker_trajectory.output[0],
        assumptions=rules.assumptions.output[0],
        camera_models=rules.camera_models.output[0],
        discrete_time=rules.discrete_time.output[0],
        sampling_period=rules.sampling_period.output[0],
        neglected_mode=rules.neglected_mode.output[0],
        fig1=rules.fig1.output.csv,
        fig2=rules.fig2.output.csv,
        working_copy=BIRTH_MARK,
    output:
        csv=report(
            "paper_figs/claims.csv",
            caption="../report/claims.rst",
            category="Claims",
            labels={"figure": "claims", "of": "the paper"},
        ),
        markdown="paper_figs/claims.md",
        quantities="results/quantities.csv",
    log:
        "results/logs/claims.log",
    params:
        plant=config["plant"],
        code=script_code("claims.py"),
    message:
        "Judging the paper's claims."
    script:
        "../scripts/claims.py"


rule paper:
    input:
        expand(
            "paper_figs/{figure}.{format}",
            figure=FIGURES,
            format=["png", "pdf", "csv"],
        ),
        rules.claims.output,
    localrule: True
    message:
        "The figures of the paper and its claims are up to date."


# The paper alone, in a minute: what a change of the datasets or of the estimator would break first.
rule check_paper:
    input:
        rules.paper.input,
        quantities=[rules.claims.output.quantities],
        tolerances=["config/tolerances.yaml"],
        schema="workflow/schemas/tolerances.schema.yaml",
    output:
        "results/check_paper.csv",
    log:
        "results/logs/check_paper.log",
    params:
        code=script_code("check.py"),
        not_checked={
            "concealed_sample": "not of the paper",
            "unlisted": "not of the paper",
            "designed_experiment": "not of the paper",
            **{
                f"recording_{name}": "not of the paper"
                for name in BENCHMARK_RECORDINGS
            },
        },
    message:
        "Comparing the paper's results with the stored tolerances."
    script:
        "../scripts/check.py"


rule check:
    input:
        rules.paper.input,
        rules.ablations.output,
        rules.concealed_sample.output,
        quantities=[
            rules.claims.output.quantities,
            *expand("results/ablations/{name}.csv", name=ABLATIONS),
            rules.concealed_sample.output.quantities,
            *expand("paper_figs/recording_{name}.csv", name=CHECKED_RECORDINGS),
        ],
        tolerances=[
            "config/tolerances.yaml",
            *expand(f"{ABLATION_FOLDER}/{{name}}/tolerances.yaml", name=ABLATIONS),
        ],
        schema="workflow/schemas/tolerances.schema.yaml",
    output:
        "results/check.csv",
    log:
        "results/logs/check.log",
    params:
        code=script_code("check.py"),
        # The recordings are not part of the project; what cannot be guarded here is said.
        not_checked={
            "unlisted": "snakemake -c2 unlisted",
            "designed_experiment": "snakemake -c2 designed_experiment",
            **NOT_CHECKED,
        },
    message:
        "Comparing the results with the stored tolerances."
    script:
        "../scripts/check.py"
