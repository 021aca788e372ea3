"""One reader after another under a fuzzer that follows the coverage of our code (atheris, on libFuzzer).

``python -m tests.faults.readers csv 30 7`` feeds the reader of text tables for 30 s with seed 7. Whatever is neither
read nor refused by an InputError, or takes more than 20 s or 3 GB, is written to the current folder and ends the
process with another exit code than 0.
"""

import importlib
import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from tests.support import linear_rig as rig

SECONDS_AN_INPUT, MEGABYTES, LONGEST = 20, 3000, 20_000


def csv_seeds(folder):
    table = rig.recording(12)
    texts = [
        table.to_csv(index=False),
        table.to_csv(index=False, sep=";", decimal=","),
        "# made by a logger\n" + table.to_csv(index=False, sep="\t"),
        "t [ms],u [V],y [mm]\n0,1,2\n10,1,3\n20,0,5\n",
        "t,u,y\ns,V,mm\n0,1,2\n0.01,1,3\n0.02,0,5\n",
        "sep=;\nt;u;y\n2026-05-31T13:45:00;1;2\n2026-05-31T13:45:01;1;3\n2026-05-31T13:45:02;0;5\n",
        't,u,"y ""q"""\n0,1,2\n1,1,\n2,0,nan\n',
    ]
    for i, text in enumerate(texts):
        (folder / f"{i}.csv").write_text(text, encoding="utf-8")
    (folder / "utf16.csv").write_text(texts[0], encoding="utf-16")


def parquet_seeds(folder):
    rig.recording(12).to_parquet(folder / "0.parquet")
    pd.DataFrame({"t": np.arange(5.0), "u": ["a", "b", "", "c", "d"], "y": [1, 2, 3, 4, 5]}).to_parquet(
        folder / "1.parquet", compression=None
    )


def mat_seeds(folder):
    import scipy.io

    columns = {name: column.to_numpy() for name, column in rig.recording(12).items()}
    scipy.io.savemat(folder / "0.mat", columns)
    scipy.io.savemat(folder / "1.mat", columns, do_compression=True)
    scipy.io.savemat(folder / "2.mat", columns, format="4")
    scipy.io.savemat(folder / "3.mat", {"run": columns, "cells": np.array([columns, columns], dtype=object)})


def hdf5_seeds(folder):
    import h5py

    with h5py.File(folder / "0.h5", "w") as file:
        for name, column in rig.recording(12).items():
            file[name] = column.to_numpy()
    with h5py.File(folder / "1.h5", "w") as file:
        for name, column in rig.recording(12).items():
            file.create_dataset(f"run/{name}", data=column.to_numpy(), compression="gzip")
            file["run"][name].attrs["units"] = "mm"


def yaml_seeds(folder):
    rig.write_yaml(rig.simulation(), folder / "0.yaml")
    rig.write_yaml(
        rig.simulation(
            validation={"start": 1.0, "end": 2.0},
            effects=[{"id": "coulomb-friction", "parameters": {"force": 0.1}, "standard_deviations": {"force": 0.01}}],
            recording={"separator": ";", "decimal": ",", "missing": "leave-out"},
        ),
        folder / "1.yaml",
    )
    quotient = {"numerator": ["1"], "denominator": ["m", "k"]}
    physical = {"parameters": {"m": 1.0, "k": 2.0}, "transfer_function": quotient}
    rig.write_yaml(rig.simulation(plant={"physical": physical}), folder / "2.yaml")
    (folder / "3.yaml").write_text("a: &a [1, 1]\nb: [*a, *a]\n<<: {schema: 1}\n")


def video_seeds(folder):
    from tests.support import films

    frames = films.film(films.path(4, centre=(24.0, 16.0), reach=(10.0, 6.0)), seed=1, size=(32, 48), radius=3.0)
    for name in ("0.avi", "1.mkv"):
        films.encode(folder / name, frames)


def read_table(path):
    from camid.recording.read import read_recordings

    read_recordings(path, "t", ["u", "y"], holds={"u": "zoh"})


def read_yaml(path):
    from camid.simulation.file import load_simulation

    load_simulation(path)


def read_video(path):
    from camid.tracking.video import VideoFile

    for number, _ in enumerate(VideoFile(path).frames()):
        if number == 20:
            break


READERS = {
    "csv": (csv_seeds, read_table, ".csv"),
    "parquet": (parquet_seeds, read_table, ".parquet"),
    "mat": (mat_seeds, read_table, ".mat"),
    "hdf5": (hdf5_seeds, read_table, ".h5"),
    "yaml": (yaml_seeds, read_yaml, ".yaml"),
    "video": (video_seeds, read_video, ".avi"),
}


def main(reader, seconds, seed):
    import atheris

    with atheris.instrument_imports(include=["camid"]):
        for module in ("camid.recording.read", "camid.recording.text", "camid.recording.mat_hdf5"):
            importlib.import_module(module)
        importlib.import_module("camid.simulation.file")
        importlib.import_module("camid.simulation.refusals")
        importlib.import_module("camid.tracking.video")
    from camid.errors import InputError

    seeds, read, suffix = READERS[reader]
    scratch = Path(tempfile.mkdtemp(prefix="camid-fuzz-"))
    corpus = scratch / "corpus"
    corpus.mkdir()
    seeds(corpus)
    path = scratch / f"input{suffix}"

    def one(data):
        path.write_bytes(data)
        try:
            read(path)
        except InputError:
            return  # one line: the command line has no other

    options = [
        f"-max_total_time={seconds}",
        f"-seed={seed}",
        f"-timeout={SECONDS_AN_INPUT}",
        f"-rss_limit_mb={MEGABYTES}",
        f"-max_len={LONGEST}",
    ]
    atheris.Setup([sys.argv[0], *options, str(corpus)], one)
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
