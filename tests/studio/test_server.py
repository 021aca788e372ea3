"""The folder of the studio is private and goes with it; what cannot be served is said in one line."""

import socket
import stat

import pytest

from camid.errors import InputError
from camid.studio import server
from camid.studio.server import project_folder, serve


def mode(path):
    return stat.S_IMODE(path.stat().st_mode)


def test_files_lie_in_a_private_folder_that_is_removed():
    with project_folder(None) as folder:
        assert mode(folder) == 0o700
        (folder / "slide.csv").write_text("t,u,y\n", encoding="utf-8")
    assert not folder.exists()


def test_a_folder_that_is_named_is_kept(tmp_path):
    with project_folder(tmp_path / "kept") as folder:
        assert mode(folder) == 0o700
        (folder / "slide.csv").write_text("t,u,y\n", encoding="utf-8")
        (folder / server.SCRATCH).mkdir()
    assert [p.name for p in folder.iterdir()] == ["slide.csv"]


def test_a_folder_that_holds_something_is_refused(tmp_path):
    (tmp_path / "mine.csv").write_text("t,y\n", encoding="utf-8")
    with pytest.raises(InputError, match="this folder is not empty; name a new one, or an empty one"):
        project_folder(tmp_path).__enter__()
    with pytest.raises(InputError, match="no such folder"):
        project_folder(tmp_path / "a" / "b").__enter__()
    with pytest.raises(InputError, match="not empty"):
        project_folder(tmp_path / "mine.csv").__enter__()
    assert [p.name for p in tmp_path.iterdir()] == ["mine.csv"]


def test_a_port_that_is_taken_is_said_in_one_line(monkeypatch):
    monkeypatch.setattr(server, "need", lambda *_: None)
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port}: Address already in use; name another --port, or 0 for any"):
            serve(port=port, folder=None, largest_upload=1, browser=False)


def test_it_listens_on_this_computer_alone():
    with server._listener(0) as listener:
        assert listener.getsockname()[0] == "127.0.0.1"
