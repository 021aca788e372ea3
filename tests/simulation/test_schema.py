"""The models of the simulation file: the JSON schema that they make, and files of any content."""

import json
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from camid.chain.controller import Controller
from camid.chain.pendulum import Pendulum
from camid.chain.plant import TransferFunction
from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.units import Conversion
from camid.simulation.file import load_simulation, simulation_text
from camid.simulation.json_schema import json_schema
from camid.simulation.model import DeclaredEffect, Simulation
from camid.simulation.schema import SimulationFile
from camid.simulation.yaml_file import read_yaml, yaml_text
from tests.support import linear_rig as rig

JSON_SCHEMA = "schemas/simulation.schema.json"  # in the package
SCHEMA = json.loads(files("camid").joinpath(JSON_SCHEMA).read_text(encoding="utf-8"))


def test_the_committed_json_schema_is_that_of_the_models():
    committed = files("camid").joinpath(JSON_SCHEMA).read_text(encoding="utf-8")
    assert committed == json_schema(), f"run python -m camid.simulation.json_schema > src/camid/{JSON_SCHEMA}"
    Draft202012Validator.check_schema(SCHEMA)


def properties(schema, path=""):
    for name, value in schema.get("properties", {}).items():
        # Pydantic leaves a description to the part that is referred to where both have the same.
        yield f"{path}.{name}", value.get("description", "") or described_by_reference(value)
    for name, part in schema.get("$defs", {}).items():
        yield from properties(part, name)


def described_by_reference(value):
    return SCHEMA["$defs"][value["$ref"].removeprefix("#/$defs/")]["description"]


def test_every_key_is_described():
    described = dict(properties(SCHEMA))
    assert len(described) > 60
    assert [name for name, description in described.items() if len(description) < 8] == []


def test_every_mapping_of_named_keys_refuses_unknown_ones():
    parts = [SCHEMA, *(p for p in SCHEMA["$defs"].values() if "properties" in p)]
    assert len(parts) > 15
    assert all(part["additionalProperties"] is False for part in parts)


@pytest.mark.parametrize(
    ("changes", "valid"),
    [
        ({}, True),
        ({"input": None}, True),
        ({"plant": {"pendulum": {"natural_frequency": 3.0, "damping": 0.01}}}, True),
        ({"plant": {"pendulum": {"natural_frequency": 0.0, "damping": 0.01}}}, False),
        ({"plant": {"pendulum": {"natural_frequency": 3.0, "damping": 0.1}, "free": {"gain": [True]}}}, False),
        ({"sensor": {"column": "y", "kind": "camera", "exposure": 0}}, False),
        ({"sensor": {"column": "y", "kind": "camera", "exposure": None}}, False),
        ({"sensor": {"column": "y", "kind": "camera", "latency": -0.1}}, False),
        ({"time": {"column": 3}}, False),
        ({"effects": [{"id": "absolute-value"}]}, True),
        ({"effects": [{"parameters": {}}]}, False),
        ({"effects": [{"id": "dead-zone", "parameters": {"half_width": 0.1}}]}, True),
        ({"recording": {"decimal": ";"}}, False),
        ({"remainder": 0.1, "initial_state": "estimate"}, True),
        ({"schema": 2}, False),
        ({"exposure": 0.1}, False),
    ],
)
def test_the_json_schema_and_the_models_agree(changes, valid):
    content = rig.simulation(**changes)
    assert Draft202012Validator(SCHEMA).is_valid(content) is valid
    if valid:
        SimulationFile.model_validate(content)
        load_simulation(content)
    else:
        with pytest.raises(InputError):
            load_simulation(content)


# -- any simulation is written and read back --------------------------------------------------------------------------

finite = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=1e-300, max_value=1e300)
names = st.text(st.characters(codec="utf-8", exclude_characters="\x85\u2028\u2029\ufeff"), max_size=12).filter(
    lambda text: all(c.isprintable() or c in "\t\n" for c in text)
)
conversions = st.builds(
    Conversion,
    unit=st.none() | st.sampled_from(["mm", "deg", "mV", "m/s^2"]),
    scale=positive | positive.map(lambda v: -v),
    offset=finite,
)


@st.composite
def transfer_functions(draw):
    """A stable plant from poles in the left half plane, with what is known of its accuracy."""
    poles = draw(st.lists(st.floats(min_value=-1e3, max_value=-1e-3), min_size=1, max_size=4))
    lead = draw(st.floats(min_value=0.1, max_value=10.0))
    denominator = tuple((lead * np.poly(poles)).tolist())
    numerator = tuple(draw(st.lists(st.floats(0.5, 1e3), min_size=1, max_size=len(denominator))))
    size = len(numerator) + len(denominator) - 1
    free = draw(st.lists(st.booleans(), min_size=size, max_size=size))
    deviations = {"numerator": [0.5] * len(numerator), "denominator": [0.0] + [0.25] * (len(denominator) - 1)}
    return {
        "plant": TransferFunction(numerator, denominator),
        "free_numerator": np.array(free[: len(numerator)]),
        "free_denominator": np.array([False, *free[len(numerator) :]]),
        "standard_deviations": draw(st.sampled_from([None, deviations])),
        "covariance": draw(st.sampled_from([None, np.diag(np.full(size, 0.25)).tolist()])),
    }


@st.composite
def pendulums(draw):
    pendulum = Pendulum(
        draw(st.floats(0.1, 100.0)),
        draw(st.floats(0.0, 1.0)),
        draw(st.floats(0.1, 10.0)),
        draw(st.floats(-4.0, 4.0)),
        free=draw(st.dictionaries(st.sampled_from(["gain", "rest", "damping"]), st.booleans())),
    )
    return {"plant": pendulum.transfer_function(), "pendulum": pendulum}


# A name that no other column has.
added = st.dictionaries(names.map(lambda name: f"added {name}" * 3), conversions, max_size=2)


@st.composite
def simulations(draw):
    start = draw(st.floats(-1e6, 1e6))
    driven = draw(st.booleans())
    camera = draw(st.booleans())
    controlled = driven and draw(st.booleans())
    effects = st.builds(
        DeclaredEffect,
        identifier=names,
        parameters=st.dictionaries(names, finite | names | st.lists(finite, max_size=3), max_size=3),
        standard_deviations=st.none() | st.dictionaries(names, finite, min_size=1, max_size=3),
    )
    limit = {"limit": draw(positive)} if draw(st.booleans()) else {}
    plant = draw(transfer_functions() | pendulums())
    unknown = [] if "pendulum" in plant or controlled else ["estimate"]
    return Simulation(
        draw(names),
        draw(names) if driven else None,
        draw(names),
        **plant,
        hold=draw(st.sampled_from(["zoh", "foh", "band-limited"])) if driven and not controlled else "zoh",
        sensor="camera" if camera else "instant",
        exposure=draw(st.none() | positive) if camera else None,
        latency=draw(st.floats(0.0, 1e300)),
        offset=draw(st.none() | finite | st.sampled_from(unknown)) if unknown else draw(st.none() | finite),
        bias=draw(st.none() | finite) if driven and not controlled else None,
        initial_state=draw(st.sampled_from(["zero", "estimate"])),
        validation=draw(st.none() | st.floats(start, 2e6, exclude_min=True).map(lambda end: (start, end))),
        effects=tuple(draw(st.lists(effects, max_size=2))),
        controller=Controller(draw(names), draw(positive), draw(positive), **limit) if controlled else None,
        remainder=draw(st.none() | positive),
        reading=Reading(
            separator=draw(st.none() | st.sampled_from([";", " ", "|"])),
            decimal=draw(st.none() | st.sampled_from([".", ","])),
            group=draw(st.none() | names.filter(bool)),
            experiment=draw(st.none() | names),
            leave_out=draw(st.floats(0.0, 1e9)),
            gaps=draw(st.sampled_from(["refuse", "hold"])),
            missing=draw(st.sampled_from(["refuse", "leave-out"])),
            time=draw(st.sampled_from([Conversion(), Conversion("ms")])),
            input=draw(conversions) if driven else Conversion(),
            added=draw(added) if driven and not controlled else {},
            output=replace(draw(conversions), offset=0.0),
            reference=draw(conversions) if controlled else Conversion(),
        ),
    )


@given(simulations())
@settings(max_examples=60, deadline=None)
def test_any_simulation_is_written_and_read_back(tmp_path_factory, simulation):
    path = tmp_path_factory.getbasetemp() / "written.yaml"
    path.write_bytes(simulation_text(simulation).encode("utf-8"))
    Draft202012Validator(SCHEMA).validate(simulation.to_mapping())
    read = load_simulation(path)
    assert read.to_mapping() == simulation.to_mapping()


@pytest.mark.parametrize(
    "text", [":", ":a", "a:", "", "-", "?", "?b", "? b", "{", "#", "&a", "true", "1e3", "a\nb", "é" * 200]
)
def test_any_text_is_written_and_read_back(tmp_path, text):
    content = {"effects": [{"parameters": {text: 1.0}}, [text]], text: {"nested": [{text: text}], "value": text}}
    (tmp_path / "written.yaml").write_text(yaml_text(content), encoding="utf-8")
    assert read_yaml(tmp_path / "written.yaml") == content


# -- whatever a file holds, it is a simulation or an InputError of one line -------------------------------------------

KEYS = [*SCHEMA["properties"], *(key for part in SCHEMA["$defs"].values() for key in part.get("properties", {}))]
scalars = (
    st.none()
    | st.booleans()
    | st.integers(-3, 3)
    | st.floats()
    | st.sampled_from(["u", "zoh", "camera", "estimate", "mm", "furlongg", ""])
    | st.text(max_size=5)
    | st.dates()
)
values = st.recursive(
    scalars,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(KEYS) | st.integers(), inner, max_size=4)
    ),
    max_leaves=12,
)


@st.composite
def nearly_simulations(draw):
    """A valid content in which values at random places are replaced, added or removed."""
    content = json.loads(json.dumps(rig.simulation(plant=rig.plant([1.0], [1.0, 2.0, 3.0]))))
    for _ in range(draw(st.integers(1, 3))):
        part = content
        while True:
            keys = list(part) if isinstance(part, dict) else list(range(len(part)))
            if not keys:
                break
            key = draw(st.sampled_from(keys))
            if isinstance(part[key], dict | list) and draw(st.booleans()):
                part = part[key]
                continue
            action = draw(st.sampled_from(["replace", "remove", "add"]))
            if action == "replace":
                part[key] = draw(values)
            elif action == "remove":
                del part[key]
            elif isinstance(part, dict):
                part[draw(st.sampled_from(KEYS))] = draw(values)
            else:
                part.append(draw(values))
            break
    return content


def loads_or_refuses(source):
    try:
        return load_simulation(source)
    except InputError as error:
        refusal = str(error)
    assert "\n" not in refusal
    return None


@given(nearly_simulations())
@settings(max_examples=400, deadline=None)
def test_a_wrong_content_is_an_input_error(content):
    loaded = loads_or_refuses(content)
    if loaded is not None:
        assert load_simulation(loaded.to_mapping()).to_mapping() == loaded.to_mapping()


@given(st.binary(max_size=200) | st.text(max_size=200).map(lambda t: t.encode("utf-8", "surrogatepass")))
@settings(max_examples=200, deadline=None)
def test_any_bytes_are_no_simulation(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "junk.yaml"
    path.write_bytes(data)
    assert loads_or_refuses(path) is None


@given(st.data())
@settings(max_examples=200, deadline=None)
def test_a_damaged_file_is_an_input_error(tmp_path_factory, data):
    text = simulation_text(load_simulation(rig.simulation()))
    place = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 20))
    inserted = data.draw(st.sampled_from(["&a ", "*a", "!!int ", "\t", "{", "]", ": ", "- ", "'", "|", "---\n"]))
    path = tmp_path_factory.getbasetemp() / "damaged.yaml"
    path.write_text(text[:place] + inserted + text[place + length :], encoding="utf-8")
    loads_or_refuses(path)


def test_a_value_that_contains_itself_is_an_input_error():
    endless = [1.0]
    endless.append(endless)
    assert loads_or_refuses(rig.simulation(effects=[{"id": "x", "parameters": {"p": endless}}])) is None


@pytest.mark.parametrize("anchored", ["hold: &a zoh", "hold: 'zoh'", 'hold: "zoh"'])
def test_words_may_be_quoted_and_anchored(tmp_path, anchored):
    path = tmp_path / "simulation.yaml"
    text = simulation_text(load_simulation(rig.simulation()))
    assert "hold: zoh" in text
    path.write_text(text.replace("hold: zoh", anchored))
    assert load_simulation(path).hold == "zoh"


def test_truth_values_may_be_anchored(tmp_path):
    path = tmp_path / "simulation.yaml"
    path.write_text(
        simulation_text(load_simulation(rig.simulation())) + "recording: {header: &a false, columns: [t, u, y]}\n"
    )
    assert load_simulation(path).reading.header is False
