"""Compares `squeakscope branch` with AUTO-07p on the ball joint: the branch of a periodic motion over the Stribeck slope of
friction, at the tilt of the scene.

    python3 -m venv peers && peers/bin/pip install -r benches/peers/branches/requirements.txt
    peers/bin/python benches/peers/branches/auto_peer.py target/release/squeakscope periodic-2deg --slopes 8:14

bifpy compiles AUTO-07p (it needs gfortran). AUTO gets the right-hand side in Python, from the arrays that `squeakscope model`
writes, and one orbit of `squeakscope branch` as its start; mesh, Newton's method, step control, multipliers and detection
of bifurcations are its own. At some slopes the periods and the largest multipliers of both are printed side by side, and
after them the bifurcations. The script fails if a multiplier differs by more than 1e-4, or a period by more than 1e-7 of
itself: the errors of AUTO's collocation on this mesh.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from bifpy import auto
from scipy.integrate import solve_ivp

from monodromy import right_hand_side

KEY = "friction.stribeck_slope_s_per_m"
SLOPE = 3  # in the array `friction`
SHOWN = 4  # multipliers


class Joint:
    """Eq. (8) over the Stribeck slope, in units of the orbit: `[omega q | dq/dt] / speed` and time in periods."""

    def __init__(self, model, orbit):
        self.model, self.period = model, orbit["period_s"]
        omega = model["omega"]
        speed = np.max(orbit["component_amplitudes"][len(omega):])
        self.unit = np.concatenate([speed / omega, np.full(len(omega), speed)])
        self.start = np.array(orbit["state"])

    def slope(self, stribeck):
        """dz/dt. The equilibrium depends on the slope: there, all forces cancel."""
        friction = self.model["friction"].copy()
        friction[SLOPE] = stribeck
        model = self.model | {"friction": friction, "q_eq": np.zeros_like(self.model["q_eq"])}
        slope = right_hand_side(model)
        steady = slope(0, np.zeros_like(self.start))
        return lambda t, z: slope(t, z) - steady


def ours(squeakscope, scene, span, start):
    """The document of `squeakscope branch` from a slope."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "branch.json"
        command = [squeakscope, "branch", scene, "--param", f"{KEY}={span[0]}:{span[1]}", "--start", f"{start}",
                   "--points", "2", "--json", path]
        subprocess.run(command, check=True, capture_output=True)
        return json.loads(path.read_text())


def by_size(multipliers):
    """The largest multipliers, of a pair the one above the real axis first."""
    return sorted(multipliers, key=lambda m: (-round(abs(m), 6), -m.imag))[:SHOWN]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("squeakscope")
    parser.add_argument("scene")
    parser.add_argument("--slopes", default="8:14", help="interval of the Stribeck slope, s/m")
    parser.add_argument("--mesh", type=int, default=40, help="intervals of AUTO's mesh")
    args = parser.parse_args()
    span = [float(x) for x in args.slopes.split(":")]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.npz"
        subprocess.run([args.squeakscope, "model", args.scene, "--out", path], check=True, capture_output=True)
        model = dict(np.load(path))
    own = model["friction"][SLOPE]
    began = time.perf_counter()
    document = ours(args.squeakscope, args.scene, span, own)
    seconds = time.perf_counter() - began
    name = KEY.split(".")[1]
    orbit = next(point for point in document["points"] if point[name] == own)
    joint = Joint(model, orbit)
    start = solve_ivp(joint.slope(own), (0, joint.period), joint.start, method="DOP853", rtol=1e-10, atol=1e-12 * joint.unit,
                      dense_output=True).sol
    cache = {}

    def equations(state, parameters):
        stribeck = parameters[0]
        slope = cache.get(stribeck) or cache.setdefault(stribeck, joint.slope(stribeck))
        return slope(0, np.asarray(state) * joint.unit) * joint.period / joint.unit

    def first(state, parameters, normalized_time):
        parameters[0] = own
        parameters[auto.PERIOD_INDEX - 1] = 1.0
        state[:] = start(normalized_time * joint.period) / joint.unit

    wanted = np.linspace(*span, 7)[1:-1]
    shared = dict(ips=auto.IPS_PERIODIC_ORBIT, ndim=len(joint.start), npar=1, nmx=60, ntst=args.mesh, ncol=4, iad=3, ilp=1, isp=2,
                  mxbf=0, iads=1, itmx=9, itnw=7, nwtn=3, jac=0, dsmin=1e-4, dsmax=0.5, rl0=span[0], rl1=span[1], a0=-1e300,
                  a1=1e300, epsl=1e-8, epsu=1e-8, epss=1e-6, iid=2, iplt=0)
    began = time.perf_counter()
    points = []
    for direction in (-0.1, 0.1):
        result = auto.run(equations, first, shared | {"ds": direction}, icu=[1, auto.PERIOD_INDEX],
                          uzr={1: [float(w) for w in wanted if (w - own) * direction > 0]})
        points += result.branches[0].points
    auto_seconds = time.perf_counter() - began
    worst = [0.0, 0.0]
    print(f"{args.scene} over {KEY}: period and largest multipliers, squeakscope and AUTO-07p")
    for value in wanted:
        theirs = min(points, key=lambda point: abs(point.parameters[0] - value))
        at = theirs.parameters[0]
        # The branch from the same start to this value: its last point lies on the bound.
        ends = sorted([own, at]) if at != own else span
        found = next(point for point in ours(args.squeakscope, args.scene, ends, own)["points"] if point[name] == at)
        period = theirs.parameters[1] * joint.period
        mine = by_size([complex(*pair) for pair in found["multipliers"]])
        other = by_size(theirs.floquet_multipliers)
        # The one at 1 shows AUTO's own error.
        off = max(min(abs(m - o) for o in theirs.floquet_multipliers) for m in mine if abs(m - 1) > 1e-6)
        worst = [max(worst[0], abs(period / found["period_s"] - 1)), max(worst[1], off)]
        print(f"  {at:.6f}  {found['period_s']:.12e}  {period:.12e}")
        for m, o in zip(mine, other):
            print(f"      {m:.7f}  {o:.7f}")
    print(f"largest differences: period {worst[0]:.1e} of itself, multiplier {worst[1]:.1e}")
    for found in document["bifurcations"]:
        if "branch" in found:
            print(f"squeakscope: {found['kind']} at {found[name]:.7f}")
    for point in points:
        if point.point_type in (auto.PointType.TORUS, auto.PointType.FOLD, auto.PointType.PERIOD_DOUBLING):
            print(f"AUTO-07p: {point.point_type.name} at {point.parameters[0]:.7f}")
    print(f"wall time of the branch: squeakscope {seconds:.2f} s, AUTO-07p with a right-hand side in Python {auto_seconds:.1f} s")
    assert worst[0] <= 1e-7 and worst[1] <= 1e-4


if __name__ == "__main__":
    main()
