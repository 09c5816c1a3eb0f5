"""Exports the common scene with `squeakscope model` and `squeakscope run`, and writes it as the arrays of
the plain loop (read by rhs.hpp)."""

import subprocess
import tomllib

import numpy as np

LANES = 8
#: Start times along the squeak, s after the scene's start, and integration time of each, s.
SQUEAK = np.arange(60e-3, 76e-3, 2e-3)
HORIZON = 4e-3


def scene_text(squeakscope, name, nodes):
    """The scene `name` with `nodes` contact nodes, as TOML."""
    text = subprocess.run([squeakscope, "scenes", name], capture_output=True, text=True,
                          check=True).stdout
    before = tomllib.loads(text)["contact"]["nodes"]
    changed = text.replace(f"\nnodes = {before}\n", f"\nnodes = {nodes}\n")
    assert tomllib.loads(changed)["contact"]["nodes"] == nodes
    return changed


class Exported:
    """A scene with `nodes` contact nodes, in a separate folder:

    * `scene.toml`: the scene;
    * `cold.bin`, `squeak.bin`: the model and the start states. `cold` is the start state of the scene,
      a small kick from steady sliding; `squeak` contains states of the developed vibration.
    * `cold.npy`, `squeak.npy`: the start states only, `[q | dq/dt]`.
    """

    def __init__(self, folder, squeakscope, name, nodes):
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.nodes = folder, nodes
        self.scene = folder / "scene.toml"
        self.scene.write_text(scene_text(squeakscope, name, nodes))
        quiet = {"check": True, "capture_output": True}
        model = folder / "model.npz"
        subprocess.run([squeakscope, "model", self.scene, "--out", model, "--force"], **quiet)
        self.model = dict(np.load(model))
        run, end = folder / "run.npz", 1e3 * SQUEAK[-1] + 1
        # In its folder, where it leaves its recording.
        subprocess.run([squeakscope, "run", self.scene, "--duration", f"{end}", "--npz", run,
                        "--force"], cwd=folder, **quiet)
        run = np.load(run)
        at = np.searchsorted(run["t"], SQUEAK - 1e-9)
        self.starts = {"cold": self.scaled(self.model["z0"])[None],
                       "squeak": self.scaled(np.hstack([run["q"], run["qdot"]])[at])}
        for start, states in self.starts.items():
            np.save(folder / f"{start}.npy", states / self.scale())
            self.write(start)

    def scaled(self, z):
        """Converts [q | dq/dt] to [omega q | dq/dt], whose squared norm is twice the energy of the free
        vibration."""
        return z * self.scale()

    def scale(self):
        return np.concatenate([self.model["omega"], np.ones_like(self.model["omega"])])

    def path(self, start):
        return self.folder / f"{start}.bin"

    def write(self, start):
        """Writes the structure of arrays in the sliding frame of each node, padded to whole vectors."""
        m = self.model
        assert m["radial"] == 1 and m["unilateral"] == 1 and not m["damping"].any()
        n, modes = len(m["areas"]), len(m["omega"])
        speed = np.linalg.norm(m["sliding_velocity"], axis=1)
        along = m["sliding_velocity"] / speed[:, None]
        outward = m["normals"]
        frame = np.stack([along, np.cross(outward, along), outward])  # axis, node, xyz
        rows = np.einsum("akx,kxi->aik", frame, m["shapes"])  # axis, mode, node
        more = -n % LANES
        pad = lambda x, value: np.pad(x, [(0, 0)] * (x.ndim - 1) + [(0, more)],
                                      constant_values=value)
        starts = self.starts[start]
        numbers = [[n + more, modes], m["friction"], [len(starts)], m["omega"], pad(speed, 1.0),
                   pad(m["pre_stress"], 1.0), pad(m["stiffness"], 0.0), pad(m["areas"], 0.0),
                   pad(rows, 0.0), starts]
        np.concatenate([np.ravel(x) for x in numbers]).astype("<f8").tofile(self.path(start))
