"""A recording, and how tests read it from files that others write."""

import numpy as np
import pytest

from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.read import read_recordings

COUNT = 60
T = 0.02 * np.arange(COUNT)
U = np.where(np.arange(COUNT) // 7 % 2 == 0, 1.0, -1.0)
Y = np.cumsum(U) * 0.1 + np.sin(3.0 * T)


def read(source, time="t", columns=("u", "y"), holds=("u",), conversions=None, **keys):
    return read_recordings(
        source, time, columns, (), Reading(**keys), dict.fromkeys(holds, "zoh"), conversions=conversions
    )


def refusal(source, **keys):
    with pytest.raises(InputError) as caught:
        read(source, **keys)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def check_one_line(refused):
    assert "\n" not in str(refused)
    assert refused.where is not None


def cells(*values):
    array = np.empty((1, len(values)), dtype=object)
    for i, value in enumerate(values):
        array[0, i] = value
    return array


def text_file(folder, content, name="recording.csv"):
    (folder / name).write_text(content, encoding="utf-8")
    return folder / name
