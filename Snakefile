from snakemake.utils import min_version

min_version("9.10")


configfile: "config/config.yaml"
configfile: "config/concealed.yaml"


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/ablation_folders.smk"
include: "workflow/rules/datasets.smk"
include: "workflow/rules/imaging.smk"
include: "workflow/rules/identification.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/ablations.smk"
include: "workflow/rules/monte_carlo.smk"
include: "workflow/rules/concealed.smk"
include: "workflow/rules/calibration.smk"
include: "workflow/rules/other_authors.smk"
include: "workflow/rules/physical_rigs.smk"
include: "workflow/rules/two_clocks.smk"
include: "workflow/rules/designed_experiment.smk"
include: "workflow/rules/filmed_rigs.smk"
include: "workflow/rules/unlisted.smk"
include: "workflow/rules/recordings.smk"
include: "workflow/rules/check.smk"


onstart:
    if workflow.is_main_process and not WORKING_COPY.begin_work():
        raise WorkflowError(
            f"another Snakemake is at work in {Path.cwd()}; wait until it is done"
        )


rule all:
    default_target: True
    input:
        rules.paper.input,
        rules.ablations.output,
    localrule: True
    message:
        "All figures and the table of claims are up to date."
