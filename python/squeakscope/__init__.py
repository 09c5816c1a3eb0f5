"""Simulation and analysis of friction-induced vibration.

A scene describes a run: ``squeakscope.run("torus-1.75deg")`` simulates it with all of its analyses. Studies compute
many runs or the linearised system; functions of signals take arrays. All numbers are in SI units unless a name
contains another unit, such as ``tilt_deg``; keys of scenes have the units of the scene file.

Long calls release the interpreter's lock, end after Ctrl-C, and take ``progress``: a function that receives the
share of the work that is done, or True for a bar. Errors are :class:`Error`, and :class:`InputError` (a ``ValueError``) for what is not
valid.
"""

from ._errors import Error, InputError
from ._result import Estimates, Result, Results
from ._squeakscope import (
    Contact, Run, Samples, Scene, Simulation, System, __version__, analyse, basins, branch, choose_delay, cost,
    embed, exponents, false_neighbours, integrate, largest_exponent, lyapunov, model, mutual_information,
    poincare_section, read_signal, recurrence_plot, regime, rqa, rqa_windowed, run, scenes, sensitivities,
    spectrogram, spectrum, stability, sweep, tonal_events, zero_one_test,
)

__all__ = [
    "Contact", "Error", "Estimates", "InputError", "Result", "Results", "Run", "Samples", "Scene", "Simulation",
    "System", "__version__", "analyse", "basins", "branch", "choose_delay", "cost", "embed", "exponents",
    "false_neighbours", "integrate", "largest_exponent", "lyapunov", "model", "mutual_information",
    "poincare_section", "read_signal", "recurrence_plot", "regime", "rqa", "rqa_windowed", "run", "scenes",
    "sensitivities", "spectrogram", "spectrum", "stability", "sweep", "tonal_events", "zero_one_test",
]
