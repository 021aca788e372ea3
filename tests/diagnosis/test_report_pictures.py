"""Pictures of the report: what each effect is drawn against, its law over the recording, and panels that read."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import camid
from camid.chain.acquisition import Acquisition
from camid.chain.plant import TransferFunction
from camid.diagnosis.diagnosis import Location
from camid.diagnosis.effect_signals import EffectSignals
from camid.diagnosis.finding import Finding, ParameterEstimate
from camid.diagnosis.next_experiment import next_experiments
from camid.diagnosis.report import effect_pictures, noise_pictures, panel, pictures
from camid.diagnosis.report import page as report
from camid.diagnosis.report.words import with_titles
from camid.effects import known_effects
from camid.effects.friction import CoulombFriction
from camid.effects.hysteresis import Hysteresis
from camid.effects.plant_force import force_along
from camid.fitting.equivalent_input import equivalent_input, force_through_filter
from tests.support import written_diagnoses
from tests.support.report_page import Page

PERIOD = written_diagnoses.PERIOD
SHOWN = written_diagnoses.signals(7)
NUMBERS = {"step": 0.05, "std": 0.002, "spectrum": [0.8, -0.1], "fraction": 0.02}


def finding_of(identifier):
    """A finding of this effect, with numbers where its picture asks for some."""
    kind = known_effects()[identifier]
    parameters = {p.name: ParameterEstimate(NUMBERS.get(p.name, 0.1), 0.01, p.unit) for p in kind.parameters}
    return Finding(identifier, kind.place, kind.title, "", "", parameters, {})


def diagnosis_of(identifier, signals=SHOWN, **changes):
    """A diagnosis of this effect alone, with a law and what the recording shows of it."""
    kind = known_effects()[identifier]
    shown = []
    if not kind.noise_like:
        law = -0.3 * np.sign(signals.velocity)
        rate = np.gradient(signals.position, PERIOD)
        shown = [EffectSignals(identifier, signals.position, signals.velocity, rate, law, law, law)]
    changes = {"findings": [finding_of(identifier)], "effect_signals": shown, "signals": signals} | changes
    return written_diagnoses.diagnosis("explained", **changes)


@pytest.mark.parametrize("identifier", known_effects())
def test_every_effect_of_the_catalogue_has_a_picture_of_its_own(identifier):
    diagnosis = diagnosis_of(identifier)
    drawn = pictures.draw(diagnosis)
    if known_effects()[identifier].drawn_against == "frequency":
        assert not drawn["effects"]
        return
    assert drawn["effects"]
    for each in drawn["effects"]:
        assert each.located
        assert each.title.startswith(known_effects()[identifier].title)
    # What bends no force is not drawn as if it might.
    if known_effects()[identifier].place in {"sensor", "noise"}:
        assert not drawn["structure"]


@pytest.mark.parametrize(
    ("identifier", "words"),
    [
        ("cubic-stiffness", "missing force against position"),
        ("coulomb-friction", "missing force against velocity"),
        ("dead-zone", "missing force against input"),
        ("step-disturbance", "missing force against time"),
        ("lens-distortion", "error of the reading against position"),
        ("delay", "time shift over time"),
        ("clock-skew", "time shift over time"),
        ("rolling-shutter", "time shift over position"),
        ("input-hold", "missing force against the change of the input"),
        ("outliers", "histogram of the residual"),
        ("quantisation", "recorded against simulated output"),
        ("dropped-frames", "residual against the way since the last frame"),
        ("timestamp-jitter", "spread of the residual against the rate of the output"),
        ("multiplicative-noise", "spread of the residual against the reading"),
        ("coloured-noise", "correlation of the residual with its past"),
    ],
)
def test_an_effect_is_drawn_against_what_shows_it(identifier, words):
    first = pictures.draw(diagnosis_of(identifier))["effects"][0]
    assert first.title == f"{known_effects()[identifier].title}: {words}"


def test_the_frame_follows_the_effect_and_not_the_region():
    """The residual may be large where the speed is, although the force depends on the position."""
    location = Location("plant", {"plant": 1.0}, state=("velocity", -1.0, 1.0))
    drawn = pictures.draw(diagnosis_of("cubic-stiffness", location=location))
    framed = [p.title for panels in drawn.values() for p in panels if p.located]
    assert framed == ["Cubic stiffness: missing force against position"]


def test_a_force_has_no_second_picture_without_its_law():
    drawn = pictures.draw(diagnosis_of("coulomb-friction"))["structure"]
    assert [p.title.split(" against ")[1] for p in drawn] == ["input", "position", "output"]


def test_friction_along_a_motion_is_against_it_whatever_the_sign_of_the_gain():
    velocity = np.array([-2.0, 0.0, 3.0])
    motion = (np.arange(3.0), np.zeros(3), velocity, np.zeros(3))
    for gain in (100.0, -100.0):
        plant = TransferFunction((gain,), (1.0, 2.0, 100.0))
        force = force_along(CoulombFriction(force=0.3), plant, motion)
        assert force * np.sign(gain) == pytest.approx([0.3, 0.0, -0.3])


def test_a_force_with_memory_runs_through_a_loop():
    position = np.sin(np.linspace(0.0, 4.0 * np.pi, 400))
    effect = Hysteresis(strength=0.5, shape=5.0)
    plant = TransferFunction((100.0,), (1.0, 2.0, 100.0))
    zeros = np.zeros(len(position))
    force = force_along(effect, plant, (zeros, position, np.gradient(position), zeros))
    up, down = (np.flatnonzero((np.abs(position) < 0.1) & (s * np.gradient(position) > 0.0))[-1] for s in (1.0, -1.0))
    assert force[up] * force[down] < 0.0
    assert np.abs(force[up]) > 0.1


def test_a_force_is_smoothed_as_the_equivalent_input_of_its_response_is():
    """The law is drawn as smooth as what the recording shows of it."""
    plant = TransferFunction((100.0,), (1.0, 4.0, 100.0))
    acquisition = Acquisition(0.01, "zoh", "camera", 0.01, 0.0)
    time = 0.01 * np.arange(4096)
    force = np.sign(np.sin(5.0 * time)) * np.exp(-(((time - 20.0) / 6.0) ** 2))
    angular = 2.0 * np.pi * np.fft.rfftfreq(2 * len(force), 0.01)
    response = plant.frequency_response(np.maximum(angular, 1e-4)) * np.sinc(angular * 0.01 / (2.0 * np.pi))
    response = response * np.exp(-1j * angular * 0.005)
    seen = np.fft.irfft(np.fft.rfft(force, 2 * len(force)) * response)[: len(force)]
    smoothed = force_through_filter(plant, acquisition, force)
    assert equivalent_input(plant, acquisition, seen) == pytest.approx(smoothed, abs=0.01)
    assert np.abs(smoothed - force).max() > 0.2  # it is no copy


def test_readings_that_are_late_are_late_by_the_error_over_the_rate():
    random = np.random.default_rng(np.random.SeedSequence(2))
    rate = random.standard_normal(5000)
    error = -0.007 * rate + 1e-4 * random.standard_normal(5000)
    groups = np.array_split(np.arange(5000), 10)
    shift, deviation = effect_pictures.windowed_shift(groups, error, rate)
    assert shift == pytest.approx(0.007, abs=2e-5)
    assert 0.5 * deviation.mean() < np.std(shift) < 2.0 * deviation.mean()


def test_a_constant_delay_is_also_a_line_over_the_rate_and_a_drifting_clock_is_none():
    rate = np.gradient(SHOWN.position, PERIOD)
    for identifier, late, count in (("delay", 0.007, 2), ("clock-skew", 4e-4 * SHOWN.time, 1)):
        law = -late * rate
        shown = EffectSignals(identifier, SHOWN.position, SHOWN.velocity, rate, law, law, law)
        assert len(pictures.draw(diagnosis_of(identifier, effect_signals=[shown]))["effects"]) == count


def test_repeated_frames_and_outliers_are_counted_in_their_captions():
    recorded = SHOWN.recorded.copy()
    recorded[100:1000:100] = recorded[99:999:100]
    repeated = pictures.draw(diagnosis_of("dropped-frames", replace(SHOWN, recorded=recorded)))["effects"][0]
    assert f"9 of {len(recorded)} frames repeat" in repeated.caption
    recorded = SHOWN.improved + 0.01 * np.sin(np.arange(len(recorded)))
    recorded[50:1050:100] += 1.0
    outlying = pictures.draw(diagnosis_of("outliers", replace(SHOWN, recorded=recorded)))["effects"][0]
    assert f"10 of {len(recorded)} rows lie beyond" in outlying.caption


def test_the_correlation_of_an_autoregression():
    lags = np.array([1, 2, 3])
    assert noise_pictures._correlation([0.8], lags) == pytest.approx(0.8**lags, rel=1e-6)


@pytest.mark.parametrize("size", [1e-9, 1e-6, 1.0, 1e8])
def test_small_and_large_numbers_stand_as_a_power_of_ten_in_the_label(size):
    with panel.look_of_the_project():
        axes = panel.new_panel()
        axes.plot([0.0, 1.0], [0.0, 3.7 * size])
        axes.set(xlabel="time, s", ylabel="residual, y", xlim=(0.0, 1.0))
        svg = panel.inline_svg(axes, "a line")
    named = {1e-9: "residual, 10⁻⁹ y", 1e-6: "residual, 10⁻⁶ y", 1.0: "residual, y", 1e8: "residual, 10⁶ y"}[size]
    assert f">{named}</text>" in svg
    assert max(len(text) for text in re.findall(r">([\d.−]+)</text>", svg)) <= 4


def test_colours_are_those_of_the_page():
    for panels in pictures.draw(written_diagnoses.diagnosis("partly-explained")).values():
        for each in panels:
            for svg in (each.svg, each.narrow):
                assert not re.search(r"#[0-9a-fA-F]{6}", " ".join(re.findall(r'style="[^"]*"', svg)))
                assert svg.count("var(--ink)") or not svg


def test_what_is_wide_is_drawn_for_a_telephone_too():
    drawn = [p for panels in pictures.draw(written_diagnoses.diagnosis("explained")).values() for p in panels]
    assert all(bool(p.narrow) == p.wide for p in drawn)
    assert sum(p.wide for p in drawn) >= 2


def test_the_input_is_drawn_above_the_output():
    svg = next(p for p in pictures.draw(written_diagnoses.diagnosis("explained"))["fit"] if p.wide).svg
    assert svg.index(">input, u</text>") < svg.index(">output, y</text>")
    assert svg.count('class="axes"') == 2
    free = written_diagnoses.diagnosis("explained", input_column=None)
    assert next(p for p in pictures.draw(free)["fit"] if p.wide).svg.count('class="axes"') == 1


@pytest.mark.parametrize("column", ["u", None])
@pytest.mark.parametrize("place", ["actuator", "plant", "disturbance", "sensor", "noise", None])
def test_what_has_no_name_asks_for_another_experiment(place, column):
    diagnosis = written_diagnoses.diagnosis("unexplained", location=Location(place), input_column=column)
    advised = next_experiments(diagnosis)
    assert advised
    # Nobody who recorded a free decay is told to record one, or to change an input that there is not.
    assert column or not any("a free decay" in each or "input" in each for each in advised)
    assert len(advised) == len(set(advised))
    named = [
        next_experiments(written_diagnoses.diagnosis(v, location=Location(place))) for v in ("adequate", "explained")
    ]
    assert named == [[], []]


def test_sentences_name_effects_by_their_titles():
    assert with_titles("dead-zone or cubic-stiffness") == "Dead zone of the actuator or cubic stiffness"
    assert with_titles("a free-running clip.csv of /some/dead-zone") == "a free-running clip.csv of /some/dead-zone"
    assert with_titles("as my-own-force does", {"my-own-force": "Force of a magnet"}) == "as force of a magnet does"


@pytest.fixture(scope="module")
def rubbing():
    """A diagnosis of a slide with Coulomb friction, which a refit without it takes for damping."""
    plant = {"transfer_function": {"numerator": [100.0], "denominator": [1.0, 2.0, 100.0]}}
    simulation = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": plant,
        "sensor": {"column": "y", "kind": "camera", "exposure": 0.02},
        "initial_state": "zero",
    }
    random = np.random.default_rng(np.random.SeedSequence(8))
    signal = np.repeat(random.choice([-3.0, -1.0, 1.0, 3.0], 100), 10)
    table = pd.DataFrame({"t": 0.02 * np.arange(1000), "u": signal})
    true = simulation | {"effects": [{"id": "coulomb-friction", "parameters": {"force": 0.4}}]}
    table["y"] = camid.simulate(table, true)["simulated"] + 0.01 * random.standard_normal(1000)
    return camid.diagnose(table, simulation)


def test_what_the_recording_shows_follows_the_law_and_is_not_bent(rubbing):
    shown = next(e for e in rubbing.effect_signals if e.identifier == rubbing.findings[0].identifier)
    assert rubbing.findings[0].identifier.endswith("friction")
    fast = np.abs(shown.velocity) > 0.5 * np.max(np.abs(shown.velocity))
    assert shown.law[fast] == pytest.approx(-0.4 * np.sign(shown.velocity[fast]), abs=0.03)
    # As smooth as each other, they differ by the noise alone.
    assert np.sqrt(np.mean((shown.data - shown.seen) ** 2)) < 0.02
    # What the refit leaves at high speed lacks what its damping took.
    taken = rubbing.signals.equivalent_input[fast] * -np.sign(shown.velocity[fast])
    assert np.median(taken) < 0.25
    assert np.median(shown.data[fast] * -np.sign(shown.velocity[fast])) > 0.35


def test_the_law_is_drawn_over_it(rubbing):
    first = pictures.draw(rubbing)["effects"][0]
    assert first.title.endswith("missing force against velocity")
    assert [name for name in ("recording", "law", "law, smoothed alike") if f'data-series="{name}"' in first.svg] == [
        "recording",
        "law",
        "law, smoothed alike",
    ]


@pytest.mark.parametrize(
    ("location", "framed"),
    [
        (Location("plant", state=("velocity", -1.0, 1.0)), ["Missing force against velocity"]),
        (Location("plant"), ["Missing force against velocity", "Missing force against position"]),
        (Location("sensor", state=("position", 0.0, 1.0)), ["Residual against output"]),
        (Location("disturbance"), []),
    ],
)
def test_the_pictures_of_the_located_place_are_framed(location, framed):
    drawn = pictures.draw(written_diagnoses.diagnosis("unexplained", location=location))["structure"]
    assert [p.title for p in drawn if p.located] == framed


def test_a_free_decay_has_no_picture_against_its_input():
    diagnosis = written_diagnoses.diagnosis("explained", input_column=None)
    signals = diagnosis.signals
    still = type(signals)(**{**vars(signals), "signal": np.zeros(len(signals.time))})
    drawn = pictures.draw(written_diagnoses.diagnosis("explained", input_column=None, signals=still))["structure"]
    assert [p.title.split(" against ")[1] for p in drawn] == ["position", "output"]  # velocity is drawn with the law
    assert "no input" in Page(report.render(diagnosis)).text


def test_medians_show_the_law_through_outliers():
    random = np.random.default_rng(np.random.SeedSequence(3))
    x = random.uniform(-1.0, 1.0, 4000)
    y = np.sign(x) + 0.1 * random.standard_normal(4000)
    y[::40] = 50.0
    centres, quartiles = panel.quartiles_of_bins(x, y)
    away = np.abs(centres) > 0.1
    assert away.sum() >= 16
    assert np.abs(quartiles[away, 1] - np.sign(centres[away])).max() < 0.06
    assert np.all(np.diff(quartiles, axis=1) > 0.0)
    levels, _ = panel.quartiles_of_bins(np.tile([-1.0, 0.5], 100), np.ones(200))
    assert levels.tolist() == [-1.0, 0.5]


def test_thinning_keeps_the_extremes():
    time = np.arange(50_000.0)
    values = np.sin(time)
    values[12_345] = 9.0
    thin_time, thin = panel.thinned(time, values)
    assert len(thin) <= panel.LARGEST_LINE
    assert thin.max() == 9.0
    assert thin_time[thin.argmax()] == 12_345.0
    assert np.all(np.diff(thin_time) >= 0.0)


def test_drawing_leaves_the_settings_of_matplotlib_alone():
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 3.0, "text.usetex": True}):
        before = dict(mpl.rcParams)
        pictures.draw(written_diagnoses.diagnosis("explained"))
        assert dict(mpl.rcParams) == before
