# What the figures say in numbers, the paper's claims, and the comparison with the stored tolerances.


rule quantities:
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
        sources=sources("workflow/scripts/quantities.py"),
    output:
        "results/quantities.csv",
    log:
        "results/logs/quantities.log",
    params:
        plant=lookup(within=config, dpath="plant"),
    message:
        "Collecting the numbers that claims quote and tolerances guard."
    script:
        "../scripts/quantities.py"


rule claims:
    input:
        quantities=rules.quantities.output[0],
        working_copy=BIRTH_MARK,
        sources=sources("workflow/scripts/claims.py"),
    output:
        csv=report(
            "paper_figs/claims.csv",
            caption="../report/claims.rst",
            category="Claims",
            labels={"figure": "claims", "of": "the paper"},
        ),
        markdown="paper_figs/claims.md",
    log:
        "results/logs/claims.log",
    message:
        "Judging the paper's claims."
    script:
        "../scripts/claims.py"


# The paper alone, in a minute: what a change of the datasets or of the estimator would break first.
rule check_paper:
    input:
        expand(
            "paper_figs/{figure}.{format}",
            figure=FIGURES,
            format=["png", "pdf", "csv"],
        ),
        rules.claims.output,
        quantities=[rules.quantities.output[0]],
        tolerances=["config/tolerances.yaml"],
        schema="workflow/schemas/tolerances.schema.yaml",
        sources=sources("workflow/scripts/check.py"),
    output:
        "results/check_paper.csv",
    log:
        "results/logs/check_paper.log",
    params:
        not_checked={
            "concealed_sample": "not of the paper",
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
        expand(
            "paper_figs/{figure}.{format}",
            figure=FIGURES,
            format=["png", "pdf", "csv"],
        ),
        rules.claims.output,
        rules.ablations.output,
        rules.concealed_sample.output,
        quantities=[
            rules.quantities.output[0],
            *expand("results/ablations/{name}.csv", name=ABLATIONS),
            rules.concealed_sample.output.quantities,
            *expand("paper_figs/recording_{name}.csv", name=CHECKED_RECORDINGS),
        ],
        tolerances=[
            "config/tolerances.yaml",
            *expand(f"{ABLATION_FOLDER}/{{name}}/tolerances.yaml", name=ABLATIONS),
        ],
        schema="workflow/schemas/tolerances.schema.yaml",
        sources=sources("workflow/scripts/check.py"),
    output:
        "results/check.csv",
    log:
        "results/logs/check.log",
    params:
        # The recordings are not part of the project; what cannot be guarded here is said.
        not_checked=NOT_CHECKED,
    message:
        "Comparing the results with the stored tolerances."
    script:
        "../scripts/check.py"
