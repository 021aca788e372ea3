"""What the workflow promises, shown by running it in fresh copies."""

import platform
import re
import sys
from pathlib import Path

import pytest

from tests.support import ROOT

FIGURES = {f"fig{number}" for number in range(1, 9)}
DATASETS = {
    "excitation",
    "sampling_period_outputs",
    "noise",
    "neglected_mode_outputs",
    "marker_image",
    "marker_trajectory",
}
pytestmark = pytest.mark.workflow


def made_by_check(name):
    """Whether `check` makes a file of paper_figs: not those of all noise seeds, large proofs and real recordings."""
    others = ("monte_carlo", "concealed", "recording_", "second_author", "physical_rigs", "two_clocks", "filmed_rigs")
    others += ("designed_experiment", "unlisted", "undeclared_loops")
    return name.startswith("concealed_sample") or not name.startswith(others)


def test_fresh_clone_with_committed_figures_computes_all_of_them(computed):
    """The trap: figures that are there and whose data are missing look up to date to Snakemake."""
    assert {f"{f}.{kind}" for f in FIGURES for kind in ("png", "pdf", "csv")} <= set(computed.before)
    for name, stamp in computed.figures_before.items():
        if made_by_check(name):
            assert (computed.folder / "paper_figs" / name).stat().st_mtime_ns > stamp, name
    assert "0 failed" in computed.printed
    for dataset in ("excitation", "sampling_period", "noise", "neglected_mode", "marker_trajectory"):
        assert (computed.folder / f"results/datasets/{dataset}.parquet").is_file()


def test_file_target_and_named_target_alone_compute_in_a_fresh_clone(fresh):
    assert {"fig8", "neglected_mode", "excitation"} <= fresh.planned("paper_figs/fig8.png")
    assert {"fig7", "sampling_period", "noise"} <= fresh.planned("fig7")
    assert fresh.planned("all") >= FIGURES | DATASETS | {
        "claims",
        "ablations",
        "ablation_exposure",
        "monte_carlo_shard",
    }
    assert {"ablation_latency", "latency_runs"} == fresh.planned("paper_figs/ablation_latency.png")
    assert "monte_carlo_all_runs" in fresh.planned("monte_carlo")


def test_removed_results_are_computed_again(computed, tmp_path):
    kept = computed.folder / "results"
    moved = kept.rename(tmp_path / "results")
    try:
        assert computed.planned("all") >= FIGURES | DATASETS
    finally:
        (kept / ".working-copy").unlink()
        kept.rmdir()
        moved.rename(kept)


def test_second_run_does_nothing(computed):
    assert computed.planned("all") == set()
    assert computed.planned("check") == set()


def test_deleted_figure_takes_one_job(computed):
    (computed.folder / "paper_figs/fig4.png").unlink()
    assert computed.planned("fig4") == {"fig4"}
    computed.snakemake("paper_figs/fig4.png")
    assert (computed.folder / "paper_figs/fig4.png").read_bytes() == computed.before["fig4.png"]


@pytest.mark.parametrize(
    ("module", "rerun", "kept"),
    [
        ("src/camid/paper/fig8_neglected_mode/drawing.py", {"fig8"}, DATASETS | {"neglected_mode", "fig7"}),
        ("src/camid/ablations/latency/drawing.py", {"ablation_latency"}, {"latency_runs", "ablation_exposure", "fig7"}),
        (
            "src/camid/ablations/latency/runs.py",
            {"latency_runs"},
            {"exposure_runs", "monte_carlo_shard", "fig7"},
        ),
        ("src/camid/plotting.py", FIGURES, DATASETS | {"neglected_mode", "sampling_period"}),
        ("src/camid/identification/srivc.py", {"sampling_period", "neglected_mode", "fig7"}, DATASETS | {"fig6"}),
        (
            "src/camid/chain/exact.py",
            {"sampling_period_outputs", "neglected_mode_outputs"},
            {"excitation", "marker_image"},
        ),
        ("src/camid/chain/excitation.py", {"excitation", "noise", "fig7", "fig8"}, {"marker_image", "fig1", "fig6"}),
        ("src/camid/images/forming.py", {"marker_image", "marker_trajectory", "fig1", "fig3"}, {"excitation", "fig7"}),
    ],
)
def test_changed_source_reruns_the_rules_that_use_it_and_no_others(computed, module, rerun, kept):
    path = computed.folder / module
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "\nCHANGED = True\n", encoding="utf-8")
    try:
        planned = computed.planned("all")
    finally:
        path.write_text(text, encoding="utf-8")
    assert rerun <= planned
    assert not kept & planned


def test_changed_source_really_changes_the_result(computed):
    """Not only planned: the drawing code of the copy is what runs, and only its figure is drawn."""
    path = computed.folder / "src/camid/paper/fig6_camera_models/drawing.py"
    text = path.read_text(encoding="utf-8")
    stamp = (computed.folder / "paper_figs/fig7.png").stat().st_mtime_ns
    path.write_text(text.replace('"gain (dB)"', '"gain of the camera (dB)"'), encoding="utf-8")
    computed.snakemake("all")
    changed = computed.outputs()["fig6.png"]
    path.write_text(text, encoding="utf-8")
    computed.snakemake("all")
    assert changed != computed.before["fig6.png"]
    assert computed.outputs()["fig6.png"] == computed.before["fig6.png"]
    assert (computed.folder / "paper_figs/fig7.png").stat().st_mtime_ns == stamp


def test_changed_number_reruns_only_what_uses_it(computed):
    path = computed.folder / "config/config.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r"threshold: 0\.2 ", "threshold: 0.3 ", text), encoding="utf-8")
    try:
        planned = computed.planned("all")
    finally:
        path.write_text(text, encoding="utf-8")
    assert {"fig2", "marker_trajectory"} <= planned
    assert not planned & {"excitation", "sampling_period", "fig7", "fig8"}


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        ("config/config.yaml", "noise_samples:", "noise_sample:"),
        ("src/camid/ablations/past_shannon/settings.yaml", "nominal_error:", "nominal_eror:"),
    ],
)
def test_wrong_key_in_the_configuration_is_named(fresh, file, right, wrong):
    path = fresh.folder / file
    path.write_text(path.read_text(encoding="utf-8").replace(right, wrong), encoding="utf-8")
    printed = fresh.snakemake("-n", expect=1)
    assert wrong.rstrip(":") in printed


def test_second_clone_takes_its_datasets_from_the_cache(computed, fresh):
    printed = fresh.snakemake(
        "results/datasets/sampling_period.parquet", "results/datasets/marker_image.npz", cache=computed.cache
    )
    for name in ("excitation.parquet", "sampling_period.parquet", "marker_image.npz"):
        assert f"Symlinking output file results/datasets/{name} from cache" in printed
    assert "Moving output file" not in printed  # which is what happens to a file that was computed here
    for name in ("excitation.parquet", "sampling_period.parquet"):
        ours = (fresh.folder / "results/datasets" / name).read_bytes()
        assert ours == (computed.folder / "results/datasets" / name).read_bytes()


def test_one_core_gives_the_same_bytes_as_two(computed, fresh):
    """Two cold runs. The Monte Carlo, half of the work, is left out: tests of its own add up its shards."""
    ablations = [f"ablation_{name}" for name in ("exposure", "methods", "past_shannon")]
    fresh.snakemake(*sorted(FIGURES), "claims", *ablations, cores=1)
    names = [*FIGURES, "claims", *ablations]
    ours, theirs = fresh.outputs(), computed.outputs()
    compared = [n for n in ours if n.split(".")[0] in names]
    # Of the ablations there is no PDF.
    assert len(compared) == 3 * len(FIGURES) + 2 * len(ablations) + 2
    assert {n for n in compared if ours[n] != theirs[n]} == set()


@pytest.mark.skipif(
    platform.machine() not in {"x86_64", "AMD64"}, reason="the committed bytes are those of x86-64 processors"
)
def test_committed_results_are_those_of_the_workflow(computed):
    """Figures, tables and text that are committed must be, to the byte, what the committed code computes."""
    ours = {name: content for name, content in computed.outputs().items() if made_by_check(name)}
    committed = {name: content for name, content in computed.before.items() if made_by_check(name)}
    assert {Path(name).suffix for name in committed} == {".csv", ".md", ".pdf", ".png"}
    assert set(ours) == set(committed)
    assert {name for name in committed if ours[name] != committed[name]} == set()


def test_wrong_declaration_makes_check_fail(computed, fresh):
    """The datasets come from the cache; tests/paper/test_mutations.py has further mutations, without Snakemake."""
    path = fresh.folder / "config/config.yaml"
    text = path.read_text(encoding="utf-8")
    right = "{hold: foh, sensor: instant, shift: 1, methods: [srivc]}"
    assert text.count(right) == 1
    path.write_text(text.replace(right, right.replace("foh", "zoh")), encoding="utf-8")
    printed = fresh.snakemake("check_paper", cache=computed.cache, expect=1)
    failed = re.findall(r"FAIL │ \S+ +│ (\S+)", printed)
    assert "largest_error_foh-argument" in failed, printed


def test_lint_has_nothing_but_the_missing_containers(fresh):
    """One locked environment serves the whole workflow."""
    printed = fresh.snakemake("--lint", expect=None)
    titles = set(re.findall(r"^    \* (.*?):?$", printed, flags=re.MULTILINE))
    assert titles == {"Specify a conda environment or container for each rule."}


def test_report_holds_every_figure_with_its_caption_and_needs_no_network(computed):
    computed.snakemake("--report", "report.html")
    page = (computed.folder / "report.html").read_text(encoding="utf-8")
    for figure in sorted(FIGURES):
        assert f"{figure}.png" in page
    for phrase in ("Sobel gradient", "neglected mode", "second version"):
        assert phrase in page
    assert not re.findall(r'(?:src|href)="https?://[^"]+\.(?:js|css)"', page)
    # It opens at words, on a phone too: the graph of the rules stands below them in a frame of its own.
    assert "#rulegraph { max-width: 100%" in page
    assert "Figs. 7 and 8, errors of the estimates" in page


@pytest.mark.skipif("not __import__('os').environ.get('CAMID_RECORDINGS')", reason="CAMID_RECORDINGS is not set")
def test_silverbox_reaches_its_references(computed):
    """The linear models; what the diagnosis makes of the real recordings is guarded by `make check`."""
    import numpy as np
    import pandas as pd

    for hold, reference in (("zoh", 14.8), ("foh", 7.0)):
        file = f"results/recordings/silverbox_{hold}_multisine.csv"
        computed.snakemake(file, recordings=True)
        table = pd.read_csv(computed.folder / file)[50:]  # the official transient
        error = 1e3 * float(np.sqrt(np.mean((table["V2"] - table["simulated"]) ** 2)))
        assert error == pytest.approx(reference, abs=0.1)


def test_recording_that_cannot_be_found_is_one_clear_line(fresh, monkeypatch):
    monkeypatch.setenv("CAMID_RECORDINGS", "nowhere")
    printed = fresh.snakemake("recordings", expect=1, recordings=True)
    assert "camid: error: nowhere/silverbox.csv: no such file; correct or unset CAMID_RECORDINGS" in printed


def test_rules_are_formatted_files_that_the_snakefile_includes():
    included = set(re.findall(r'include: "workflow/rules/(\w+)\.smk"', (ROOT / "Snakefile").read_text()))
    assert included == {p.stem for p in (ROOT / "workflow/rules").glob("*.smk")}


def test_make_uses_the_cache_where_one_is_named(computed, fresh, monkeypatch):
    """`--cache` in front of a target would take it for the name of a rule, and nothing would be drawn."""
    import shutil
    import subprocess

    shutil.copy(ROOT / "Makefile", fresh.folder)
    shutil.copy(ROOT / "requirements.lock", fresh.folder)
    binaries = fresh.folder / ".venv/bin"
    binaries.mkdir(parents=True)
    (binaries / "snakemake").symlink_to(Path(sys.executable).parent / "snakemake")
    (fresh.folder / ".venv/.installed").touch()
    monkeypatch.setenv("SNAKEMAKE_OUTPUT_CACHE", str(computed.cache))
    monkeypatch.setenv("PYTHONPATH", str(fresh.folder / "src"))
    run = subprocess.run(["make", "all"], cwd=fresh.folder, capture_output=True, text=True, check=False)
    printed = run.stdout + run.stderr
    assert run.returncode == 0, printed
    assert printed.count("from cache") >= 6
    assert fresh.planned("all") == set()
