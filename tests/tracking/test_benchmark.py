"""The benchmark's clip and tools, on a short clip."""

import numpy as np

from benchmarks import run, tracking


def test_all_tools_find_the_same_marker(tmp_path, monkeypatch):
    assert "tracking" in run.NAMES
    monkeypatch.setattr(tracking, "FRAMES", 12)
    truth = tracking.render(tmp_path / "clip.mp4")
    assert truth.shape == (12, 2)
    for found, limit in (
        (tracking.by_camid(tmp_path / "clip.mp4", dark=True), 0.2),
        (tracking.by_camid(tmp_path / "clip.mp4", colour="red"), 0.4),
        (tracking.by_opencv(tmp_path / "clip.mp4", tracking.darkness), 0.2),
        (tracking.by_opencv(tmp_path / "clip.mp4", tracking.edges), 1.0),
    ):
        assert np.abs(found - truth).max() < limit
