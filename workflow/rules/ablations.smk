# What lies past the paper: one question a target (ablation_exposure, …), all of them `ablations`.

# Name of the module in camid.experiments.ablations and of its section in config/ablations.yaml → title of the figure,
# and the sections of config/config.yaml that it uses besides.
ABLATIONS = {
    "monte_carlo": (
        "Errors over the Cramér–Rao bound, many noise seeds a period",
        ["plant", "excitation", "sampling_period_sweep", "seed"],
    ),
    "past_shannon": (
        "Identification past the Shannon limit",
        ["plant", "excitation", "seed"],
    ),
    "marker_size": (
        "Assumption A1: shift of the centre of mass by a large marker",
        ["imaging"],
    ),
    "exposure": (
        "Bias against the exposure under five declarations of the sensor",
        ["plant", "excitation"],
    ),
    "crossing_path": (
        "Assumption A2: a path that crosses or covers itself in an exposure",
        ["imaging"],
    ),
    "acceleration": (
        "Assumption A4: a speed that changes within the exposure",
        ["imaging"],
    ),
    "latency": (
        "Bias against a latency that is not declared",
        ["plant", "excitation"],
    ),
    "centroids": (
        "Grey-level against gradient centroid, from ideal to bad images",
        ["imaging", "seed"],
    ),
    "signal_to_noise": (
        "Errors against the signal-to-noise ratio",
        ["plant", "excitation", "seed"],
    ),
    "image_quality": (
        "Assumption A3: coarse pixels, few bits and noise",
        ["imaging", "seed"],
    ),
    "pairing": (
        "Bias under wrong pairings of input and output samples",
        ["plant", "excitation"],
    ),
    "excitation_length": (
        "Errors against the length of the excitation",
        ["plant", "excitation", "seed"],
    ),
    "rolling_shutter": (
        "Rolling shutter: the marker's row decides the time",
        ["plant", "excitation", "imaging"],
    ),
    "two_amplitudes": (
        "Price and gain of a second amplitude in the excitation",
        ["plant", "seed"],
    ),
    "methods": (
        "Error over the Cramér–Rao bound and failures of every method",
        ["plant", "excitation", "seed"],
    ),
    "model_order": (
        "Choice and consequences of the number of poles",
        ["plant", "excitation", "seed"],
    ),
    "wrong_hold": (
        "Bias under a wrong hold or sensor, and the warning of it",
        ["plant", "excitation", "seed"],
    ),
}


# Those whose runs are shared out among jobs of their own (monte_carlo.smk).
SHARDED = {"monte_carlo"}


for name, (title, shared) in ABLATIONS.items():
    if name in SHARDED:
        continue

    rule:
        name:
            f"{name}_runs"
        input:
            sources=sources(
                "workflow/scripts/ablation_runs.py",
                f"src/camid/experiments/ablations/{name}.py",
            ),
        output:
            f"results/ablations/{name}.parquet",
        log:
            f"results/logs/{name}_runs.log",
        cache: True
        params:
            ablation=name,
            settings=config["ablations"][name],
            shared={section: config[section] for section in shared},
        message:
            f"Computing: {title}."
        script:
            "../scripts/ablation_runs.py"


for name, (title, _) in ABLATIONS.items():

    rule:
        name:
            f"ablation_{name}"
        input:
            runs=f"results/ablations/{name}.parquet",
            working_copy=BIRTH_MARK,
            sources=sources(
                "workflow/scripts/ablation_figure.py",
                f"src/camid/experiments/ablations/{name}.py",
                f"src/camid/figures/ablations/{name}.py",
            ),
        output:
            png=report(
                f"paper_figs/ablation_{name}.png",
                caption="../report/ablation.rst",
                category="Ablations",
                labels={"figure": name.replace("_", " "), "of": "past the paper"},
            ),
            pdf=f"paper_figs/ablation_{name}.pdf",
            csv=f"paper_figs/ablation_{name}.csv",
            quantities=f"results/ablations/{name}.csv",
            conclusion=f"results/ablations/{name}.txt",
        log:
            f"results/logs/ablation_{name}.log",
        params:
            ablation=name,
            title=title,
        message:
            f"Drawing: {title}."
        script:
            "../scripts/ablation_figure.py"


rule ablations:
    input:
        figures=expand(
            "paper_figs/ablation_{name}.{format}",
            name=ABLATIONS,
            format=["png", "pdf", "csv"],
        ),
        conclusions=expand("results/ablations/{name}.txt", name=ABLATIONS),
        working_copy=BIRTH_MARK,
        sources=sources("workflow/scripts/ablations.py"),
    output:
        csv="paper_figs/ablations.csv",
        markdown="paper_figs/ablations.md",
    log:
        "results/logs/ablations.log",
    params:
        names=list(ABLATIONS),
    message:
        "Collecting the conclusions of all ablations."
    script:
        "../scripts/ablations.py"
