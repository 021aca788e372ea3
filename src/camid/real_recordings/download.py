"""Real recordings by name: found in a local folder, else downloaded with a checksum. None is part of this project."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from camid.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

FOLDER_VARIABLE = "CAMID_RECORDINGS"


@dataclass(frozen=True)
class BenchmarkRecording:
    """A published recording.

    Attributes
    ----------
    file : str
        Name in the local folder.
    address : str
        Public address, fixed to a revision.
    sha256 : str
    """

    file: str
    address: str
    sha256: str


BENCHMARK_RECORDINGS = {
    # Wigren & Schoukens (2013), an electronic oscillator with a cubic spring; columns V1 (input), V2 (output).
    "silverbox": BenchmarkRecording(
        "silverbox.csv",
        "https://raw.githubusercontent.com/forgi86/pytorch-ident/f00d79ff8c6cb96d094d9ea1c079d4dcbf9a67e0/"
        "examples/statespace/silverbox/SilverboxFiles/SNLS80mV.csv",
        "ae62d5a91230c10f76e6dd02c8a4fac3c9d4d8a95fbf50e87cb0c4885003e0f1",
    ),
    # Janot, Gautier & Brunot (2019), a drive for a prismatic joint in closed loop; columns t (s), qg, qm (m), vir (V).
    "emps": BenchmarkRecording(
        "emps.mat",
        "https://raw.githubusercontent.com/forgi86/sysid-neural-continuous/956aa7ecd73061b0321c6f6098d74c9e4a7ce67a/"
        "examples/EMPS/data/DATA_EMPS.mat",
        "6cf6814ae14618795da0101aae2bb97ff0c6351b0501b5492751b02b07facf7e",
    ),
    # A pendulum on an encoder swings out; no header, columns time (s), angle (rad), angular rate (rad/s).
    "pendulum_decay": BenchmarkRecording(
        "pendulum_decay.csv",
        "https://raw.githubusercontent.com/nielsSkov/masterThesisMatlab/0e2c7253fe6e740c36da872508a71c0d1f66a965/"
        "parameterEstimation/data/pend1test/test1pend1.csv",
        "a92411887a922c43780ac27b504cf18e5d2236c5f704d9294f9fa679d82f69c4",
    ),
    # A red ball on a string in front of a white wall, filmed at 29.75 frames per second.
    "pendulum_clip": BenchmarkRecording(
        "pendulum.mp4",
        "https://raw.githubusercontent.com/juangomez177/Pendulum_Oscillatory_Motion/"
        "9281de3f32438efd18d44567a9ec44d9458a9e2b/pendulum.mp4",
        "ebf6d5810f7e55f269e4a1464c28b981f86c35a1f8c2c31e3d1960b652fccb0c",
    ),
    # A second, lighter pendulum on the same encoder, from near upright; columns as those of the first.
    "pendulum2_decay": BenchmarkRecording(
        "pendulum2_decay.csv",
        "https://raw.githubusercontent.com/nielsSkov/masterThesisMatlab/0e2c7253fe6e740c36da872508a71c0d1f66a965/"
        "parameterEstimation/data/pend2test/test1pend2.csv",
        "04a8a911f4be476a88a24c46246d02e80dfbae03e578abaa2df011eeb08b98d5",
    ),
    # Wigren & Schoukens (2017), two motors, a belt and a pulley on a spring; three records from u1, u2, u3 (V) to the
    # speed without its sign, z1, z2, z3.
    "coupled_drives": BenchmarkRecording(
        "coupled_drives.mat",
        "https://raw.githubusercontent.com/anubhabghosh/ParamEstimation/acb959d7158eba36b0d57fb515a75201b2316f22/"
        "data/coupled_drive/DATAPRBS.MAT",
        "47d0825678d854d8a1bbcfb0ad1188026b853f69beb2067ea00cfd88d13dc4ca",
    ),
    # Schoukens & Noël (2017), a pump and two tanks; estimation record uEst, yEst (V), validation record uVal, yVal (V).
    "cascaded_tanks": BenchmarkRecording(
        "cascaded_tanks.csv",
        "https://raw.githubusercontent.com/forgi86/sysid-neural-continuous/956aa7ecd73061b0321c6f6098d74c9e4a7ce67a/"
        "examples/CTS/data/dataBenchmark.csv",
        "ef2388ed822f3aef4aa80d6b0f2b466dd80b361786b3eafc7a2957c31ea323a7",
    ),
}


def reason_absent(name: str) -> str | None:
    """Why a recording is not in the local folder; None if it is there."""
    folder = os.environ.get(FOLDER_VARIABLE)
    if not folder:
        return f"{FOLDER_VARIABLE} is not set"
    path = Path(folder) / BENCHMARK_RECORDINGS[name].file
    return None if path.is_file() else f"{path} is not there"


def fetch(name: str) -> Path:
    """Path of a real recording.

    The folder in ``CAMID_RECORDINGS`` comes first, then pooch's cache, then the public address; the checksum is
    verified in each case.

    Raises
    ------
    InputError
        If there is no such recording, its contents differ from the checksum, or it cannot be downloaded.
    """
    import pooch

    if name not in BENCHMARK_RECORDINGS:
        raise InputError(f"no recording '{name}'", hint=f"known here: {', '.join(BENCHMARK_RECORDINGS)}")
    recording = BENCHMARK_RECORDINGS[name]
    folder = os.environ.get(FOLDER_VARIABLE)
    if folder:
        path = Path(folder) / recording.file
        if not path.is_file():
            raise InputError("no such file", where=str(path), hint=f"correct or unset {FOLDER_VARIABLE}")
        if pooch.file_hash(str(path), alg="sha256") != recording.sha256:
            raise InputError("not the published file (its SHA-256 differs)", where=str(path), hint="fetch it again")
        return path
    pooch.get_logger().setLevel("ERROR")
    try:
        return Path(
            pooch.retrieve(
                recording.address, known_hash=recording.sha256, fname=recording.file, path=pooch.os_cache("camid")
            )
        )
    except (OSError, ValueError) as error:  # requests' errors are OSErrors, a wrong checksum is a ValueError
        reason = type(error).__name__
        raise InputError(
            f"the recording '{name}' cannot be downloaded ({reason})",
            where=recording.address,
            hint=f"download it and name its folder in {FOLDER_VARIABLE}",
        ) from None


SILVERBOX_PERIOD = 1.0 / 610.35  # seconds
# Official split, first row and the row after the last; the tests start with a state that is not known.
SILVERBOX_TRAINING = (40650, 105712)
SILVERBOX_MULTISINE = (105712, 127400)
SILVERBOX_ARROW = (100, 40575)
SILVERBOX_TRANSIENT = 50


def silverbox_parts(path: Path) -> dict[str, pd.DataFrame]:
    """Training part and test multisine of the Silverbox, each as a recording that camid reads.

    The means of the training part are taken from both: a linear model has no place for an offset.

    Returns
    -------
    dict of DataFrame
        ``training`` and ``multisine``, with columns ``t`` (s), ``V1`` and ``V2`` (V).
    """
    import numpy as np
    import pandas as pd

    table = pd.read_csv(path, index_col=False)[["V1", "V2"]].dropna()
    table.insert(0, "t", np.arange(len(table)) * SILVERBOX_PERIOD)
    parts = {
        "training": table.iloc[slice(*SILVERBOX_TRAINING)].copy(),
        "multisine": table.iloc[slice(*SILVERBOX_MULTISINE)].copy(),
    }
    means = parts["training"][["V1", "V2"]].mean()
    for part in parts.values():
        part[["V1", "V2"]] -= means
    return parts
