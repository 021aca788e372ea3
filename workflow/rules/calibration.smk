# The constants of the diagnosis's weights: estimated from recordings of rigs with concealed effects, of a seed that nothing
# else uses. Copy the result to src/camid/diagnosis/weights.json to let the diagnosis use it.

CALIBRATION = config["concealed"]["calibration"]


rule calibration_comparisons:
    output:
        f"results/calibration/{CALIBRATION['seed']}/{{recordings}}/{CONCEALED_SHARD}.json",
    log:
        "results/logs/calibration_comparisons_{recordings}_{shard}_of_{shards}.log",
    wildcard_constraints:
        recordings="one|two",
    params:
        code=script_code("calibration_comparisons.py", "camid.commands.diagnose"),
        seed=CALIBRATION["seed"],
        number=CALIBRATION["recordings"],
        second=CALIBRATION["second_recordings"],
    message:
        "Diagnosing {wildcards.recordings} recordings of rigs to calibrate weights, {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/calibration_comparisons.py"


rule calibration:
    input:
        **{
            recordings: expand(
                rules.calibration_comparisons.output,
                recordings=recordings,
                shard=range(CALIBRATION["shards"]),
                shards=CALIBRATION["shards"],
            )
            for recordings in ["one", "two"]
        },
    output:
        constants="results/calibration/weights.json",
        reliability="results/calibration/reliability.csv",
        outside="results/calibration/outside.csv",
    log:
        "results/logs/calibration.log",
    params:
        code=script_code("calibration.py"),
        seed=CALIBRATION["seed"],
        number=CALIBRATION["recordings"],
    message:
        "Calibrating the weights of the diagnosis."
    script:
        "../scripts/calibration.py"
