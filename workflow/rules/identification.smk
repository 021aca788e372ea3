# Identification runs and the frequency responses behind the figures.


rule camera_models:
    input:
        sources=sources("workflow/scripts/camera_models.py"),
    output:
        "results/estimates/camera_models.parquet",
    log:
        "results/logs/camera_models.log",
    params:
        camera_models=lookup(within=config, dpath="camera_models"),
    message:
        "Computing the frequency responses of the three camera models."
    script:
        "../scripts/camera_models.py"


rule discrete_time:
    input:
        excitation=rules.excitation.output[0],
        sources=sources("workflow/scripts/discrete_time.py"),
    output:
        "results/estimates/discrete_time.parquet",
    log:
        "results/logs/discrete_time.log",
    params:
        plant=lookup(within=config, dpath="plant"),
        periods=lookup(within=config, dpath="discrete_time/periods"),
    message:
        "Comparing the closed form (16)-(23) with exact and identified discrete-time models."
    script:
        "../scripts/discrete_time.py"


rule sampling_period:
    input:
        outputs=rules.sampling_period_outputs.output[0],
        noise=rules.noise.output[0],
        sources=sources("workflow/scripts/sampling_period.py"),
    output:
        "results/estimates/sampling_period.parquet",
    log:
        "results/logs/sampling_period.log",
    cache: True
    params:
        plant=lookup(within=config, dpath="plant"),
        sweep=lookup(within=config, dpath="sampling_period_sweep"),
    message:
        "Identifying at every sampling period of Fig. 7."
    script:
        "../scripts/sampling_period.py"


rule neglected_mode:
    input:
        outputs=rules.neglected_mode_outputs.output[0],
        sources=sources("workflow/scripts/neglected_mode.py"),
    output:
        "results/estimates/neglected_mode.parquet",
    log:
        "results/logs/neglected_mode.log",
    cache: True
    params:
        plant=lookup(within=config, dpath="plant"),
        sweep=lookup(within=config, dpath="neglected_mode_sweep"),
    message:
        "Identifying with a neglected mode at every ω1 of Fig. 8."
    script:
        "../scripts/neglected_mode.py"
