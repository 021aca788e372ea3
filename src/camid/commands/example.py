"""``camid example``: files to try everything with, and the commands that lead from a clip to an improved simulation."""

from __future__ import annotations

import os
from pathlib import Path

from camid.writing import check_folder, write_whole

PathLike = str | os.PathLike[str]

# What is written, and what each file holds. The wheel takes the same files from examples/ (pyproject.toml).
FILES = {
    "README.md": "the story of the arm in six commands, and what each file holds",
    "arm_clip.mp4": "a red marker on a spring arm, filmed for 20 s at 50 frames per second; 0.5 mm per pixel",
    "arm_drive.csv": "the drive's log: voltage of the motor every 10 ms, by the drive's own clock",
    "arm_simulation.yaml": "what is believed of the arm: a mass on a spring, with viscous friction",
    "arm_notebook.ipynb": "the same story in Python, for Jupyter",
    "make_arm.py": "what rendered the clip; it knows the right answers and uses nothing of camid",
    "slide.csv": "a recording without a clip: a driven slide, 30 s",
    "slide.yaml": "what is believed of the slide",
    "make_recording.py": "what simulated the slide",
}

# From the clip to the improved simulation, in the folder.
COMMANDS = (
    "camid track arm_clip.mp4 --colour red --scale 0.0005 --unit m --origin 119.5 52"
    " --output arm_marker.csv --preview arm_marker.png",
    "camid join arm_marker.csv arm_drive.csv --simulation arm_simulation.yaml"
    " --output arm_recording.csv --write-simulation arm_joined.yaml",
    "camid identify arm_recording.csv --simulation arm_joined.yaml --output arm_model.yaml",
    "camid diagnose arm_recording.csv --simulation arm_joined.yaml --output arm_diagnosis",
    "camid compare arm_recording.csv arm_model.yaml arm_diagnosis/improved.yaml --output arm_compare.png",
)


def example_folder() -> Path:
    """Where the files lie: in the installed package, or in the repository that this module is run from."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "example_files"
    return installed if installed.is_dir() else package.parents[1] / "examples"


def write_example(folder: PathLike) -> list[Path]:
    """Write the example's files to a folder, which is made where it does not exist.

    Parameters
    ----------
    folder : path
        Files that are there already and hold the same are left as they are.

    Returns
    -------
    list of Path
        The files, in the order of `FILES`.

    Raises
    ------
    InputError
        If a file of the same name holds something else, or the folder cannot be written to; nothing is written then.
    """
    target, source = Path(folder), example_folder()
    contents = {target / name: (source / name).read_bytes() for name in FILES}
    new = {path: content for path, content in contents.items() if not path.is_file() or path.read_bytes() != content}
    check_folder(target, dict.fromkeys(path.name for path in new))
    target.mkdir(exist_ok=True)
    for path, content in new.items():
        _write(path, content)
    return list(contents)


def _write(path: Path, content: bytes) -> None:
    write_whole(path, lambda temporary: temporary.write_bytes(content))
