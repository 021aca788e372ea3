"""Forms of the dictionary go to another process and come back as what they are."""

import pickle

import pytest

from camid.diagnosis.laws.formula.dictionary import FORMS, POWERS


@pytest.mark.parametrize("form", [*FORMS, *POWERS], ids=lambda form: form.text)
def test_a_form_is_itself_behind_a_pickle(form):
    assert pickle.loads(pickle.dumps(form)) is form
