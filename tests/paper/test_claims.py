"""The verdicts must follow the numbers."""

import pandas as pd
import pytest

from camid.paper.claims import CAVEAT, NOT_REPRODUCED, REPRODUCED, ambiguities, claims, to_markdown


@pytest.fixture
def quantities():
    """Numbers that satisfy every claim without a caveat, where that is possible."""
    values = {
        ("assumptions", "A1_8_threshold_0.5"): 0.5,
        ("assumptions", "A1_45_threshold_0.5"): 3.0,
        ("assumptions", "A1_45_threshold_0.05"): 1.0,
        ("assumptions", "A2_0.75_threshold_0.2"): 1.0,
        ("assumptions", "A2_1.5_threshold_0.2"): 8.0,
        ("assumptions", "A4_holds"): 0.0,
        ("assumptions", "A4_fails"): 10.0,
        ("assumptions", "colour_against_grey"): 0.0,
        ("fig3", "signal_to_noise_measured"): 40.0,
        ("fig3", "signal_to_noise_half_threshold"): 35.0,
        ("fig3", "signal_to_noise_grey_level"): 90.0,
        ("fig3", "systematic_share_of_error"): 0.1,
        ("fig3", "outward_error_measured"): 0.1,
        ("fig3", "outward_error_half_threshold"): 0.1,
        ("fig6", "gain_1_at_1_over_T"): -0.1,
        ("fig6", "phase_at_1_over_T"): -1.0,
        ("fig6", "phase_apart_modulo_half_turn"): 0.0,
        ("fig6", "phase_apart_below_first_zero"): 0.0,
        ("fig6", "gain_1_at_its_zeros"): 0.0,
        ("fig6", "gain_2_at_its_zeros"): 0.0,
        ("fig6", "zeros_shown_1"): 3,
        ("fig6", "zeros_shown_2"): 4,
        ("fig6", "largest_gain_1_past_1_over_T_hertz"): -13.0,
        ("fig6", "largest_gain_2_past_1_over_T_hertz"): 0.0,
        ("discrete_time", "largest_difference_hold_equivalent"): 0.0,
        ("discrete_time", "largest_difference_closed_form"): 0.0,
        ("discrete_time", "largest_difference_identified"): 0.0,
        ("discrete_time", "coefficients"): 5,
        ("fig7", "largest_error_camera"): 0.0,
        ("fig7", "largest_error_foh-argument"): 0.0,
        ("fig7", "largest_error_plain_srivc_where_converged"): 0.0,
        ("fig7", "plain_srivc_fails_from_product"): float("nan"),
        ("fig8", "one_percent_from_product"): 1.5,
        ("fig8", "a0_error_zoh_at_highest"): 2.0,
        ("fig8", "a0_error_foh_at_highest"): 0.1,
        ("fig8", "camera_foh_against_instant_zoh"): 0.01,
    }
    for parameter, noise in {"b0": 2.0, "a1": 3.0, "a0": 0.4}.items():
        values[("fig7", f"noise_rms_error_{parameter}")] = noise
        values[("fig7", f"noise_rms_error_{parameter}_amplitude")] = noise / 3.0
        values[("fig7", f"noise_bound_{parameter}")] = noise
        for period, shift in {"0.02": 1.5, "0.05": 5.0, "0.1": 11.0}.items():
            value = shift if parameter == "a0" else 0.1
            for case in ("zoh_plain-srivc", "zoh_srivc", "zoh-unshifted_srivc"):
                values[("fig7", f"{case}_{parameter}_at_{period}")] = value

    def build(**changes):
        table = dict(values)
        for name, value in changes.items():
            target, quantity = name.split("__")
            key = next(k for k in table if k[0] == target and k[1].replace("-", "_").replace(".", "_") == quantity)
            table[key] = value
        return pd.DataFrame([{"target": t, "quantity": q, "value": v} for (t, q), v in table.items()])

    return build


def verdict_of(table, beginning):
    rows = table[table["claim"].str.contains(beginning, regex=False)]
    assert len(rows) == 1
    return rows["verdict"].iloc[0]


def test_all_claims_hold_where_the_numbers_are_ideal(quantities):
    table = claims(quantities())
    assert len(table) >= 18
    assert set(table["verdict"]) <= {REPRODUCED, CAVEAT}
    assert verdict_of(table, "below 1 % without noise") == REPRODUCED


@pytest.mark.parametrize(
    ("change", "claim", "expected"),
    [
        ({"fig7__largest_error_camera": 1.5}, "below 1 % without noise", NOT_REPRODUCED),
        ({"fig7__plain_srivc_fails_from_product": 2.7}, "below 1 % without noise", CAVEAT),
        ({"fig7__noise_rms_error_a1": 40.0}, "several percent with noise", NOT_REPRODUCED),
        ({"fig7__zoh_plain_srivc_a0_at_0_1": 4.0}, "mainly on a0", NOT_REPRODUCED),
        ({"fig7__zoh_plain_srivc_a1_at_0_1": 12.0}, "mainly on a0", CAVEAT),
        ({"assumptions__A1_45_threshold_0_5": 0.1}, "If A1 fails", NOT_REPRODUCED),
        ({"assumptions__A1_45_threshold_0_05": -3.0}, "If A1 fails", CAVEAT),
        ({"assumptions__A2_1_5_threshold_0_2": 1.2}, "If A2 fails", NOT_REPRODUCED),
        ({"assumptions__A4_holds": 0.1}, "Under A4", NOT_REPRODUCED),
        ({"fig3__signal_to_noise_measured": 10.0}, "Fig. 3", NOT_REPRODUCED),
        ({"fig3__systematic_share_of_error": 0.9}, "Fig. 3", CAVEAT),
        ({"fig6__gain_2_at_its_zeros": 0.01}, "Zeros of Model #1", NOT_REPRODUCED),
        ({"fig6__phase_at_1_over_T": -28.6}, "negligible", CAVEAT),
        ({"fig6__gain_1_at_1_over_T": -3.0}, "negligible", NOT_REPRODUCED),
        ({"fig6__largest_gain_1_past_1_over_T_hertz": -2.0}, "anti-aliasing", NOT_REPRODUCED),
        ({"discrete_time__largest_difference_closed_form": 1e-3}, "closed form", NOT_REPRODUCED),
        ({"discrete_time__largest_difference_identified": 1e-3}, "one delay and order two", NOT_REPRODUCED),
        ({"fig8__one_percent_from_product": float("nan")}, "1 % if Tω1", NOT_REPRODUCED),
        ({"fig8__a0_error_foh_at_highest": 1.9}, "improves much", NOT_REPRODUCED),
        ({"fig8__camera_foh_against_instant_zoh": 1.0}, "one more hold", NOT_REPRODUCED),
    ],
)
def test_a_number_that_contradicts_changes_the_verdict(change, claim, expected, quantities):
    assert verdict_of(claims(quantities(**change)), claim) == expected


def test_markdown_has_a_row_for_each_claim_and_question(quantities):
    table, questions = claims(quantities()), ambiguities(quantities())
    text = to_markdown(table, questions)
    assert sum(line.startswith("|") for line in text.splitlines()) == len(table) + len(questions) + 4
