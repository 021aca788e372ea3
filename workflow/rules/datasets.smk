# PRBS of order 9, camera-sampled outputs of each sweep, noise seeds. Parquet; kept between runs, shareable between clones.


rule excitation:
    output:
        "results/datasets/excitation.parquet",
    log:
        "results/logs/excitation.log",
    cache: True
    params:
        **calls("compute.py", "paper.excitation.excitation_table"),
        order=config["excitation"]["order"],
        amplitude=config["excitation"]["amplitude"],
    message:
        "Generating the pseudo-random binary sequence."
    script:
        "../scripts/compute.py"


rule sampling_period_outputs:
    input:
        excitation=rules.excitation.output[0],
    output:
        "results/datasets/sampling_period.parquet",
    log:
        "results/logs/sampling_period_outputs.log",
    cache: True
    params:
        **calls("compute.py", "paper.datasets.sampling_period_outputs"),
        plant=config["plant"],
        sweep=selected("sampling_period_sweep", "start", "stop", "step"),
    message:
        "Sampling the plant by camera at every period of Fig. 7."
    script:
        "../scripts/compute.py"


rule noise:
    input:
        excitation=rules.excitation.output[0],
    output:
        "results/datasets/noise.parquet",
    log:
        "results/logs/noise.log",
    cache: True
    params:
        **calls("compute.py", "paper.datasets.noise_samples"),
        seed=config["seed"],
        sweep=selected(
            "sampling_period_sweep", "start", "stop", "step", "noise_samples"
        ),
    message:
        "Drawing the noise samples of Fig. 7."
    script:
        "../scripts/compute.py"


rule neglected_mode_outputs:
    input:
        excitation=rules.excitation.output[0],
    output:
        "results/datasets/neglected_mode.parquet",
    log:
        "results/logs/neglected_mode_outputs.log",
    cache: True
    params:
        **calls("compute.py", "paper.datasets.neglected_mode_outputs"),
        plant=config["plant"],
        sweep=selected(
            "neglected_mode_sweep", "period", "damping", "start", "stop", "points"
        ),
    message:
        "Sampling the plant with two modes at every ω1 of Fig. 8."
    script:
        "../scripts/compute.py"
