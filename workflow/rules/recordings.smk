# Real recordings. Not part of `all`: they carry no licence and need a local copy (CAMID_RECORDINGS) or the network. Only
# results leave results/: the recorded samples are neither committed nor drawn into a table.

from camid.real_recordings.download import BENCHMARK_RECORDINGS, reason_absent

# Recordings that are not diagnosed as they are: their file is measured first.
TRACKED = {"pendulum_clip": "--colour red"}
DIAGNOSED = {
    name: (
        f"results/recordings/{name}.csv"
        if name in TRACKED
        else f"results/recordings/{recording.file}"
    )
    for name, recording in BENCHMARK_RECORDINGS.items()
}
# The longest diagnoses begin first, or one would keep a core busy when all else is done. So do the files they wait for.
DIAGNOSIS_PRIORITY = {"silverbox": 100, "emps": 50}
RECORDING_FIGURES = expand(
    "paper_figs/recording_{name}.{format}",
    name=BENCHMARK_RECORDINGS,
    format=["png", "csv"],
)


NOT_CHECKED = {
    f"recording_{name}": reason
    for name in BENCHMARK_RECORDINGS
    if (reason := reason_absent(name)) is not None
}
CHECKED_RECORDINGS = [
    name for name in BENCHMARK_RECORDINGS if f"recording_{name}" not in NOT_CHECKED
]


wildcard_constraints:
    recording="|".join(BENCHMARK_RECORDINGS),
    hold="zoh|foh",


for name, recording in BENCHMARK_RECORDINGS.items():

    rule:
        name:
            f"recording_file_{name}"
        output:
            f"results/recordings/{recording.file}",
        log:
            f"results/logs/recording_file_{name}.log",
        priority: DIAGNOSIS_PRIORITY.get(name, 0)
        params:
            code=script_code("recording_file.py"),
            name=name,
        message:
            f"Finding the recording {name}."
        script:
            "../scripts/recording_file.py"


rule recording_track:
    input:
        video=f"results/recordings/{BENCHMARK_RECORDINGS['pendulum_clip'].file}",
    output:
        recording=DIAGNOSED["pendulum_clip"],
        preview="results/recordings/pendulum_clip_preview.png",
    log:
        "results/logs/recording_track.log",
    params:
        code=CODE("camid.cli.track"),
        camid=CAMID,
        options=TRACKED["pendulum_clip"],
    message:
        "Measuring the ball's positions in the clip."
    shell:
        "{params.camid} track {input.video:q} {params.options} --output {output.recording:q} --preview {output.preview:q}"
        " > {log:q} 2>&1"


for name in BENCHMARK_RECORDINGS:

    rule:
        name:
            f"recording_diagnosis_{name}"
        input:
            recording=DIAGNOSED[name],
            simulation=f"config/simulations/{name}.yaml",
        output:
            diagnosis=f"results/recordings/{name}/diagnosis.json",
            improved=f"results/recordings/{name}/improved.yaml",
            residuals=f"results/recordings/{name}/residuals.csv",
            report=f"results/recordings/{name}/report.html",
        log:
            f"results/logs/recording_{name}.log",
        priority: DIAGNOSIS_PRIORITY.get(name, 0)
        params:
            code=CODE("camid.cli.diagnose"),
            camid=CAMID,
            folder=f"results/recordings/{name}",
        message:
            f"Diagnosing the recording {name}."
        shell:
            "{params.camid} diagnose {input.recording:q} --simulation {input.simulation:q} --output {params.folder:q}"
            " --time-limit 0 > {log:q} 2>&1"


rule recording_diagnosis_again:
    input:
        recording=lambda wildcards: DIAGNOSED[wildcards.recording],
        improved="results/recordings/{recording}/improved.yaml",
    output:
        diagnosis="results/recordings/{recording}_again/diagnosis.json",
    log:
        "results/logs/recording_{recording}_again.log",
    params:
        code=CODE("camid.cli.diagnose"),
        camid=CAMID,
        folder=lambda wildcards, output: str(Path(output.diagnosis).parent),
    message:
        "Diagnosing the recording {wildcards.recording} again, from the improved simulation."
    shell:
        "{params.camid} diagnose {input.recording:q} --simulation {input.improved:q} --output {params.folder:q} --no-report"
        " --time-limit 0 > {log:q} 2>&1"


rule silverbox_parts:
    input:
        recording=DIAGNOSED["silverbox"],
    output:
        training="results/recordings/silverbox_training.parquet",
        multisine="results/recordings/silverbox_multisine.parquet",
    log:
        "results/logs/silverbox_parts.log",
    params:
        code=script_code("silverbox_parts.py"),
    message:
        "Splitting the Silverbox."
    script:
        "../scripts/silverbox_parts.py"


rule silverbox:
    input:
        training=rules.silverbox_parts.output.training,
        multisine=rules.silverbox_parts.output.multisine,
        simulation="config/simulations/silverbox_{hold}.yaml",
    output:
        model="results/recordings/silverbox_{hold}.yaml",
        simulated="results/recordings/silverbox_{hold}_multisine.csv",
    log:
        "results/logs/silverbox_{hold}.log",
    params:
        code=CODE("camid.cli.identify", "camid.cli.simulate"),
        camid=CAMID,
    message:
        "Identifying the Silverbox with {wildcards.hold} input and simulating the test multisine."
    shell:
        "{params.camid} identify {input.training:q} --simulation {input.simulation:q} --output {output.model:q} > {log:q} 2>&1"
        " && {params.camid} simulate {input.multisine:q} --simulation {output.model:q} --output {output.simulated:q} >> {log:q} 2>&1"


for name in BENCHMARK_RECORDINGS:

    rule:
        name:
            f"recording_{name}"
        input:
            recording=DIAGNOSED[name],
            simulation=f"config/simulations/{name}.yaml",
            diagnosis=f"results/recordings/{name}/diagnosis.json",
            improved=f"results/recordings/{name}/improved.yaml",
            residuals=f"results/recordings/{name}/residuals.csv",
            again=f"results/recordings/{name}_again/diagnosis.json",
            linear=(
                expand(rules.silverbox.output.simulated, hold=["zoh", "foh"])
                if name == "silverbox"
                else []
            ),
            working_copy=BIRTH_MARK,
        output:
            png=f"paper_figs/recording_{name}.png",
            csv=f"paper_figs/recording_{name}.csv",
        log:
            f"results/logs/recording_{name}_figure.log",
        params:
            code=script_code("recording_figure.py"),
            name=name,
        message:
            f"Drawing the results on the recording {name}."
        script:
            "../scripts/recording_figure.py"


rule recordings:
    input:
        figures=RECORDING_FIGURES,
        page="workflow/report/real_recordings.md.jinja",
    output:
        page="docs/real_recordings.md",
        summary="results/recordings/summary.csv",
    log:
        "results/logs/recordings.log",
    params:
        code=script_code("recordings.py"),
        names=list(BENCHMARK_RECORDINGS),
    message:
        "Results on the real recordings beside what was published."
    script:
        "../scripts/recordings.py"


rule recording_starts:
    input:
        recording=lambda wildcards: DIAGNOSED[wildcards.recording],
        simulation="config/simulations/{recording}.yaml",
    output:
        "results/recordings/{recording}_starts.csv",
    log:
        "results/logs/recording_{recording}_starts.log",
    params:
        code=script_code("recording_starts.py"),
        draws=20,
        seed=config["seed"],
    message:
        "Diagnosing the recording {wildcards.recording} from 20 nominal plants that are off by up to a half."
    script:
        "../scripts/recording_starts.py"


rule recording_windows:
    input:
        recording=DIAGNOSED["pendulum2_decay"],
        simulation="config/simulations/pendulum2_decay.yaml",
    output:
        "results/recordings/pendulum2_decay_windows.csv",
    log:
        "results/logs/recording_pendulum2_decay_windows.log",
    params:
        code=script_code("recording_windows.py"),
        # From swings nearly upright to small ones.
        starts=[3.1, 4.5, 6.0, 7.5, 9.0, 12.0, 15.0],
    message:
        "Diagnosing the second pendulum from several rows on."
    script:
        "../scripts/recording_windows.py"


# Most of an hour: not part of `recordings`.
rule recordings_starts:
    input:
        draws=expand("results/recordings/{recording}_starts.csv", recording=DIAGNOSED),
        windows=rules.recording_windows.output[0],
        working_copy=BIRTH_MARK,
    output:
        page="docs/real_recordings_starts.md",
    log:
        "results/logs/recordings_starts.log",
    params:
        code=script_code("recordings_starts.py"),
    message:
        "What the real recordings are said to lack, from other starts."
    script:
        "../scripts/recordings_starts.py"
