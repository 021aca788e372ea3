"""A rig with its loop, its camera and a reference: what is there before anything is concealed."""

from dataclasses import dataclass, replace

import numpy as np

from .controllers import Loop, controller, draw_loop
from .motion import Motion, run
from .references import NAMES, draw_reference
from .rigs import Array, Generator, Rig, draw_rig
from .setup import Camera, Scales, Setup


@dataclass(frozen=True)
class Scene:
    """A recording to be made: ``reference`` has a value (y) for each of ``lead`` + ``rows`` + ``behind`` rows.

    The recording begins ``lead`` rows after the machine left its rest, and the machine runs on for ``behind`` rows
    after its end. ``noise`` is the camera's standard deviation (y), ``seed`` the encoder's.
    """

    rig: Rig
    loop: Loop
    camera: Camera
    excitation: str
    reference: Array
    lead: int
    rows: int
    behind: int
    noise: float
    seed: int
    scales: Scales

    def moved(self, setup: Setup, substeps: int) -> Motion:
        """Run the machine with what is installed in it."""
        rule = controller(self.rig, self.loop, self.reference, self.seed)
        return run(self.rig, setup, rule, self.reference.size, -self.lead, substeps)


def _camera(rng: Generator, rig: Rig) -> Camera:
    """Draw a camera, or a sensor that reads at once."""
    if rng.random() < 0.4:
        return Camera()
    exposure = float(np.round(rng.choice([0.25, 0.4, 0.5, 0.8]) * rig.period, 7))
    latency = 0.0 if rng.random() < 0.5 else float(np.round(rng.uniform(0.2, 3.0) * rig.period, 6))
    return Camera(exposure, latency)


def _scaled(rng: Generator, rig: Rig, loop: Loop, unit: Array, seed: int, share: float) -> tuple[Array, Loop, Motion]:
    """Scale a reference of unit size so that the command uses a share of the drive's limit; draw the encoder."""
    alone = run(rig, Setup(), controller(rig, replace(loop, noise=0.0, step=0.0), unit, seed, 1e12), unit.size, 0, 1)
    size = share * rig.limit / float(np.percentile(np.abs(alone.command), 99.0))
    reference = size * unit
    if loop.noise == 0.0:
        way = 0.5 * float(np.ptp(reference))
        # what the encoder's noise does to the command grows with the loop's speed
        quiet = float(np.exp(rng.uniform(np.log(2e-6), np.log(2e-5))))
        loop = replace(loop, noise=quiet * way, step=float(rng.choice([0.5, 1.0, 2.0])) * quiet * way)
    return reference, loop, run(rig, Setup(), controller(rig, loop, reference, seed), unit.size, 0, 1)


def draw_scene(rng: Generator, plain: bool, moving: bool, turning: bool, instant: bool) -> Scene:
    """Draw a scene; ``plain`` asks for a plant of order two, ``turning`` for a machine that turns.

    ``moving`` lets the recording begin amid the motion, ``instant`` wants a sensor that reads at once.
    """
    rig = draw_rig(rng, plain)
    while turning and rig.turn == 0.0:
        rig = draw_rig(rng, plain)
    loop, seed, rows = draw_loop(rng, rig), int(rng.integers(2**31)), int(rng.integers(1500, 3501))
    camera = Camera() if instant else _camera(rng, rig)
    lead = int(rng.integers(100, 301)) if moving and rng.random() < 0.35 else 0
    behind = int(0.013 * rows) + 8
    excitation = NAMES[int(rng.integers(len(NAMES)))]
    unit = draw_reference(rng, excitation, lead + rows + behind, loop.bandwidth, rig.period)
    share = float(rng.uniform(0.45, 0.85))
    reference, loop, motion = _scaled(rng, rig, loop, unit, seed, share)
    inner = slice(lead, lead + rows)
    seen, command = motion.position[inner], motion.command[inner]
    noise = float(np.exp(rng.uniform(np.log(2e-4), np.log(1e-2)))) * float(seen.std())
    scales = Scales(
        command=float(np.percentile(np.abs(command), 99.5)),
        slope=float(np.percentile(np.abs(np.diff(command)), 95.0)) / rig.period,
        low=float(seen.min()),
        high=float(seen.max()),
        speed=float(np.percentile(np.abs(motion.velocity[inner]), 99.5)),
        bandwidth=loop.bandwidth,
        fast=loop.fast,
        period=rig.period,
        duration=rows * rig.period,
        noise=noise,
        gain=rig.slow_gain,
        turn=rig.turn,
    )
    return Scene(rig, loop, camera, excitation, reference, lead, rows, behind, noise, seed, scales)


def another(rng: Generator, scene: Scene) -> Scene:
    """Return the same rig, loop and camera with another reference, from rest."""
    names = [name for name in NAMES if name != scene.excitation]
    excitation = names[int(rng.integers(len(names)))]
    rows = int(rng.integers(1500, 2501))
    behind = int(0.013 * rows) + 8
    unit = draw_reference(rng, excitation, rows + behind, scene.loop.bandwidth, scene.rig.period)
    seed = int(rng.integers(2**31))
    reference, _, _ = _scaled(rng, scene.rig, scene.loop, unit, seed, float(rng.uniform(0.4, 0.75)))
    # a law of the position was drawn for the way of the first recording
    most = scene.scales.reach / max(float(np.abs(reference).max()), 1e-300)
    return replace(scene, excitation=excitation, reference=min(1.0, most) * reference, lead=0, rows=rows,
                   behind=behind, seed=seed)  # fmt: skip
