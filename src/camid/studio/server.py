"""The server behind the page: on 127.0.0.1 alone, with its files in a folder that nobody else can read."""

from __future__ import annotations

import asyncio
import io
import os
import shutil
import signal
import socket
import tempfile
import webbrowser
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from camid.errors import InputError, need
from camid.studio.guard import Guard
from camid.studio.project import FRAME, Project
from camid.studio.work import Work

HOST = "127.0.0.1"
# Of the framework and of uploads on their way; within the project's folder, which is private.
SCRATCH = ".studio"


@contextmanager
def project_folder(kept: Path | None) -> Iterator[Path]:
    """A folder of mode 700: the one that is kept, or a temporary one that is removed at the end.

    Raises
    ------
    InputError
        If the one that is kept holds something already, or cannot be made.
    """
    if kept is None:
        with tempfile.TemporaryDirectory(prefix="camid-studio-", ignore_cleanup_errors=True) as made:
            yield Path(made).resolve()
        return
    if kept.exists() and (not kept.is_dir() or any(kept.iterdir())):
        raise InputError("this folder is not empty", where=str(kept), hint="name a new one, or an empty one")
    if not kept.resolve().parent.is_dir():
        raise InputError("no such folder", where=str(kept.resolve().parent), hint="make it, or name another")
    kept.mkdir(mode=0o700, exist_ok=True)
    kept.chmod(0o700)
    try:
        yield kept.resolve()
    finally:
        shutil.rmtree(kept / SCRATCH, ignore_errors=True)


def serve(
    *, port: int, folder: Path | None, largest_upload: int, browser: bool, say: Callable[[str], None] = print
) -> None:
    """Serve the page until Ctrl-C.

    Parameters
    ----------
    port : int
        0 for any that is free.
    folder : Path or None
        Keeps uploaded files and results; None for a temporary one.
    largest_upload : int
        Bytes.
    browser : bool
        Whether to open the page.
    say : callable
        Prints a line.

    Raises
    ------
    InputError
        If the extra ``studio`` is not installed, the port is taken, or the folder holds something.
    """
    need("camid studio", "studio")
    listener = _listener(port)
    with listener, project_folder(folder) as private:
        scratch = private / SCRATCH
        scratch.mkdir(mode=0o700)
        # Uploads are spooled, and the framework keeps a folder, where nobody else reads them.
        tempfile.tempdir = str(scratch)
        os.environ["NICEGUI_STORAGE_PATH"] = str(scratch)
        # FastAPI can report to a host that such variables name.
        os.environ |= {"FASTAPI_OTEL_AUTO_CONFIGURE": "false", "OTEL_SDK_DISABLED": "true"}
        os.umask(0o077)
        try:
            _run(listener, Work(Project(private)), largest_upload, browser, say)
        finally:
            tempfile.tempdir = None
    say("ended; " + (f"the files are in {folder}" if folder is not None else "uploaded files and results are removed"))


def _listener(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((HOST, port))
        listener.listen()  # who comes before the server is ready waits
    except OSError as error:
        listener.close()
        raise InputError(f"port {port}: {error.strerror}", hint="name another --port, or 0 for any") from None
    return listener


def _run(listener: socket.socket, work: Work, largest_upload: int, browser: bool, say: Callable[[str], None]) -> None:
    import uvicorn

    class Server(uvicorn.Server):
        """Ends what runs while there is a loop to end it in: afterwards uvicorn raises the signal again."""

        async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
            await work.close()
            await super().shutdown(sockets)

    guard = Guard(_application(work), listener.getsockname()[1], largest_upload)
    _page(work, guard)
    server = Server(
        uvicorn.Config(guard, log_level="error", access_log=False, timeout_graceful_shutdown=1, server_header=False)
    )
    address = f"http://{HOST}:{guard.port}/?token={guard.token}"
    say(f"camid studio: {address}")
    say("It answers this computer alone. Ctrl-C ends it.")
    if browser:
        webbrowser.open(address)
    for sign in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(sign, lambda *_: setattr(server, "should_exit", True))
    # uvicorn raises again what ended it, after its own shutdown; here it has been answered then.
    with suppress(KeyboardInterrupt):
        asyncio.run(server.serve(sockets=[listener]))


def _application(work: Work) -> Any:
    """An application of FastAPI around the framework's, which serves the files of the project as well."""
    from fastapi import FastAPI
    from nicegui import ui

    application = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    ui.run_with(
        application,
        title="camid studio",
        favicon=_FAVICON,
        dark=None,
        tailwind=False,
        show_welcome_message=False,
        language="en-US",
    )
    return application


_FAVICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 16 16"><rect width="16" height="16" rx="3" fill="#0072B2"/>'
    '<path d="M2 8q2-7 4 0t4 0 4 0" fill="none" stroke="white" stroke-width="1.6"/></svg>'
)


def _page(work: Work, guard: Guard) -> None:
    """Say what the server answers: the page, and files under an address that only the page knows."""
    from nicegui import app, ui
    from starlette.requests import Request
    from starlette.responses import FileResponse, PlainTextResponse, Response

    from camid.studio.page import Page
    from camid.studio.step_files import ARCHIVE

    @ui.page("/")
    def page() -> None:
        Page(work, guard).build()

    async def file(request: Request) -> Response:
        name, project = request.path_params["name"], work.project
        headers = {"Cache-Control": "no-store"}
        if name == ARCHIVE:
            headers["Content-Disposition"] = f"attachment; filename={ARCHIVE}"
            data = await asyncio.to_thread(_archive, project)
            return Response(data, media_type="application/zip", headers=headers)
        if name not in {*project.files(), FRAME}:
            return PlainTextResponse("camid studio: there is no such file\n", status_code=404)
        shown = Path(name).suffix in {".png", ".html"} and "download" not in request.query_params
        return FileResponse(
            project.folder / name,
            filename=Path(name).name,
            content_disposition_type="inline" if shown else "attachment",
            headers=headers,
        )

    app.add_route(f"{guard.files}{{name:path}}", file)


def _archive(project: Project) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in project.files():
            archive.write(project.folder / name, name)
    return packed.getvalue()
