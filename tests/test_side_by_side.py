"""One function of many items by this process and a copy of it."""

import os
import subprocess
import sys
import time
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from camid import side_by_side as module
from camid.side_by_side import Account, side_by_side, with_a_copy

copies = pytest.mark.skipif(not module.can_copy() or module.cores() < 2, reason="no copy of this process can be made")


@pytest.fixture(autouse=True)
def with_all_items_shared(monkeypatch):
    monkeypatch.setattr(module, "ALONE", 0.0)
    # The workers of pytest-xdist hold threads that sleep; nothing of theirs is used in a copy.
    monkeypatch.setattr(module.threading, "active_count", lambda: 1)


@dataclass
class Counted(Account):
    """Counts, and notes names."""

    names: list[str] = field(default_factory=list)

    def state(self):
        return list(self.names)

    def set(self, state):
        self.names[:] = state

    def since(self, state):
        return self.names[len(state) :]

    def add(self, changes):
        self.names += changes


@dataclass(frozen=True)
class Pair:
    """Two objects, one of them known to both processes."""

    known: object
    new: object


def process_of(_):
    time.sleep(0.02)  # so that no process takes all of them
    return os.getpid()


def paired(known, item):
    time.sleep(0.01)
    return Pair(known, (os.getpid(), item))


def noted(account, refused, item):
    time.sleep(0.01)
    account.names.append(f"item {item}")
    if item in refused:
        raise ValueError(f"not {item}")
    return len(account.names)


def gone_elsewhere(process, item):
    if os.getpid() != process:
        os._exit(3)
    time.sleep(0.01)
    return item


def nested(item):
    return side_by_side(process_of, [item, item])


def unlike(item):
    time.sleep(0.01)
    return lambda: item


@copies
def test_two_processes_take_the_items_and_results_keep_their_order():
    with with_a_copy():
        found = side_by_side(partial(paired, None), list(range(20)))
    assert [pair.new[1] for pair in found] == list(range(20))
    assert len({pair.new[0] for pair in found}) == 2


def test_without_a_copy_threads_take_them():
    assert set(side_by_side(process_of, list(range(4)))) == {os.getpid()}


@copies
def test_what_both_know_is_not_sent_and_stays_the_same_object():
    known, item = np.arange(5.0), np.arange(3.0)
    with with_a_copy(known):
        for found in side_by_side(partial(paired, known), [item] * 12):
            assert found.known is known
            assert found.new[1] is item


@copies
def test_a_second_call_may_refer_to_other_objects():
    with with_a_copy():
        for each in ("one", "another"):
            given = {"name": each}
            assert all(pair.known is given for pair in side_by_side(partial(paired, given), list(range(6))))


@copies
def test_an_account_is_changed_as_if_this_process_had_taken_all():
    account = Counted(["before"])
    with with_a_copy(account):
        account.names.append("and behind the copying")
        found = side_by_side(partial(noted, account, ()), list(range(12)))
    assert account.names == ["before", "and behind the copying", *(f"item {i}" for i in range(12))]
    assert found == [3] * 12


@copies
def test_the_first_exception_is_raised_and_the_copy_can_be_asked_again():
    account = Counted()
    with with_a_copy(account):
        with pytest.raises(ValueError, match="not 5"):
            side_by_side(partial(noted, account, (5, 9)), list(range(12)))
        assert account.names == [f"item {i}" for i in range(6)]
        assert len(set(side_by_side(process_of, list(range(8))))) == 2


def refused_here(process, folder, item):
    if os.getpid() == process:
        raise ValueError("not here")
    time.sleep(0.05)
    (folder / str(item)).touch()


@copies
def test_nothing_more_is_taken_once_an_item_has_failed(tmp_path):
    with with_a_copy(), pytest.raises(ValueError, match="not here"):
        side_by_side(partial(refused_here, os.getpid(), tmp_path), list(range(60)))
    assert len(list(tmp_path.iterdir())) < 20


@copies
def test_an_exception_keeps_the_place_where_it_was_raised():
    account = Counted()
    with with_a_copy(account):
        for _ in range(3):
            with pytest.raises(ValueError, match="not 7") as raised:
                side_by_side(partial(noted, account, (7,)), list(range(8)))
            assert raised.traceback[-1].name == "noted"


@copies
def test_a_copy_ends_with_the_process_that_made_it(tmp_path):
    program = (
        "import os, sys, time\n"
        "from functools import partial\n"
        "from camid.side_by_side import side_by_side, with_a_copy\n"
        "def note(folder, item):\n"
        "    open(os.path.join(folder, f'{item} {os.getpid()}'), 'w').close()\n"
        "    time.sleep(0.1)\n"
        "with with_a_copy():\n"
        "    side_by_side(partial(note, sys.argv[1]), list(range(200)))\n"
    )
    (tmp_path / "program.py").write_text(program)
    folder = tmp_path / "taken"
    folder.mkdir()
    process = subprocess.Popen([sys.executable, tmp_path / "program.py", folder])
    while len({each.name.split()[1] for each in folder.iterdir()}) < 2:
        time.sleep(0.05)
    process.kill()
    process.wait()
    time.sleep(0.3)  # what it is at, it ends
    count = len(list(folder.iterdir()))
    time.sleep(0.5)
    assert len(list(folder.iterdir())) == count < 200


@copies
def test_this_process_does_what_a_copy_that_died_has_taken():
    with with_a_copy():
        for _ in range(2):
            assert side_by_side(partial(gone_elsewhere, os.getpid()), list(range(8))) == list(range(8))


@copies
def test_what_cannot_be_pickled_is_done_here():
    with with_a_copy():
        assert [found() for found in side_by_side(unlike, list(range(6)))] == list(range(6))
        assert side_by_side(lambda item: item + 1, list(range(6))) == list(range(1, 7))


@copies
def test_within_an_item_the_other_core_has_work():
    with with_a_copy():
        for pair in side_by_side(nested, list(range(6))):
            assert len(set(pair)) == 1


def test_few_items_need_no_copy_and_it_is_ended_with_its_task():
    with with_a_copy():
        copy = module._here.copy
        assert side_by_side(process_of, [1]) == [os.getpid()]
    assert module._here.copy is None
    if copy is not None:
        with pytest.raises(ValueError, match="closed"):
            copy._process.is_alive()


@copies
@pytest.mark.parametrize("name", ["slide", pytest.param("detent", marks=pytest.mark.slow)])
def test_a_diagnosis_says_the_same_with_and_without_a_copy(monkeypatch, name):
    """And all that it asks the copy for can be pickled."""
    import camid

    examples = Path(__file__).parents[1] / "examples"
    recording, simulation = examples / f"{name}.csv", examples / "slide.yaml"
    written, told, asked, heard = module._Known.written, module._Known.told, [], []

    def kept(self, content):
        asked.append(written(self, content))
        return asked[-1]

    def understood(self, content):
        heard.append((content, told(self, content)))
        return heard[-1][1]

    monkeypatch.setattr(module._Known, "written", kept)
    monkeypatch.setattr(module._Known, "told", understood)
    with_copy = camid.diagnose(recording, simulation, time_limit=None).to_mapping()
    assert asked
    assert None not in asked
    # Answers that are none, because the processes found other objects, would be made again without a word.
    nothing = len(module.pickle.dumps({}, module.pickle.HIGHEST_PROTOCOL)) + module.NUMBER
    assert all(answers for content, answers in heard if len(content) > nothing)
    monkeypatch.setattr(module, "_may_copy", lambda: False)
    assert camid.diagnose(recording, simulation, time_limit=None).to_mapping() == with_copy
