"""Every example of the documentation runs: the page of the guide, and the docstrings."""

import doctest
import re
import wave
from pathlib import Path

import numpy as np
import pytest

import squeakscope as s

PAGE = Path(__file__).parents[2] / "src/guide/how_to/python.md"
RATE = 48_000


def recording(path: Path, seconds: float, parts: list[tuple[float, float]]) -> None:
    """A sound of tones, each with its frequency and amplitude, and weak noise."""
    t = np.arange(int(seconds * RATE)) / RATE
    sound = sum(amplitude * np.sin(2 * np.pi * frequency * t) for frequency, amplitude in parts)
    sound = sound + 1e-3 * np.random.default_rng(1).standard_normal(len(t))
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((32767 * sound).astype("<i2").tobytes())


def test_the_examples_of_the_guide_run_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    recording(tmp_path / "squeak.wav", 1.0, [(3210.0, 0.3), (6420.0, 0.05), (1500.0, 0.02)])
    recording(tmp_path / "calibrator.wav", 1.0, [(1000.0, 0.1)])
    t = np.arange(5 * 12_000) / 12_000
    speed = 600 + 600 * t / 5
    turns = np.cumsum(speed) / 60 / 12_000
    sound = np.sin(2 * np.pi * 36 * turns) + 0.5 * np.sin(2 * np.pi * 3200 * t)
    np.savez(tmp_path / "wheel.npz", rate=12_000.0, microphone=sound, speed_rpm=speed)

    names: dict[str, object] = {}
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    for number, block in enumerate(blocks, 1):
        exec(compile(block, f"python.md, block {number}", "exec"), names)
    # What the page says about the numbers.
    assert names["orders"].lines[0].frequency_hz == pytest.approx(36.0, abs=0.01)
    assert names["sticks"].any() and not names["sticks"].all()
    assert names["ball"].z[-1].tolist() == [0.0, 0.0, 1.0]


def test_the_examples_of_docstrings_are_true() -> None:
    finder, runner = doctest.DocTestFinder(), doctest.DocTestRunner()
    tried = 0
    for name in s.__all__:
        if name.startswith("_"):
            continue
        for test in finder.find(getattr(s, name), name, module=False, globs={"Result": s.Result, "np": np}):
            tried += len(test.examples)
            assert runner.run(test).failed == 0, test.name
    assert tried > 10
