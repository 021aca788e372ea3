"""The wheel holds what it needs, runs outside of the tree, and says which extra is missing."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile

import pytest

import camid
from camid.errors import EXTRAS
from tests.support import ROOT

# A finder that hides modules, as if an extra were not installed.
HIDING = """
import sys
from importlib.abc import MetaPathFinder
HIDDEN = {hidden!r}
class Hidden(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in HIDDEN:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
import importlib.util
original = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if name in HIDDEN else original(name, package)
sys.meta_path.insert(0, Hidden())
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder with the sdist and the wheel."""
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "--directory", folder], cwd=ROOT, check=True, capture_output=True
    )
    return folder


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """Python of an environment with camid from the wheel alone, and everybody else's packages from this one."""
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder, with_pip=False, symlinks=True)
    site = next(folder.glob("lib/python*/site-packages"))
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    # Its own packages come first; an editable camid of this environment is a .pth file, which is not read there.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return folder / "bin" / "python"


def run(python, folder, *arguments, hidden=()):
    environment = {k: v for k, v in os.environ.items() if k not in {"PYTHONPATH", "PYTHONHOME"}}
    start = HIDING.format(hidden=set(hidden)) if hidden else ""
    program = f"{start}\nimport sys\nfrom camid.cli import main\nsys.exit(main(sys.argv[1:]))"
    return subprocess.run(
        [python, "-P", "-c", program, *arguments],
        cwd=folder,
        env=environment | {"MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=False,
        timeout=1800,
    )


@pytest.fixture
def folder(tmp_path):
    for name in ("slide.csv", "slide.yaml", "pendulum.mp4"):
        (tmp_path / name).write_bytes((ROOT / "examples" / name).read_bytes())
    # That the commands run is the question here, and a part of the recording answers it.
    rows = (tmp_path / "slide.csv").read_text(encoding="utf-8").splitlines(keepends=True)[:401]
    (tmp_path / "slide.csv").write_text("".join(rows), encoding="utf-8")
    return tmp_path


def test_the_wheel_holds_every_file_of_the_package(built):
    (wheel,) = built.glob("*.whl")
    source = {
        str(p.relative_to(ROOT / "src"))
        for p in (ROOT / "src/camid").rglob("*")
        if p.is_file() and "__pycache__" not in p.parts and p.suffix not in {".pyc", ".nbi", ".nbc"}
    }
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert source <= names
    assert {"camid/py.typed", "camid/schemas/simulation.schema.json", "camid/schemas/diagnosis.schema.json"} <= names
    assert any(n.startswith("camid/diagnosis/report/") and not n.endswith(".py") for n in names), "no template"


def test_the_sdist_holds_the_package_and_its_examples_alone(built):
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = [n.partition("/")[2] for n in archive.getnames()]
    assert {"pyproject.toml", "README.md", "LICENSE", "src/camid/__init__.py", "examples/slide.csv"} <= set(names)
    assert {n.partition("/")[0] for n in names} <= {
        *("src", "examples", "pyproject.toml", "PKG-INFO", ".gitignore"),
        *("README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff"),
    }


def test_the_wheel_writes_the_example(installed, tmp_path):
    done = run(installed, tmp_path, "example", "first")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "first" / "README.md").is_file()
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (ROOT / "examples" / path.name).read_bytes()
    again = run(installed, tmp_path, "identify", "first/slide.csv", "--simulation", "first/slide.yaml")
    assert again.returncode == 0, again.stderr


def test_the_wheel_identifies_diagnoses_and_tracks_outside_of_the_tree(installed, folder):
    where = subprocess.run(
        [installed, "-P", "-c", "import camid; print(camid.__file__)"],
        cwd=folder,
        env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert str(ROOT) not in where.stdout
    simulation = ("--simulation", "slide.yaml", "--output")
    for arguments, written in (
        (("identify", "slide.csv", *simulation, "model.yaml"), "model.yaml"),
        (("diagnose", "slide.csv", *simulation, "diagnosis"), "diagnosis/report.html"),
        (("track", "pendulum.mp4", "--colour", "red", "--output", "clip.csv"), "clip.csv"),
    ):
        done = run(installed, folder, *arguments)
        assert done.returncode == 0, done.stderr
        assert (folder / written).is_file()


CALLS = {
    "plots": (
        ("diagnose", "slide.csv", "--simulation", "slide.yaml", "--output", "diagnosis"),
        r"report.html needs matplotlib: pip install 'camid\[plots\]'; or say --no-report",
    ),
    "video": (
        ("track", "pendulum.mp4", "--colour", "red", "--output", "clip.csv"),
        r"tracking a video needs OpenCV, PyAV and matplotlib: pip install 'camid\[video\]'",
    ),
    "formats": (
        ("simulate", "slide.csv", "--simulation", "slide.yaml", "--output", "simulated.parquet"),
        r"writing a Parquet file needs PyArrow: pip install 'camid\[formats\]'; or write CSV",
    ),
    "control": (
        ("bode", "slide.yaml", "--output", "bode.csv"),
        r"a frequency response needs python-control: pip install 'camid\[control\]'",
    ),
    "studio": (
        ("studio", "--no-browser", "--folder", "kept"),
        r"camid studio needs NiceGUI: pip install 'camid\[studio\]'",
    ),
}


@pytest.mark.parametrize("extra", CALLS)
def test_a_missing_extra_is_named_in_one_line(extra, folder):
    arguments, line = CALLS[extra]
    before = set(folder.iterdir())
    environment = dict(os.environ, PYTHONPATH=str(ROOT / "src"))
    start = HIDING.format(hidden=set(EXTRAS[extra]))
    program = f"{start}\nfrom camid.cli import main\nsys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert done.returncode == 2
    assert re.fullmatch(f"camid: error: {line}\n", done.stderr)
    assert set(folder.iterdir()) == before


def test_extras_are_those_of_the_package():
    with (ROOT / "pyproject.toml").open("rb") as file:
        declared = tomllib.load(file)["project"]["optional-dependencies"]
    distributions = {"cv2": "opencv-python-headless", "python_calamine": "python-calamine"}
    for extra, modules in EXTRAS.items():
        required = {re.split(r"[<>=\[]", r)[0] for r in declared[extra]} - {"camid"}  # other extras of its own
        assert {distributions.get(m, m) for m in modules} == required


def test_the_version_is_the_same_everywhere():
    with (ROOT / "pyproject.toml").open("rb") as file:
        version = tomllib.load(file)["project"]["version"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    released = re.search(r"^date-released: (\S+)$", citation, re.MULTILINE)[1]
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert camid.__version__ == version
    assert f"\nversion: {version}\n" in citation
    assert re.search(r"^## (.*)$", changes, re.MULTILINE)[1] == f"{version} – {released}"
