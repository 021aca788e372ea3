# What every stage needs: which code a rule depends on, and whether this working copy has computed anything yet.

import os
import shlex
import sys
import time
from pathlib import Path

ROOT = Path(workflow.basedir)
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "workflow")]

import jsonschema
import yaml
from camid.workflow.arithmetic import reproducible_environment
from code_digest import CodeDigest
from snakemake.exceptions import WorkflowError
from working_copy import WorkingCopy, settle_times


def read_yaml(path):
    """Content of a YAML file, by the compiled parser: there are three files for each ablation."""
    return yaml.load(
        Path(path).read_bytes(), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    )


# Snakemake's own validate() imports pandas, which takes longer than all the rest of this file.
def check_against_schema(content, schema, what):
    """Stop with the place and the key that do not fit."""
    error = jsonschema.exceptions.best_match(
        jsonschema.Draft202012Validator(read_yaml(schema)).iter_errors(content)
    )
    if error is not None:
        place = ".".join(map(str, error.absolute_path))
        raise WorkflowError(f"{what}: {f'{place}: ' if place else ''}{error.message}")


check_against_schema(config, ROOT / "workflow/schemas/config.schema.yaml", "config")
check_against_schema(
    config["concealed"],
    ROOT / "workflow/schemas/concealed.schema.yaml",
    "config: concealed",
)

# Jobs in processes of their own read this file, too; the working copy is that of the process that starts them.
WORKING_COPY = WorkingCopy(Path(".snakemake"))
if workflow.is_main_process and WORKING_COPY.enter():
    settle_times(Path())


# Jobs inherit it, so that committed results are those of any machine.
os.environ.update(reproducible_environment())

# The command line of the environment that runs the workflow, whatever the PATH.
CAMID = f"{shlex.quote(sys.executable)} -m camid"
FIGURES = [f"fig{number}" for number in range(1, 9)]

# A fresh clone holds the committed figures but none of their data, and to Snakemake a file that is there is up
# to date. This mark is made when the workflow is first read in a working copy (or after results/ was removed); it is
# newer than anything committed, and every rule that writes into paper_figs/ depends on it. Its content is the time,
# because Snakemake takes a new file with the old content for unchanged. Its time is that of the clock here, as that of every
# result, because the file system may be a server's, whose clock runs ahead: every result would be older than the mark.
BIRTH_MARK = "results/.working-copy"
if not Path(BIRTH_MARK).exists():
    Path(BIRTH_MARK).parent.mkdir(exist_ok=True)
    Path(BIRTH_MARK).write_text(f"{time.time_ns()}\n")
    os.utime(BIRTH_MARK, ns=(time.time_ns(), time.time_ns()))

# The parameter `code` is the digest of all the code that a job runs. A change runs the job again, a docstring does not.
CODE = CodeDigest(ROOT / "src", Path(".snakemake/code_digests.json"))


def script_code(script, *modules):
    """Digest of a script, of what it imports and of modules that it loads by name."""
    return CODE(ROOT / "workflow/scripts" / script, *modules)


def calls(script, function):
    """Parameters of a rule whose script calls a function of camid with the rule's inputs and parameters by name."""
    return {
        "function": f"camid.{function}",
        "code": script_code(script, f"camid.{function}".rpartition(".")[0]),
    }


def selected(section, *keys):
    """Some keys of a section of the configuration: a change of the others does not rerun the rule."""
    return {key: config[section][key] for key in keys}
