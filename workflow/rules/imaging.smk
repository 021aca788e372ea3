# Image formation by exposure and the measurement of the marker (section 2 of the paper).


rule marker_image:
    output:
        "results/datasets/marker_image.npz",
    log:
        "results/logs/marker_image.log",
    cache: True
    params:
        **calls("compute.py", "paper.fig1_marker_image.runs.fast_marker_image"),
        imaging=config["imaging"],
    message:
        "Exposing the image of the fast marker."
    script:
        "../scripts/compute.py"


rule marker_trajectory:
    output:
        "results/datasets/marker_trajectory.parquet",
    log:
        "results/logs/marker_trajectory.log",
    cache: True
    params:
        **calls(
            "compute.py", "paper.fig3_marker_trajectory.runs.slow_marker_trajectory"
        ),
        imaging=config["imaging"],
    message:
        "Measuring the slow marker in rendered images."
    script:
        "../scripts/compute.py"


rule assumptions:
    output:
        "results/estimates/assumptions.parquet",
    log:
        "results/logs/assumptions.log",
    params:
        **calls("compute.py", "paper.assumptions.assumption_failures"),
        imaging=config["imaging"],
    message:
        "Measuring what happens when the assumptions A1, A2 and A4 fail."
    script:
        "../scripts/compute.py"
