# The constants of the diagnosis's weights: estimated from recordings of rigs with concealed effects, of a seed that nothing
# else uses. Copy the result to src/camid/diagnosis/weights.json to let the diagnosis use it.

CALIBRATION = config["concealed"]["calibration"]


rule calibration_comparisons:
    output:
        f"results/calibration/{CALIBRATION['seed']}/{CONCEALED_SHARD}.json",
    log:
        "results/logs/calibration_comparisons_{shard}_of_{shards}.log",
    params:
        code=script_code("calibration_comparisons.py", "camid.commands.diagnose"),
        seed=CALIBRATION["seed"],
        number=CALIBRATION["recordings"],
        shards=CALIBRATION["shards"],
    message:
        "Diagnosing what calibrates the weights, shard {wildcards.shard} of {wildcards.shards}."
    script:
        "../scripts/calibration_comparisons.py"


rule calibration:
    input:
        expand(
            rules.calibration_comparisons.output,
            shard=range(CALIBRATION["shards"]),
            shards=CALIBRATION["shards"],
        ),
    output:
        constants="results/calibration/weights.json",
        reliability="results/calibration/reliability.csv",
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
