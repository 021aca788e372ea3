"""``camid diagnose``."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from camid.cli.shared import FromZero, own_effects_option, progress_display, warn
from camid.diagnosis.watch import EFFORT, TIME_LIMIT
from camid.errors import need

if TYPE_CHECKING:
    from camid.commands.results import DiagnosisResult

# Of what a diagnosis holds; named and not imported, which would take as long as all else before.
HELD = ("camid.commands.results", "camid.diagnosis.remaining_hypotheses", "camid.analysis.diagnosed_responses")


@click.command(short_help="Find, name and model what a simulation leaves out.")
@click.argument("recording", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--simulation", type=click.Path(path_type=Path), required=True, help="What you believe of the rig (YAML)."
)
@click.option(
    "--output", type=click.Path(path_type=Path), required=True, help="Folder for the results; created if missing."
)
@own_effects_option
@click.option("--report/--no-report", default=True, show_default=True, help="Also write report.html.")
@click.option(
    "--time-limit",
    type=FromZero(),
    default=TIME_LIMIT,
    show_default=True,
    help="Seconds after which nothing new is tried; 0 for no limit.",
)
@click.option(
    "--effort",
    type=FromZero(),
    default=EFFORT,
    show_default=True,
    help="How much is simulated before nothing new is tried, in multiples of the usual; 0 for no bound.",
)
@click.option("--json", "as_json", is_flag=True, help="Print diagnosis.json.")
def diagnose(
    *,
    recording: tuple[Path, ...],
    simulation: Path,
    output: Path,
    effects: tuple[Path, ...],
    report: bool,
    time_limit: float,
    effort: float,
    as_json: bool,
) -> None:
    """Find, name and model what a simulation leaves out of one or several RECORDINGs of a rig.

    All recordings are fitted, and a fifth of each validates, unless the simulation says which rows do.
    """
    from camid.diagnosis.report.beside import PageDrawnBeside

    if report:
        need("report.html", "plots", hint="or say --no-report")
    with ExitStack() as stack:
        drawn_beside = stack.enter_context(PageDrawnBeside(*HELD)) if report else None
        from camid.diagnosis.results_folder import RESULTS, write_diagnosis
        from camid.writing import check_folder, without_infinities

        check_folder(output, RESULTS, [*recording, simulation, *effects])
        progress = stack.enter_context(progress_display(as_json))
        from camid.commands.diagnose import diagnose as run

        result = run(
            list(recording),
            simulation,
            progress=progress,
            time_limit=time_limit or None,
            effort=effort or None,
            effects=effects,
        )
        limits = {"--time-limit": (time_limit, TIME_LIMIT), "--effort": (effort, EFFORT)}
        result = _with_command(result, recording, simulation, output, effects, limits)
        written = write_diagnosis(result, output, report=report, drawn_beside=drawn_beside)
    if as_json:
        click.echo(json.dumps(without_infinities(result.to_mapping()), indent=2))
    else:
        from camid.diagnosis.report.summary import print_summary

        print_summary(result, written)
    for sentence in result.warnings:
        warn(sentence)


def _with_command(
    result: DiagnosisResult,
    recordings: Sequence[Path],
    simulation: Path,
    output: Path,
    effects: Sequence[Path],
    limits: Mapping[str, tuple[float, float]],
) -> DiagnosisResult:
    """The result with what was typed, as far as it changes what is found."""
    words = ["camid", "diagnose", *map(str, recordings), "--simulation", str(simulation), "--output", str(output)]
    words += [word for path in effects for word in ("--effects", str(path))]
    for option, (value, usual) in limits.items():
        words += [] if value == usual else [option, f"{value:g}"]
    if result.provenance is None:
        return result
    return replace(result, provenance=replace(result.provenance, command=shlex.join(words)))
