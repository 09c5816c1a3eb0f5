import subprocess
import sys


def program(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "squeakscope", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_command_is_the_program(tmp_path) -> None:
    assert "Simulate and analyse" in program("--help").stdout
    assert program("scenes").stdout.count("doubled-torus-3deg") >= 1
    wrong = program("run", "torus-3dge")
    assert wrong.returncode == 2 and "did you mean" in wrong.stderr
    assert program("--no-such-option").returncode == 2
    out = tmp_path / "x.rrd"
    done = program("run", "mass-on-belt", "--duration", "5", "--save", str(out))
    assert done.returncode == 0 and out.exists(), done.stderr
