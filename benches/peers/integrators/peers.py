"""The compared programs, their request protocol and their methods."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
#: Tolerances, and steps (s) of the methods with a fixed step, from loose to tight.
TOLERANCES = 10.0 ** -np.arange(1.5, 11.1, 0.5)
STEPS = 16e-6 * 0.84 ** np.arange(40)

#: Cheap methods first, to abandon far more expensive ones early.
METHODS = {
    "CVODE": ["adams-fixed", "adams-anderson", "adams-diagonal", "adams-newton",
              "adams-differences", "bdf-fixed", "bdf-newton", "bdf-differences"],
    "Boost.odeint": ["dopri5", "cash-karp54", "fehlberg78", "bulirsch-stoer", "rosenbrock4",
                     "rk4-fixed", "dopri5-fixed", "fehlberg78-fixed", "adams4-fixed",
                     "adams6-fixed", "adams8-fixed"],
    "SciPy solve_ivp": ["LSODA", "DOP853", "RK45", "RK23", "Radau", "BDF"],
    "SciPy odeint, ode": ["odeint", "ode-dop853", "ode-dopri5", "ode-lsoda", "ode-vode-adams",
                          "ode-vode-bdf"],
}
OURS = "squeakscope"
#: Methods of squeakscope with a fixed step.
FIXED = ["rk4"]


def our_methods(squeakscope):
    """Method names in scene files."""
    keys = subprocess.run([squeakscope, "scenes", "--keys"], capture_output=True, text=True,
                          check=True).stdout
    row = next(line for line in keys.splitlines() if line.startswith("| `method` | Integration"))
    return re.findall(r'"([a-z0-9]+)"', row.split("|")[4])


def settings(peer, method):
    is_fixed = method in FIXED if peer == OURS else method.endswith("-fixed")
    is_fixed &= peer != "CVODE"  # there it is the fixed-point iteration
    return STEPS if is_fixed else TOLERANCES


class Program:
    """A program that answers each request line with a line of JSON, pinned to one core."""

    def __init__(self, command, core):
        command = ["taskset", "-c", str(core), *map(str, command)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)

    def ask(self, request, number):
        self.process.stdin.write(f"{request} {number!r}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.process.args} exited at `{request} {number!r}`")
        return json.loads(line)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


class Programs:
    """The programs built by the Makefile, and squeakscope's bench."""

    def __init__(self, build, bench, core):
        self.build, self.bench, self.core = build, bench, core
        subprocess.run(["make", "-s", "-C", HERE, f"OUT={build}"], check=True)

    def plain(self, exported, start):
        return Program([self.build / "plain", exported.path(start)], self.core)

    def ours(self, exported, start):
        return Program([self.bench, exported.folder, start], self.core)

    def integrators(self, exported, start, horizon):
        """All peers and squeakscope, by name."""
        model = exported.path(start)
        scipy = Program([sys.executable, HERE / "scipy_peer.py", model, horizon,
                         self.build / "librhs.so"], self.core)
        return {
            OURS: self.ours(exported, start),
            "CVODE": Program([self.build / "cvode", model, horizon], self.core),
            "Boost.odeint": Program([self.build / "odeint", model, horizon], self.core),
            "SciPy solve_ivp": scipy,
            "SciPy odeint, ode": scipy,
        }
