"""The page of a diagnosis in a browser: it fits every width, zooms and reads values, and runs no script but its own."""

import html
import json
import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from camid.diagnosis.report import page as report
from tests.support import written_diagnoses

BROWSER = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
# Without one these tests fail: they belong to those of the workflow, whose machine has a browser.


MEASURE = """<script>
addEventListener("load", () => {
  const page = document.querySelector("iframe").contentDocument, all = (what) => [...page.querySelectorAll(what)];
  const shown = (e) => !e.closest(".picture") || getComputedStyle(e.closest(".picture")).display !== "none";
  const drawn = all("figure svg, svg.equation").filter(shown), labels = all("figure svg text").filter(shown);
  const sizes = [...drawn, ...all(".chain li")].map((e) => e.getBoundingClientRect());
  document.body.replaceChildren(JSON.stringify({
    title: page.title, width: page.defaultView.innerWidth, needed: page.documentElement.scrollWidth,
    drawings: drawn.length, empty: sizes.filter((s) => s.width < 5 || s.height < 5).length,
    labels: labels.length, unseen: labels.filter((t) => !t.getBBox().width).length,
    stray: all("main *").filter((e) => !e.closest(".formula") && shown(e)
      && e.getBoundingClientRect().right > page.defaultView.innerWidth + 0.5).length}));
});
</script>"""


def in_browser(page, folder, width, script=MEASURE):
    """What a browser makes of the page, measured from a frame of this width (a window is never narrower than 500)."""
    frame = f'<iframe style="width: {width}px; height: 900px; border: 0" srcdoc="{html.escape(page)}"></iframe>'
    (folder / "frame.html").write_text(f'<meta charset="utf-8">{frame}{script}', encoding="utf-8")
    assert BROWSER, "no Chromium is installed: install Debian's package chromium"
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}"]
    command += ["--hide-scrollbars", "--window-size=1400,1000", "--dump-dom", (folder / "frame.html").as_uri()]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    return json.loads(html.unescape(re.search(r"<body>(.*?)</body>", shown, re.DOTALL).group(1)))


@pytest.mark.workflow
@pytest.mark.parametrize(("width", "named"), [(1280, "usually"), (390, "badly")])
def test_a_browser_lays_it_out_without_scrolling_sideways(tmp_path, pages, hostile, width, named):
    seen = in_browser(pages["partly-explained"] if named == "usually" else hostile, tmp_path, width)
    assert (seen["width"], seen["needed"]) == (width, width)
    assert seen["drawings"] == 9 + 2
    assert seen["labels"] > 100
    assert (seen["empty"], seen["unseen"], seen["stray"]) == (0, 0, 0)
    assert seen["title"].startswith("Partly explained: diagnosis of ")


@pytest.mark.workflow
def test_the_browser_test_sees_a_page_that_is_too_wide(tmp_path, pages):
    page = pages["explained"].replace("overflow-wrap: anywhere;", "")
    page = page.replace("bench/run_07.csv", "a" * 200)
    assert in_browser(page, tmp_path, 390)["needed"] > 390


@pytest.mark.workflow
def test_the_page_forbids_scripts(tmp_path, pages):
    page = pages["explained"]
    script = "<script>document.title = 'run'</script></body>"
    assert in_browser(page.replace("</body>", script), tmp_path, 1280)["title"].startswith("Explained")


POINTING = """<script>
addEventListener("load", () => {
  const view = document.querySelector("iframe").contentWindow, page = view.document;
  const svg = page.querySelector("#fit .desk svg[data-axes]"), about = JSON.parse(svg.dataset.axes);
  const send = (kind, [x, y], more = {}) => {
    const p = new view.DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
    svg.dispatchEvent(new view.PointerEvent(kind, { clientX: p.x, clientY: p.y, bubbles: true, button: 0, ...more }));
  };
  const state = () => [...svg.querySelectorAll(".axes path, .axes use, .axes text")]
    .filter((e) => !e.closest("[style*='display: none']"))
    .map((e) => `${e.getAttribute("d")}${e.getAttribute("x")}${e.textContent}`).join(";");
  const ticks = () => [...svg.querySelectorAll(".xtick")].filter((g) => g.style.display !== "none")
    .map((g) => g.textContent.trim()).filter((t) => t);
  const [left, top, right, bottom] = about[1].box, middle = (top + bottom) / 2;
  send("pointerenter", [left + 5, middle]);
  const line = svg.querySelectorAll(".axes")[1].querySelector("[data-series=improved] path").getAttribute("d");
  const [x, y] = line.match(/-?[\\d.]+/g).slice(40, 42).map(Number);
  send("pointermove", [x, y]);
  const said = svg.closest(".picture").querySelector("output").textContent, before = state(), whole = ticks();
  send("pointerdown", [left + 0.25 * (right - left), middle]);
  send("pointermove", [left + 0.5 * (right - left), middle]);
  send("pointerup", [left + 0.5 * (right - left), middle]);
  const zoomed = ticks(), changed = state() !== before;
  svg.dispatchEvent(new view.MouseEvent("dblclick"));
  document.body.replaceChildren(JSON.stringify({ said, whole, zoomed, changed, back: ticks(), limits: about[1].x,
    values: [about[1].x[0] + (about[1].x[1] - about[1].x[0]) * (x - left) / (right - left),
      about[1].y[0] + (about[1].y[1] - about[1].y[0]) * (y - bottom) / (top - bottom)] }));
});
</script>"""
# Where labels end, beside what of them is seen.
LABELS = """<script>
addEventListener("load", () => {
  const page = document.querySelector("iframe").contentDocument, cut = [];
  for (const text of page.querySelectorAll("figure svg text")) {
    const [t, s] = [text, text.ownerSVGElement].map((e) => e.getBoundingClientRect());
    if (s.width && (t.left < s.left - 1 || t.right > s.right + 3 || t.top < s.top - 1 || t.bottom > s.bottom + 1))
      cut.push(text.textContent);
  }
  document.body.replaceChildren(JSON.stringify(cut));
});
</script>"""
PRINTED = """<script>
addEventListener("load", () => {
  const page = document.querySelector("iframe").contentDocument, view = page.defaultView;
  const edge = page.documentElement.clientWidth + 0.5, bar = view.getComputedStyle(page.querySelector(".weights i"));
  document.body.replaceChildren(JSON.stringify({ exact: bar.printColorAdjust, drawn: bar.backgroundImage,
    beyond: [...page.querySelectorAll("main *")].filter((e) => e.getBoundingClientRect().right > edge)
      .map((e) => e.className || e.tagName) }));
});
</script>"""


@pytest.mark.workflow
def test_dragging_zooms_and_pointing_reads_a_value(tmp_path, pages):
    seen = in_browser(pages["explained"], tmp_path, 1100, POINTING)
    low, high = seen["limits"]
    numbers = [float(text.replace("−", "-")) for text in seen["zoomed"]]
    quarter = 0.25 * (high - low)
    assert seen["changed"]
    assert len(numbers) >= 4
    assert low + quarter - 1e-9 <= min(numbers) < max(numbers) <= low + 2 * quarter + 1e-9
    assert seen["whole"] == seen["back"] != seen["zoomed"]
    name, time, value = re.fullmatch(r"(\S+): time (\S+) s; output (\S+) y", seen["said"]).groups()
    assert name in {"recorded", "improved", "re-estimated", "as given"}
    assert float(time) == pytest.approx(seen["values"][0], rel=1e-3)
    assert float(value.replace("−", "-")) == pytest.approx(seen["values"][1], abs=0.02)


@pytest.mark.workflow
@pytest.mark.parametrize("size", [1e-6, 1e7])
def test_no_label_is_cut_whatever_the_size_of_the_numbers(tmp_path, size):
    diagnosis = written_diagnoses.diagnosis("explained")
    scaled = {
        name: size * getattr(diagnosis.signals, name)
        for name in ("recorded", "nominal", "refitted", "improved", "position", "velocity")
    }
    signals = replace(diagnosis.signals, **scaled)
    shown = [replace(e, velocity=size * e.velocity, position=size * e.position) for e in diagnosis.effect_signals]
    page = report.render(replace(diagnosis, signals=signals, effect_signals=shown))
    for width in (1100, 390):
        assert in_browser(page, tmp_path, width, LABELS) == []


@pytest.mark.workflow
def test_on_paper_bars_are_filled_and_nothing_is_beyond_the_edge(tmp_path, pages):
    """The rules for paper, applied to a frame as wide as a sheet between its margins."""
    page = pages["partly-explained"].replace("@media print", "@media all").replace("@media screen", "@media print")
    seen = in_browser(page, tmp_path, 672, PRINTED)
    assert seen["exact"] == "exact"
    assert "gradient" in seen["drawn"]
    assert seen["beyond"] == []
