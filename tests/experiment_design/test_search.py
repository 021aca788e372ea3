"""The search for an experiment: what it spends its simulations on."""

from collections import Counter

import numpy as np

from camid.diagnosis.watch import Watch
from camid.experiment_design.limits import Limits
from camid.experiment_design.search import REFINED, Search
from camid.experiment_design.signals import FAMILIES, Band
from tests.experiment_design.test_design import NOISE, hypothesis
from tests.support.mass_on_spring import PERIOD, effect


def test_families_that_say_little_are_looked_at_no_further(monkeypatch):
    """A few members of each family tell which are worth more."""
    names = [hypothesis("drag", effect("quadratic-drag", coefficient=0.01)), hypothesis("")]
    limits = Limits(-1.0, 1.0, 100.0, 4.0, (PERIOD,))
    worth = {family.name: i for i, family in enumerate(FAMILIES)}
    seen = []
    search = Search(names, limits, NOISE, lambda _: worth[seen[-1]], 2e5, Watch(None, None))
    sampled = search.member

    def member(family, *others):
        seen.append(family.name)
        return sampled(family, *others)

    monkeypatch.setattr(search, "member", member)
    monkeypatch.setattr(search, "_refined", lambda *_: None)
    monkeypatch.setattr(search, "_join", lambda _: None)
    search.best()
    counts = Counter(seen)
    best = [family.name for family in FAMILIES[-REFINED:]]
    assert min(counts[name] for name in best) > 2 * max(counts[f.name] for f in FAMILIES if f.name not in best)
    assert all(counts[f.name] > 1 for f in FAMILIES)


def test_half_of_the_candidates_use_a_third_of_the_range():
    band = Band(0.5, 5.0, PERIOD, 400)
    for family in FAMILIES:
        sizes = [
            np.max(np.abs(family.make(np.random.default_rng(seed).random(family.numbers), band)[0]))
            for seed in range(60)
        ]
        assert np.median(sizes) > 0.3
        assert min(sizes) < 0.15
