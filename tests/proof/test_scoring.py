"""Scores and rates on cases made by hand, whose right answer is known."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from camid.proof.figures import confusion_matrix, recovered_share, run_time, sample, strength, weights
from camid.proof.figures.confusion_matrix import count
from camid.proof.figures.sample import outcome
from camid.proof.rates import by_strength, coverage, largest_difference_by_chance, median, rate, reliability
from camid.proof.score_table import recovered_shares
from camid.proof.scoring import class_of, named_effects, own_weight, parameter_rows, score, weight_rows
from camid.proof.sealed_files import HELD_OUT
from camid.proof.targets import lines, quantities, to_markdown

QUANTITIES = ("refitted", "improved", "floor", "share")


def true_effect(identifier, place="plant", multiple=5.0, law="catalogue", **parameters):
    return {"id": identifier, "place": place, "multiple": multiple, "law": law, "parameters": parameters}


def truth(*effects, kind=None, snr_db=40.0, repeatable=True):
    kind = kind or ("none", "single", "several")[min(len(effects), 2)]
    return {"kind": kind, "effects": list(effects), "snr_db": snr_db, "repeatable": repeatable, "images": False}


def entry(identifier, *alternatives, **parameters):
    listed = [{"id": i, "weight": w} for i, w in alternatives]
    stated = {name: {"value": value, "std": std, "unit": "u"} for name, (value, std) in parameters.items()}
    return {"id": identifier, "place": "plant", "alternatives": listed, "parameters": stated}


def diagnosis(*effects, verdict="explained", place="plant"):
    return {"verdict": verdict, "effects": list(effects), "location": {"place": place}}


SILENT = diagnosis(verdict="adequate", place=None)


def test_class_leaves_out_what_is_unlisted_and_weights_sum_to_one():
    effect = entry("coulomb-friction", ("hysteresis", 0.25), ("unlisted", 0.15))
    assert class_of(effect) == ["coulomb-friction", "hysteresis"]
    assert own_weight(effect) == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("kind", "said", "alarm"),
    [
        ("none", SILENT, False),
        ("none", diagnosis(entry("delay")), True),
        ("none", diagnosis(verdict="unexplained", place="noise"), True),
        ("none", None, True),
        ("invisible", SILENT, False),
        ("invisible", diagnosis(entry("dead-zone")), True),
    ],
)
def test_false_alarm_is_whatever_is_said_of_nothing(kind, said, alarm):
    effects = [true_effect("dead-zone", "actuator", 0.0)] if kind == "invisible" else []
    assert score(truth(*effects, kind=kind), said)["false_alarm"] is alarm


def test_coloured_noise_alone_may_be_called_nothing_else():
    alone = truth(true_effect("coloured-noise", "noise", None))
    assert not score(alone, diagnosis(entry("coloured-noise"), place="noise"))["false_alarm"]
    assert not score(alone, SILENT)["false_alarm"]
    assert score(alone, diagnosis(entry("coloured-noise"), entry("delay"), place="noise"))["false_alarm"]
    assert np.isnan(score(alone, SILENT)["multiple"])


def test_single_effect_named_first_in_class_and_not_at_all():
    friction = truth(true_effect("coulomb-friction"))
    first = score(friction, diagnosis(entry("coulomb-friction", ("hysteresis", 0.3))))
    assert (first["detected"], first["top"], first["in_class"], first["place_top"]) == (True, True, True, True)
    second = score(friction, diagnosis(entry("hysteresis", ("coulomb-friction", 0.3))))
    assert (second["top"], second["in_class"], second["wrong_names"]) == (False, True, 0)
    wrong = score(friction, diagnosis(entry("delay"), place="sensor"))
    assert (wrong["top"], wrong["in_class"], wrong["place_in_class"], wrong["wrong_names"]) == (False, False, False, 1)
    silent = score(friction, SILENT)
    assert (silent["detected"], silent["in_class"], silent["place_top"], silent["named"]) == (False, False, False, "")
    failed = score(friction, None)
    assert (failed["detected"], failed["in_class"], failed["verdict"]) == (False, False, "failed")


def test_class_of_five_names_nothing_but_its_own_id():
    others = [("hysteresis", 0.1), ("quadratic-drag", 0.1), ("extra-mode", 0.1), ("unlisted", 0.1)]
    friction = truth(true_effect("quadratic-drag"))
    assert score(friction, diagnosis(entry("coulomb-friction", *others)))["in_class"]
    larger = entry("coulomb-friction", *others, ("cubic-stiffness", 0.1))
    assert not score(friction, diagnosis(larger))["in_class"]
    assert score(truth(true_effect("coulomb-friction")), diagnosis(larger))["in_class"]


def test_place_of_the_inseparable_is_right_if_the_class_holds_the_truth():
    exposure = truth(true_effect("exposure", "sensor"))
    shown = score(exposure, diagnosis(entry("actuator-lag", ("exposure", 0.4)), place="actuator"))
    assert (shown["place_top"], shown["place_in_class"]) == (False, True)
    hidden = score(exposure, diagnosis(entry("actuator-lag"), place="actuator"))
    assert not hidden["place_in_class"]
    # Others in a class do not lend their place.
    clipped = score(
        truth(true_effect("clipping", "sensor")), diagnosis(entry("saturation", ("clipping", 0.4)), place="actuator")
    )
    assert not clipped["place_in_class"]


def test_one_entry_names_one_effect_and_the_best_assignment_counts():
    both = entry("hysteresis", ("coulomb-friction", 0.4))
    pair = ["coulomb-friction", "hysteresis"]
    assert named_effects(pair, [both], in_class=True).sum() == 1
    # Greedy from the left would give the first entry to the first truth and leave the second truth without one.
    assert named_effects(pair, [both, entry("coulomb-friction")], in_class=True).all()
    # One entry for two truths stands for its own name.
    assert named_effects(pair, [both], in_class=True).tolist() == [False, True]
    assert named_effects(pair[::-1], [both], in_class=True).tolist() == [True, False]
    assert named_effects([], [both], in_class=True).shape == (0,)
    assert not named_effects(pair, [], in_class=True).any()


def test_several_count_only_the_strong_and_the_strongest_decides_the_place():
    three = truth(
        true_effect("delay", "sensor", 4.0),
        true_effect("coulomb-friction", "plant", 20.0),
        true_effect("quantisation", "sensor", 1.0),
    )
    row = score(three, diagnosis(entry("coulomb-friction"), entry("exposure", ("delay", 0.5))))
    assert (row["strong"], row["strong_top"], row["strong_in_class"]) == (2, 1, 2)
    assert (row["place"], row["multiple"], row["place_top"], row["in_class"]) == ("plant", 20.0, True, False)


@pytest.mark.parametrize(
    ("said", "wrong"),
    [
        (diagnosis(entry("end-stop", ("unlisted", 0.5))), True),
        (diagnosis(entry("end-stop", ("unlisted", 0.5)), verdict="partly-explained"), False),
        (diagnosis(entry("end-stop", ("unlisted", 0.1)), verdict="partly-explained"), True),
        (diagnosis(entry("unlisted"), verdict="unexplained"), False),
        (diagnosis(entry("magnetic-detent")), False),
        (SILENT, False),
    ],
)
def test_confidently_wrong_outside_the_catalogue(said, wrong):
    assert score(truth(true_effect("magnetic-detent"), kind="outside"), said)["confidently_wrong"] is wrong


def test_intervals_are_judged_for_the_catalogue_law_of_a_rightly_named_effect_only():
    friction = true_effect("coulomb-friction", force=0.5)
    said = diagnosis(entry("coulomb-friction", force=(0.52, 0.011)))
    (row,) = parameter_rows(truth(friction), said)
    assert row["covered"]  # 1.82 standard deviations
    (row,) = parameter_rows(truth(friction), diagnosis(entry("coulomb-friction", force=(0.52, 0.0101))))
    assert not row["covered"]  # 1.98 standard deviations
    assert parameter_rows(truth({**friction, "law": "LuGre"}), said) == []
    assert parameter_rows(truth(friction), diagnosis(entry("hysteresis", ("coulomb-friction", 0.5)))) == []
    drift = true_effect("parameter-drift", coefficient="stiffness", rate=0.1)
    said = diagnosis(entry("parameter-drift", coefficient=("stiffness", None), rate=(0.1, 0.01)))
    assert [r["parameter"] for r in parameter_rows(truth(drift), said)] == ["rate"]


def test_phase_that_differs_by_a_whole_turn_is_covered():
    hum = true_effect("periodic-disturbance", "disturbance", phase=-3.1)
    (row,) = parameter_rows(truth(hum), diagnosis(entry("periodic-disturbance", phase=(3.2, 0.02))))
    assert row["covered"]


def test_weights_of_all_members_are_held_against_the_truth():
    said = diagnosis(entry("hysteresis", ("coulomb-friction", 0.3), ("unlisted", 0.1)))
    rows = weight_rows(truth(true_effect("coulomb-friction")), said)
    assert [(r["id"], round(r["weight"], 9), r["right"]) for r in rows] == [
        ("hysteresis", 0.6, False),
        ("coulomb-friction", 0.3, True),
        ("unlisted", 0.1, False),
    ]
    # Where no name of the class is there, what is there is outside of it.
    assert [r["right"] for r in weight_rows(truth(), said)] == [False, False, True]
    assert weight_rows(truth(), SILENT) == []


def test_rate_is_wilsons_and_median_is_bracketed():
    # Newcombe, Statistics in Medicine 17 (1998), table I: 81 of 263 by Wilson's score method.
    assert rate(81, 263) == pytest.approx((81 / 263, 0.2553, 0.3662), abs=5e-5)
    assert np.isnan(rate(0, 0)).all()
    middle, low, high = median(np.r_[np.arange(1.0, 100.0), np.nan])
    assert (middle, low, high) == (50.0, 40.0, 60.0)  # order statistics of 99 values at 95 %


def scored(*pairs):
    rows = [{"index": i, **score(t, d)} for i, (t, d) in enumerate(pairs)]
    return pd.DataFrame(rows).assign(share_same_kind=np.nan, share_double_amplitude=np.nan)


def test_strength_bins_take_single_effects_with_a_size():
    pairs = [
        (truth(true_effect("delay", multiple=m)), SILENT if m < 3 else diagnosis(entry("delay"))) for m in (1, 2, 5)
    ]
    pairs += [(truth(), SILENT), (truth(true_effect("coloured-noise", "noise", None)), SILENT)]
    table = by_strength(scored(*pairs)).set_index(["low", "rate"])
    assert table.loc[(1.0, "detected"), ["share", "recordings"]].tolist() == [0.0, 2]
    assert table.loc[(3.0, "top"), ["share", "recordings"]].tolist() == [1.0, 1]
    assert table["recordings"].groupby("rate").sum().tolist() == [3] * 4


def test_reliability_and_coverage_tables_count_every_row():
    weights = pd.DataFrame({"weight": [0.0, 0.5, 0.55, 1.0], "right": [False, True, False, True]})
    table = reliability(weights)
    assert table["members"].sum() == 4
    assert table.set_index("low").loc[0.5, "share"] == 0.5
    parameters = pd.DataFrame(
        {"id": "delay", "parameter": "delay", "true": [1.0, 2.0], "value": [1.1, 2.0], "covered": [False, True]}
    )
    assert coverage(parameters).loc[0, ["share", "intervals"]].tolist() == [0.5, 2]


def test_weights_that_are_exactly_right_differ_by_chance_as_drawn_samples_do():
    generator = np.random.default_rng(5)
    table = pd.DataFrame({"weight": [0.1, 0.5, 0.9], "members": [400, 40, 60]})
    drawn = generator.binomial(table["members"], table["weight"], (20000, 3)) / table["members"].to_numpy()
    worst = np.abs(drawn - table["weight"].to_numpy()).max(axis=1)
    limit = largest_difference_by_chance(table)
    assert np.mean(worst <= limit + 1e-3) == pytest.approx(0.95, abs=0.02)
    assert np.isnan(largest_difference_by_chance(table.iloc[:0]))


def test_table_holds_every_rate_against_its_target():
    strong = true_effect("delay", "sensor")
    pairs = [(truth(), SILENT)] * 9 + [(truth(), diagnosis(entry("delay")))]
    pairs += [(truth(strong), diagnosis(entry("delay"), place="sensor"))] * 3 + [(truth(strong), SILENT)]
    pairs += [(truth(true_effect("detent"), kind="outside", snr_db=20.0), diagnosis(entry("delay")))]
    pairs += [(truth(true_effect("detent"), kind="outside", snr_db=40.0), SILENT)]
    parameters = pd.DataFrame({"id": [], "parameter": [], "covered": []})
    found = {q.quantity: q for q in lines(scored(*pairs), parameters, pd.DataFrame({"seconds": [1.0, 2.0, 16.0]}))}
    assert (found["false_alarms"].value, found["false_alarms"].met) == (10.0, False)
    assert (found["named_in_class"].value, found["named_in_class"].met, found["named_in_class"].count) == (
        75.0,
        False,
        4,
    )
    assert (found["outside_20"].value, found["outside_20"].met) == (100.0, False)
    assert (found["outside_40"].value, found["outside_40"].met) == (0.0, True)
    assert (found["run_time"].value, found["run_time"].met) == (2.0, True)
    assert (found["run_time_largest"].value, found["run_time_largest"].met) == (16.0, False)
    assert found["detected"].met is None
    text = to_markdown(list(found.values()), "computed at dusk")
    assert text.count("**no**") == 5
    assert text.endswith("computed at dusk\n")
    table = quantities(list(found.values()), "concealed").set_index("quantity")
    assert table.loc["place", "value"] == 75.0


def write_rig(folder, gains, offset):
    """Recordings of a rig with an input bias, and an improved model whose gain is given."""
    from camid.chain.acquisition import Acquisition
    from camid.chain.exact import sample
    from camid.chain.plant import TransferFunction

    generator = np.random.default_rng(5)
    plant = TransferFunction((100.0,), (1.0, 2.0, 100.0))
    acquisition = Acquisition(0.02, "zoh", "camera", 0.02, 0.0)

    def recorded(amplitude):
        signal = amplitude * np.sign(generator.standard_normal(600))
        clean = sample(plant, signal, acquisition) + offset
        noisy = clean + 0.01 * generator.standard_normal(600)
        return pd.DataFrame({"t": 0.02 * np.arange(600), "u": signal, "y": noisy, "clean": clean})

    simulation = {
        "schema": 1,
        "time": {"column": "t"},
        "input": {"column": "u", "hold": "zoh"},
        "plant": {"transfer_function": {"numerator": [100.0], "denominator": [1.0, 2.0, 100.0]}},
        "sensor": {"column": "y", "kind": "camera", "exposure": 0.02, "latency": 0.0},
        "effects": [],
    }
    for name in ("recordings", "held_out", "diagnoses"):
        (folder / name / "0").mkdir(parents=True)
    recorded(1.0)[["t", "u", "y"]].to_csv(folder / "recordings/0/recording.csv", index=False)
    for name, amplitude in (("same_kind", 1.0), ("double_amplitude", 2.0)):
        recorded(amplitude).to_csv(folder / f"held_out/0/{name}.csv", index=False)
    # JSON is YAML.
    (folder / "recordings/0/simulation.yaml").write_text(json.dumps(simulation), encoding="utf-8")
    simulation["plant"]["transfer_function"]["numerator"] = [100.0 * gains]
    (folder / "diagnoses/0/improved.yaml").write_text(json.dumps(simulation), encoding="utf-8")
    return [folder / name for name in ("recordings", "held_out", "diagnoses")]


def test_recovered_share_is_nothing_to_gain_where_the_nominal_model_is_right(tmp_path):
    found = recovered_shares(0, *write_rig(tmp_path, 1.0, 0.0))
    # Three coefficients of 600 rows: the refitted model is as near to the truth as the noise lets it.
    assert found["refitted_same_kind"] == pytest.approx(found["floor_same_kind"], rel=0.01)
    assert found["improved_same_kind"] == pytest.approx(found["floor_same_kind"], rel=1e-9)


def test_recovered_share_follows_its_definition_and_shows_a_worse_model(tmp_path):
    found = recovered_shares(0, *write_rig(tmp_path, 1.5, 0.3))
    for name in ("same_kind", "double_amplitude"):
        refitted, improved, floor = (found[f"{which}_{name}"] for which in ("refitted", "improved", "floor"))
        assert floor < refitted < improved
        assert found[f"share_{name}"] == pytest.approx((refitted - improved) / (refitted - floor))
        assert found[f"share_{name}"] < 0.0


def test_matrix_counts_every_chosen_recording_once():
    friction, weak = true_effect("coulomb-friction"), true_effect("coulomb-friction", multiple=1.0)
    said = diagnosis(entry("hysteresis", ("coulomb-friction", 0.3)))
    pairs = [
        (truth(friction), said),
        (truth(friction), diagnosis(entry("delay"), entry("coulomb-friction"))),
        (truth(friction), diagnosis(verdict="unexplained")),
        (truth(friction), SILENT),
        (truth(weak), said),  # too weak to count
        (truth(friction, true_effect("delay")), said),  # two effects are no cell of the matrix
        (truth(), SILENT),
        (truth(true_effect("detent"), kind="outside"), diagnosis(entry("van-der-pol"))),
    ]
    table = count(scored(*pairs)).set_index(["truth", "named"])
    assert table["recordings"].to_dict() == {
        ("coulomb-friction", "hysteresis"): 1,
        ("coulomb-friction", "coulomb-friction"): 1,
        ("coulomb-friction", "detected, no name"): 1,
        ("coulomb-friction", "nothing missing"): 1,
        ("nothing missing", "nothing missing"): 1,
        ("outside the catalogue", "another name"): 1,
    }
    assert table.loc["coulomb-friction", "in_class"].sum() == 2


NO_CLAIM = "outside the catalogue, no confident claim"


@pytest.mark.parametrize(
    ("case", "said", "word"),
    [
        (truth(), SILENT, "right"),
        (truth(), diagnosis(entry("delay")), "wrong"),
        (truth(true_effect("delay")), diagnosis(entry("exposure", ("delay", 0.5))), "right, in a class"),
        (truth(true_effect("delay")), diagnosis(verdict="unexplained"), "not (all) named"),
        (
            truth(true_effect("delay")),
            diagnosis(entry("delay"), entry("end-stop")),
            "right, with a wrong name besides",
        ),
        (
            truth(true_effect("delay"), true_effect("end-stop", multiple=1.0)),
            diagnosis(entry("delay")),
            "a weaker one not named",
        ),
        (truth(true_effect("delay"), true_effect("end-stop")), diagnosis(entry("delay")), "not (all) named"),
        (truth(true_effect("detent"), kind="outside"), diagnosis(entry("end-stop")), "wrong"),
        (truth(true_effect("detent"), kind="outside"), diagnosis(verdict="unexplained"), NO_CLAIM),
        (truth(true_effect("detent"), kind="outside"), SILENT, "not detected"),
        (truth(true_effect("delay", multiple=0.3)), SILENT, "not detected"),
    ],
)
def test_sample_puts_the_outcome_in_one_word(case, said, word):
    assert outcome(score(case, said)) == word


def test_every_figure_is_drawn_from_scores_that_lack_most_kinds():
    """A small set has empty groups; no figure may fail on them or lose a row."""
    few = scored((truth(), SILENT), (truth(true_effect("delay")), diagnosis(entry("delay"))))
    for module in (confusion_matrix, strength, recovered_share, sample):
        figure, plotted = module.draw(few.assign(**{f"{q}_{n}": 0.5 for q in QUANTITIES for n in HELD_OUT}))
        assert len(plotted) >= 1
        plt.close(figure)
    figure, plotted = run_time.draw(pd.DataFrame({"seconds": [2.0, 1.0]}))
    assert plotted["share"].tolist() == [50.0, 100.0]
    plt.close(figure)
    figure, plotted = weights.draw(pd.DataFrame({"weight": [1.0], "right": [True]}))
    assert plotted["members"].tolist() == [1]
    plt.close(figure)
