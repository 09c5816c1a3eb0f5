"""The stubs agree with the extension, and the package with its types."""

import subprocess
import sys
from pathlib import Path

import pytest

import squeakscope as s
from squeakscope import results
from squeakscope._result import definitions, properties

pytest.importorskip("mypy")


def python(*words: str, cwd: Path) -> None:
    done = subprocess.run([sys.executable, "-m", *words], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_describe_the_extension(tmp_path: Path) -> None:
    config = tmp_path / "mypy.ini"
    config.write_text("[mypy]\ndisable_error_code = import-untyped\n")
    # The extension exports all of its names, and a slot of a class is no attribute of it.
    allowed = tmp_path / "allowed.txt"
    # Classes of results are made when first used; the next test compares them.
    names = ("_squeakscope.__all__", "_squeakscope.Run.__getattr__", "results.*", "_result.class_of", "_result.definitions")
    allowed.write_text("\n".join(f"squeakscope.{name}" for name in names))
    options = ["--mypy-config-file", str(config), "--allowlist", str(allowed)]
    python("mypy.stubtest", "squeakscope", *options, cwd=tmp_path)


def test_types_of_results_follow_from_their_schemas(run) -> None:
    generator = [sys.executable, str(Path(__file__).with_name("result_types.py"))]
    done = subprocess.run(generator, capture_output=True, text=True, check=True)
    stub = Path(s.__file__).with_name("results.pyi").read_text()
    assert done.stdout == stub, "results.pyi is out of date: write the output of result_types.py to it"
    # What is returned has the fields that its class states.
    x = run.u
    for found in (
        s.rqa(x, rate=1.0), s.regime(x, 1.0), s.spectrum(x, 1.0), s.mutual_information(x), s.choose_delay(x),
        s.poincare_section(x, 5, rate=1.0), s.recurrence_plot(x[:300]), s.zero_one_test(x), run.summary,
        s.integrate(lambda t, z: [-z[0]], [1.0], [0.0, 1.0]), s.stability("torus-1.75deg").tilts[0],
    ):
        name = type(found).__name__
        assert set(definitions()[name]["required"]) <= set(found) <= set(properties(name)), name
        assert "Attributes" in type(found).__doc__
    assert isinstance(s.spectrum(x, 1.0).lines[0], results.NamedLine)
    assert "frequency_hz" in results.NamedLine.__doc__


def test_the_package_has_consistent_types(tmp_path: Path) -> None:
    (tmp_path / "user.py").write_text(
        "import squeakscope as s\n"
        "run: s.Run = s.run(s.Scene.load('doubled-torus-3deg').replace(nodes=28), duration=0.1)\n"
        "rate: float = s.rqa(run.u).recurrence_rate\n"
        "names: list[str] = [line.label for line in s.spectrum(run.u, 1.0).lines]\n"
        "values: list[float] = [x for x in s.exponents(lambda t, z: -z, [1.0], 1.0, settle=1.0, interval=0.1).exponents]\n"
    )
    python("mypy", "--strict", "--disable-error-code=import-untyped", "-p", "squeakscope", cwd=tmp_path)
    python("mypy", "--strict", "user.py", cwd=tmp_path)


def test_every_function_has_a_docstring_with_its_parameters() -> None:
    import inspect

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
