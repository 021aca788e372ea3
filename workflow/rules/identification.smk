# Identification runs and the frequency responses for the figures.


rule camera_models:
    output:
        "results/estimates/camera_models.parquet",
    log:
        "results/logs/camera_models.log",
    params:
        **calls("compute.py", "paper.fig6_camera_models.runs.camera_model_responses"),
        configuration=config["camera_models"],
    message:
        "Computing the frequency responses of the three camera models."
    script:
        "../scripts/compute.py"


rule discrete_time:
    input:
        excitation=rules.excitation.output[0],
    output:
        "results/estimates/discrete_time.parquet",
    log:
        "results/logs/discrete_time.log",
    params:
        **calls("compute.py", "paper.discrete_time.compare_discrete_time"),
        plant=config["plant"],
        periods=config["discrete_time"]["periods"],
    message:
        "Comparing the closed form (16)-(23) with exact and identified discrete-time models."
    script:
        "../scripts/compute.py"


rule sampling_period:
    input:
        outputs=rules.sampling_period_outputs.output[0],
        noise=rules.noise.output[0],
    output:
        "results/estimates/sampling_period.parquet",
    log:
        "results/logs/sampling_period.log",
    cache: True
    params:
        **calls(
            "compute.py", "paper.fig7_sampling_period.runs.identify_sampling_period"
        ),
        plant=config["plant"],
        sweep=config["sampling_period_sweep"],
        cases=config["sampling_period_sweep"]["cases"],
    message:
        "Identifying at every sampling period of Fig. 7."
    script:
        "../scripts/compute.py"


rule neglected_mode:
    input:
        outputs=rules.neglected_mode_outputs.output[0],
    output:
        "results/estimates/neglected_mode.parquet",
    log:
        "results/logs/neglected_mode.log",
    cache: True
    params:
        **calls("compute.py", "paper.fig8_neglected_mode.runs.identify_neglected_mode"),
        plant=config["plant"],
        sweep=config["neglected_mode_sweep"],
        cases=config["neglected_mode_sweep"]["cases"],
    message:
        "Identifying with a neglected mode at every ω1 of Fig. 8."
    script:
        "../scripts/compute.py"
