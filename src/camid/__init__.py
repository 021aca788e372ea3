"""Camera-aware identification of machine dynamics.

``identify`` re-estimates the plant of a believed simulation from a recording, ``simulate`` runs it, ``diagnose``
finds what it leaves out, ``design`` computes the next experiment, ``track`` makes a recording of a video,
``init_recording`` a first simulation of a recording; ``compare``, ``bode``, ``poles``, ``step`` and ``residuals`` draw
models.
They mirror the commands of the same name. Importing this package is cheap: each name is loaded when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camid.commands.bode import bode
    from camid.commands.compare import compare
    from camid.commands.design import design
    from camid.commands.diagnose import diagnose
    from camid.commands.identify import identify
    from camid.commands.init_recording import init_recording
    from camid.commands.join import join
    from camid.commands.order import select_order
    from camid.commands.poles import poles
    from camid.commands.residuals import residuals
    from camid.commands.simulate import simulate
    from camid.commands.step import step
    from camid.commands.track import track
    from camid.diagnosis.diagnosis import Diagnosis
    from camid.effects.own_effects import own_effects
    from camid.errors import InputError
    from camid.experiment_design.result import Design
    from camid.identification.identification import Identification
    from camid.recording.read import read_recording
    from camid.recording.recording import Recording
    from camid.simulation.file import load_simulation, write_simulation
    from camid.simulation.model import Simulation
    from camid.tracking.result import Track

__version__ = "0.1.0"

_MODULE_OF = {
    "Design": "experiment_design.result",
    "Diagnosis": "diagnosis.diagnosis",
    "Identification": "identification.identification",
    "InputError": "errors",
    "Recording": "recording.recording",
    "Simulation": "simulation.model",
    "Track": "tracking.result",
    "bode": "commands.bode",
    "compare": "commands.compare",
    "design": "commands.design",
    "diagnose": "commands.diagnose",
    "identify": "commands.identify",
    "init_recording": "commands.init_recording",
    "join": "commands.join",
    "load_simulation": "simulation.file",
    "own_effects": "effects.own_effects",
    "poles": "commands.poles",
    "read_recording": "recording.read",
    "residuals": "commands.residuals",
    "select_order": "commands.order",
    "simulate": "commands.simulate",
    "step": "commands.step",
    "track": "commands.track",
    "write_simulation": "simulation.file",
}

__all__ = [
    "Design",
    "Diagnosis",
    "Identification",
    "InputError",
    "Recording",
    "Simulation",
    "Track",
    "__version__",
    "bode",
    "compare",
    "design",
    "diagnose",
    "identify",
    "init_recording",
    "join",
    "load_simulation",
    "own_effects",
    "poles",
    "read_recording",
    "residuals",
    "select_order",
    "simulate",
    "step",
    "track",
    "write_simulation",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'camid' has no attribute '{name}'")
    return getattr(import_module(f"camid.{_MODULE_OF[name]}"), name)


def __dir__() -> list[str]:
    return __all__
