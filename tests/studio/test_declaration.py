"""The form changes single keys of a simulation's text, and what it writes is read back as it was typed."""

import pytest

from camid.draft.templates import TEMPLATES
from camid.simulation.file import load_simulation
from camid.studio import declaration
from camid.studio.declaration import NO_INPUT, chain_of, changed, fields_of, parsed, polynomial

SLIDE = """\
schema: 1
time: {column: t}  # period 0.02 s, regular
input:
  column: u  # a guess
  hold: zoh
plant:
  transfer_function: {numerator: [100.0], denominator: [1.0, 2.0, 100.0]}
sensor:
  column: "y"  # a guess
  kind: camera
  exposure: 0.02
initial_state: zero
"""


def loaded(text, tmp_path):
    path = tmp_path / "simulation.yaml"
    path.write_text(text, encoding="utf-8")
    return load_simulation(path)


def values(text):
    return {".".join(f.path): f.value for f in fields_of(parsed(text), ["t", "u", "y"])}


def test_the_form_shows_what_the_text_says():
    shown = values(SLIDE)
    assert shown["plant.transfer_function.denominator"] == "1, 2, 100"
    assert shown["sensor.exposure"] == "0.02"
    assert shown["sensor.latency"] == ""
    assert shown["input.column"] == "u"


def test_a_change_keeps_comments_and_everything_else(tmp_path):
    text = changed(SLIDE, ("plant", "transfer_function", "denominator"), "1, 2.5 90")
    assert text == SLIDE.replace("[1.0, 2.0, 100.0]", "[1.0, 2.5, 90.0]")
    assert list(loaded(text, tmp_path).plant.denominator) == [1.0, 2.5, 90.0]


def test_every_field_can_be_changed_and_is_read_back(tmp_path):
    typed = {"sensor.latency": "0.004", "sensor.offset": "estimate", "sensor.unit": "mm", "input.hold": "foh"}
    text = SLIDE
    for path, value in typed.items():
        text = changed(text, tuple(path.split(".")), value)
    assert typed.items() <= values(text).items()
    simulation = loaded(text, tmp_path)
    assert (simulation.latency, simulation.hold) == (0.004, "foh")


def test_a_free_decay_has_no_input_and_gets_one_back(tmp_path):
    decay = changed(SLIDE, ("input", "column"), NO_INPUT)
    assert loaded(decay, tmp_path).input_column is None
    assert "input.hold" not in values(decay)
    driven = changed(decay, ("input", "column"), "u")
    assert (loaded(driven, tmp_path).input_column, loaded(driven, tmp_path).hold) == ("u", "zoh")


def test_an_instant_sensor_loses_its_exposure(tmp_path):
    text = changed(SLIDE, ("sensor", "kind"), "instant")
    assert loaded(text, tmp_path).exposure is None
    assert "sensor.exposure" not in values(text)


def test_an_empty_field_removes_its_key():
    assert "exposure" not in changed(SLIDE, ("sensor", "exposure"), "  ")


@pytest.mark.parametrize(
    "name", ["y", "no", ":a", "?b", "a: b", "# c", "<script>alert(1)</script>", "x {1}", "größe", "1e3"]
)
def test_any_name_of_a_column_is_read_back(name, tmp_path):
    simulation = loaded(changed(SLIDE, ("sensor", "column"), name), tmp_path)
    assert simulation.output_column == name
    assert name in fields_of(parsed(SLIDE), [name])[0].choices


def test_what_is_no_number_is_left_to_camid_to_refuse(tmp_path):
    text = changed(SLIDE, ("plant", "transfer_function", "numerator"), "lots")
    with pytest.raises(ValueError, match=r"line 7, plant.transfer_function.numerator"):
        loaded(text, tmp_path)


@pytest.mark.parametrize("name", TEMPLATES)
def test_constants_of_a_plant_are_fields(name):
    from camid.draft.plant import Resonance

    resonance = Resonance(natural_frequency=10.0, damping=0.1, gain=1.0, rest=0.0)
    text = "\n".join(["schema: 1", *TEMPLATES[name].lines(resonance, 1.0, 1.0), "sensor: {column: x, kind: instant}"])
    fields = [f for f in fields_of(parsed(text), []) if f.part == "plant"]
    assert [f.label for f in fields] == [*TEMPLATES[name].units]
    assert all(float(f.value) == float(f.value) for f in fields)


def test_the_chain_is_that_of_the_text():
    blocks = chain_of(parsed(SLIDE))
    assert [b.name for b in blocks] == ["input", "hold", "plant", "camera", "output"]
    assert blocks[2].lines == ("100", "―――", "s² + 2 s + 100")
    assert blocks[3].lines == ("exposure 0.02 s", "no latency")
    decay = chain_of(parsed(changed(changed(SLIDE, ("input", "column"), NO_INPUT), ("sensor", "latency"), "estimate")))
    assert [b.name for b in decay] == ["plant", "camera", "output"]
    assert decay[1].lines[1] == "latency estimate"


def test_polynomials_read_as_people_write_them():
    assert polynomial([1.0, -2.5, 0.0]) == "s² − 2.5 s"
    assert polynomial([3.0]) == "3"
    assert polynomial([0.0]) == "0"
    assert polynomial(["m", "c", "k"]) == "m s² + c s + k"
    assert polynomial([1.0] + [0.0] * 11 + [2.0]) == "s¹² + 2"


def test_the_column_of_a_part_is_found():
    content = parsed(SLIDE)
    assert [declaration.column_of(content, part) for part in ("time", "input", "sensor")] == ["t", "u", "y"]
    assert declaration.column_of({"input": None}, "input") is None
