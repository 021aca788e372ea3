"""The page of a diagnosis in a browser: it fits every width, zooms and reads values, and runs no script but its own."""

import html
import json
import re
import shutil
import subprocess

import pytest

from camid.diagnosis.report import page as report
from camid.diagnosis.report import summary
from tests.diagnosis.test_report import HOSTILE
from tests.support import written_diagnoses

BROWSER = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed: the layout was not looked at")


@pytest.fixture(scope="module")
def pages():
    return {verdict: report.render(written_diagnoses.diagnosis(verdict)) for verdict in summary.VERDICT_WORDS}


@pytest.fixture(scope="module")
def hostile():
    return report.render(written_diagnoses.diagnosis("partly-explained", **HOSTILE))


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


def in_browser(page, folder, width):
    """What a browser makes of the page, measured from a frame of this width (a window is never narrower than 500)."""
    frame = f'<iframe style="width: {width}px; height: 900px; border: 0" srcdoc="{html.escape(page)}"></iframe>'
    (folder / "frame.html").write_text(f'<meta charset="utf-8">{frame}{MEASURE}', encoding="utf-8")
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}"]
    command += ["--hide-scrollbars", "--window-size=1400,1000", "--dump-dom", (folder / "frame.html").as_uri()]
    shown = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    return json.loads(html.unescape(re.search(r"<body>(.*?)</body>", shown, re.DOTALL).group(1)))


@needs_browser
@pytest.mark.parametrize(("width", "named"), [(1280, "usually"), (390, "badly")])
def test_a_browser_lays_it_out_without_scrolling_sideways(tmp_path, pages, hostile, width, named):
    seen = in_browser(pages["partly-explained"] if named == "usually" else hostile, tmp_path, width)
    assert (seen["width"], seen["needed"]) == (width, width)
    assert seen["drawings"] == 9 + 2
    assert seen["labels"] > 100
    assert (seen["empty"], seen["unseen"], seen["stray"]) == (0, 0, 0)
    assert seen["title"].startswith("Partly explained: diagnosis of ")


@needs_browser
def test_the_browser_test_sees_a_page_that_is_too_wide(tmp_path, pages):
    page = pages["explained"].replace("overflow-wrap: anywhere;", "")
    page = page.replace("bench/run_07.csv", "a" * 200)
    assert in_browser(page, tmp_path, 390)["needed"] > 390


@needs_browser
def test_the_page_forbids_scripts(tmp_path, pages):
    page = pages["explained"]
    script = "<script>document.title = 'run'</script></body>"
    assert in_browser(page.replace("</body>", script), tmp_path, 1280)["title"].startswith("Explained")
