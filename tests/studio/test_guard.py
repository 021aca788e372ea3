"""Other hosts, other origins, other users and large uploads are refused before the page hears of them."""

import asyncio

import pytest

from camid.studio.guard import ROOM, Guard

HOST = ("host", "127.0.0.1:8000")


class Page:
    """Stands for the framework: reads the body, answers 200, and remembers that it was asked."""

    def __init__(self):
        self.asked = 0

    async def __call__(self, scope, receive, send):
        self.asked += 1
        if scope["type"] == "websocket":
            await send({"type": "websocket.accept"})
            return
        while True:
            message = await receive()
            if message["type"] == "http.disconnect":
                raise ConnectionError("the client went away")
            if not message.get("more_body"):
                break
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"page"})


@pytest.fixture
def guard():
    return Guard(Page(), 8000, 1_000_000)


def ask(guard, *headers, path="/", query="", method="GET", kind="http", body=(b"",)):
    """Status, headers and text of the answer."""
    scope = {"type": kind, "method": method, "path": path, "query_string": query.encode()}
    scope["headers"] = [(name.encode(), value.encode("latin-1")) for name, value in headers]
    parts = [{"type": "http.request", "body": b, "more_body": k < len(body) - 1} for k, b in enumerate(body)]
    waiting = [{"type": "websocket.connect"}] if kind == "websocket" else parts
    sent = []

    async def receive():
        return waiting.pop(0)

    async def send(message):
        sent.append(message)

    asyncio.run(guard(scope, receive, send))
    if kind == "websocket":
        return sent[0]["type"]
    found = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
    return sent[0]["status"], found, b"".join(m.get("body", b"") for m in sent[1:]).decode()


def cookie(guard):
    return ("cookie", f"other=1; {guard.cookie}={guard.token}")


def test_the_token_of_the_terminal_opens_the_page_once(guard):
    status, headers, _ = ask(guard, HOST, query=f"token={guard.token}")
    assert (status, headers["location"]) == (303, "/")
    assert headers["set-cookie"] == f"{guard.cookie}={guard.token}; Path=/; HttpOnly; SameSite=Strict"
    assert guard.app.asked == 0
    assert ask(guard, HOST, cookie(guard))[::2] == (200, "page")


@pytest.mark.parametrize("given", ["", "token=", "token=wrong", "token=%ff", "token"])
def test_without_the_token_nobody_is_let_in(guard, given):
    status, _, line = ask(guard, HOST, query=given)
    assert (status, line) == (403, "camid studio: open the address that camid studio printed: it holds the token\n")
    assert ask(guard, HOST, ("cookie", f"{guard.cookie}=wrong"))[0] == 403
    assert ask(guard, HOST, ("cookie", f"camid-studio-8001={guard.token}"))[0] == 403
    assert ask(guard, HOST, kind="websocket") == "websocket.close"
    assert guard.app.asked == 0


@pytest.mark.parametrize(
    "host", ["evil.example:8000", "127.0.0.1", "127.0.0.1:8001", "[::1]:8000", "127.0.0.1:8000.x", ""]
)
def test_another_host_is_refused_even_with_the_token(guard, host):
    """What DNS rebinding looks like: the name is the attacker's, the address is this one's."""
    for path in ("/", f"{guard.files}diagnosis/report.html"):
        status, _, line = ask(guard, ("host", host), cookie(guard), path=path, query=f"token={guard.token}")
        assert status == 403
        assert line == f"camid studio: this is not the host {host!r}: open http://127.0.0.1:8000/\n"
    assert ask(guard, ("host", host), cookie(guard), kind="websocket") == "websocket.close"
    assert guard.app.asked == 0


@pytest.mark.parametrize(
    "header",
    [
        ("origin", "http://evil.example"),
        ("origin", "null"),
        ("origin", "http://127.0.0.1:8001"),
        ("origin", "https://127.0.0.1:8000"),
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-site", "same-site"),
    ],
)
def test_other_origins_are_refused_even_with_the_cookie(guard, header):
    status, _, line = ask(guard, HOST, cookie(guard), header, method="POST")
    assert status == 403
    assert line.startswith("camid studio: requests from ")
    assert ask(guard, HOST, cookie(guard), header, kind="websocket") == "websocket.close"
    assert guard.app.asked == 0


def test_the_own_origin_is_let_in_under_both_names(guard):
    for name in ("127.0.0.1:8000", "localhost:8000"):
        headers = (("host", name), cookie(guard), ("origin", f"http://{name}"), ("sec-fetch-site", "same-origin"))
        assert ask(guard, *headers, method="POST")[0] == 200
        assert ask(guard, *headers, kind="websocket") == "websocket.accept"


def test_files_need_their_address_and_no_cookie(guard):
    """A report is shown in a frame without an origin, whose links send no cookie."""
    headers = (HOST, ("sec-fetch-site", "cross-site"), ("origin", "null"))
    status, found, _ = ask(guard, *headers, path=f"{guard.files}diagnosis/residuals.csv")
    assert status == 200
    assert found["content-security-policy"].startswith(
        "sandbox allow-scripts allow-downloads allow-popups; default-src 'none'"
    )
    assert ask(guard, *headers, path=f"{guard.files}report.html", method="POST")[0] == 403
    assert ask(guard, *headers, path="/files/guessed/report.html")[0] == 403


def test_a_page_may_load_from_this_server_alone(guard):
    _, headers, _ = ask(guard, HOST, cookie(guard))
    policy = dict(part.strip().split(" ", 1) for part in headers["content-security-policy"].split(";"))
    allowed = {source for sources in policy.values() for source in sources.split()}
    assert {a for a in allowed if "/" in a} == {"ws://127.0.0.1:8000", "ws://localhost:8000"}
    assert policy["default-src"] == "'self'"
    assert policy["frame-ancestors"] == "'none'"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["x-content-type-options"] == "nosniff"


LINE = "camid studio: this file is larger than 1 MB; start camid studio with a larger --largest-upload\n"


def test_a_large_upload_is_refused_before_it_is_read(guard):
    status, _, line = ask(guard, HOST, cookie(guard), ("content-length", str(1_000_001 + ROOM)), method="POST")
    assert (status, line) == (413, LINE)
    assert ask(guard, HOST, cookie(guard), ("content-length", "-1"), method="POST")[0] == 413
    assert guard.app.asked == 0


def test_an_upload_that_does_not_say_its_length_is_counted(guard):
    status, _, line = ask(guard, HOST, cookie(guard), method="POST", body=[b"x" * 300_000] * 4)
    assert (status, line) == (413, LINE)
    assert ask(guard, HOST, cookie(guard), method="POST", body=[b"x" * 300_000] * 3)[0] == 200
