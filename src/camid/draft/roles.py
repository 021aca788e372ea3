"""Guesses of what the columns of a recording are: time, input, output, reference; by their names and their nature."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from camid.draft.layout import Layout
from camid.errors import InputError
from camid.recording.nature import Nature, nature_of
from camid.recording.units import unit_in_header

Array = NDArray[np.float64]

# Names that people give to a role; the name of a column or its first word, without digits and unit, is one of them.
NAMES = {
    "time": "t time timestamp times zeit sec seconds clock datetime date",
    "input": "u input in command cmd voltage v vin force f torque tau current i pwm drive motor stimulus",
    "output": "y output out position pos x angle theta th phi alpha q z w level speed response measured vout",
    "reference": "r ref reference setpoint sp desired target",
    "period": "ts dt h period sampletime samplingperiod sampleperiod tsample step",
    "rate": "fs rate framerate fps frequency samplerate samplingrate",
}
SETS = {role: set(words.split()) for role, words in NAMES.items()}
# A column is the rate of change of another if it follows its differences this well, with a factor near one.
RATE_CORRELATION, RATE_FACTOR = 0.9, (0.8, 1.25)
# A reference is followed by the output this well.
REFERENCE_CORRELATION = 0.98
# Without name or levels, an input is rougher than the output by this factor.
ROUGHER = 1.5


@dataclass(frozen=True)
class Roles:
    """What the columns are taken for, and why, in words.

    Attributes
    ----------
    time, input, reference : str or None
    output : str
    why : dict of str to str
        By role.
    unused : dict of str to str
        Columns that are not used, and what they look like.
    runs : tuple of dict
        Runs side by side: for each, the columns in place of those of the first.
    period : float or None
        Seconds, from a single value whose name says so.
    frame_time : str or None
        Column with the times of the frames that the output is of, where they lie between the samples of the input.
    """

    output: str
    time: str | None = None
    input: str | None = None
    reference: str | None = None
    why: dict[str, str] = field(default_factory=dict)
    unused: dict[str, str] = field(default_factory=dict)
    runs: tuple[dict[str, str], ...] = ()
    period: float | None = None
    frame_time: str | None = None


def says(name: str, role: str) -> bool:
    """Whether the name of a column is one that people give to a role."""
    bare = unit_in_header(name)[0].rpartition("/")[2]
    words = [w.lower() for w in re.findall(r"[A-ZÄÖÜ]?[a-zäöüµ]+|[A-ZÄÖÜ]+", bare)]
    return bool(SETS[role] & {"".join(words), *words[:1]})


def roles_of(layout: Layout) -> Roles:
    """Guess the roles of columns.

    Raises
    ------
    InputError
        If all columns but the time are constant.
    """
    natures = {n: found for n, c in layout.columns.items() if (found := nature_of(c)) is not None}
    natures.pop(layout.frame_time or "", None)
    time = time_of(layout, natures)
    rest = [n for n, nature in natures.items() if n != time and nature.kind != "constant"]
    if not rest:
        raise InputError("no column beside the time changes", hint="a recording needs an output that moves")
    runs = _runs(rest, natures)
    considered = [n for n in rest if not runs or n in runs[0].values()]
    unused = dict(layout.left_out)
    unused |= {
        n: ("constant" if nature.kind == "constant" else nature.words())
        for n, nature in natures.items()
        if n != time and n not in considered
    }
    considered = _without_companions(layout, time, considered, unused)
    source, output, why = _pair(considered, natures, layout)
    reference = _reference(layout, [n for n in considered if n not in (source, output)], output) if source else None
    for name in considered:
        if name not in (source, output, reference):
            unused[name] = natures[name].words()
    if runs:
        stems = {column: stem for stem, column in runs[0].items()}
        keep = [n for n in (source, output) if n in stems]
        runs = tuple({n: run[stems[n]] for n in keep} for run in runs)
        for run in runs:
            for column in run.values():
                unused.pop(column, None)
    frame_time = layout.frame_time if source is not None and output in layout.seen else None
    if layout.frame_time is not None and frame_time is None:
        unused[layout.frame_time] = "times of frames"
    return Roles(
        output=output,
        frame_time=frame_time,
        time=time,
        input=source,
        reference=reference,
        why=why,
        unused=unused,
        runs=runs,
        period=_period(layout.values) if time is None else None,
    )


def time_of(layout: Layout, natures: dict[str, Nature] | None = None) -> str | None:
    """The column that looks like the time, if one does."""
    if natures is None:
        natures = {n: found for n, c in layout.columns.items() if (found := nature_of(c)) is not None}
    clocks = [n for n, nature in natures.items() if nature.kind == "clock"]
    # A counter of rows is a clock, too, but only where there is no other.
    counters = [n for n in clocks if np.all(np.diff(layout.columns[n]) == 1.0) and not says(n, "time")]
    order = [*layout.dates, *(n for n in clocks if says(n, "time")), *(n for n in clocks if n not in counters)]
    return order[0] if order else None


def _period(values: dict[str, float]) -> float | None:
    """Sampling period from a single value whose name is that of a period or a rate."""
    for name, value in values.items():
        if value > 0.0 and says(name, "period"):
            return value
        if value > 0.0 and says(name, "rate"):
            return 1.0 / value
    return None


def _runs(names: list[str], natures: dict[str, Nature]) -> tuple[dict[str, str], ...]:
    """Runs side by side, such as u1, y1, u2, y2: for each, its columns by what their names have in common."""
    best: tuple[dict[str, str], ...] = ()
    for split in (_by_digits, _by_front, _by_back):
        for parts in split(names):
            labels = list(dict.fromkeys(label for _, label in parts.values()))
            stems = list(dict.fromkeys(stem for stem, _ in parts.values()))
            table = {(stem, label): n for n, (stem, label) in parts.items()}
            complete = len(labels) > 1 and len(stems) == 2 and len(table) == 4 * len(labels) // 2
            # Two markers filmed together, x1, y1, x2, y2, are alike; an input and an output are not.
            if complete and len(labels) > len(best) and _differ([natures[table[s, labels[0]]] for s in stems], stems):
                best = tuple({s: table[s, label] for s in stems} for label in labels)
    return best


def _differ(natures: list[Nature], stems: list[str]) -> bool:
    named = any(says(s, "input") for s in stems) and any(says(s, "output") for s in stems)
    rough = sorted(n.roughness for n in natures)
    return named or len({n.kind for n in natures}) > 1 or rough[1] > ROUGHER * rough[0]


def _by_digits(names: list[str]) -> list[dict[str, tuple[str, str]]]:
    found = {n: (m[1] + m[3], m[2]) for n in names if (m := re.fullmatch(r"(\D*)(\d+)(\D*)", n))}
    return [found]


def _by_front(names: list[str]) -> list[dict[str, tuple[str, str]]]:
    return [{n: (n[:k], n[k:]) for n in names if len(n) > k} for k in range(1, 8)]


def _by_back(names: list[str]) -> list[dict[str, tuple[str, str]]]:
    return [{n: (n[-k:], n[:-k]) for n in names if len(n) > k} for k in range(1, 8)]


def _without_companions(layout: Layout, time: str | None, names: list[str], unused: dict[str, str]) -> list[str]:
    """Columns that are not the accuracy, the quality or the rate of change of another; why not goes to ``unused``."""
    kept = list(names)
    for name in names:
        if any(name in (f"{o}_std", f"{o}_gradient", f"{o}_grey_level") for o in names) or name == "quality":
            unused[name] = "belongs to what was tracked"
            kept.remove(name)
    if time is None:
        return kept
    steps = layout.columns[time]
    for name in [n for n in kept if not says(n, "input")]:
        source = next((o for o in kept if o != name and _is_rate(layout.columns[o], layout.columns[name], steps)), None)
        if source is not None:
            unused[name] = f"looks like the rate of change of '{source}'"
            kept.remove(name)
    return kept


def _is_rate(values: Array, rate: Array, time: Array) -> bool:
    if not len(values) == len(rate) == len(time):
        return False
    with np.errstate(all="ignore"):
        backward = np.diff(values) / np.diff(time)
        central = 0.5 * (backward[1:] + backward[:-1])
        for change, shown in ((backward, rate[1:]), (central, rate[1:-1])):
            known = np.isfinite(change) & np.isfinite(shown)
            if not known.any():
                continue
            a, b = change[known] - np.mean(change[known]), shown[known] - np.mean(shown[known])
            scale = float(a @ a) * float(b @ b)
            if scale > 0.0 and a @ b / np.sqrt(scale) > RATE_CORRELATION:
                return bool(RATE_FACTOR[0] < np.sqrt((b @ b) / (a @ a)) < RATE_FACTOR[1])
    return False


def _pair(names: list[str], natures: dict[str, Nature], layout: Layout) -> tuple[str | None, str, dict[str, str]]:
    """Input (None for a free decay) and output, and why."""

    def like_input(name: str) -> float:
        nature = natures[name]
        named = says(name, "input") - says(name, "output") - 0.5 * says(name, "reference")
        return 3.0 * named + 2.0 * (nature.kind == "held") + min(nature.roughness, 1.4)

    order = sorted(names, key=like_input, reverse=True)
    if len(order) == 1:
        return None, order[0], {"input": "no other column is left: taken for a free decay"}
    tracked = [n for n in names if f"{n}_std" in layout.columns]
    if len(tracked) == len(names):
        moved = max(tracked, key=lambda n: float(np.nanstd(layout.columns[n])))
        return None, moved, {"input": "all columns are positions of a marker: taken for a free decay"}
    source = next(n for n in order if n not in tracked)
    outputs = [n for n in order if n != source]

    def like_output(name: str) -> float:
        return 3.0 * (says(name, "output") - says(name, "reference")) - natures[name].roughness

    output = max(outputs, key=like_output)
    leading = next(
        (n for n in outputs if n != output and not says(output, "output") and _follows(layout, n, output)), None
    )
    output = leading or output
    rougher = natures[source].roughness > ROUGHER * natures[output].roughness
    if not (natures[source].kind == "held" or says(source, "input") or rougher):
        spread = {n: float(np.nanstd(layout.columns[n])) for n in names}
        output = max([n for n in names if says(n, "output")] or names, key=lambda n: spread[n])
        return None, output, {"input": "no column looks like a command: taken for a free decay"}
    why = [*(["its name"] if says(source, "input") else []), natures[source].words()]
    if rougher:
        why.append("rougher than the output")
    reasons = [*(["its name"] if says(output, "output") else []), natures[output].words()]
    return source, output, {"input": ", ".join(why), "output": ", ".join(reasons)}


def _follows(layout: Layout, name: str, other: str) -> bool:
    """Whether a column is nearly another one, but later: what is measured follows what is wanted."""
    late, early = layout.columns[name], layout.columns[other]
    if len(late) != len(early) or not (np.isfinite(late).all() and np.isfinite(early).all()):
        return False
    if np.corrcoef(late, early)[0, 1] < REFERENCE_CORRELATION:
        return False
    return float((late - early - np.mean(late - early)) @ np.gradient(early)) < 0.0


def _reference(layout: Layout, names: list[str], output: str) -> str | None:
    """A column that the output follows closely, as in a closed loop."""
    followed = layout.columns[output]
    for name in names:
        values = layout.columns[name]
        if len(values) == len(followed) and np.isfinite(values).all() and np.isfinite(followed).all():
            close = float(np.corrcoef(values, followed)[0, 1])
            if close > REFERENCE_CORRELATION or (says(name, "reference") and close > 0.5):
                return name
    return None
