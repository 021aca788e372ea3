import pandas as pd
import pytest
from jsonschema import ValidationError, validate
from ruamel.yaml import YAML

from camid.workflow.tolerances import compare, print_comparison
from tests.support import ROOT

QUANTITIES = pd.DataFrame(
    [
        {"target": "fig7", "quantity": "error", "value": 1.05, "unit": "%"},
        {"target": "fig7", "quantity": "nothing", "value": float("nan"), "unit": "%"},
    ]
)


@pytest.mark.parametrize(
    ("entry", "passed"),
    [
        ({"quantity": "error", "reference": 1.0, "tolerance": 0.06}, True),
        ({"quantity": "error", "reference": 1.0, "tolerance": 0.04}, False),
        ({"quantity": "error", "at_most": 1.0}, False),
        ({"quantity": "error", "at_most": 1.1}, True),
        ({"quantity": "error", "at_least": 1.1}, False),
        ({"quantity": "error", "at_least": 1.0, "at_most": 1.1}, True),
        ({"quantity": "nothing", "at_most": 1.0}, False),
        ({"quantity": "missing", "at_most": 1.0}, False),
        ({"quantity": "missing", "reference": 0.0, "tolerance": 1e9}, False),
    ],
)
def test_comparison(entry, passed, capsys):
    comparison = compare(QUANTITIES, [{"target": "fig7", "source": "theory", **entry}])
    assert bool(comparison["passed"].iloc[0]) is passed
    print_comparison(comparison)
    assert ("pass" if passed else "FAIL") in capsys.readouterr().out


def test_stored_tolerances_follow_their_schema_and_name_each_quantity_once():
    yaml = YAML(typ="safe")
    tolerances = yaml.load(ROOT / "config/tolerances.yaml")
    schema = yaml.load(ROOT / "workflow/schemas/tolerances.schema.yaml")
    validate(tolerances, schema)
    names = [(t["target"], t["quantity"]) for t in tolerances]
    assert len(names) == len(set(names))
    with pytest.raises(ValidationError):
        validate([{"target": "fig7", "quantity": "error", "source": "none"}], schema)
