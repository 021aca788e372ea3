# Real recordings. Not part of `all`: they carry no licence and need a local copy (CAMID_RECORDINGS) or the network.


rule silverbox_parts:
    input:
        sources=sources("workflow/scripts/silverbox_parts.py"),
    output:
        training="results/recordings/silverbox_training.parquet",
        multisine="results/recordings/silverbox_multisine.parquet",
    message:
        "Finding the Silverbox recording and splitting it."
    script:
        "../scripts/silverbox_parts.py"


rule silverbox:
    input:
        training=rules.silverbox_parts.output.training,
        multisine=rules.silverbox_parts.output.multisine,
        simulation="config/simulations/silverbox_{hold}.yaml",
        sources=sources("src/camid/cli.py", "src/camid/api.py"),
    output:
        model="results/recordings/silverbox_{hold}.yaml",
        simulated="results/recordings/silverbox_{hold}_multisine.csv",
    message:
        "Identifying the Silverbox with {wildcards.hold} input and simulating the test multisine."
    shell:
        "{CAMID} identify {input.training} --simulation {input.simulation} --output {output.model}"
        " && {CAMID} simulate {input.multisine} --simulation {output.model} --output {output.simulated}"


rule recordings:
    input:
        simulated=expand(
            "results/recordings/silverbox_{hold}_multisine.csv", hold=["zoh", "foh"]
        ),
        sources=sources("workflow/scripts/recordings.py"),
    output:
        "results/recordings/summary.csv",
    message:
        "Root mean square errors on the real recordings beside their references."
    script:
        "../scripts/recordings.py"
