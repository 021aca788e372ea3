# PRBS of order 9, camera-sampled outputs of each sweep, noise seeds. Parquet; kept between runs, shareable between clones.


rule excitation:
    input:
        sources=sources("workflow/scripts/excitation.py"),
    output:
        "results/datasets/excitation.parquet",
    log:
        "results/logs/excitation.log",
    cache: True
    params:
        excitation=lookup(within=config, dpath="excitation"),
    message:
        "Generating the pseudo-random binary sequence."
    script:
        "../scripts/excitation.py"


rule sampling_period_outputs:
    input:
        excitation=rules.excitation.output[0],
        sources=sources("workflow/scripts/sampling_period_outputs.py"),
    output:
        "results/datasets/sampling_period.parquet",
    log:
        "results/logs/sampling_period_outputs.log",
    cache: True
    params:
        plant=lookup(within=config, dpath="plant"),
        start=lookup(within=config, dpath="sampling_period_sweep/start"),
        stop=lookup(within=config, dpath="sampling_period_sweep/stop"),
        step=lookup(within=config, dpath="sampling_period_sweep/step"),
    message:
        "Sampling the plant by camera at every period of Fig. 7."
    script:
        "../scripts/sampling_period_outputs.py"


rule noise:
    input:
        excitation=rules.excitation.output[0],
        sources=sources("workflow/scripts/noise.py"),
    output:
        "results/datasets/noise.parquet",
    log:
        "results/logs/noise.log",
    cache: True
    params:
        seed=lookup(within=config, dpath="seed"),
        start=lookup(within=config, dpath="sampling_period_sweep/start"),
        stop=lookup(within=config, dpath="sampling_period_sweep/stop"),
        step=lookup(within=config, dpath="sampling_period_sweep/step"),
        noise_samples=lookup(within=config, dpath="sampling_period_sweep/noise_samples"),
    message:
        "Drawing the noise samples of Fig. 7."
    script:
        "../scripts/noise.py"


rule neglected_mode_outputs:
    input:
        excitation=rules.excitation.output[0],
        sources=sources("workflow/scripts/neglected_mode_outputs.py"),
    output:
        "results/datasets/neglected_mode.parquet",
    log:
        "results/logs/neglected_mode_outputs.log",
    cache: True
    params:
        plant=lookup(within=config, dpath="plant"),
        period=lookup(within=config, dpath="neglected_mode_sweep/period"),
        damping=lookup(within=config, dpath="neglected_mode_sweep/damping"),
        start=lookup(within=config, dpath="neglected_mode_sweep/start"),
        stop=lookup(within=config, dpath="neglected_mode_sweep/stop"),
        points=lookup(within=config, dpath="neglected_mode_sweep/points"),
    message:
        "Sampling the plant with two modes at every ω1 of Fig. 8."
    script:
        "../scripts/neglected_mode_outputs.py"
