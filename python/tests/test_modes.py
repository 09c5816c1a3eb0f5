import csv
import subprocess
import sys

import numpy as np
import pytest

import squeakscope as s
from squeakscope import modes

CENTRE = np.array([0.0, 0.0, 120.0])  # mm


@pytest.fixture(scope="module")
def patch(tmp_path_factory) -> dict:
    path = tmp_path_factory.mktemp("patch") / "patch.npz"
    command = [sys.executable, "-m", "squeakscope", "model", "torus-3deg", "--out", str(path)]
    subprocess.run(command, check=True, capture_output=True)
    return dict(np.load(path))


@pytest.fixture(scope="module")
def mesh(patch) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes on the sphere around the patch, in mm, three shapes and frequencies; the first mode is a rigid one."""
    positions = patch["positions"]
    radius = np.linalg.norm(positions, axis=1).mean()
    axis = positions.mean(axis=0) / np.linalg.norm(positions.mean(axis=0))
    rng = np.random.default_rng(1)
    directions = axis + 1.2 * rng.uniform(-1, 1, (4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    nodes = radius * directions
    return 1e3 * nodes + CENTRE, shapes_at(nodes), np.array([0.0, 4100.0, 8200.0])


def shapes_at(places: np.ndarray) -> np.ndarray:
    """A translation, and two smooth shapes."""
    x, y, z = (places / 0.016).T
    one = np.stack([np.ones_like(x), 0 * x, 0 * x], axis=1)
    two = np.stack([0.5 + 0.2 * x, 0.1 * y * z, 0.3 * z], axis=1)
    three = np.stack([np.sin(x), np.cos(y), x * y], axis=1)
    return np.stack([one, two, three], axis=2)


def write_uff(path, mesh, nodes_set: int, mass: float = 4.0) -> None:
    pyuff = pytest.importorskip("pyuff")
    nodes, shapes, frequencies = mesh
    numbers = np.arange(1, len(nodes) + 1)
    file = pyuff.UFF(str(path))
    x, y, z = nodes.T
    places = {"node_nums": numbers, "x": x, "y": y, "z": z}
    if nodes_set == 15:
        file.write_sets(pyuff.prepare_15(**places, def_cs=0 * numbers, disp_cs=0 * numbers, color=0 * numbers), "add")
    else:
        file.write_sets(pyuff.prepare_2411(**places, def_cs=0 * numbers, disp_cs=0 * numbers, color=0 * numbers), "add")
    for k, frequency in enumerate(frequencies):
        r1, r2, r3 = (np.sqrt(mass) * shapes[:, c, k] for c in range(3))
        mode = pyuff.prepare_55(
            model_type=1, analysis_type=2, data_ch=2, spec_data_type=8, data_type=2, n_data_per_node=3,
            r1=r1, r2=r2, r3=r3, load_case=1, mode_n=k + 1, freq=frequency, modal_m=mass,
            modal_damp_vis=0.0, modal_damp_his=0.0, node_nums=numbers, id1="mode", id2="", id3="", id4="", id5="",
        )
        file.write_sets(mode, "add")


def check(found: modes.Modes, patch: dict) -> modes.PatchModes:
    # Without the rigid body, in m from the centre, of unit modal mass.
    assert found.frequencies_hz == pytest.approx([4100.0, 8200.0])
    assert np.linalg.norm(found.nodes, axis=1).max() == pytest.approx(np.linalg.norm(found.nodes, axis=1).min(), rel=1e-3)
    at_patch = found.at_patch(patch)
    expected = shapes_at(patch["positions"])[:, :, 1:]
    assert np.abs(at_patch.arrays["shapes"] - expected).max() < 1e-4
    assert at_patch.assurance.min() > 0.999
    return at_patch


@pytest.mark.parametrize("nodes_set", [15, 2411])
def test_modes_from_a_universal_file(tmp_path, mesh, patch, nodes_set: int) -> None:
    path = tmp_path / "body.unv"
    write_uff(path, mesh, nodes_set)
    at_patch = check(modes.from_uff(path, length_unit=1e-3, centre=CENTRE), patch)
    # The library accepts the file.
    at_patch.save(tmp_path / "body.npz")
    text = s.Scene.load("torus-3deg").text
    kept = text[text.index("[load]") :]
    body = f'[body]\nmodes = "{tmp_path / "body.npz"}"\n\n'
    scene = tmp_path / "scene.toml"
    lines = [line for line in kept.splitlines() if not line.startswith(("nodes", "quadrature"))]
    scene.write_text(body + "\n".join(lines))
    assert len(s.stability(scene)[0].modes) == 2


def test_modes_from_tables(tmp_path, mesh, patch) -> None:
    nodes, shapes, frequencies = mesh
    with open(tmp_path / "nodes.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["node", "x", "y", "z"])
        rows.writerows([k, *place] for k, place in enumerate(nodes))
    with open(tmp_path / "shapes.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["frequency_hz", "node", "x", "y", "z"])
        for m, frequency in enumerate(frequencies):
            rows.writerows([frequency, k, *shapes[k, :, m]] for k in range(len(nodes)))
    check(modes.from_csv(tmp_path / "nodes.csv", tmp_path / "shapes.csv", length_unit=1e-3, centre=CENTRE), patch)
    (tmp_path / "bad.csv").write_text("node,x,y\n1,2,3\n")
    with pytest.raises(s.InputError, match="no column `z`"):
        modes.from_csv(tmp_path / "bad.csv", tmp_path / "shapes.csv")


def test_a_mesh_elsewhere_is_refused(tmp_path, mesh, patch) -> None:
    path = tmp_path / "body.unv"
    write_uff(path, mesh, 15)
    with pytest.raises(s.InputError, match="check length_unit and centre"):
        modes.from_uff(path, length_unit=1e-3).at_patch(patch)
    write_uff(tmp_path / "massless.unv", mesh, 15, mass=0.0)
    with pytest.raises(s.InputError, match="no modal mass"):
        modes.from_uff(tmp_path / "massless.unv")
