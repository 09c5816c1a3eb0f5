"""Files of modes that the tests write themselves, by the libraries of their formats where these can write.

The modes of the file of Ansys are those of the example in its library, and CalculiX solves its own.
"""

import csv
import importlib
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import squeakscope as s
from squeakscope import modes

CENTRE = np.array([0.0, 0.0, 120.0])  # mm


@pytest.fixture(scope="module")
def patch() -> dict:
    return s.model("doubled-torus-3deg")


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


def write_uff(path, mesh, nodes_set: int, shapes_set: int = 55, mass: float = 4.0) -> None:
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
        if shapes_set == 2414:
            rows = np.sqrt(mass) * shapes[:, :, k]
            ones = {f"record{r}_field{f}": 0 for r in (10, 11) for f in range(1, 9)}
            ones |= {f"record{r}_field{f}": 0.0 for r in (12, 13) for f in range(1, 7)}
            ones |= {"record10_field6": k + 1, "record12_field2": frequency, "record12_field4": mass}
            # `prepare_2414` takes the fields of frequency responses only.
            mode = ones | {"type": 2414, "analysis_dataset_label": k + 1, "analysis_dataset_name": "mode"}
            mode |= dict.fromkeys(("id1", "id2", "id3", "id4", "id5"), "")
            mode |= {"dataset_location": 1, "model_type": 1, "analysis_type": 2, "data_characteristic": 2}
            mode |= {"result_type": 8, "data_type": 2, "number_of_data_values_for_the_data_component": 3}
            mode |= {"node_nums": numbers, "data_at_node": rows}
            file.write_sets(mode, "add")
            continue
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


FRAME = {"length_unit": 1e-3, "centre": CENTRE}


@pytest.mark.parametrize(("nodes_set", "shapes_set"), [(15, 55), (2411, 55), (2411, 2414)])
def test_modes_from_a_universal_file(tmp_path, mesh, patch, nodes_set: int, shapes_set: int) -> None:
    path = tmp_path / "body.unv"
    write_uff(path, mesh, nodes_set, shapes_set)
    check(modes.from_uff(path, **FRAME), patch)


def test_a_universal_file_that_cannot_be_read_is_named(tmp_path) -> None:
    pytest.importorskip("pyuff")
    with pytest.raises(s.InputError, match="absent.unv cannot be read as a universal file"):
        modes.from_uff(tmp_path / "absent.unv", **FRAME)


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
            # The order of the nodes does not matter.
            order = np.roll(range(len(nodes)), m)
            rows.writerows([frequency, k, *shapes[k, :, m]] for k in order)
    check(modes.from_csv(tmp_path / "nodes.csv", tmp_path / "shapes.csv", **FRAME), patch)
    (tmp_path / "bad.csv").write_text("node,x,y\n1,2,3\n")
    with pytest.raises(s.InputError, match="no column `z`"):
        modes.from_csv(tmp_path / "bad.csv", tmp_path / "shapes.csv")


def test_modes_of_nastran(tmp_path, mesh, patch) -> None:
    pytest.importorskip("pyNastran", reason="pyNastran is not installed (see the guide)")
    geometry = importlib.import_module("pyNastran.op2.op2_geom")
    from pyNastran.op2.tables.oug.oug_eigenvectors import RealEigenvectorArray

    nodes, shapes, frequencies = mesh
    numbers = np.arange(1, len(nodes) + 1)
    squared = (2 * np.pi * frequencies) ** 2
    model = geometry.OP2Geom(debug=None)
    for number, place in zip(numbers, nodes, strict=True):
        model.add_grid(int(number), place)
    grids = np.stack([numbers, np.ones_like(numbers)], axis=1)
    data = np.zeros((len(squared), len(nodes), 6), "float32")
    data[:, :, :3] = np.moveaxis(shapes, 2, 0)
    vectors = RealEigenvectorArray.add_modal_case(
        "OUGV1", grids, data, 1, np.arange(1, len(squared) + 1), squared, frequencies
    )
    vectors.table_code = vectors.data_code["table_code"] = 7
    model.eigenvectors[1] = vectors
    model.write_op2(str(tmp_path / "body.op2"), post=-1, nastran_format="msc")
    check(modes.from_nastran(tmp_path / "body.op2", **FRAME), patch)

    bulk = importlib.import_module("pyNastran.bdf.bdf").BDF(debug=None)
    for number, place in zip(numbers, nodes, strict=True):
        bulk.add_grid(int(number), place)
    bulk.write_bdf(str(tmp_path / "body.bdf"), size=16, is_double=True)
    lines, count = [], 0

    def punch(text: str) -> None:
        nonlocal count
        count += 1
        lines.append(f"{text:<72}{count:8d}")

    for m, value in enumerate(squared):
        for text in ("$TITLE   = HIP", "$SUBTITLE=", "$LABEL   =", "$EIGENVECTOR", "$REAL OUTPUT", "$SUBCASE ID =           1"):
            punch(text)
        punch(f"$EIGENVALUE = {value:14.7E}  MODE = {m + 1:5d}")
        for number, shape in zip(numbers, shapes[:, :, m], strict=True):
            punch(f"{number:10d}       G" + "".join(f"{x:18.6E}" for x in shape))
            punch("-CONT-            " + 3 * f"{0:18.6E}")
    (tmp_path / "body.pch").write_text("\n".join(lines) + "\n")
    check(modes.from_nastran(tmp_path / "body.pch", tmp_path / "body.bdf", **FRAME), patch)
    with pytest.raises(s.InputError, match="give the bulk data"):
        modes.from_nastran(tmp_path / "body.pch", **FRAME)
    bulk.nodes[7].cd = 3
    bulk.add_cord2r(3, [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
    bulk.write_bdf(str(tmp_path / "turned.bdf"), size=16)
    with pytest.raises(s.InputError, match="node 7 .* axes of their own"):
        modes.from_nastran(tmp_path / "body.pch", tmp_path / "turned.bdf", **FRAME)


def test_modes_of_ansys() -> None:
    pytest.importorskip("ansys.mapdl.reader")
    from ansys.mapdl.reader import examples

    # A square beam, whose bending modes form pairs in perpendicular planes.
    found = modes.from_ansys(examples.rstfile)
    assert found.shapes.shape == (321, 3, 6)
    assert found.frequencies_hz == pytest.approx([7366.495, 7366.495, 11504.895, 17285.705, 17285.705, 20137.190])
    products = np.einsum("vim,vin->mn", found.shapes, found.shapes)
    assert np.abs(products[[0, 3], [1, 4]]).max() < 1e-6 * products[0, 0]
    assert products[0, 0] == pytest.approx(products[1, 1], rel=1e-6)
    assert found.mass_kg is None


def test_modes_of_a_report_of_abaqus(tmp_path, mesh, patch) -> None:
    nodes, shapes, frequencies = mesh
    path = tmp_path / "abaqus.csv"
    with open(path, "w") as file:
        file.write("ODB Name, Step, Frame, Part Instance Name, Node Label, X, Y, Z, U-Magnitude, U-U1, U-U2, U-U3 \n")
        names = ["Increment      0: Base State"]
        names += [
            f"Mode         {m + 1}: Value = {(2 * np.pi * f) ** 2:11.5E} Freq = {f:9.3f}     (cycles/time)"
            for m, f in enumerate(frequencies)
        ]
        for m, name in enumerate(names):
            for k, place in enumerate(nodes):
                shape = shapes[k, :, m - 1] if m else np.zeros(3)
                numbers = ", ".join(f"{x:.8g}" for x in [*place, np.linalg.norm(shape), *shape])
                file.write(f"C:/hip.odb, Step-1, {name}, PART-1-1, {k + 1}, {numbers}\n")
    check(modes.from_abaqus(path, **FRAME), patch)
    text = path.read_text()
    path.write_text(text + text.partition("\n")[2].replace("PART-1-1", "PART-2-1"))
    with pytest.raises(s.InputError, match="node 1 twice; export the nodes of one part"):
        modes.from_abaqus(path, **FRAME)


def record(key: int, *items: int | float | str) -> str:
    """A record of a results file of Abaqus in text form, as its manual describes it (Results file: record format)."""
    words = {
        int: lambda x: f"I{len(str(x)):2}{x}",
        float: lambda x: "D" + f"{x:22.15E}".replace("E", "D"),
        str: lambda x: f"A{x:8}",
    }
    return "*" + "".join(words[type(item)](item) for item in (len(items) + 2, key, *items))


def test_modes_of_a_results_file_of_abaqus(tmp_path, mesh, patch) -> None:
    nodes, shapes, frequencies = mesh
    path, mass = tmp_path / "hip.fil", 4.0
    records = [record(1921, "6.14-1", "25-Nov-2", "026", "12:00:00", len(nodes), len(nodes), 1.0)]
    records += [record(1900, 1, "C3D8R", *range(1, 9))]
    records += [record(1901, k + 1, *map(float, place)) for k, place in enumerate(nodes)]
    records += [record(1922, "a *head*"), record(1902, 1, 2, 3, 0, 0, 0), record(2001)]
    # A static step before does not count.
    records += [record(2000, 0.0, 0.0, 0.0, 0.0, 1, 1, 1), record(101, 1, 1.0, 2.0, 3.0), record(2001)]
    records += [record(2000, 0.0, 0.0, 0.0, 0.0, 41, 2, 1)]
    for m, frequency in enumerate(frequencies):
        records += [record(1980, m + 1, (2 * np.pi * float(frequency)) ** 2, mass, 0.0), record(1911, 1, "ASSEMBLY")]
        records += [record(101, k + 1, *map(float, np.sqrt(mass) * shape)) for k, shape in enumerate(shapes[:, :, m])]
    records += [record(2001)]
    text = "".join(records)
    lines = [text[k : k + 80].rstrip() for k in range(0, len(text), 80)]
    path.write_text("\n".join(lines) + "\n")
    check(modes.from_abaqus(path, **FRAME), patch)
    for old, new, reason in (
        (record(1901, 5, *map(float, nodes[4])), record(1901, 5, 1.0, 2.0), "key 1901.* lacks a number"),
        (record(1980, 1, 0.0, mass, 0.0), record(1980, 1, 0.0, 0.0, 0.0), "key 1980.* a generalised mass"),
        ("*I", "I", "is binary; write it in text form"),
    ):
        assert old in text
        path.write_text(text.replace(old, new, 1))
        with pytest.raises(s.InputError, match=reason):
            modes.from_abaqus(path, **FRAME)
    with pytest.raises(s.InputError, match="CSV report"):
        modes.from_abaqus("hip.odb")


def test_a_mesh_elsewhere_is_refused(tmp_path, mesh, patch) -> None:
    path = tmp_path / "body.unv"
    write_uff(path, mesh, 15)
    with pytest.raises(s.InputError, match="check length_unit"):
        modes.from_uff(path, length_unit=1e-3).at_patch(patch)
    with pytest.raises(s.InputError, match="and length_unit"):
        modes.from_uff(path, centre=CENTRE).at_patch(patch)
    with pytest.raises(s.InputError, match="check mass_unit"):
        modes.from_uff(path, mass_unit=1e-5, **FRAME).at_patch(patch)
    write_uff(tmp_path / "massless.unv", mesh, 15, mass=0.0)
    with pytest.raises(s.InputError, match="no modal mass"):
        modes.from_uff(tmp_path / "massless.unv")


def test_the_stem_is_not_the_surface_of_a_wide_patch() -> None:
    radius, rng = 0.016, np.random.default_rng(2)
    ball = rng.normal(size=(6000, 3))
    ball *= radius / np.linalg.norm(ball, axis=1)[:, None]
    angle, depth = rng.uniform(0, 2 * np.pi, 2000), rng.uniform(-0.1, -0.015, 2000)
    stem = np.stack([0.005 * np.cos(angle), 0.005 * np.sin(angle), depth], axis=1)
    nodes = np.concatenate([ball[ball[:, 2] > -0.0152], stem])
    body = modes.Modes(nodes, shapes_at(nodes)[:, :, 1:], np.array([4100.0, 8200.0]), None)
    # A half-angle of 42 degrees.
    polar, around = np.meshgrid(np.radians([5, 15, 30, 42]), np.radians(np.arange(0, 360, 45)))
    positions = [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)]
    positions = radius * np.stack([one.ravel() for one in positions], axis=1)
    at_patch = body.at_patch({"positions": positions})
    assert np.abs(at_patch.arrays["shapes"] - shapes_at(positions)[:, :, 1:]).max() < 1e-3
    # A cap at another distance is still found.
    shifted = modes.Modes(nodes + [0, 0, 0.002], body.shapes, body.frequencies_hz, None)
    with pytest.raises(s.InputError, match="check length_unit, centre"):
        shifted.at_patch({"positions": positions})


def test_a_missing_library_is_named(monkeypatch, tmp_path) -> None:
    for library in ("pyuff", "pyNastran.op2.op2_geom", "ansys.mapdl.reader"):
        monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ModuleNotFoundError, match="pip install pyuff"):
        modes.from_uff("hip.unv")
    with pytest.raises(ModuleNotFoundError, match="pip install --no-deps pyNastran"):
        modes.from_nastran("hip.op2")
    with pytest.raises(ModuleNotFoundError, match="pip install ansys-mapdl-reader"):
        modes.from_ansys("hip.rst")


def from_arrays(tmp_path: Path, nodes, shapes, frequencies, **frame) -> modes.Modes:
    head = "frequency_hz,node,x,y,z\n"
    places = "".join(f"{k},{x!r},{y!r},{z!r}\n" for k, (x, y, z) in enumerate(nodes.tolist()))
    (tmp_path / "nodes.csv").write_text("node,x,y,z\n" + places)
    rows = (
        f"{frequency!r},{k},{x!r},{y!r},{z!r}\n"
        for frequency, shape in zip(frequencies.tolist(), np.moveaxis(shapes, 2, 0), strict=True)
        for k, (x, y, z) in enumerate(shape.tolist())
    )
    (tmp_path / "shapes.csv").write_text(head + "".join(rows))
    return modes.from_csv(tmp_path / "nodes.csv", tmp_path / "shapes.csv", **frame)


def test_axes_and_units_of_the_file(tmp_path, mesh, patch) -> None:
    nodes, shapes, frequencies = mesh
    # The axis of the body is y in the file, and the shapes are those of masses in tonnes.
    axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    turned = np.einsum("ji,vjm->vim", axes, shapes) * np.sqrt(1e3)
    found = from_arrays(
        tmp_path, nodes @ axes, turned, frequencies, length_unit=1e-3, mass_unit=1e3, centre=CENTRE @ axes, axes=axes
    )
    check(found, patch)
    with pytest.raises(s.InputError, match="right-handed"):
        modes.from_csv(tmp_path / "nodes.csv", tmp_path / "shapes.csv", axes=-np.eye(3))


def test_rigid_body_modes_give_the_mass(tmp_path) -> None:
    rng = np.random.default_rng(2)
    nodes = rng.uniform(-0.1, 0.1, (40, 3))
    mass, centre, inertia = 0.4, np.array([0.01, 0.02, 0.03]), np.diag([1e-3, 2e-3, 2.5e-3])
    arm = nodes - centre
    rigid = [np.tile(axis, (40, 1)) / np.sqrt(mass) for axis in np.eye(3)]
    rigid += [np.cross(axis, arm) / np.sqrt(axis @ inertia @ axis) for axis in np.eye(3)]
    # Modes of equal frequency are any orthogonal combination.
    turn = np.linalg.qr(rng.normal(size=(6, 6)))[0]
    shapes = np.concatenate([np.stack(rigid, axis=2) @ turn, rng.normal(size=(40, 3, 1))], axis=2)
    frequencies = np.array([1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 3000.0])
    assert from_arrays(tmp_path, nodes, shapes, frequencies).mass_kg == pytest.approx(mass, rel=1e-9)
    # Each mode scaled to the largest displacement 1.
    scaled = shapes / np.abs(shapes).max(axis=(0, 1))
    with pytest.raises(s.InputError, match="not mass-normalised"):
        from_arrays(tmp_path, nodes, scaled, frequencies)


def test_the_patch_moves_over_the_surface_and_not_beyond(tmp_path, mesh) -> None:
    nodes, shapes, frequencies = mesh
    top = nodes[:, 2] - CENTRE[2] > 0.64 * np.linalg.norm(nodes - CENTRE, axis=1)
    found = from_arrays(tmp_path, nodes[top], shapes[top], frequencies, **FRAME)
    scene = s.Scene.load("doubled-torus-3deg").replace(**{"load.load_n": 300})
    with pytest.raises(s.InputError, match=r"tilt of 80 degrees; .* covers tilts from -\d+ to \d+ degrees") as refusal:
        found.at_patch(scene.replace(**{"load.tilt_deg": 80}))
    low, high = (int(word) for word in str(refusal.value).split("tilts from ")[1].split(" degrees")[0].split(" to "))
    # The surface ends 50 degrees from the axis, and the patch has a half-width of several degrees.
    assert -45 < low < -35 and 35 < high < 45
    for tilt in (low, high):
        moved = scene.replace(**{"load.tilt_deg": tilt})
        at_patch = found.at_patch(moved)
        expected = shapes_at(s.model(moved)["positions"])[:, :, 1:]
        # Nodes lie on all sides, but more of them on one.
        assert np.abs(at_patch.arrays["shapes"] - expected).max() < 1e-2
    for tilt in (low - 1, high + 1):
        with pytest.raises(s.InputError, match="does not extend"):
            found.at_patch(scene.replace(**{"load.tilt_deg": tilt}))


def test_a_scene_ready_to_run(tmp_path, mesh) -> None:
    found = from_arrays(tmp_path, *mesh, **FRAME)
    scene = s.Scene.load("doubled-torus-3deg").replace(**{"load.azimuth_deg": 40})
    at_patch = found.at_patch(scene)
    at_patch.save(tmp_path / "body.toml")
    ready = s.Scene.load(tmp_path / "body.toml")
    assert ready["load.azimuth_deg"] == 40
    assert ready["contact.stiffness_factor"] == 2.75
    # The contact is that of the scene: its factor acts once.
    assert s.model(ready)["stiffness"] == pytest.approx(s.model(scene)["stiffness"], rel=1e-12)
    assert len(s.stability(ready).tilts[0].modes) == 2
    command = [sys.executable, "-m", "squeakscope", "run", "body.toml", "--duration", "10", "--save", "body.rrd"]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path)
    with pytest.raises(s.InputError, match=r"\.npz or \.toml"):
        at_patch.save(tmp_path / "body.txt")
    with pytest.raises(s.InputError, match="without a scene"):
        found.at_patch(s.model(scene)).save(tmp_path / "body.toml")


def test_modes_of_calculix(tmp_path) -> None:
    pytest.importorskip("skfem")
    if shutil.which("ccx") is None:
        pytest.skip("ccx is not installed (apt install calculix-ccx)")
    folder = Path(__file__).parents[2] / "examples/own_modes"
    for script, *words in (["calculix.py", "hip.inp"], ["from_calculix.py", "hip.frd", "hip.toml"]):
        subprocess.run([sys.executable, folder / script, *words], check=True, capture_output=True, cwd=tmp_path)
    found = modes.from_calculix(tmp_path / "hip.frd", length_unit=1e-3, mass_unit=1e3, centre=(0, 0, 120))
    # The same body of scikit-fem, with other elements on the same mesh.
    other = np.load(folder / "hip.npz")["frequencies_hz"]
    assert found.frequencies_hz == pytest.approx(other, rel=2e-3)
    mine, theirs = (max(s.stability(path).tilts[0].modes, key=lambda mode: mode.growth_per_s) for path in (tmp_path / "hip.toml", folder / "hip.toml"))
    assert mine.frequency_hz == pytest.approx(theirs.frequency_hz, rel=2e-3)
    assert mine.growth_per_s == pytest.approx(theirs.growth_per_s, rel=0.1)
