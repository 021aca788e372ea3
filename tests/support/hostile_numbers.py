"""Columns that no machine ever recorded, and the tables and commands that hold them."""

import contextlib
import io
import os
from pathlib import Path

import numpy as np
import pandas as pd
from hypothesis import strategies as st

from camid.cli import main
from tests.support import linear_rig as rig

SMALLEST = 5e-324  # subnormal
ROWS = [2, 3, 4, 6, 20, 60]
VALUES = [0.0, -0.0, 1.0, SMALLEST, 1e-310, 1e-300, 1e300, 1.7e308, np.nan, np.inf, -np.inf]
NAMES = [
    "y",
    "ÿ·мм",
    "y [mm]",
    "位置",
    "a b",
    "<b>y</b>",
    "y'\"",
    "$(touch owned)",
    "`id`",
    "../y",
    "=1+1",
    "\\",
    "%s{}",
]
TIMES = {
    "regular": lambda n: rig.PERIOD * np.arange(n),
    "far": lambda n: 1e12 + rig.PERIOD * np.arange(n),
    "tiny": lambda n: 1e-300 * np.arange(n),
    "huge": lambda n: 1e300 * np.arange(n),
    "equal": np.ones,
    "falling": lambda n: -rig.PERIOD * np.arange(n),
    "growing": lambda n: 2.0 ** np.arange(n),
    "broken": lambda n: np.where(np.arange(n) == n // 2, np.nan, rig.PERIOD * np.arange(n)),
}


@st.composite
def columns(draw, count, *, accepted):
    """A column: noise, steps or a ramp of an accepted scale, else also constants, extremes and any numbers."""
    kinds = ["noise", "steps", "ramp"] if accepted else ["constant", "noise", "steps", "any", "ramp"]
    kind = draw(st.sampled_from(kinds))
    if kind == "constant":
        return np.full(count, draw(st.sampled_from(VALUES)))
    if kind == "any":
        return np.array(draw(st.lists(st.floats(), min_size=count, max_size=count)))
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    made = {"noise": generator.standard_normal, "steps": lambda n: generator.choice([-1.0, 1.0], n), "ramp": np.arange}
    scale = draw(st.integers(-68, 66) if accepted else st.integers(-320, 307))
    with np.errstate(over="ignore"):
        column = (made[kind](count) * np.float64(10.0) ** scale).astype(np.float64)
    for value in [] if accepted else draw(st.lists(st.sampled_from(VALUES), max_size=2)):
        column[draw(st.integers(0, count - 1))] = value
    return column


@st.composite
def tables(draw):
    """Name of the output, and a recording with it, u and t; in half of them nothing has to be refused."""
    accepted = draw(st.booleans())
    count = draw(st.sampled_from([20, 60, 200] if accepted else ROWS))
    name = draw(st.sampled_from(NAMES))
    time = TIMES["regular" if accepted else draw(st.sampled_from(sorted(TIMES)))](count)
    names = ["t", "u", name, *([] if accepted else draw(st.sampled_from([[], [name], ["t"], ["other"]])))]
    table = pd.DataFrame(np.column_stack([time, *(draw(columns(count, accepted=accepted)) for _ in names[1:])]))
    table.columns = names
    return name, table


COMMANDS = st.sampled_from(
    [
        ["identify", "--output", "out/model.yaml"],
        ["identify", "--residuals", "out/residuals.csv"],
        ["simulate", "--output", "out/simulated.csv"],
        ["identify", "--json"],
    ]
)
SETTINGS = st.fixed_dictionaries(
    {
        "initial_state": st.sampled_from(["zero", "estimate"]),
        "hold": st.sampled_from(["zoh", "foh"]),
        "input": st.sampled_from([True, True, True, False]),
        "order": st.sampled_from([([300.0], [2.0, 6.0, 200.0]), ([1.0], [1.0, 1.0]), ([1e200], [1.0, 1e-200])]),
    }
)


def answer(folder, recorded, command, settings, suffix=".csv"):
    """Run a command on a table in a folder; what is wrong with the answer, or None, and its exit code."""
    name, table = recorded
    path = folder / f"name with a space{suffix}"
    table.to_csv(path, index=False, na_rep="nan")
    numerator, denominator = settings["order"]
    content = rig.simulation(
        plant=rig.plant(numerator, denominator),
        input={"column": "u", "hold": settings["hold"]} if settings["input"] else None,
        sensor={"column": name, "kind": "camera"},
        initial_state=settings["initial_state"],
    )
    rig.write_yaml(content, folder / "S.yaml")
    (folder / "out").mkdir(exist_ok=True)
    before = {p for p in folder.rglob("*") if "out" not in p.relative_to(folder).parts}
    verb, *options = command
    out, err = io.StringIO(), io.StringIO()
    here = Path.cwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main([verb, path.name, "--simulation", "S.yaml", *options])
    finally:
        os.chdir(here)
    after = {p for p in folder.rglob("*") if "out" not in p.relative_to(folder).parts}
    return what_is_wrong(code, err.getvalue(), after - before), code


def what_is_wrong(code, err, made):
    """None for a result, or for one clear line with exit code 2; nothing made beside the output folder."""
    if made:
        return f"made {sorted(map(str, made))}"
    errors = [line for line in err.splitlines() if not line.startswith("camid: warning: ")]
    if code == 0 and not errors:
        return None
    if code == 2 and len(errors) == 1 and errors[0].startswith("camid: error: "):
        return None
    return f"exit code {code}: {err[-300:]}"
