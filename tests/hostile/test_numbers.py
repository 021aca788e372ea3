"""Numbers that no machine ever recorded: a result, or one clear line; `make test-faults` tries many more."""

import tempfile
from pathlib import Path

from hypothesis import given, settings

from tests.support import hostile_numbers as hostile


@given(hostile.tables(), hostile.COMMANDS, hostile.SETTINGS)
@settings(max_examples=60)
def test_any_numbers_have_a_result_or_one_line(recorded, command, chosen):
    with tempfile.TemporaryDirectory() as folder:
        wrong, _ = hostile.answer(Path(folder), recorded, command, chosen)
    assert wrong is None
