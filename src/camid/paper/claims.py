"""The paper's checkable claims with a verdict computed from the numbers, and its ambiguities with the choice made."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

REPRODUCED, CAVEAT, NOT_REPRODUCED = "reproduced", "reproduced with a caveat", "not reproduced"
ROUNDING = 1e-11  # what exact arithmetic leaves of an identity between coefficients of the order of one


class Numbers:
    """Look-up of quantities by target and name."""

    def __init__(self, quantities: pd.DataFrame) -> None:
        self._values = quantities.set_index(["target", "quantity"])["value"]

    def __call__(self, target: str, quantity: str) -> float:
        """Value of a quantity."""
        return float(self._values[(target, quantity)])


def verdict(holds: bool, caveat: bool = False) -> str:
    """Verdict on a claim that holds or not, with or without a caveat."""
    if not holds:
        return NOT_REPRODUCED
    return CAVEAT if caveat else REPRODUCED


def claims(quantities: pd.DataFrame) -> pd.DataFrame:
    """Table of claims.

    Parameters
    ----------
    quantities : DataFrame
        From :func:`camid.paper.quantities.all_quantities`.

    Returns
    -------
    DataFrame
        Columns ``claim``, ``section``, ``verdict``, ``number``, ``target``.
    """
    value = Numbers(quantities)
    rows = [*_imaging(value), *_models(value), *_discrete_time(value), *_identification(value), *_neglected_mode(value)]
    return pd.DataFrame(rows, columns=["claim", "section", "verdict", "number", "target"])


Row = tuple[str, str, str, str, str]


def tiny(value: float, limit: float) -> str:
    """Rounding errors differ between processors, so only the limit that they stay below is stated."""
    return f"less than {limit:.0e}" if abs(value) < limit else f"{value:.0e}"


def _imaging(value: Numbers) -> Iterable[Row]:
    small, large = value("assumptions", "A1_8_threshold_0.5"), value("assumptions", "A1_45_threshold_0.5")
    low = value("assumptions", "A1_45_threshold_0.05")
    yield (
        "If A1 fails, the centre of mass shifts in the centrifugal direction",
        "2.2",
        verdict(large > small > 0.0, caveat=low < 0.0),
        f"outward shift at 24 Hz {small:+.2f} px (8 px marker) to {large:+.2f} px (45 px) with the threshold at 0.5 of "
        f"the largest gradient; at 0.05 it turns inward ({low:+.2f} px): the sign is the threshold's",
        "assumptions",
    )
    without, crossing = value("assumptions", "A2_0.75_threshold_0.2"), value("assumptions", "A2_1.5_threshold_0.2")
    yield (
        "If A2 fails, the result shifts compared with (1)",
        "2.2",
        verdict(crossing > 2.0 * without),
        f"{without:.1f} px from (1) at 3/4 of a turn in an exposure, {crossing:.1f} px at 1½ turns (8 px marker)",
        "assumptions",
    )
    holds, fails = value("assumptions", "A4_holds"), value("assumptions", "A4_fails")
    yield (
        "Under A4, (2) becomes the time mean (4), (5)",
        "2.2",
        verdict(holds < 1e-9 and fails > 1.0),
        f"they differ by {tiny(holds, 1e-9)} px at constant speed, by {fails:.1f} px for 60 px from rest at constant "
        "acceleration",
        "assumptions",
    )
    ratio, share = value("fig3", "signal_to_noise_measured"), value("fig3", "systematic_share_of_error")
    yield (
        "Fig. 3: the model reproduces the image processing, the error is random and the SNR high",
        "2.2",
        verdict(ratio > 30.0, caveat=share > 0.5),
        f"SNR {ratio:.1f} dB; but {100 * share:.0f} % of the error's power is one constant outward shift of "
        f"{value('fig3', 'outward_error_measured'):.2f} px, not random",
        "fig3",
    )
    difference = value("assumptions", "colour_against_grey")
    yield (
        "A colour camera is three independent components",
        "2.1",
        verdict(difference < 1e-9),
        f"largest difference of a component from the grey camera {tiny(difference, 1e-9)} grey levels",
        "assumptions",
    )


def _models(value: Numbers) -> Iterable[Row]:
    gain, phase = value("fig6", "gain_1_at_1_over_T"), value("fig6", "phase_at_1_over_T")
    yield (
        "The camera's effects are negligible below ω = 1/T",
        "2.4",
        verdict(gain > -0.5, caveat=phase < -5.0),
        f"at ω = 1/T the gain is {gain:.2f} dB, but the phase already {phase:.1f}°",
        "fig6",
    )
    apart, before = value("fig6", "phase_apart_modulo_half_turn"), value("fig6", "phase_apart_below_first_zero")
    yield (
        "The three models have the same phase and different gains",
        "2.4",
        verdict(apart < 1e-6, caveat=True),
        f"phases differ by {tiny(before, 1e-9)}° up to 1/(2T); each zero turns the sign, so beyond it they differ by "
        "half turns",
        "fig6",
    )
    zero_1, zero_2 = value("fig6", "gain_1_at_its_zeros"), value("fig6", "gain_2_at_its_zeros")
    yield (
        "Zeros of Model #1 at (1 + k)/T, of Model #2 at (½ + k)/T",
        "2.4",
        verdict(max(zero_1, zero_2) < ROUNDING),
        f"largest gain at {value('fig6', 'zeros_shown_1'):.0f} and {value('fig6', 'zeros_shown_2'):.0f} zeros: "
        f"{tiny(zero_1, 1e-12)} and {tiny(zero_2, 1e-12)}",
        "fig6",
    )
    first = value("fig6", "largest_gain_1_past_1_over_T_hertz")
    second = value("fig6", "largest_gain_2_past_1_over_T_hertz")
    yield (
        "Model #1 attenuates high frequencies (natural anti-aliasing), Model #2 does not",
        "2.4",
        verdict(first < -10.0 and second > -0.5),
        f"largest gain between 1/T and 3/T: {first:.1f} dB (Model #1), {second:.1f} dB (Model #2)",
        "fig6",
    )


def _discrete_time(value: Numbers) -> Iterable[Row]:
    for statement, column in (
        ("(14) is the first-order-hold equivalent behind one delay", "hold_equivalent"),
        ("The closed form (16)–(23)", "closed_form"),
        ("A discrete-time model with one delay and order two above and below is exact for camera data", "identified"),
    ):
        difference = value("discrete_time", f"largest_difference_{column}")
        yield (
            statement,
            "3.1",
            verdict(difference < (1e-9 if column == "identified" else ROUNDING)),
            f"largest difference from the exact discretisation {tiny(difference, 1e-12)}",
            "discrete_time",
        )
    count = value("discrete_time", "coefficients")
    yield (
        "Five discrete-time against three continuous-time parameters",
        "3.1",
        verdict(count == 5),
        f"{count:.0f} coefficients identified in discrete time, 3 in continuous time",
        "discrete_time",
    )


def _identification(value: Numbers) -> Iterable[Row]:
    default, argument = value("fig7", "largest_error_camera"), value("fig7", "largest_error_foh-argument")
    plain, fails = (
        value("fig7", "largest_error_plain_srivc_where_converged"),
        value("fig7", "plain_srivc_fails_from_product"),
    )
    yield (
        "Declared as first-order hold, camera data give errors below 1 % without noise while Tω0 < π",
        "3.2",
        verdict(max(default, argument, plain) < GOOD_PERCENT, caveat=fails < 3.14),
        f"largest error {tiny(default, 1e-9)} % (camera sensor model), {tiny(argument, 1e-9)} % (first-order-hold "
        f"argument); plain SRIVC {tiny(plain, 1e-5)} %, but it first fails to converge at Tω0 = {fails:.2f}",
        "fig7",
    )
    errors = [value("fig7", f"noise_rms_error_{p}") for p in ("b0", "a1", "a0")]
    bounds = [value("fig7", f"noise_bound_{p}") for p in ("b0", "a1", "a0")]
    yield (
        "… and around several percent with noise",
        "3.2",
        verdict(all(e < 10.0 for e in errors) and max(errors) > 1.0),
        "rms error of b0, a1, a0: {:.1f}, {:.1f}, {:.2f} %; Cramér–Rao bound {:.1f}, {:.1f}, {:.2f} %".format(
            *errors, *bounds
        ),
        "fig7",
    )
    shift = {p: [value("fig7", f"zoh_plain-srivc_{p}_at_{t:g}") for t in (0.02, 0.05, 0.1)] for p in ("b0", "a1", "a0")}
    grows = shift["a0"][0] < shift["a0"][1] < shift["a0"][2]
    mainly = all(abs(a0) >= max(abs(b0), abs(a1)) for b0, a1, a0 in zip(*shift.values(), strict=True))
    yield (
        "Declared as zero-order hold, a shift appears, mainly on a0, and grows with T",
        "3.2",
        verdict(grows and shift["a0"][0] > 1.0, caveat=not mainly),
        "plain SRIVC, T = 20, 50, 100 ms: a0 {:+.1f}, {:+.1f}, {:+.1f} %".format(*shift["a0"])
        + "; a1 {:+.1f}, {:+.1f}, {:+.1f} %".format(*shift["a1"])
        + "; b0 {:+.1f}, {:+.1f}, {:+.1f} %".format(*shift["b0"])
        + (": a1 shifts as much" if not mainly else ""),
        "fig7",
    )


def _neglected_mode(value: Numbers) -> Iterable[Row]:
    product = value("fig8", "one_percent_from_product")
    yield (
        "With a neglected mode, the accuracy is 1 % if Tω1 is large enough",
        "3.3",
        verdict(product < 8.0),
        f"all three errors below 1 % from Tω1 = {product:.2f} on (camera, first-order hold)",
        "fig8",
    )
    hold, argument = value("fig8", "a0_error_zoh_at_highest"), value("fig8", "a0_error_foh_at_highest")
    yield (
        "The first-order-hold argument improves much, specially a0",
        "3.3",
        verdict(hold > 3.0 * argument),
        f"error of a0 at the highest ω1: {hold:.2f} % declared zero-order hold, {argument:.2f} % first-order hold",
        "fig8",
    )
    same = value("fig8", "camera_foh_against_instant_zoh")
    yield (
        "The camera acts like one more hold of the input: camera + FOH is as good as no camera + ZOH",
        "4",
        verdict(same < 0.1),
        f"the errors of the two cases differ by at most {same:.3f} percentage points",
        "fig8",
    )


GOOD_PERCENT = 1.0


def ambiguities(quantities: pd.DataFrame) -> pd.DataFrame:
    """What the paper leaves open: the choice made here and what the other choice gives.

    Returns
    -------
    DataFrame
        Columns ``question``, ``choice``, ``otherwise``.
    """
    value = Numbers(quantities)
    power = [value("fig7", f"noise_rms_error_{p}") for p in ("b0", "a1", "a0")]
    amplitude = [value("fig7", f"noise_rms_error_{p}_amplitude") for p in ("b0", "a1", "a0")]
    shifted = [value("fig7", f"zoh_srivc_{p}_at_0.1") for p in ("b0", "a1", "a0")]
    unshifted = [value("fig7", f"zoh-unshifted_srivc_{p}_at_0.1") for p in ("b0", "a1", "a0")]
    rows = [
        (
            "What does “SNR of 10” mean?",
            "a ratio of powers, 10 dB: rms errors of b0, a1, a0 {:.1f}, {:.1f}, {:.2f} %".format(*power),
            "a ratio of amplitudes, 20 dB: {:.2f}, {:.2f}, {:.2f} %".format(*amplitude),
        ),
        (
            "Which samples are paired in case (ii)?",
            "u[k] with w[k+1], as in case (i), so that only the hold differs: b0, a1, a0 off by "
            "{:+.1f}, {:+.1f}, {:+.1f} % at T = 0.1 s by the default method".format(*shifted),
            "u[k] with w[k]: {:+.1f}, {:+.1f}, {:+.1f} %".format(*unshifted),
        ),
        (
            "What is K in (24)?",
            "the numerator b0 = Kω0² of (15); with K = 1 as printed the static gain would be 1/a0",
            "static gain b0/a0 = K: its error is that of b0 less that of a0, to first order",
        ),
        (
            "Which threshold follows the Sobel filter?",
            f"0.2 of the largest gradient: SNR of Fig. 3 {value('fig3', 'signal_to_noise_measured'):.1f} dB, outward "
            f"shift {value('fig3', 'outward_error_measured'):.2f} px",
            f"0.5: {value('fig3', 'signal_to_noise_half_threshold'):.1f} dB, "
            f"{value('fig3', 'outward_error_half_threshold'):.2f} px; the grey-level centroid "
            f"{value('fig3', 'signal_to_noise_grey_level'):.0f} dB",
        ),
        (
            "How is SRIVC started and stopped?",
            "state-variable filters, best of eight cut-offs; at most 100 iterations, relative change 1e-8",
            f"the curves of Fig. 7 use safeguarded SRIVC, which converges up to π; plain SRIVC first fails without "
            f"noise at Tω0 = {value('fig7', 'plain_srivc_fails_from_product'):.2f}",
        ),
    ]
    return pd.DataFrame(rows, columns=["question", "choice", "otherwise"])


def to_markdown(claim_table: pd.DataFrame, ambiguity_table: pd.DataFrame) -> str:
    """Both tables as Markdown."""
    from tabulate import tabulate

    def pipe(table: pd.DataFrame) -> str:
        escaped = table.map(lambda cell: str(cell).replace("|", "\\|"))
        return tabulate(escaped.to_dict("list"), headers="keys", tablefmt="pipe", disable_numparse=True)

    return f"{pipe(claim_table)}\n\nWhat the paper leaves open:\n\n{pipe(ambiguity_table)}\n"
