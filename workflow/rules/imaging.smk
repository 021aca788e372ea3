# Image formation by exposure and the measurement of the marker (section 2 of the paper).


rule marker_image:
    input:
        sources=sources("workflow/scripts/marker_image.py"),
    output:
        "results/datasets/marker_image.npz",
    log:
        "results/logs/marker_image.log",
    cache: True
    params:
        imaging=lookup(within=config, dpath="imaging"),
    message:
        "Exposing the image of the fast marker."
    script:
        "../scripts/marker_image.py"


rule marker_trajectory:
    input:
        sources=sources("workflow/scripts/marker_trajectory.py"),
    output:
        "results/datasets/marker_trajectory.parquet",
    log:
        "results/logs/marker_trajectory.log",
    cache: True
    params:
        imaging=lookup(within=config, dpath="imaging"),
    message:
        "Measuring the slow marker in rendered images."
    script:
        "../scripts/marker_trajectory.py"


rule assumptions:
    input:
        sources=sources("workflow/scripts/assumptions.py"),
    output:
        "results/estimates/assumptions.parquet",
    log:
        "results/logs/assumptions.log",
    params:
        imaging=lookup(within=config, dpath="imaging"),
    message:
        "Measuring what happens when the assumptions A1, A2 and A4 fail."
    script:
        "../scripts/assumptions.py"
