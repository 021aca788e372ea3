"""Work in a copy of a process, and without one."""

import multiprocessing
import os

import pytest

from camid.diagnosis.report.copied_process import begun_in_a_copy


def process_of(_):
    return os.getpid()


def gone_unless(process):
    if os.getpid() != process:
        os._exit(1)
    return "here"


def refused(_):
    raise ValueError("not like this")


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system cannot copy a process")
def test_another_process_does_it():
    with begun_in_a_copy(process_of, None) as result:
        assert result() != os.getpid()


def test_a_copy_that_ends_without_a_result_is_replaced_by_this_process():
    with begun_in_a_copy(gone_unless, os.getpid()) as result:
        assert result() == "here"


def test_this_process_does_it_where_none_can_be_copied(monkeypatch):
    monkeypatch.setattr(multiprocessing, "get_all_start_methods", lambda: ["spawn"])
    with begun_in_a_copy(process_of, None) as result:
        assert result() == os.getpid()


def test_what_goes_wrong_is_said_here():
    with begun_in_a_copy(refused, None) as result, pytest.raises(ValueError, match="not like this"):
        result()
