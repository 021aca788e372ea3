"""``camid example``: what it writes, what it refuses, and that the story told in it is true."""

import json
import re
import subprocess
import sys
import tomllib

import numpy as np
import pytest

from camid.cli import main
from camid.commands.example import COMMANDS, FILES
from tests.support import ROOT

FRICTION = 0.25  # V, in make_arm.py


def test_the_files_are_written_and_the_commands_printed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example"]) == 0
    printed = capsys.readouterr().out
    written = {p.name: p.read_bytes() for p in (tmp_path / "camid-example").iterdir()}
    assert written == {name: (ROOT / "examples" / name).read_bytes() for name in FILES}
    lines = [line.strip() for line in printed.splitlines()]
    assert lines[2:-1] == ["cd camid-example", *COMMANDS]
    assert main(["example"]) == 0  # the same files are no obstacle


def test_the_files_are_small():
    assert (ROOT / "examples" / "arm_clip.mp4").stat().st_size < 300_000
    assert sum((ROOT / "examples" / name).stat().st_size for name in FILES) < 400_000


@pytest.mark.parametrize("name", ["slide.csv", "README.md"])
def test_foreign_files_are_not_overwritten(name, tmp_path, capsys):
    (tmp_path / name).write_text("mine\n", encoding="utf-8")
    assert main(["example", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error == (
        f"camid: error: {tmp_path / name}: camid did not write this file and would overwrite it; "
        "move or remove it, or name another folder\n"
    )
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text(encoding="utf-8") == "mine\n"


@pytest.mark.parametrize(("name", "reason"), [("file", "this is a file"), ("no/such", "no such folder")])
def test_folders_that_cannot_be_are_refused(name, reason, tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main(["example", str(tmp_path / name)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert reason in error
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_the_list_names_every_file_and_writes_none(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(FILES)
    assert not list(tmp_path.iterdir())


def test_the_wheel_takes_what_is_written():
    with (ROOT / "pyproject.toml").open("rb") as file:
        included = tomllib.load(file)["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert included == {f"examples/{name}": f"camid/example_files/{name}" for name in FILES}


def test_the_readme_of_the_folder_names_the_files_and_the_commands():
    text = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in FILES if name != "README.md")
    (story, _) = re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL)
    assert story.splitlines() == list(COMMANDS)


def frames(path):
    import av

    with av.open(str(path)) as container:
        return np.stack([frame.to_ndarray(format="gray") for frame in container.decode(video=0)]).astype(float)


def test_the_maker_writes_log_and_clip_and_uses_nothing_of_camid(tmp_path):
    """The clip may be coded by other bytes where the encoder is another; its pictures are the same."""
    examples = ROOT / "examples"
    source = (examples / "make_arm.py").read_text(encoding="utf-8")
    assert not re.search(r"^\s*(import|from) camid", source, flags=re.MULTILINE)
    assert f"FRICTION = {FRICTION:.2f}  # V" in source
    subprocess.run([sys.executable, examples / "make_arm.py"], cwd=tmp_path, check=True)
    assert (tmp_path / "arm_drive.csv").read_bytes() == (examples / "arm_drive.csv").read_bytes()
    made, kept = (frames(folder / "arm_clip.mp4") for folder in (tmp_path, examples))
    assert made.shape == kept.shape
    assert np.abs(made - kept).mean() < 0.5  # grey levels


def notebook():
    return json.loads((ROOT / "examples" / "arm_notebook.ipynb").read_text(encoding="utf-8"))


def test_the_notebook_holds_no_outputs():
    cells = [cell for cell in notebook()["cells"] if cell["cell_type"] == "code"]
    assert cells
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells)


def test_the_cells_of_the_notebook_find_the_friction(tmp_path, monkeypatch):
    """Its code as a script; the kernel's turn is in ``make test-workflow``."""
    main(["example", str(tmp_path)])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    names: dict = {}
    for cell in notebook()["cells"]:
        if cell["cell_type"] != "code":
            continue
        *lines, last = "".join(cell["source"]).splitlines()
        exec("\n".join(lines), names)
        try:
            eval(last, names)
        except SyntaxError:  # a statement
            exec(last, names)
    for shown in ("model", "diagnosis", "comparison"):
        assert names[shown]._repr_html_().startswith("<")
    force = names["force"]
    assert names["friction"].identifier == "coulomb-friction"
    assert abs(force.value - FRICTION) < 3.0 * force.standard_deviation < 0.01
    fits = names["comparison"].fits.set_index("model")["fit_held_out"]
    assert fits.loc["identified"] < 92.0
    assert fits.loc["improved"] > 99.5
    assert (tmp_path / "arm_improved.yaml").read_text(encoding="utf-8").count("coulomb-friction") == 1


@pytest.mark.workflow
def test_a_kernel_executes_the_notebook(tmp_path):
    """As Jupyter does, with what requirements-notebook.lock installs."""
    nbformat = pytest.importorskip("nbformat")
    client = pytest.importorskip("nbclient", reason="make test-workflow installs it")
    main(["example", str(tmp_path)])
    done = nbformat.read(tmp_path / "arm_notebook.ipynb", as_version=4)
    nbformat.validate(done)
    client.NotebookClient(done, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in done.cells for output in cell.get("outputs", ())]
    assert not [output for output in outputs if output.output_type == "error"]
    printed = "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")
    assert re.search(r"^coulomb-friction: 0\.2[45]\d\d ± 0\.000\d V$", printed, flags=re.MULTILINE)
    shown = [output.data for output in outputs if "data" in output]
    assert sum("text/html" in data for data in shown) >= 3
    assert any("image/png" in data for data in shown)
