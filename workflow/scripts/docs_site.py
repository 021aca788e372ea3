"""Content of the site beyond docs/: figures, the paper's claims, ablations, the proof and the catalogue of effects.

A hook of mkdocs (see mkdocs.yml). Nothing of it is written into docs/: a page says ``<!-- generated: NAME -->`` where a
part belongs, with a pointer for those who read the page in the repository, and the part is made from the committed
results, the classes of the effects or the schema of simulation files, during the build.
"""

from __future__ import annotations

import csv
import posixpath
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

from camid.diagnosis.report.page import equation
from camid.effects import PLACES, known_effects

sys.path.insert(0, str(Path(__file__).parent))
import effect_pictures
from simulation_keys import simulation_keys

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "paper_figs"
PICTURES = ROOT / "results" / "docs" / "effects"
# What stands up to an end mark is for those who read the page in the repository.
MARK = re.compile(r"<!-- generated: (\w+) -->(?:\n[^<]*\n<!-- end of \1 -->)?")
# What Sphinx would make a link of; mkdocstrings leaves the role in the text.
ROLE = re.compile(r":(?:attr|class|func|meth|mod):(?=<code>)")
OUTSIDE = re.compile(r"(!?)\[([^\]]*)\]\(((?:\.\./)+)([^)#\s]+)\)")
CAPTIONS = {
    "fig1": "Fig. 1: image of the marker on a circle at 24 Hz, and its trajectory",
    "fig2": "Fig. 2: gradient image and centre of mass",
    "fig3": "Fig. 3: image processing against the simplified model, 5 Hz",
    "fig4": "Fig. 4: Model #1, first version",
    "fig5": "Fig. 5: Model #1, second version",
    "fig6": "Fig. 6: Bode diagrams of the three camera models",
    "fig7": "Fig. 7: estimation errors against the sampling period",
    "fig8": "Fig. 8: estimation errors due to a neglected mode",
}


def rows(name: str) -> list[dict[str, str]]:
    """Rows of a committed table."""
    with (RESULTS / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def claims() -> str:
    """Each figure of the paper with the claims that its target computes; then the claims without a figure."""
    found = rows("claims.csv")
    parts = []
    for target, caption in CAPTIONS.items():
        parts += [f"### {caption}", f"![{caption}](../paper_figs/{target}.png)"]
        parts += _claim_list([c for c in found if c["target"] == target])
    others = sorted({c["target"] for c in found} - set(CAPTIONS))
    for target in others:
        parts += [f"### Without a figure: target `{target}`", *_claim_list([c for c in found if c["target"] == target])]
    return "\n\n".join(parts)


def _claim_list(found: list[dict[str, str]]) -> list[str]:
    signs = {"reproduced": "success", "reproduced with a caveat": "warning"}
    return [
        f'!!! {signs.get(c["verdict"], "failure")} "{_quoted(c["claim"])} (section {c["section"]})"\n\n'
        f"    **{c['verdict'].capitalize()}.** {c['number']}"
        for c in found
    ]


def _quoted(text: str) -> str:
    return text.replace('"', "”")


def open_questions() -> str:
    """The second table of claims.md: what the paper leaves open."""
    text = (RESULTS / "claims.md").read_text(encoding="utf-8")
    return text.partition("What the paper leaves open:")[2].strip()


def ablations() -> str:
    """Each ablation: its conclusion and its figure."""
    parts = []
    for row in rows("ablations.csv"):
        target = row["target"]
        title = target.removeprefix("ablation_").replace("_", " ").capitalize()
        parts += [f"## {title}", row["conclusion"], f"![{title}](../paper_figs/{target}.png)", f"Target: `{target}`"]
    return "\n\n".join(parts)


def monte_carlo() -> str:
    """The sentence of the large Monte Carlo."""
    return (RESULTS / "monte_carlo.txt").read_text(encoding="utf-8").strip()


def proof() -> str:
    """The table of the sealed proof."""
    return (RESULTS / "concealed.md").read_text(encoding="utf-8").strip()


def second_proof() -> str:
    """The table of the second proof."""
    return (RESULTS / "second_author.md").read_text(encoding="utf-8").strip()


def third_proof() -> str:
    """The table of the proof in loops that are not declared."""
    return (RESULTS / "undeclared_loops.md").read_text(encoding="utf-8").strip()


def catalogue() -> str:
    """Every effect from its class: equation, parameters, source and picture, in the order of the chain."""
    drawn = {path.stem for path in PICTURES.glob("*.png")}
    parts = []
    for place in PLACES:
        parts.append(f"## {place.capitalize()}")
        kinds = [k for k in known_effects().values() if k.place == place and k.__module__.startswith("camid.")]
        for kind in sorted(kinds, key=lambda k: k.identifier):
            parts += [
                f"### {kind.title} {{#{kind.identifier}}}",
                f"`{kind.identifier}` – {(kind.__doc__ or '').strip().splitlines()[0]}",
                f'<div class="equation">{equation(kind.equation.replace(chr(10), " "))}</div>',
            ]
            if kind.parameters:
                lines = ["| parameter | unit | meaning |", "|---|---|---|"]
                for p in kind.parameters:
                    unit = " or ".join(p.choices) if p.choices else p.unit or "–"
                    lines.append(f"| `{p.name}` | {unit} | {p.meaning} |")
                parts.append("\n".join(lines))
            for law in kind.finer_laws:
                more = [p for p in law.parameters if p not in kind.parameters]
                keys = " and ".join(f"`{p.name}` ({p.unit}), {p.meaning}" for p in more)
                parts.append(f"With {keys}: {law.title[0].lower()}{law.title[1:]} ({law.reference}).")
                parts.append(f'<div class="equation">{equation(law.equation.replace(chr(10), " "))}</div>')
            if kind.identifier in drawn:
                parts.append(f"![{kind.title}: output with and without it](effects/{kind.identifier}.png)")
            parts.append(f"Source: {kind.reference}")
    return "\n\n".join(parts)


GENERATED: dict[str, Callable[[], str]] = {
    "ablations": ablations,
    "catalogue": catalogue,
    "claims": claims,
    "monte_carlo": monte_carlo,
    "open_questions": open_questions,
    "proof": proof,
    "second_proof": second_proof,
    "third_proof": third_proof,
    "simulation_keys": simulation_keys,
}


def on_files(files: Files, *, config: Any) -> Files:
    """Add the figures of paper_figs/, the examples and the pictures of the effects."""
    effect_pictures.save_all(PICTURES)
    for source, folder in ((RESULTS, "paper_figs"), (PICTURES, "effects")):
        for path in sorted(source.glob("*.png")):
            files.append(File.generated(config, f"{folder}/{path.name}", abs_src_path=str(path)))
    for path in sorted((ROOT / "examples").glob("*.*")):
        files.append(File.generated(config, f"examples/{path.name}", abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, *, page: Any, config: Any, files: Files) -> str:
    """Put in the generated parts, and lead links to files of the repository to where they are on the site."""
    markdown = MARK.sub(lambda match: GENERATED[match[1]](), markdown)
    folder = posixpath.dirname(page.file.src_uri)

    def on_site(match: re.Match[str]) -> str:
        target = match[4]
        if files.get_file_from_path(target) is not None:
            return f"{match[1]}[{match[2]}]({posixpath.relpath(target, folder or '.')})"
        if not (ROOT / target).exists():
            return match[0]  # the strict build reports it
        if match[2] == target:
            return f"`{target}`"
        return match[2] if match[2].startswith("`") else f"{match[2]} (`{target}`)"

    return OUTSIDE.sub(on_site, markdown)


def on_page_content(html: str, *, page: Any, config: Any, files: Files) -> str:
    """Take the roles of reStructuredText out of the docstrings."""
    return ROLE.sub("", html)
