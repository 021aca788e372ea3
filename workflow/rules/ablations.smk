# What lies past the paper: one question per target (ablation_exposure, …), all of them `ablations`.

for name, ablation in ABLATIONS.items():
    if ablation.get("own_rules", False):
        continue

    rule:
        name:
            f"{name}_runs"
        output:
            f"results/ablations/{name}.parquet",
        log:
            f"results/logs/{name}_runs.log",
        cache: True
        params:
            **calls("compute.py", f"ablations.{name}.runs.compute"),
            settings=SETTINGS[name],
            shared={section: config[section] for section in ablation["uses"]},
        message:
            f"Computing: {ablation['title']}."
        script:
            "../scripts/compute.py"


for name, ablation in ABLATIONS.items():

    rule:
        name:
            f"ablation_{name}"
        input:
            runs=f"results/ablations/{name}.parquet",
            working_copy=BIRTH_MARK,
        output:
            png=report(
                f"paper_figs/ablation_{name}.png",
                caption="../report/ablation.rst",
                category=ablation.get("category", "Ablations"),
                labels={"figure": name.replace("_", " "), "of": "past the paper"},
            ),
            csv=f"paper_figs/ablation_{name}.csv",
            quantities=f"results/ablations/{name}.csv",
            conclusion=f"results/ablations/{name}.txt",
        log:
            f"results/logs/ablation_{name}.log",
        params:
            ablation=name,
            title=ablation["title"],
            code=ablation_code(name),
        message:
            f"Drawing: {ablation['title']}."
        script:
            "../scripts/draw_ablation.py"


rule ablations:
    input:
        figures=expand(
            "paper_figs/ablation_{name}.{format}",
            name=ABLATIONS,
            format=["png", "csv"],
        ),
        conclusions=expand("results/ablations/{name}.txt", name=ABLATIONS),
        working_copy=BIRTH_MARK,
    output:
        csv="paper_figs/ablations.csv",
        markdown="paper_figs/ablations.md",
    log:
        "results/logs/ablations.log",
    params:
        names=list(ABLATIONS),
        code=script_code("ablations.py"),
    message:
        "Collecting the conclusions of all ablations."
    script:
        "../scripts/ablations.py"
