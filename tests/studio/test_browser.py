"""The page in a browser: the whole way from the example clip to the report, and what is refused on it.

These tests need the extra ``studio``, Playwright (requirements-browser.lock), and a Chromium: Debian's package, or the
one that CAMID_CHROMIUM names.
"""

import http.server
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import urllib.error
import urllib.request
import zipfile
from pathlib import Path

import pytest

from tests.support import ROOT

pytestmark = pytest.mark.workflow

# Milliseconds: for one command, and for a diagnosis, on a busy machine.
SOON, LATE = 120_000, 600_000
# Of a phone, and of a desktop.
PHONE, DESKTOP = {"width": 390, "height": 844}, {"width": 1200, "height": 900}
# Runs the command, and writes down every host that Python is about to look up or to connect to.
AUDITED = """
import sys
from camid.cli import main
def noted(event, values):
    if event in {"socket.connect", "socket.getaddrinfo"}:
        with open(sys.argv[1], "a", encoding="utf-8") as file:
            print(event, values[1:] if event == "socket.connect" else values, file=file)
sys.addaudithook(noted)
sys.exit(main(sys.argv[2:]))
"""
HOSTILE = "<img src=x onerror=alert(1)>"


class Studio:
    """A running ``camid studio``."""

    def __init__(self, folder, *arguments):
        self.hosts = folder / "hosts.txt"
        self.process = subprocess.Popen(
            [sys.executable, "-c", AUDITED, self.hosts, "studio", "--no-browser", *arguments],
            cwd=folder,
            env={**os.environ, "TMPDIR": str(folder), "PYTHONPATH": str(ROOT / "src")},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        line = self.process.stdout.readline()
        self.address = re.fullmatch(r"camid studio: (http://127\.0\.0\.1:\d+/\?token=\S+)\n", line)[1]
        self.origin = self.address.partition("/?")[0]

    def end(self, sign=signal.SIGINT):
        """What it printed since it started."""
        self.process.send_signal(sign)
        try:
            return self.process.communicate(timeout=60)[0]
        finally:
            self.process.kill()

    def status(self, path="/", **headers):
        request = urllib.request.Request(self.origin + path, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=30) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            return error.code


@pytest.fixture
def studio(tmp_path):
    running = Studio(tmp_path)
    yield running
    running.end()


@pytest.fixture(scope="module")
def chromium():
    from playwright.sync_api import sync_playwright

    names = ("chromium", "chromium-browser", "google-chrome")
    path = os.environ.get("CAMID_CHROMIUM") or next(filter(None, map(shutil.which, names)), None)
    assert path, "no Chromium: apt-get install chromium, or name it in CAMID_CHROMIUM"
    with sync_playwright() as playwright:
        # No host but this one has an address.
        arguments = ["--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"]
        browser = playwright.chromium.launch(executable_path=path, args=arguments)
        yield browser
        browser.close()


class Tab:
    """A tab that remembers what it asked for, what it complained of, and whether a script of others ran."""

    def __init__(self, chromium, studio, **options):
        self.context = chromium.new_context(viewport=DESKTOP, **options)
        self.page = self.context.new_page()
        self.page.set_default_timeout(SOON)
        self.requested, self.complaints, self.dialogs = [], [], []
        self.context.on("request", lambda request: self.requested.append(request.url))
        self.page.on("websocket", lambda socket: self.requested.append(socket.url))
        self.page.on("console", lambda m: self.complaints.append(m.text) if m.type in {"error", "warning"} else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.dialogs.append(dialog.message), dialog.dismiss()))
        self.page.goto(studio.address)
        self.step("recording").wait_for()

    def step(self, name, inside=""):
        return self.page.locator(f"#{name} {inside}".strip())

    def drop(self, path):
        self.page.set_input_files("#recording input[type=file]", path)

    def press(self, name):
        self.page.get_by_role("button", name=name, exact=True).click()

    def fill(self, label, value):
        field = self.page.get_by_label(label, exact=True)
        field.fill(value)
        field.press("Tab")

    def rest(self, step):
        """Wait until nothing runs in a step."""
        self.step(step, ".studio-progress").wait_for(state="detached")

    def click_image(self, x, y, size=(240, 96)):
        """Click on the frame at a pixel of the clip."""
        frame = self.step("marker", ".studio-frame img").first
        box = frame.bounding_box()
        frame.click(position={"x": x * box["width"] / size[0], "y": y * box["height"] / size[1]}, force=True)


@pytest.fixture
def tab(chromium, studio):
    opened = Tab(chromium, studio)
    yield opened
    foreign = [u for u in opened.requested if not re.match(rf"(https?|ws)://{studio.origin[7:]}/|data:|blob:", u)]
    assert foreign == []
    assert opened.dialogs == []
    opened.context.close()


def track(tab):
    """The marker by its colour, the region by two corners, the scale by two clicks and a length."""
    tab.drop(ROOT / "examples/pendulum.mp4")
    tab.page.get_by_text("Found: what moves").wait_for()
    tab.page.get_by_text("Colour: a point on the marker").click()
    tab.click_image(207, 65)
    tab.page.get_by_text(re.compile(r"Found: the colour #[0-9a-f]{6} at x 207\.\d, y 64\.\d px")).wait_for()
    tab.page.get_by_text("Region: two opposite corners").click()
    tab.click_image(180, 40)
    tab.page.get_by_text("First point taken; now the opposite corner.").wait_for()
    tab.click_image(235, 90)
    tab.page.wait_for_function("document.querySelector('#marker [aria-label=Region]').value.startsWith('180 40 5')")
    tab.rest("marker")
    tab.page.get_by_text("Scale: two points").click()
    tab.click_image(20, 50)
    tab.page.get_by_text("now the other end of the line").wait_for()
    tab.click_image(220, 50)
    tab.page.get_by_text(re.compile(r"The line is (199|200)\.\d px long")).wait_for()
    tab.fill("Length of the line", "100")
    tab.press("Track the marker")
    tab.page.get_by_text(re.compile(r"360 of 360 frames with the marker .* positions in mm")).wait_for()
    tab.step("marker", ".studio-picture img").wait_for()


def test_the_whole_way_from_the_clip_to_the_report(tab, studio, tmp_path):
    track(tab)
    # The draft, corrected in the form, with its chain.
    chain = tab.step("simulation", ".studio-chain")
    chain.wait_for()
    assert "exposure: the period" in chain.inner_text()
    tab.fill("Exposure in s", "0.02")
    chain.get_by_text("exposure 0.02 s").wait_for()
    tab.press("Identify")
    tab.step("identify", ".studio-table").get_by_text("natural frequency").wait_for()
    tab.step("identify", ".studio-picture img").wait_for()
    tab.press("Diagnose")
    tab.step("diagnose", ".studio-progress").wait_for()
    assert studio.status() == 403  # the server answers while the diagnosis runs
    tab.step("diagnose", "iframe").wait_for(timeout=LATE)
    report = tab.page.frame_locator("#diagnose iframe")
    report.get_by_text("Coulomb friction").first.wait_for()
    assert report.get_by_text("pendulum.csv").count() > 0
    # What is downloaded is what was written; nothing was complained of on the way.
    with tab.page.expect_download() as arriving:
        tab.page.get_by_text("All of them (ZIP)").click()
    with zipfile.ZipFile(arriving.value.path()) as archive:
        names = set(archive.namelist())
        found = json.loads(archive.read("diagnosis/diagnosis.json"))
        simulation = archive.read("simulation.yaml").decode()
    assert {"pendulum.csv", "model.yaml", "diagnosis/report.html", "diagnosis/improved.yaml"} <= names
    assert found["verdict"] == "explained"
    assert "exposure: 0.02" in simulation
    # Another tab, at another time, sees the same.
    tab.page.reload()
    tab.step("diagnose", "iframe").wait_for()
    assert tab.complaints == []
    for scheme in ("light", "dark"):
        tab.page.emulate_media(color_scheme=scheme)
        tab.page.set_viewport_size(PHONE)
        assert tab.page.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
    assert not outside(studio)


def outside(studio):
    """Hosts that Python wanted to talk to, this one left out."""
    lines = studio.hosts.read_text(encoding="utf-8").splitlines() if studio.hosts.exists() else []
    return [line for line in lines if "127.0.0.1" not in line]


def test_names_of_columns_and_lines_of_errors_are_text(tab, tmp_path):
    rows = (ROOT / "examples/slide.csv").read_text(encoding="utf-8").splitlines()
    (tmp_path / "rows.csv").write_text("\n".join([f"t,{HOSTILE},y", *rows[1:400]]), encoding="utf-8")
    tab.drop(tmp_path / "rows.csv")
    tab.page.get_by_text(f"Columns: t, {HOSTILE}, y").wait_for()
    tab.step("simulation", ".studio-chain").get_by_text(HOSTILE).wait_for()
    tab.press("Identify")
    tab.step("identify", ".studio-table").wait_for()
    tab.page.get_by_text("As text (YAML)").click()
    area = tab.page.locator("#simulation textarea").first
    area.fill(f"schema: 1\n'{HOSTILE}': 1\n")
    tab.press("Use this text")
    error = tab.step("simulation", "[role=alert]")
    error.wait_for()
    assert error.inner_text().startswith("simulation.yaml")
    assert HOSTILE in error.inner_text()
    assert tab.page.locator("img[src=x]").count() == 0
    (tmp_path / "bad.csv").write_text(f"{HOSTILE}\n", encoding="utf-8")
    tab.drop(tmp_path / "bad.csv")
    error = tab.step("recording", "[role=alert]")
    error.wait_for()
    assert error.inner_text().startswith("bad.csv: ")
    assert "Traceback" not in tab.page.content()


def test_a_diagnosis_is_cancelled(tab):
    tab.drop(ROOT / "examples/slide.csv")
    tab.step("simulation", ".studio-chain").wait_for()
    tab.press("Diagnose")
    tab.step("diagnose", ".studio-progress").wait_for()
    tab.press("Cancel")
    tab.step("diagnose").get_by_text("cancelled; no file is half-written").wait_for()
    tab.press("Identify")  # and another command can be run
    tab.step("identify", ".studio-table").wait_for()


def test_a_large_file_is_refused_with_a_line(chromium, tmp_path):
    studio = Studio(tmp_path, "--largest-upload", "1")
    try:
        tab = Tab(chromium, studio)
        (tmp_path / "large.csv").write_text("t,u,y\n" * 300_000, encoding="utf-8")
        tab.drop(tmp_path / "large.csv")
        error = tab.step("recording", "[role=alert]")
        error.wait_for()
        assert error.inner_text() == "this file is larger than 1 MB; start camid studio with a larger --largest-upload"
        # What passes by the page is refused by the server.
        answer = tab.context.request.post(f"{studio.origin}/any", data=b"x" * 1_500_000)
        assert answer.status == 413
        tab.context.close()
    finally:
        studio.end()


def test_pages_of_other_origins_reach_nothing(chromium, studio, tmp_path):
    """Another port of this computer, with the cookie of the page in the same browser."""

    class Silent(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    (tmp_path / "index.html").write_text("<title>other</title>", encoding="utf-8")
    handler = lambda *a: Silent(*a, directory=str(tmp_path))  # noqa: E731
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        tab = Tab(chromium, studio)
        evil = tab.context.new_page()
        evil.goto(f"http://127.0.0.1:{other.server_address[1]}/index.html")
        socket = studio.origin.replace("http", "ws") + "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
        opened = evil.evaluate(
            "url => new Promise(done => { const s = new WebSocket(url);"
            " s.onopen = () => done('open'); s.onerror = () => done('refused'); })",
            socket,
        )
        assert opened == "refused"
        answers = []
        evil.on("response", lambda response: answers.append((response.request.method, response.status)))
        for method in ("GET", "POST"):
            evil.evaluate(
                "([url, method]) => fetch(url, {method, mode: 'no-cors', credentials: 'include'}).catch(() => 0)",
                [studio.origin + "/", method],
            )
        framed = evil.evaluate(
            "url => new Promise(done => { const f = document.createElement('iframe'); f.src = url;"
            " f.onload = () => done(true); document.body.append(f); })",
            studio.origin + "/",
        )
        assert framed
        other.shutdown()
        assert answers == [("GET", 403), ("POST", 403), ("GET", 403)]
        tab.context.close()


def test_without_the_token_or_under_another_name_nobody_is_let_in(studio):
    port = studio.origin.rpartition(":")[2]
    assert studio.status() == 403
    assert studio.status("/?token=guessed") == 403
    assert studio.status("/_nicegui_ws/socket.io/?EIO=4&transport=polling") == 403
    assert studio.status("/?" + studio.address.partition("?")[2], Host=f"evil.example:{port}") == 403
    assert studio.status("/openapi.json") == 403


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_files_go_with_the_studio(sign, chromium, tmp_path):
    studio = Studio(tmp_path)
    tab = Tab(chromium, studio)
    tab.drop(ROOT / "examples/slide.csv")
    tab.page.get_by_text("Columns: t, u, y").wait_for()
    (folder,) = tmp_path.glob("camid-studio-*")
    assert folder.stat().st_mode & 0o777 == 0o700
    assert (folder / "slide.csv").is_file()
    printed = studio.end(sign)
    tab.context.close()
    assert printed.endswith("ended; uploaded files and results are removed\n")
    assert "Traceback" not in printed
    assert studio.process.returncode == 0
    assert not folder.exists()


def test_a_folder_keeps_what_was_uploaded(chromium, tmp_path):
    studio = Studio(tmp_path, "--folder", "kept")
    tab = Tab(chromium, studio)
    tab.drop(ROOT / "examples/slide.csv")
    tab.step("simulation", ".studio-chain").wait_for()
    printed = studio.end()
    tab.context.close()
    assert printed.endswith("ended; the files are in kept\n")
    kept = Path(tmp_path / "kept")
    assert kept.stat().st_mode & 0o777 == 0o700
    assert sorted(p.name for p in kept.iterdir()) == ["simulation.yaml", "slide.csv"]
