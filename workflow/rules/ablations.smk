# What lies past the paper: one question a target (ablation_exposure, …), all of them `ablations`.

from snakemake.common.configfile import load_configfile
from snakemake.exceptions import WorkflowError
from snakemake.utils import update_config, validate

# A folder of src/camid/ablations is an ablation: what it computes (runs.py) and draws (drawing.py), its settings and their
# schema, its tolerances, and in ablation.yaml its title and the sections of config/config.yaml that it uses.
ABLATION_FOLDER = "src/camid/ablations"
ABLATIONS = {
    path.parent.name: load_configfile(path)
    for path in sorted(ROOT.glob(f"{ABLATION_FOLDER}/*/ablation.yaml"))
}


# A configuration file may change single settings, under `ablations` and the name of the ablation.
def ablation_settings(name):
    """The settings of an ablation, checked."""
    settings = load_configfile(ROOT / ABLATION_FOLDER / name / "settings.yaml")
    update_config(settings, config.get("ablations", {}).get(name, {}))
    validate(settings, ROOT / ABLATION_FOLDER / name / "settings.schema.yaml")
    return settings


SETTINGS = {name: ablation_settings(name) for name in ABLATIONS}
unknown_ablations = set(config.get("ablations", {})) - set(ABLATIONS)
if unknown_ablations:
    raise WorkflowError(
        f"config: no ablation is called {', '.join(sorted(unknown_ablations))}; "
        f"{ABLATION_FOLDER} holds {', '.join(ABLATIONS)}"
    )


for name, ablation in ABLATIONS.items():
    if "shards" in SETTINGS[name]:
        continue  # its runs are shared out among jobs of their own (monte_carlo.smk)

    rule:
        name:
            f"{name}_runs"
        input:
            sources=sources(
                "workflow/scripts/ablation_runs.py",
                f"{ABLATION_FOLDER}/{name}/runs.py",
            ),
        output:
            f"results/ablations/{name}.parquet",
        log:
            f"results/logs/{name}_runs.log",
        cache: True
        params:
            ablation=name,
            settings=SETTINGS[name],
            shared={section: config[section] for section in ablation["uses"]},
        message:
            f"Computing: {ablation['title']}."
        script:
            "../scripts/ablation_runs.py"


for name, ablation in ABLATIONS.items():

    rule:
        name:
            f"ablation_{name}"
        input:
            runs=f"results/ablations/{name}.parquet",
            working_copy=BIRTH_MARK,
            sources=sources(
                "workflow/scripts/ablation_figure.py",
                f"{ABLATION_FOLDER}/{name}/runs.py",
                f"{ABLATION_FOLDER}/{name}/drawing.py",
            ),
        output:
            png=report(
                f"paper_figs/ablation_{name}.png",
                caption="../report/ablation.rst",
                category="Ablations",
                labels={"figure": name.replace("_", " "), "of": "past the paper"},
            ),
            pdf=f"paper_figs/ablation_{name}.pdf",
            csv=f"paper_figs/ablation_{name}.csv",
            quantities=f"results/ablations/{name}.csv",
            conclusion=f"results/ablations/{name}.txt",
        log:
            f"results/logs/ablation_{name}.log",
        params:
            ablation=name,
            title=ablation["title"],
        message:
            f"Drawing: {ablation['title']}."
        script:
            "../scripts/ablation_figure.py"


rule ablations:
    input:
        figures=expand(
            "paper_figs/ablation_{name}.{format}",
            name=ABLATIONS,
            format=["png", "pdf", "csv"],
        ),
        conclusions=expand("results/ablations/{name}.txt", name=ABLATIONS),
        working_copy=BIRTH_MARK,
        sources=sources("workflow/scripts/ablations.py"),
    output:
        csv="paper_figs/ablations.csv",
        markdown="paper_figs/ablations.md",
    log:
        "results/logs/ablations.log",
    params:
        names=list(ABLATIONS),
    message:
        "Collecting the conclusions of all ablations."
    script:
        "../scripts/ablations.py"
