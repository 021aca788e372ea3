"""What a diagnosis got right, from the contracts alone: the truth and the content of diagnosis.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

# An effect counts where it is this many times the detectable size, a class where it has at most this many ids.
STRONG = 3.0
LARGEST_CLASS = 4
CONFIDENT = 0.9
# How much more an assignment of entries to true effects counts for an entry's own name: no two outweigh another effect.
OWN_NAME = 0.01
COVERAGE = 0.95
# Alternative of a finding that stands for physics outside the catalogue and names nothing. It is part of the contract
# of diagnosis.json, so that it is written here and not imported from what is judged.
UNLISTED = "unlisted"
# Laws that were learned and claim no name.
NAMELESS = frozenset({"learned-force", "learned-curve"})
# Input and output alone cannot tell these apart, though they sit in different places (the design, section 2).
INSEPARABLE = (
    frozenset({"delay", "exposure", "actuator-lag", "input-hold"}),
    frozenset({"input-bias", "sensor-offset"}),
    frozenset({"asymmetric-friction", "coulomb-friction"}),  # beside a bias, or an offset that is estimated
)
COLOURED_NOISE = "coloured-noise"
FAILED = "failed"


def named_in(diagnosis: Mapping[str, Any] | None) -> list[Mapping[str, Any]]:
    """The entries of a diagnosis that claim a name."""
    return [e for e in (diagnosis or {}).get("effects", []) if e["id"] not in NAMELESS]


def class_of(effect: Mapping[str, Any]) -> list[str]:
    """Ids that an entry of the diagnosis offers, its own first."""
    ids = [effect["id"], *(a["id"] for a in effect.get("alternatives") or [])]
    return [i for i in dict.fromkeys(ids) if i != UNLISTED]


def own_weight(effect: Mapping[str, Any]) -> float:
    """Weight of the entry's own id: what its alternatives leave of one."""
    # A weight that is no number says nothing.
    return 1.0 - sum(float(a["weight"] or 0.0) for a in effect.get("alternatives") or [])


def _offers(effect: Mapping[str, Any], identifier: str, in_class: bool) -> bool:
    """Whether the entry names an id: as its own or, if asked, in a class that is small enough to say something."""
    if effect["id"] == identifier:
        return True
    members = class_of(effect)
    return in_class and len(members) <= LARGEST_CLASS and identifier in members


def named_effects(truths: Sequence[str], effects: Sequence[Mapping[str, Any]], *, in_class: bool) -> NDArray[np.bool_]:
    """Which true effects a diagnosis names, each by an entry of its own.

    Parameters
    ----------
    truths : sequence of str
        True ids.
    effects : sequence of mapping
        ``effects`` of diagnosis.json.
    in_class : bool
        Whether a place in the class of an entry counts, too.

    Returns
    -------
    ndarray of bool, shape (len(truths),)
    """
    from scipy.optimize import linear_sum_assignment

    offered = np.array([[_offers(e, t, in_class) for e in effects] for t in truths], bool)
    offered = offered.reshape(len(truths), len(effects))
    named = np.zeros(len(truths), bool)
    # An entry stands for what it has for its own name before it stands for another of its class.
    own = np.array([[e["id"] == t for e in effects] for t in truths], bool).reshape(offered.shape)
    rows, columns = linear_sum_assignment(offered + OWN_NAME * own, maximize=True)
    named[rows] = offered[rows, columns]
    return named


def strongest(effects: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """The true effect of the largest multiple of the detectable size; one without a multiple only if none has one."""
    return max(effects, key=lambda e: -1.0 if e["multiple"] is None else e["multiple"], default=None)


def score(truth: Mapping[str, Any], diagnosis: Mapping[str, Any] | None) -> dict[str, Any]:
    """Hold one diagnosis against the truth.

    Parameters
    ----------
    truth : mapping
        ``kind`` (none, single, several, outside, invisible) and ``effects`` with id, place and ``multiple`` of the
        detectable size beside the others, among others; optionally ``multiple_alone``, that without them.
    diagnosis : mapping or None
        Content of diagnosis.json; None where the diagnosis failed, which counts as wrong everywhere.

    Returns
    -------
    dict
        ``kind``, ``truth`` (ids joined by " + "), ``place``, ``multiple`` (of the strongest), ``snr_db``, ``verdict``,
        ``inexact`` (whether a law is not that of the catalogue), ``named`` (the strongest entry's id or ""), ``names``
        (all of them), ``named_place``; and what was right:

        ``detected``; ``false_alarm`` (kinds none and invisible, and coloured noise alone: something else named);
        ``top`` and ``in_class`` (all true effects named); ``place_top``, ``place_in_class``; ``strong`` (true effects
        of at least three times the detectable size), ``strong_top``, ``strong_in_class`` (those named), and the same of
        the sizes alone (``strong_alone``, ``strong_alone_in_class``); ``wrong_names``
        (entries that fit no truth); ``confidently_wrong`` (said to be explained without the true effects, or a wrong id
        with a weight of at least 0.9).
    """
    true_effects = list(truth["effects"])
    ids = [e["id"] for e in true_effects]
    main = strongest(true_effects)
    effects = named_in(diagnosis)
    verdict = diagnosis["verdict"] if diagnosis else FAILED
    detected = verdict not in {"adequate", FAILED}
    place = diagnosis["location"]["place"] if diagnosis else None
    top, in_class = (named_effects(ids, effects, in_class=wide) for wide in (False, True))
    strong, strong_alone = (
        np.array([e.get(size) is not None and e[size] >= STRONG for e in true_effects], bool)
        for size in ("multiple", "multiple_alone")
    )
    place_top = bool(detected and main is not None and place == main["place"])
    inseparable = main is not None and any(main["id"] in group for group in INSEPARABLE)
    wrong = [e for e in effects if e["id"] != UNLISTED and not any(_offers(e, i, True) for i in ids)]
    return {
        "kind": truth["kind"],
        "truth": " + ".join(ids),
        "place": main["place"] if main else "",
        "multiple": main["multiple"] if main and main["multiple"] is not None else np.nan,
        "snr_db": float(truth["snr_db"]),
        "repeatable": bool(truth["repeatable"]),
        "images": bool(truth["images"]),
        "inexact": any(e["law"] != "catalogue" for e in true_effects),
        "verdict": verdict,
        "named": next((e["id"] for e in effects if e["id"] != UNLISTED), ""),
        "names": " + ".join(e["id"] for e in effects),
        "named_place": place or "",
        "detected": detected,
        "false_alarm": _false_alarm(truth["kind"], ids, verdict, effects),
        "top": bool(ids) and bool(top.all()),
        "in_class": bool(ids) and bool(in_class.all()),
        "place_top": place_top,
        "place_in_class": place_top
        or bool(main is not None and inseparable and any(_offers(e, main["id"], True) for e in effects)),
        "strong": int(strong.sum()),
        "strong_top": int(top[strong].sum()),
        "strong_in_class": int(in_class[strong].sum()),
        "strong_alone": int(strong_alone.sum()),
        "strong_alone_in_class": int(in_class[strong_alone].sum()),
        "wrong_names": len(wrong),
        "confidently_wrong": (verdict == "explained" and not in_class.all())
        or any(own_weight(e) >= CONFIDENT for e in wrong),
    }


def _false_alarm(kind: str, ids: list[str], verdict: str, effects: Sequence[Mapping[str, Any]]) -> bool:
    if kind in {"none", "invisible"}:
        return verdict != "adequate"
    if kind == "single" and ids == [COLOURED_NOISE]:
        return verdict == FAILED or any(e["id"] != COLOURED_NOISE for e in effects)
    return False


def parameter_rows(truth: Mapping[str, Any], diagnosis: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    """True and stated values of the parameters of rightly named effects that follow the catalogue's law.

    Returns
    -------
    list of dict
        ``id``, ``parameter``, ``true``, ``value``, ``std``, ``unit`` and ``covered``: whether the stated 95 % interval
        (value ± 1.96 std) holds the true value. Parameters that are words, and values without std, are left out.
    """
    reach = NormalDist().inv_cdf(0.5 + COVERAGE / 2.0)
    rows = []
    for true_effect in truth["effects"]:
        if true_effect["law"] != "catalogue":
            continue
        found = next((e for e in (diagnosis or {}).get("effects", []) if e["id"] == true_effect["id"]), None)
        for name, true_value in true_effect["parameters"].items():
            stated = (found or {}).get("parameters", {}).get(name)
            if stated is None or stated["std"] is None:
                continue
            if not all(isinstance(v, int | float) for v in (stated["value"], true_value)):
                continue
            difference = float(stated["value"]) - float(true_value)
            if name == "phase":  # a whole turn makes no difference
                difference = float(np.angle(np.exp(1j * difference)))
            rows.append(
                {
                    "id": true_effect["id"],
                    "parameter": name,
                    "true": float(true_value),
                    "value": float(stated["value"]),
                    "std": float(stated["std"]),
                    "unit": stated["unit"],
                    "covered": abs(difference) <= reach * float(stated["std"]),
                }
            )
    return rows


def weight_rows(truth: Mapping[str, Any], diagnosis: Mapping[str, Any] | None) -> list[dict[str, Any]]:
    """Stated weights of all members of all classes, and whether each is right.

    A name is right if it is one of the true ids, and physics outside the catalogue if no name of the class is.

    Returns
    -------
    list of dict
        ``id``, ``weight``, ``right``.
    """
    ids = {effect["id"] for effect in truth["effects"]}
    rows = []
    for effect in named_in(diagnosis):
        members = [(effect["id"], own_weight(effect))]
        members += [(a["id"], float(a["weight"])) for a in effect.get("alternatives") or []]
        outside = ids.isdisjoint(class_of(effect))
        rows += [{"id": i, "weight": w, "right": outside if i == UNLISTED else i in ids} for i, w in members]
    return rows
