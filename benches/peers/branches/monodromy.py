"""Compares the Floquet multipliers of `squeakscope branch` with a monodromy matrix by finite differences of SciPy's DOP853,
on the arrays that `squeakscope model` writes.

    python3 -m venv peers && peers/bin/pip install -r benches/peers/branches/requirements.txt
    peers/bin/python benches/peers/branches/monodromy.py target/release/squeakscope periodic-2deg --tilt 2

The right-hand side is Eq. (8), written down here once more from the description of the arrays. The script prints the
distance of the orbit from its end after one period, and each multiplier beside the nearest eigenvalue; it fails if one
differs by more than 1e-5.

SciPy does not stop at the kinks where nodes open and close. Its end states then have errors of about 1e-10 of the orbit, which a
difference with the step h amplifies by 1/h, while its truncation grows with h: of several steps, that with the smallest change
of the matrix under halving counts.
"""

import argparse
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

ALLOWED = 1e-5
#: Steps of the central differences, relative to the size of the orbit.
STEPS = (1.6e-4, 8e-5, 4e-5, 2e-5, 1e-5)


def right_hand_side(model):
    """dz/dt of Eq. (8) for [q | dq/dt], from the arrays of a model file."""
    shapes, normals, areas = model["shapes"], model["normals"], model["areas"]
    omega2 = model["omega"] ** 2
    linear = 2 * model["damping"] * model["omega"]
    mu_s, mu_d, creep, stribeck = model["friction"]
    assert model["radial"] == 1 and np.isfinite(mu_s), "Eq. (8) with the friction curve of Eq. (5)"
    assert "contact_damping" not in model and "convection" not in model
    radial = np.einsum("nk,nkm->nm", normals, shapes)
    m = len(omega2)

    def slope(t, z):
        q, dq = z[:m], z[m:]
        pressure = model["pre_stress"] + model["stiffness"] * (radial @ q)
        if model["unilateral"]:
            pressure = np.maximum(pressure, 0)
        slip = model["sliding_velocity"] + shapes @ dq
        speed = np.linalg.norm(slip, axis=1)
        mu = (1 - np.exp(-creep * speed)) * (mu_d + (mu_s - mu_d) * np.exp(-stribeck * speed))
        force = -(mu * pressure / speed * areas)[:, None] * slip - (pressure * areas)[:, None] * normals
        ddq = np.einsum("nkm,nk->m", shapes, force) - omega2 * (model["q_eq"] + q) - linear * dq
        return np.concatenate([dq, ddq])

    return slope


def monodromy(slope, state, period, unit, step, tolerance):
    """The derivative of the state after a period with respect to the initial state, by central differences."""

    def end(z):
        found = solve_ivp(slope, (0, period), z, method="DOP853", rtol=tolerance, atol=tolerance * 1e-3 * unit,
                          max_step=period / 64)
        assert found.success, found.message
        return found.y[:, -1]

    columns = [(end(state + h) - end(state - h)) / (2 * step) for h in np.diag(step * unit)]
    closed = np.max(np.abs(end(state) - state) / unit)
    return np.array(columns).T / unit[:, None], closed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("squeakscope")
    parser.add_argument("scene")
    parser.add_argument("--tilt", type=float, required=True, help="tilt of the scene, degrees")
    parser.add_argument("--tolerance", type=float, default=1e-12)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        model, branch = Path(folder) / "model.npz", Path(folder) / "branch.json"
        quiet = {"check": True, "capture_output": True}
        subprocess.run([args.squeakscope, "model", args.scene, "--out", model], **quiet)
        span = f"{args.tilt - 0.01}:{args.tilt + 0.01}"
        subprocess.run([args.squeakscope, "branch", args.scene, "--tilt", span, "--start", f"{args.tilt}",
                        "--points", "2", "--json", branch], **quiet)
        slope = right_hand_side(dict(np.load(model)))
        points = json.loads(branch.read_text())["points"]
        omega = np.load(model)["omega"]
    orbit = next(point for point in points if abs(point["tilt_deg"] - args.tilt) < 1e-12)
    multipliers = np.array([complex(*pair) for pair in orbit["multipliers"]])
    m = len(omega)
    speed = np.max(orbit["component_amplitudes"][m:])
    unit = np.concatenate([speed / omega, np.full(m, speed)])
    state = np.array(orbit["state"])
    best = (np.inf, None, None)
    before = None
    for step in STEPS:
        matrix, closed = monodromy(slope, state, orbit["period_s"], unit, step, args.tolerance)
        change = np.inf if before is None else np.max(np.abs(matrix - before))
        before = matrix
        eigenvalues = np.linalg.eigvals(matrix)
        nearest = [eigenvalues[np.argmin(np.abs(eigenvalues - m))] for m in multipliers]
        off = np.max(np.abs(multipliers - nearest))
        print(f"step {step:.0e}: change of the matrix {change:.1e}, largest distance of a multiplier {off:.1e}")
        best = min(best, (change, off, nearest), key=lambda tried: tried[0])
    _, worst, nearest = best
    print(f"{args.scene} at {args.tilt} degrees: period {orbit['period_s']:.12e} s, open nodes {orbit['open_guards']}, "
          f"distance of the orbit from its end {closed:.1e} of its size")
    for ours, theirs in zip(multipliers, nearest):
        print(f"{ours:.9f}   {theirs:.9f}   {abs(ours - theirs):.1e}")
    assert worst <= ALLOWED, f"{worst:.1e} exceeds {ALLOWED:.0e}"


if __name__ == "__main__":
    main()
