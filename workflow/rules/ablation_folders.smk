# The ablations that there are: folders of src/camid/ablations.

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


def ablation_code(name):
    """Digest of the code that draws an ablation and draws its conclusion."""
    return script_code(
        "draw_ablation.py",
        f"camid.ablations.{name}.runs",
        f"camid.ablations.{name}.drawing",
    )
