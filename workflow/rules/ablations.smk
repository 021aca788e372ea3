# What lies past the paper: one question a target (ablation_exposure, …), all of them `ablations`.

from snakemake.exceptions import WorkflowError
from snakemake.utils import update_config

# A folder of src/camid/ablations is an ablation: what it computes (runs.py) and draws (drawing.py), its settings and their
# schema, its tolerances, and in ablation.yaml its title and the sections of config/config.yaml that it uses.
ABLATION_FOLDER = "src/camid/ablations"
ABLATIONS = {
    path.parent.name: read_yaml(path)
    for path in sorted(ROOT.glob(f"{ABLATION_FOLDER}/*/ablation.yaml"))
}


# A configuration file may change single settings, under `ablations` and the name of the ablation.
def ablation_settings(name):
    """The settings of an ablation, checked."""
    folder = ROOT / ABLATION_FOLDER / name
    settings = read_yaml(folder / "settings.yaml")
    update_config(settings, config.get("ablations", {}).get(name, {}))
    check_against_schema(
        settings, folder / "settings.schema.yaml", f"settings of the ablation {name}"
    )
    return settings


SETTINGS = {name: ablation_settings(name) for name in ABLATIONS}
unknown_ablations = set(config.get("ablations", {})) - set(ABLATIONS)
if unknown_ablations:
    raise WorkflowError(
        f"config: no ablation is called {', '.join(sorted(unknown_ablations))}; "
        f"{ABLATION_FOLDER} holds {', '.join(ABLATIONS)}"
    )


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


def ablation_code(name):
    """Digest of the code that draws an ablation and draws its conclusion."""
    return script_code(
        "draw_ablation.py",
        f"camid.ablations.{name}.runs",
        f"camid.ablations.{name}.drawing",
    )


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
            pdf=f"paper_figs/ablation_{name}.pdf",
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
            format=["png", "pdf", "csv"],
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
