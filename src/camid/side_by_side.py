"""One function of many items on two cores: this process and a copy of it take the items in turn.

Python runs one thread at a time. Where a function is Python for the most part, as a fit is, two threads take as long as
one. A copy of the process (``fork``) that is made at the beginning of a task knows what the task is about: what it is
sent and what it answers names what both know, and holds no copies of that. Results do not depend on who made them.

Where processes cannot be copied, or should not be because other threads run here, threads take the items.
"""

from __future__ import annotations

import io
import multiprocessing
import os
import pickle
import signal
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.connection import Connection
from types import MethodType
from typing import Any, TypeVar
from zlib import crc32

Item = TypeVar("Item")
Result = TypeVar("Result")

WORKERS = 2
# To ask the copy takes as long as many short items: of more than a few, this process begins alone for so many seconds.
FEW, ALONE = 8, 0.01
# Bytes of an item's number in the pipe from which both processes take them, the number that ends them, and how many
# surely fit into the pipe.
NUMBER, END, MOST_NUMBERS = 4, 2**32 - 1, 1000


class Account(ABC):
    """What a function changes beside its result: changes that a copy of this process makes are carried over."""

    @abstractmethod
    def state(self) -> Any:
        """As it is."""

    @abstractmethod
    def set(self, state: Any) -> None:
        """Make it as it was in a state."""

    @abstractmethod
    def since(self, state: Any) -> Any:
        """What has changed since a state."""

    @abstractmethod
    def add(self, changes: Any) -> None:
        """Change it again."""


class _Here(threading.local):
    busy = False  # whether this thread takes items, so that the other core has work
    copy: _Copy | None = None


_here = _Here()


@contextmanager
def with_a_copy(*known: object) -> Iterator[bool]:
    """Let a copy of this process, which is made now, take its share in :func:`side_by_side` within the block.

    What is yielded says whether there is one.

    Parameters
    ----------
    known : object
        What the functions and items will refer to, as far as it is there already. It may not be changed any more, but
        for what each process may work out again, and for an :class:`Account`.
    """
    copy = None
    if _here.copy is None and not _here.busy and cores() > 1 and _may_copy():
        with suppress(OSError):  # no right to start a process, or no memory
            copy = _Copy(known)
    if copy is None:
        yield False
        return
    _here.copy = copy
    try:
        yield True
    finally:
        _here.copy = None
        copy.end()


def side_by_side(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """The results of a function, in the order of the items.

    Parameters
    ----------
    function : callable
        Of a module, or a ``partial`` of one: it is pickled. It may not change anything but an :class:`Account` that was
        known when the copy was made, nor rely on what another item changed.
    items : sequence

    Raises
    ------
    Exception
        That of the first item for which the function raised one.
    """
    if _here.busy or len(items) < 2:
        return [function(item) for item in items]
    if _here.copy is None:
        return in_threads(function, items)
    found: list[Result] = []
    if len(items) > FEW:
        started = time.perf_counter()
        while len(found) < len(items) and time.perf_counter() - started < ALONE:
            found.append(function(items[len(found)]))
    for first in range(len(found), len(items), MOST_NUMBERS):
        found += _here.copy.results(function, items[first : first + MOST_NUMBERS])
    return found


def in_threads(function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """The same with threads alone: for what is short, and compiled for the most part."""
    if _here.busy or len(items) < 2:
        return [function(item) for item in items]

    def taken(item: Item) -> Result:
        with _taking():
            return function(item)

    with ThreadPoolExecutor(WORKERS) as pool:
        return list(pool.map(taken, items))


@contextmanager
def _taking() -> Iterator[None]:
    _here.busy = True
    try:
        yield
    finally:
        _here.busy = False


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def can_copy() -> bool:
    """Whether this system copies processes: not macOS, whose own libraries do not survive it."""
    return hasattr(os, "sched_getaffinity") and "fork" in multiprocessing.get_all_start_methods()


def _may_copy() -> bool:
    """Whether this process may be copied: a lock that another thread holds would be held in the copy for ever."""
    return can_copy() and threading.active_count() == 1 and not multiprocessing.current_process().daemon


# A result or an exception, whether it is one, and the changes of the accounts.
_Answer = tuple[Any, bool, list[Any]]


class _Copy:
    """The copy of this process, which waits for functions and items until it is ended, or this process is."""

    def __init__(self, known: Sequence[object]) -> None:
        self._known = _Known(known)
        self._here, there = multiprocessing.Pipe()
        self._taken, self._numbers = os.pipe()
        self._lost = False
        self._process = multiprocessing.get_context("fork").Process(target=self._serve, args=(there,), daemon=True)
        try:
            self._process.start()
        except OSError:
            self._close()
            raise
        finally:
            there.close()

    def end(self) -> None:
        """End it."""
        self._process.kill()
        self._process.join()
        self._process.close()
        self._close()

    def _close(self) -> None:
        self._here.close()
        os.close(self._taken)
        os.close(self._numbers)

    def results(self, function: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
        """The results, of which the copy makes a part."""
        accounts = self._known.accounts
        states = [account.state() for account in accounts]
        asked = None if self._lost or len(items) < 2 else self._known.written((function, items, states))
        answers: dict[int, _Answer] = {}
        if asked is not None:
            both = self._known.and_of((function, items))
            os.write(self._numbers, b"".join(n.to_bytes(NUMBER, "little") for n in (*range(len(items)), END, END)))
            complete = False
            try:
                self._here.send_bytes(asked)
                answers = _answers(function, items, self._taken, accounts)
                answers |= both.told(self._here.recv_bytes())
                complete = True
            except (EOFError, OSError):  # it is gone: what it took is done here
                pass
            finally:
                self._lost = not complete
                self._clear()
        return [
            _told(answers[i] if i in answers else _answer(function, item, accounts), accounts)
            for i, item in enumerate(items)
        ]

    def _clear(self) -> None:
        """Take the numbers that nobody took: an exception has ended the work."""
        os.set_blocking(self._taken, False)
        with suppress(BlockingIOError):
            while os.read(self._taken, MOST_NUMBERS):
                pass
        os.set_blocking(self._taken, True)

    def _serve(self, there: Connection) -> None:
        """In the copy: answer until nobody asks any more."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that asks hears of it, too, and ends this one
        asking = os.getppid()
        self._here.close()  # or the end of that process would not be heard of
        os.close(self._numbers)
        _here.busy = True
        with suppress(EOFError, BrokenPipeError):
            while True:
                function, items, states = self._known.loaded(there.recv_bytes())
                _set(self._known.accounts, states)
                both = self._known.and_of((function, items))
                answers = _answers(function, items, self._taken, self._known.accounts, asking)
                # An exception is raised where it is heard of, and with where it came from.
                there.send_bytes(both.telling({i: each for i, each in answers.items() if not each[1]}))


def _answers(
    function: Callable[[Any], Any],
    items: Sequence[Any],
    taken: int,
    accounts: Sequence[Account],
    asking: int | None = None,
) -> dict[int, _Answer]:
    """Answers for the items that this process takes; after an exception, or without the process that asks, no more."""
    found: dict[int, _Answer] = {}
    while number := os.read(taken, NUMBER):
        index = int.from_bytes(number, "little")
        if index == END or (asking is not None and os.getppid() != asking):
            break
        found[index] = _answer(function, items[index], accounts)
        if found[index][1]:
            if asking is None:  # nor does the copy, behind what it is at
                while int.from_bytes(os.read(taken, NUMBER), "little") != END:
                    pass
            break
    return found


def _answer(function: Callable[[Any], Any], item: Any, accounts: Sequence[Account]) -> _Answer:
    states = [account.state() for account in accounts]
    try:
        with _taking():
            result, failed = function(item), False
    except Exception as error:
        result, failed = error, True
    changes = [account.since(state) for account, state in zip(accounts, states, strict=True)]
    _set(accounts, states)
    return result, failed, changes


def _set(accounts: Sequence[Account], states: Sequence[Any]) -> None:
    for account, state in zip(accounts, states, strict=True):
        account.set(state)


def _told(answer: _Answer, accounts: Sequence[Account]) -> Any:
    result, failed, changes = answer
    for account, change in zip(accounts, changes, strict=True):
        account.add(change)
    if failed:
        raise result
    return result


class _Known:
    """Objects that both processes have, found from some in the same order: they are numbered, and not sent."""

    def __init__(self, roots: Sequence[object], before: _Known | None = None) -> None:
        self._objects: list[object] = [] if before is None else before._objects.copy()
        self._numbers: dict[int, int] = {} if before is None else before._numbers.copy()
        self.accounts: list[Account] = [] if before is None else before.accounts
        kinds = []
        ahead = list(roots)
        while ahead:
            each = ahead.pop()
            parts = None if id(each) in self._numbers else _parts(each)
            if parts is not None:
                self._numbers[id(each)] = len(self._objects)
                self._objects.append(each)
                kinds.append(type(each).__name__)
                ahead += parts
                if before is None and isinstance(each, Account):
                    self.accounts.append(each)
        # What both have to find alike for numbers to mean the same.
        self._found = crc32(" ".join(kinds).encode()) if before is not None else 0

    def and_of(self, roots: Sequence[object]) -> _Known:
        """These objects and those found from others."""
        return _Known(roots, self)

    def written(self, content: Any) -> bytes | None:
        """Something as bytes; None where it cannot be pickled."""
        stream = io.BytesIO()
        writer = pickle.Pickler(stream, pickle.HIGHEST_PROTOCOL)
        writer.persistent_id = lambda each: self._numbers.get(id(each))  # type: ignore[method-assign]
        try:
            writer.dump(content)
        except Exception:  # whatever an object has against it
            return None
        return stream.getvalue()

    def loaded(self, content: bytes) -> Any:
        """What was written."""
        reader = pickle.Unpickler(io.BytesIO(content))
        reader.persistent_load = self._objects.__getitem__  # type: ignore[method-assign]
        return reader.load()

    def telling(self, answers: dict[int, _Answer]) -> bytes:
        """Answers as bytes, but for those that cannot be pickled."""
        whole = self.written(answers)
        if whole is None:
            whole = self.written({i: each for i, each in answers.items() if self.written(each) is not None})
        return self._found.to_bytes(NUMBER, "little") + (whole or b"")

    def told(self, content: bytes) -> dict[int, _Answer]:
        """The same as answers; none where the other process has found other objects, or they cannot be read."""
        if int.from_bytes(content[:NUMBER], "little") != self._found:
            return {}
        try:
            return dict(self.loaded(content[NUMBER:]))
        except Exception:  # whatever an object has against it
            return {}


def _is_pickled_by_its_state(kind: type) -> bool:
    """Whether an object is not pickled in a way of its own: it then has the same parts in both processes."""
    return kind.__reduce__ is object.__reduce__ and kind.__reduce_ex__ is object.__reduce_ex__


def _parts(each: object) -> Sequence[object] | None:
    """What an object refers to; None for what is as easily sent as numbered."""
    if each is None or isinstance(each, str | bytes | int | float | complex | type):
        return None
    found: Sequence[object] = ()
    if isinstance(each, MethodType):
        found = [each.__self__]
    elif isinstance(each, partial):
        found = [each.func, *each.args, *each.keywords.values()]
    elif isinstance(each, list | tuple):
        found = each
    elif isinstance(each, dict):
        found = list(each.values())
    elif not isinstance(each, Account) and _is_pickled_by_its_state(type(each)):
        state = each.__getstate__()
        found = list(state.values()) if isinstance(state, dict) else ()
    return found
