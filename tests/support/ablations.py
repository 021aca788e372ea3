"""What the workflow gives to an ablation besides its own settings."""


def shared(order=9, seed=1, **more):
    """The paper's plant, a PRBS of some order and a root of random numbers; ``more`` are further sections."""
    return {
        "plant": {"static_gain": 1.0, "natural_frequency": 10.0, "damping": 0.1},
        "excitation": {"order": order, "amplitude": 1.0},
        "seed": seed,
        **more,
    }
