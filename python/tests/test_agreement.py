"""A function and the command of the same name give the same result: every field of the function is a field of the
command's JSON, with the same value."""

import json
import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import squeakscope as s

BELT, JOINT = "mass-on-belt", "periodic-2deg"
SPEED = "mass_on_belt.belt_speed_mm_per_s"
QUICK = {"min_transient": 0.02, "max_transient": 0.03, "measure": 0.01, "exponents": 0}
QUICK_WORDS = ["--min-transient", "20", "--max-transient", "30", "--measure", "10", "--exponents", "0"]

# They differ from run to run.
MEASURED = {"wall_s", "real_time_factor", "peak_memory_bytes"}


def command(folder: Path, *words: str) -> dict:
    line = [sys.executable, "-m", "squeakscope", *words, "--json", "-"]
    return json.loads(subprocess.run(line, check=True, capture_output=True, cwd=folder).stdout)


def compare(python, document, path: str) -> int:
    """Number of equal values."""
    if isinstance(python, dict):
        assert isinstance(document, dict), path
        keys = python.keys() - MEASURED
        assert keys <= document.keys(), f"{path}: {keys - document.keys()}"
        return sum(compare(python[key], document[key], f"{path}/{key}") for key in keys)
    if isinstance(python, np.ndarray):
        python = python.tolist()
    if isinstance(python, list | tuple):
        assert len(python) == len(document), path
        return sum(compare(a, b, f"{path}/{k}") for k, (a, b) in enumerate(zip(python, document, strict=True)))
    # JSON has finite numbers only.
    expected = None if isinstance(python, float) and not math.isfinite(python) else python
    assert expected == document, f"{path}: {python} and {document}"
    return 1


def signal(folder: Path) -> str:
    time = np.arange(20_000) / 40_000
    path = folder / "tone.csv"
    np.savetxt(path, np.column_stack([time, np.sin(9000 * time)]), "%.9g", ",", header="time_s,v_m/s", comments="")
    return str(path)


CASES: list[tuple[list[str], Callable[[str], dict]]] = [
    (["run", BELT, "--duration", "200"], lambda _: s.run(BELT, duration=0.2).to_dict()),
    (["lyapunov", BELT, "--average-time", "0.5"], lambda _: s.lyapunov(BELT, average_time=0.5).to_dict()),
    (["stability", JOINT, "--tilt", "2"], lambda _: s.stability(JOINT, [2.0]).to_dict()),
    (
        ["branch", "torus-birth", "--tilt", "0:1", "--points", "5", "--equilibria"],
        lambda _: s.branch("torus-birth", interval=(0.0, 1.0), points=5, orbits=False).to_dict(),
    ),
    (
        ["sweep", BELT, "--param", f"{SPEED}=100:200:100", *QUICK_WORDS],
        lambda _: s.sweep(BELT, {SPEED: [100.0, 200.0]}, **QUICK).to_dict(),
    ),
    (["basins", BELT, "--kicks", "2", *QUICK_WORDS], lambda _: s.basins(BELT, 2, **QUICK).to_dict()),
    (["analyse", "FILE"], lambda file: s.analyse(file).to_dict()),
]


@pytest.mark.parametrize(("words", "function"), CASES, ids=[words[0] for words, _ in CASES])
def test_a_function_and_its_command_agree(words: list[str], function: Callable[[str], dict], tmp_path: Path) -> None:
    file = signal(tmp_path)
    document = command(tmp_path, *[file if word == "FILE" else word for word in words])
    assert compare(function(file), document, "") > 3
