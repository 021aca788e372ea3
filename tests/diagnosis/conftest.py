"""Pages of reports, rendered once."""

import pytest

from camid.diagnosis.report import page as report
from camid.diagnosis.report import summary
from tests.support import report_page, written_diagnoses


@pytest.fixture(scope="session")
def pages():
    """The page of each verdict."""
    return {verdict: report.render(written_diagnoses.diagnosis(verdict)) for verdict in summary.VERDICT_WORDS}


@pytest.fixture(scope="session")
def hostile():
    """The page of a diagnosis whose names and words are markup."""
    return report.render(written_diagnoses.diagnosis("partly-explained", **report_page.HOSTILE))
