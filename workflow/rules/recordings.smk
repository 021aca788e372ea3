# Real recordings. Not part of `all`: they carry no licence and need a local copy (CAMID_RECORDINGS) or the network.


rule silverbox_parts:
    input:
        sources=sources("workflow/scripts/silverbox_parts.py"),
    output:
        training="results/recordings/silverbox_training.parquet",
        multisine="results/recordings/silverbox_multisine.parquet",
    log:
        "results/logs/silverbox_parts.log",
    message:
        "Finding the Silverbox recording and splitting it."
    script:
        "../scripts/silverbox_parts.py"


rule silverbox:
    input:
        training=rules.silverbox_parts.output.training,
        multisine=rules.silverbox_parts.output.multisine,
        simulation="config/simulations/silverbox_{hold}.yaml",
        sources=sources("src/camid/cli/__init__.py", "src/camid/api.py"),
    output:
        model="results/recordings/silverbox_{hold}.yaml",
        simulated="results/recordings/silverbox_{hold}_multisine.csv",
    log:
        "results/logs/silverbox_{hold}.log",
    params:
        camid=CAMID,
    message:
        "Identifying the Silverbox with {wildcards.hold} input and simulating the test multisine."
    shell:
        "{params.camid} identify {input.training} --simulation {input.simulation} --output {output.model} > {log} 2>&1"
        " && {params.camid} simulate {input.multisine} --simulation {output.model} --output {output.simulated} >> {log} 2>&1"


rule recordings:
    input:
        simulated=expand(
            "results/recordings/silverbox_{hold}_multisine.csv", hold=["zoh", "foh"]
        ),
        sources=sources("workflow/scripts/recordings.py"),
    output:
        "results/recordings/summary.csv",
    log:
        "results/logs/recordings.log",
    message:
        "Root mean square errors on the real recordings beside their references."
    script:
        "../scripts/recordings.py"
