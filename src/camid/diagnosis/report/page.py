"""The page of a diagnosis: one HTML file that needs no network and no other file, and reads the same without script."""

from __future__ import annotations

import re
from base64 import b64encode
from dataclasses import dataclass, replace
from functools import cache, partial
from hashlib import sha256
from importlib import import_module
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

from camid import number_text
from camid.diagnosis.diagnosis import Coefficient, Diagnosis
from camid.diagnosis.explanation import LISTED_WEIGHT
from camid.diagnosis.finding import Finding
from camid.diagnosis.in_declared_units import in_declared_units
from camid.diagnosis.laws.learned_effect_file import NAME, effect_file
from camid.diagnosis.next_experiment import next_experiments
from camid.diagnosis.report import summary
from camid.diagnosis.report.words import with_titles
from camid.diagnosis.weights import HEADLINE_WEIGHT
from camid.effects import known_effects

if TYPE_CHECKING:
    from jinja2 import Template

    from camid.diagnosis.report.panel import Panel

STRUCTURE_BELOW = 0.01  # p-values below it are set in bold: chance hardly makes them
HOLDS = {"zoh": "zero-order hold", "foh": "first-order hold", "band-limited": "band-limited input"}


@dataclass(frozen=True)
class Box:
    """An element of the chain as it is drawn.

    Attributes
    ----------
    name, detail : str
    kind : str
        ``signal``, ``box``, ``sum`` or ``source`` (a box that enters at a sum).
    share : float or None
        Share of the mismatch that the best description here accounts for.
    flag : str
        Empty, ``here`` (where the mismatch sits) or ``also here`` (the place of a weaker effect).
    area : str
        Its place in the drawing.
    share_text : str
        The share as it is printed.
    """

    name: str
    detail: str
    kind: str
    share: float | None = None
    flag: str = ""
    area: str = ""
    share_text: str = ""


def equation(latex: str, size: float = 17.0) -> str | None:
    """Inline SVG of an equation in mathtext, in the colour of the text; None where mathtext cannot read it.

    MathML (by latex2mathml) would be smaller, 0.5 instead of 5 kB, but browsers set it with whatever font the machine
    has: without one for mathematics, dots over letters vanish and brackets do not grow. It also shows a command that
    it does not know as if it were a name.
    """
    from html import escape

    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    # The page has room for tall fractions; mathtext lacks the commands for the size of a delimiter.
    written, latex = latex, re.sub(r"\\[bB]igg?[lrm]?(?![A-Za-z])", "", latex.replace(r"\frac", r"\dfrac"))
    font = FontProperties(math_fontfamily="dejavusans")
    try:
        path = TextPath((0.0, 0.0), f"${latex}$", size=size, prop=font)
    except (ValueError, RuntimeError):  # a command that mathtext does not have
        return None
    if not len(path.vertices):
        return None
    letters = {1: "M", 2: "L", 3: "Q", 4: "C", 79: "Z"}
    parts = []
    for vertices, code in path.iter_segments(simplify=False, curves=True):
        points = " ".join(f"{v:.2f}" for v in vertices * np.resize([1.0, -1.0], len(vertices)))
        parts.append("Z" if code == 79 else f"{letters[int(code)]}{points}")
    box = path.get_extents()
    margin = 1.0
    view = (box.x0 - margin, -box.y1 - margin, box.width + 2.0 * margin, box.height + 2.0 * margin)
    return (
        f'<svg class="equation" role="img" aria-label="{escape(written)}" '
        f'viewBox="{" ".join(f"{v:.2f}" for v in view)}" '
        # A narrow screen shrinks it to six tenths, beyond which it scrolls.
        f'style="width:min({view[2]:.1f}px,max(100%,{0.6 * view[2]:.1f}px))">'
        f'<path fill="currentColor" d="{"".join(parts)}"/></svg>'
    )


def chain(diagnosis: Diagnosis) -> list[Box]:
    """The chain of the design with the located box marked."""
    simulation, location = diagnosis.improved, diagnosis.location
    # The hold is part of the actuator's side, and drawn as a box of its own.
    boxes = [_box_of(f) for f in diagnosis.findings]
    flags = dict.fromkeys(boxes, "also here")
    if location.place is not None:
        there = [box for box, finding in zip(boxes, diagnosis.findings, strict=True) if finding.place == location.place]
        flags[there[0] if there else location.place] = "here"
    # Where there is no mismatch, or the noise is all of it, no place has a share of it.
    shares = {} if location.place in {None, "noise"} else location.places
    printed = dict(zip(shares, number_text.percentages([*shares.values()]), strict=True))
    sensor = "instant"
    if simulation.sensor == "camera":
        exposure = diagnosis.period if simulation.exposure is None else simulation.exposure
        sensor = f"camera, exposure {number_text.plain(1e3 * exposure, unit='ms')}"
    if simulation.known_latency:
        sensor += f", latency {number_text.plain(1e3 * simulation.known_latency, unit='ms')}"

    def box(place: str, detail: str, kind: str = "box") -> Box:
        return Box(place, detail, kind, shares.get(place), flags.get(place, ""), place, printed.get(place, ""))

    order = simulation.plant.order
    held = HOLDS.get(simulation.hold, simulation.hold) if simulation.input_column else "no input"
    return [
        Box(number_text.printable(simulation.input_column or "no input"), "command", "signal", area="command"),
        Box("hold", held, "box", None, flags.get("hold", ""), "hold"),
        box("actuator", "command to force"),
        box("disturbance", "force from outside", "source"),
        Box("+", "", "sum", area="force"),
        box("plant", f"{order} {'pole' if order == 1 else 'poles'}"),
        box("sensor", sensor),
        box("noise", "of the measurement", "source"),
        Box("+", "", "sum", area="added"),
        Box(number_text.printable(simulation.output_column), "recorded", "signal", area="recorded"),
    ]


def _larger_share(diagnosis: Diagnosis) -> str | None:
    """A place with more of the mismatch than the one that is named, where its share is shown."""
    location = diagnosis.location
    if location.place in {None, "noise"} or not diagnosis.findings:
        return None
    largest = max(location.places, key=lambda place: location.places[place])
    return largest if location.places[largest] > location.places.get(str(location.place), 0.0) else None


def _box_of(finding: Finding) -> str:
    """Box of the chain that an effect is marked at."""
    known = known_effects().get(finding.identifier)
    return finding.place if known is None else known.box


def _parameter_rows(finding: Finding) -> list[dict[str, str]]:
    rows = []
    for name, parameter in finding.parameters.items():
        unit = parameter.unit
        if isinstance(parameter.value, str):
            value, interval = HOLDS.get(parameter.value, parameter.value), "–"
        elif isinstance(parameter.value, list | tuple):
            value, interval = number_text.with_deviation(parameter.value, parameter.standard_deviation), "–"
        elif parameter.at_bound:
            value, interval = summary.at_bound_text(replace(parameter, unit="")), "–"
        elif parameter.stated:
            value, interval = summary.stated_text(replace(parameter, unit="")), "–"
        else:
            value = number_text.with_deviation(parameter.value, parameter.standard_deviation)
            interval = number_text.interval(parameter.value, parameter.standard_deviation)
            if unit == "rad/s":
                unit += f" ({number_text.plain(parameter.value / (2.0 * np.pi), unit='Hz')})"
        rows.append({"name": name.replace("_", " "), "value": value, "interval": interval, "unit": unit})
    return rows


def _coefficient_row(coefficient: Coefficient) -> dict[str, str]:
    """A row of the table of coefficients, with what the refit alone had bent."""
    c = coefficient
    bend = c.refitted - c.improved
    spread = float(np.hypot(c.refitted_deviation, c.improved_deviation))
    return {
        "name": c.name,
        "unit": c.unit,
        "nominal": number_text.plain(c.nominal, 6),
        "refitted": summary.refitted_text(c),
        "improved": number_text.with_deviation(c.improved, c.improved_deviation),
        "nominal_off": _change(c.nominal - c.improved, c.improved),
        "bend": "–" if c.ran_away else _change(bend, c.improved),
        "bend_deviations": number_text.number(abs(bend) / spread, 2) if spread > 0.0 and not c.ran_away else "–",
    }


def _change(difference: float, reference: float) -> str:
    if not reference:
        return "–"
    sign = "+" if difference * reference > 0.0 else ""
    return (
        f"{sign}{number_text.number(100.0 * difference / abs(reference), 2)}{number_text.SPACE}%"
        if difference
        else f"0{number_text.SPACE}%"
    )


def _findings(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    from markupsafe import Markup

    found = []
    for finding in diagnosis.findings:
        drawn = equation(finding.equation) if finding.equation else None
        rivals = sorted((o for o in finding.alternatives if o[1] >= LISTED_WEIGHT), key=lambda pair: -pair[1])
        members = [(finding.title, finding.weight, True)] if rivals else []
        members += [(summary.title_of(name, diagnosis.own_titles), weight, False) for name, weight in rivals]
        found.append(
            {
                "finding": finding,
                # The path is made of numbers alone, so it needs no escaping.
                "equation": None if drawn is None else Markup(drawn),
                "parameters": _parameter_rows(finding),
                "evidence": summary.evidence_lines(finding.evidence, diagnosis.own_titles),
                "members": members,
                "stands_alone": summary.stands_alone(finding),
            }
        )
    return found


def _context(diagnosis: Diagnosis, shared: bool) -> dict[str, Any]:
    from markupsafe import Markup

    import camid
    from camid.diagnosis.report.pictures import draw

    units = diagnosis.improved.units
    own = diagnosis.own_titles
    seen, unseen = summary.sorted_undetectable(summary.not_found(diagnosis), own)
    pictures = draw(diagnosis, shared=shared)
    state = diagnosis.location.state
    headings = _headings(diagnosis)
    return {
        "diagnosis": diagnosis,
        "verdict": summary.verdict_words(diagnosis),
        "larger_share": _larger_share(diagnosis),
        "corrected": summary.needs_new_coefficients(diagnosis),
        "chain": chain(diagnosis),
        "findings": _findings(diagnosis),
        # Matplotlib has escaped the labels.
        "pictures": {key: [(p, Markup(p.svg), Markup(p.narrow)) for p in panels] for key, panels in pictures.items()},
        "headings": headings,
        "contents": _contents(diagnosis, headings, pictures),
        "next_experiments": next_experiments(diagnosis),
        "provenance": diagnosis.provenance,
        "versions": (
            [("camid", camid.__version__)] if diagnosis.provenance is None else [*diagnosis.provenance.versions.items()]
        ),
        "printable": number_text.printable,
        # It is ours, and what it is hashed to is all that the page may run.
        "script": Markup(_script()),
        "script_hash": f"sha256-{b64encode(sha256(_script().encode()).digest()).decode('ascii')}",
        "state": state and summary.state_text(state, diagnosis.improved),
        "coefficients": [_coefficient_row(c) for c in diagnosis.coefficients],
        "constants": summary.constants_text(diagnosis.improved),
        "bent": bool(diagnosis.findings),
        "seen": [(u, u.unit or "") for u in seen],
        "unseen": unseen,
        "units": units,
        "compared_name": number_text.printable(diagnosis.compared),
        "recordings": [number_text.printable(name) for name in diagnosis.recordings],
        "rows": len(diagnosis.signals.time),
        "structure_below": STRUCTURE_BELOW,
        "headline_weight": HEADLINE_WEIGHT,
        "number": number_text.number,
        "plain": number_text.plain,
        "apart_from": number_text.apart_from,
        "span": number_text.span,
        "percentage": number_text.percentage,
        "probability": number_text.probability,
        "title_of": partial(summary.title_of, own=own),
        "with_titles": partial(with_titles, own=own),
        "effect_file_name": NAME,
    }


def _headings(diagnosis: Diagnosis) -> dict[str, str]:
    """What the sections are called."""
    named = bool(diagnosis.findings or diagnosis.learned)
    structure = "What the missing part depends on"
    if diagnosis.known_remainder is not None:
        structure = "What the declared remainder depends on"
    elif diagnosis.explains_nothing:
        structure = "What is left"
    elif diagnosis.verdict == "adequate":
        structure = "What is left depends on nothing"
    elif named:
        structure = "What the recording shows of it"
    return {
        "location": "Where the mismatch sits",
        "effects": "What was found",
        "learned": "What has no name",
        "structure": structure,
        "fit": "Before and after" if named else "How well it fits",
        "response": "Frequency response" + (" before and after" if named else ""),
        "coefficients": "Coefficients of the plant",
        "tests": "Tests for structure",
        "undetectable": "What could not be seen",
        "warnings": "Warnings",
        "about": "Where this comes from",
    }


def _contents(
    diagnosis: Diagnosis, headings: dict[str, str], pictures: dict[str, list[Panel]]
) -> list[tuple[str, str]]:
    """Identifiers and headings of the sections that the page has."""
    missing = {
        name
        for name, content in (
            ("learned", diagnosis.learned),
            ("response", pictures["response"]),
            ("coefficients", diagnosis.coefficients),
            ("tests", diagnosis.tests),
            ("warnings", diagnosis.warnings),
        )
        if not content
    }
    return [(name, words) for name, words in headings.items() if name not in missing]


@cache
def _script() -> str:
    """The page's script."""
    return files("camid.diagnosis.report").joinpath("templates", "plots.js").read_text(encoding="utf-8")


def load() -> None:
    """Import and prepare everything that drawing a page needs, which takes longer than the drawing itself."""
    # What drawing would load on its way.
    for module in ("multiprocessing.popen_fork", "numpy.fft", "uncertainties", "camid.diagnosis.report.pictures"):
        import_module(module)
    from camid.diagnosis.report.panel import inline_svg, look_of_the_project, new_panel

    with look_of_the_project():
        inline_svg(new_panel(), "")
    equation(r"\frac{x}{y}")
    _template()


def render(diagnosis: Diagnosis, *, shared: bool = False) -> str:
    """The page as text; ``shared`` as in :func:`camid.diagnosis.report.pictures.draw`."""
    # The file of a learned law is in SI units, as everything that programs read.
    return _template().render(_context(in_declared_units(diagnosis), shared), effect_file=effect_file(diagnosis))


@cache
def _template() -> Template:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("camid.diagnosis.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("report.html")
