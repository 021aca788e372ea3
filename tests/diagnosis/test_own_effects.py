"""A user's own effects in search, improved simulation and report, and refused in a line where they fail."""

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML

import camid
from camid.cli import main
from camid.diagnosis.report import page, summary
from camid.diagnosis.results_folder import write_diagnosis
from camid.effects import known_effects
from camid.effects.own_effects import own_effects
from camid.errors import InputError
from tests.support import ROOT
from tests.support.linear_rig import write_yaml
from tests.support.mass_on_spring import PERIOD, effect, record, simulation
from tests.support.own_effects import GUESS, LAW, RIGHT, line_of, with_other

LOSS = 0.06
FRAMES = 800


def rig(seed, loss=LOSS, noise=0.004):
    """A mass on a spring whose motor loses force with the square of the displacement, by an integrator of its own."""
    random = np.random.default_rng(np.random.SeedSequence((seed, 77)))
    signal = np.repeat(random.uniform(-1.5, 1.5, FRAMES // 8), 8)
    step = PERIOD / 20

    def slope(state, u):
        y, v = state
        return np.array([v, 100.0 * (1.0 - loss * y * y) * u - 2.0 * v - 100.0 * y])

    state, output = np.zeros(2), np.empty(FRAMES)
    for k, u in enumerate(signal):
        output[k] = state[0]
        for _ in range(20):
            a = slope(state, u)
            b = slope(state + 0.5 * step * a, u)
            c = slope(state + 0.5 * step * b, u)
            state = state + step / 6.0 * (a + 2.0 * b + 2.0 * c + slope(state + step * c, u))
    noisy = output + noise * random.standard_normal(FRAMES)
    return pd.DataFrame({"t": PERIOD * np.arange(FRAMES), "u": signal, "y": noisy})


def believed():
    return simulation(sensor={"column": "y", "kind": "instant", "offset": 0.0})


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A folder with a recording, its simulation, a file of effects and the diagnosis that the command line wrote."""
    folder = tmp_path_factory.mktemp("own")
    rig(1).to_csv(folder / "rig.csv", index=False)
    write_yaml(believed(), folder / "S.yaml")
    (folder / "mine.py").write_text(RIGHT)
    options = ["--simulation", str(folder / "S.yaml"), "--output", str(folder / "out")]
    assert main(["diagnose", str(folder / "rig.csv"), *options, "--effects", str(folder / "mine.py")]) == 0
    return folder


@pytest.fixture(scope="module")
def diagnosis(bench):
    return camid.diagnose(bench / "rig.csv", bench / "S.yaml", effects=[bench / "mine.py"])


def test_it_is_named_with_value_and_deviation(diagnosis):
    (found,) = diagnosis.findings
    assert (diagnosis.verdict, found.identifier, found.place) == ("explained", "fading", "plant")
    estimate = found.parameters["coefficient"]
    assert abs(estimate.value - LOSS) < 3.0 * estimate.standard_deviation < 0.1 * LOSS
    assert found.weight > 0.5
    assert "fading" not in known_effects()


@pytest.mark.slow
def test_a_class_may_be_given_in_place_of_a_file(bench, diagnosis):
    with own_effects(bench / "mine.py") as (fading,):
        pass
    again = camid.diagnose(bench / "rig.csv", bench / "S.yaml", effects=fading)
    assert again.to_mapping()["effects"] == diagnosis.to_mapping()["effects"]


def test_what_the_command_wrote_runs_again_with_the_file_alone(bench, capsys):
    model = bench / "out" / "improved.yaml"
    assert f"--effects {bench / 'mine.py'}" in model.read_text()
    simulate = ["simulate", str(bench / "rig.csv"), "--simulation", str(model), "--output", str(bench / "s.csv")]
    assert main([*simulate, "--effects", str(bench / "mine.py")]) == 0
    table = pd.read_csv(bench / "s.csv")
    assert np.std(table["y"] - table["simulated"]) < 0.005
    capsys.readouterr()
    assert main(simulate) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "no effect 'fading'" in said
    assert "--effects FILE.py" in said
    for command in ("diagnose", "identify"):
        assert main([command, *simulate[1:-1], str(bench / "again")]) == 2
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert "--effects FILE.py" in said


def test_identify_re_estimates_plant_and_effect(bench, capsys):
    model, written = bench / "out" / "improved.yaml", bench / "model.yaml"
    rig(4).to_csv(bench / "again.csv", index=False)
    options = ["--simulation", str(model), "--effects", str(bench / "mine.py"), "--output", str(written)]
    assert main(["identify", str(bench / "again.csv"), *options]) == 0
    assert "fading, coefficient" in capsys.readouterr().out
    found = camid.load_simulation(written)
    assert found.plant.denominator == pytest.approx((1.0, 2.0, 100.0), rel=0.02)
    (effect_found,) = found.effects
    deviation = effect_found.standard_deviations["coefficient"]
    assert abs(effect_found.parameters["coefficient"] - LOSS) < 3.0 * deviation < 0.1 * LOSS


def test_join_takes_what_names_it(bench):
    believed = YAML(typ="safe").load((ROOT / "examples" / "filmed.yaml").read_text())
    believed["effects"] = [{"id": "fading", "parameters": {"coefficient": 1e-6}}]
    tables = (ROOT / "examples" / "clip.csv", ROOT / "examples" / "drive.csv")
    with pytest.raises(InputError, match="own needs its file"):
        camid.join(*tables, simulation=believed)
    joined = camid.join(*tables, simulation=believed, effects=bench / "mine.py")
    assert joined.simulation.effects[0].identifier == "fading"


def test_identify_takes_effects_of_the_catalogue_and_leaves_those_on_the_noise():
    recording = record(effect("dead-zone", half_width=0.2), noise=0.003)
    believed = simulation(
        effects=[
            {"id": "quantisation", "parameters": {"step": 0.001}},
            {"id": "dead-zone", "parameters": {"half_width": 0.1}},
        ]
    )
    found = camid.identify(recording, believed)
    kept, estimated = found.simulation.effects
    assert (kept.identifier, kept.parameters) == ("quantisation", {"step": 0.001})
    (row,) = found.effect_rows
    assert abs(estimated.parameters["half_width"] - 0.2) < 3.0 * row["standard_deviation"] < 0.01
    declared = {"value": row["value"], "std": row["standard_deviation"], "unit": "u"}
    assert found.to_mapping()["effects"] == [row | {"declared": declared}]
    assert found.converged


def test_it_may_be_declared_and_is_fitted_then(bench, diagnosis):
    again = camid.diagnose(rig(2), diagnosis.improved, effects=bench / "mine.py")
    assert again.verdict == "adequate"
    (kept,) = again.improved.effects
    assert kept.identifier == "fading"
    assert kept.parameters["coefficient"] == pytest.approx(LOSS, rel=0.05)
    assert kept.standard_deviations["coefficient"] < 0.05 * LOSS


@pytest.fixture(scope="module")
def without(bench):
    """Diagnosis of a rig where nothing is missing, with an own effect in the search."""
    return camid.diagnose(rig(3, loss=0.0), believed(), effects=bench / "mine.py")


def test_where_it_is_not_its_limit_is_told(without):
    assert without.verdict == "adequate"
    (limit,) = (u for u in without.undetectable if u.identifier == "fading")
    assert limit.parameter == "coefficient"
    assert limit.unit == "1/y^2"
    assert 0.0 < limit.value < 0.2 * LOSS


def test_page_and_summary_call_it_by_its_title(bench, diagnosis, without, capsys):
    text = page.render(diagnosis)
    assert "Fading force constant" in text
    assert 'aria-label="f = c\\,y^2\\,u"' in text
    # The process that draws the page knows nothing of the class, and the page of the command came from there.
    assert "Fading force constant" in (bench / "out" / "report.html").read_text()
    assert "Fading force constant" in page.render(without)
    summary.print_summary(diagnosis, [])
    assert "Fading force constant" in " ".join(capsys.readouterr().out.split())


def test_an_alternative_of_a_users_own_has_its_title(diagnosis):
    assert summary.title_of("fading", diagnosis.own_titles) == "Fading force constant"
    assert summary.title_of("fading") == "Fading"


def force_values(body):
    return RIGHT.replace("    @classmethod", f"    def force_values(self, plant):\n        {body}\n\n    @classmethod")


def with_method(place, method, body):
    """The right file with another hook in the place of its force."""
    text = with_other('place = "plant"', f'place = "{place}"').replace("    @compiled\n", "")
    text = text.replace("force(time, position, velocity, signal, memory, values)", method)
    return text.replace(LAW, f"        {body}\n")


def observing(body):
    return with_method("sensor", "observe(self, output, time)", body)


def measuring(body):
    return with_method("sensor", "measure(self, motion, start, end)", body)


def carrying(body):
    return with_method("sensor", "carry(self, motion)", body)


def opening(body):
    return with_method("sensor", "windows(self, motion, start, end)", body)


def actuating(body):
    return with_method("actuator", "transform(self, start, end, step)", body)


@pytest.mark.parametrize(
    ("text", "where", "says"),
    [
        (with_other(LAW, "        return sqrt(position)\n"), "def force", "'force' returns nan at position -"),
        (with_other(LAW, "        return 1.0 / position**400\n"), "def force", "'force' returns inf at position"),
        (with_other(LAW, "        return values[1] * position\n"), "def force", "reads values[1], and there"),
        (force_values("return [float('nan')]"), "def force_values", "'force_values' returns [nan]"),
        (force_values("return None"), "def force_values", "'force_values' returns nothing"),
        (force_values("return [1.0 / 0.0]"), "1.0 / 0.0", "ZeroDivisionError"),
        (with_other(GUESS, "        return None\n"), "def candidates", "'candidates' gives no guesses"),
        (
            with_other(GUESS, "        yield from ()\n"),
            "def candidates",
            "'candidates' yields no guess for this recording; without one it is not looked for",
        ),
        (with_other(GUESS, "        yield 3.0\n"), "def candidates", "'candidates' yields a float"),
        (
            with_other(GUESS, "        while True:\n            yield cls(coefficient=0.1)\n"),
            "def candidates",
            "'candidates' yields more than 500 guesses",
        ),
        (with_other(GUESS, "        yield cls(size=3.0)\n"), "size=3.0", "has no parameter 'size'"),
        (with_other(GUESS, "        yield cls(coefficient=situation.lagest)\n"), "lagest", "no attribute 'lagest'"),
        (observing("return output[1:]"), "def observe", "'observe' returns the shape (799,) for 800 rows"),
        (observing("return None"), "def observe", "'observe' returns the shape () for 800 rows"),
        (observing("return output / 0.0"), "def observe", "'observe' returns what is no finite number"),
        (observing("raise ValueError('never')"), "never", "ValueError: never"),
        (carrying("return None"), "def carry", "'carry' returns nothing"),
        (opening("return start"), "def windows", "'windows' returns a ndarray"),
        (measuring("return 'x'"), "def measure", "'measure' returns"),
        (actuating("return start"), "def transform", "'transform' returns a ndarray"),
        (actuating("return start, end[:5]"), "def transform", "'transform' returns the shape (5,)"),
        (actuating("raise ValueError('never')"), "never", "ValueError: never"),
        (measuring("return output"), "return output", "NameError: name 'output' is not defined"),
        (measuring("raise ValueError('no')"), "raise ValueError", "ValueError: no"),
        (
            with_other(LAW, LAW + "\n    def before_plant(self):\n        return 3.0\n"),
            "def before_plant",
            "'before_plant' returns a float",
        ),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_what_fails_on_the_recording_is_refused_in_a_line(tmp_path, bench, capsys, text, where, says):
    path = tmp_path / "mine.py"
    path.write_text(text)
    options = ["--simulation", str(bench / "S.yaml"), "--output", str(tmp_path / "out"), "--no-report"]
    capsys.readouterr()
    assert main(["diagnose", str(bench / "rig.csv"), *options, "--effects", str(path)]) == 2
    # What is compiled for the first time on this machine is said, too, which depends on what ran here before.
    lines = capsys.readouterr().err.splitlines(keepends=True)
    said = "".join(line for line in lines if not line.startswith("camid: compiling "))
    assert said.startswith(f"camid: error: {path}, line {line_of(text, where)}: "), said
    assert says in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_law_that_is_no_number_for_declared_values_is_named_by_simulate(tmp_path, bench):
    path = tmp_path / "mine.py"
    path.write_text(with_other(LAW, "        return sqrt(values[0] - 1.0)\n"))
    declared = believed() | {"effects": [{"id": "fading", "parameters": {"coefficient": 0.5}}]}
    with pytest.raises(InputError, match="does your own effect fading return a finite number"):
        camid.simulate(bench / "rig.csv", declared, effects=path)


def test_an_output_folder_does_not_overwrite_the_file_that_it_is_made_with(tmp_path, bench, capsys):
    folder = tmp_path / "out"
    folder.mkdir()
    mine = folder / "learned_effect.py"
    mine.write_text(RIGHT)
    options = ["--simulation", str(bench / "S.yaml"), "--output", str(folder), "--effects", str(mine)]
    assert main(["diagnose", str(bench / "rig.csv"), *options]) == 2
    assert "would overwrite what it is made from" in capsys.readouterr().err
    assert mine.read_text() == RIGHT


@pytest.mark.slow
def test_named_effects_of_the_catalogue_keep_their_names_beside_it(tmp_path):
    (tmp_path / "mine.py").write_text(RIGHT)
    recording = record(effect("coulomb-friction", force=0.15), noise=0.003)
    diagnosis = camid.diagnose(recording, simulation(), effects=tmp_path / "mine.py")
    assert [f.identifier for f in diagnosis.findings] == ["coulomb-friction"]


def test_files_of_the_folder_are_written_for_it_as_well(diagnosis, tmp_path):
    written = write_diagnosis(diagnosis, tmp_path / "out", report=False)
    assert [path.name for path in written] == ["diagnosis.json", "improved.yaml", "residuals.csv"]
