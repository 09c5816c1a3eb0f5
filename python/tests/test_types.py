"""The stubs agree with the extension, and the package with its types."""

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")


def python(*words: str, cwd: Path) -> None:
    done = subprocess.run([sys.executable, "-m", *words], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_describe_the_extension(tmp_path: Path) -> None:
    config = tmp_path / "mypy.ini"
    config.write_text("[mypy]\ndisable_error_code = import-untyped\n")
    # The extension exports all of its names, and a slot of a class is no attribute of it.
    allowed = tmp_path / "allowed.txt"
    allowed.write_text("squeakscope._squeakscope.__all__\nsqueakscope._squeakscope.Run.__getattr__\n")
    options = ["--mypy-config-file", str(config), "--allowlist", str(allowed)]
    python("mypy.stubtest", "squeakscope", *options, cwd=tmp_path)


def test_the_package_has_consistent_types(tmp_path: Path) -> None:
    (tmp_path / "user.py").write_text(
        "import squeakscope as s\n"
        "run: s.Run = s.run(s.Scene.load('doubled-torus-3deg').replace(nodes=28), duration=0.1)\n"
        "rate: float = s.rqa(run.u).recurrence_rate\n"
    )
    python("mypy", "--strict", "--disable-error-code=import-untyped", "-p", "squeakscope", cwd=tmp_path)
    python("mypy", "--strict", "user.py", cwd=tmp_path)


def test_every_function_has_a_docstring_with_its_parameters() -> None:
    import inspect

    import squeakscope as s

    for name in s.__all__:
        function = getattr(s, name)
        if not inspect.isbuiltin(function):
            continue
        text = function.__doc__ or ""
        parameters = inspect.signature(function).parameters
        assert ("Parameters\n----------" in text) == bool(parameters), name
        assert "Returns\n-------" in text, name
        for parameter in parameters:
            assert parameter in text or "**options" in text, f"{name}: {parameter}"
