"""Modes of a body from other finite-element programs.

A program exports nodes and mode shapes; :meth:`Modes.at_patch` interpolates the shapes onto the contact nodes of a
scene, and :meth:`PatchModes.save` writes the file that ``body.modes`` of a scene reads::

    modes = from_uff("hip.unv", length_unit=1e-3, centre=(0, 0, 120))
    modes.at_patch("patch.npz").save("hip.npz")     # patch.npz from `squeakscope model patch.toml --out patch.npz`
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError

_Floats = NDArray[np.float64]

# Nodes of the mesh from which the shapes at a contact node are interpolated.
_NEIGHBOURS = 20
# A mode is one of the rigid body below this frequency relative to the highest one.
_RIGID = 1e-3


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a body at the nodes of a mesh.

    Attributes
    ----------
    nodes : numpy.ndarray
        Positions from the centre of the ball, m, shape (v, 3).
    shapes : numpy.ndarray
        Mass-normalised mode shapes, 1/sqrt(kg), shape (v, 3, m).
    frequencies_hz : numpy.ndarray
        Natural frequencies, ascending, without those of rigid-body modes, shape (m,).
    """

    nodes: _Floats
    shapes: _Floats
    frequencies_hz: _Floats

    @staticmethod
    def _of(
        nodes: ArrayLike,
        shapes: ArrayLike,
        frequencies_hz: ArrayLike,
        length_unit: float,
        centre: ArrayLike,
    ) -> Modes:
        places, vectors = np.asarray(nodes, float), np.asarray(shapes, float)
        frequencies = np.asarray(frequencies_hz, float)
        expected = (len(places), 3, len(frequencies))
        if places.ndim != 2 or places.shape[1] != 3 or vectors.shape != expected:
            raise InputError(f"the shapes have the dimensions {vectors.shape}; {expected} are needed")
        if not (np.isfinite(places).all() and np.isfinite(vectors).all() and np.isfinite(frequencies).all()):
            raise InputError("a position, a shape or a frequency is not finite")
        elastic = frequencies > _RIGID * frequencies.max(initial=0.0)
        if not elastic.any():
            raise InputError("there is no mode above the rigid-body modes")
        order = np.argsort(frequencies[elastic], kind="stable")
        places = (places - np.asarray(centre, float)) * length_unit
        return Modes(places, vectors[:, :, elastic][:, :, order], frequencies[elastic][order])

    def at_patch(self, patch: str | PathLike[str] | Mapping[str, ArrayLike]) -> PatchModes:
        """Interpolate the shapes onto the contact nodes of a patch.

        At each contact node the shapes are the quadratic functions that fit best at the 20 nearest nodes of the mesh.

        Parameters
        ----------
        patch : str, os.PathLike or mapping of arrays
            The arrays of ``squeakscope model``, or their file.

        Returns
        -------
        PatchModes

        Raises
        ------
        InputError
            If the mesh has no nodes near a contact node.
        """
        arrays = dict(patch) if isinstance(patch, Mapping) else dict(np.load(patch))
        positions = np.asarray(arrays["positions"], float)
        distance = np.linalg.norm(self.nodes[None] - positions[:, None], axis=2)
        count = min(_NEIGHBOURS, len(self.nodes))
        nearest = np.argsort(distance, axis=1, kind="stable")[:, :count]
        reach = np.take_along_axis(distance, nearest, axis=1)
        # The mesh is too coarse, or elsewhere, if the nearest nodes are farther than the patch is wide.
        width = 2 * np.linalg.norm(positions - positions.mean(axis=0), axis=1).max()
        worst = int(np.argmax(reach[:, 0]))
        if reach[worst, 0] > width:
            raise InputError(
                f"the nearest node of the mesh is {1e3 * reach[worst, 0]:.3g} mm from contact node {worst}, and the "
                f"patch is {1e3 * width:.3g} mm wide; check length_unit and centre, or refine the mesh"
            )
        shapes = np.empty((len(positions), 3, len(self.frequencies_hz)))
        for k, place in enumerate(positions):
            shapes[k] = self._quadratic(place, nearest[k], reach[k])
        # The same interpolation at the nodes of the mesh around the patch, each without itself.
        around = np.unique(nearest[:, 0])
        again = np.empty((len(around), *shapes.shape[1:]))
        for k, node in enumerate(around):
            away = np.linalg.norm(self.nodes - self.nodes[node], axis=1)
            others = np.argsort(away, kind="stable")[1 : count + 1]
            again[k] = self._quadratic(self.nodes[node], others, away[others])
        arrays["shapes"] = shapes
        arrays["frequencies_hz"] = self.frequencies_hz
        for name in ("omega", "z0", "probe", "equilibrium"):
            arrays.pop(name, None)
        return PatchModes(arrays, _assurance(self.shapes[around], again))

    def _quadratic(self, place: _Floats, nodes: NDArray[np.intp], distance: _Floats) -> _Floats:
        scale = distance.max() + 1e-12
        weight = 1 / (distance / scale + 1e-3)
        x, y, z = (self.nodes[nodes] - place).T / scale
        terms = [np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x]
        # Nodes on a smooth surface do not determine all terms: the smallest solution leaves out the others.
        columns = np.stack(terms, axis=1) * weight[:, None]
        values = self.shapes[nodes].reshape(len(nodes), -1) * weight[:, None]
        fitted = np.linalg.lstsq(columns, values, rcond=1e-3)[0][0]
        return np.asarray(fitted.reshape(self.shapes.shape[1:]), float)


@dataclass(frozen=True, eq=False)
class PatchModes:
    """Modes at the contact nodes of a patch.

    Attributes
    ----------
    arrays : dict of numpy.ndarray
        The arrays of a file of modes.
    assurance : numpy.ndarray
        Modal assurance criterion of each mode, 0 to 1: of its shape at the nodes of the mesh around the patch, against
        that interpolated from their neighbours. Below about 0.99 the mesh is too coarse for the mode.
    """

    arrays: dict[str, Any]
    assurance: _Floats

    def save(self, path: str | PathLike[str]) -> None:
        """Write the file of modes, which ``body.modes`` of a scene reads.

        Parameters
        ----------
        path : str or os.PathLike
            The file, .npz.
        """
        np.savez(path, **self.arrays)


def _assurance(one: _Floats, other: _Floats) -> _Floats:
    one, other = (shapes.reshape(-1, shapes.shape[-1]) for shapes in (one, other))
    products = (one * other).sum(axis=0) ** 2
    return np.asarray(products / np.maximum((one**2).sum(axis=0) * (other**2).sum(axis=0), 1e-300))


def from_uff(
    path: str | PathLike[str],
    *,
    length_unit: float = 1.0,
    centre: ArrayLike = (0.0, 0.0, 0.0),
) -> Modes:
    """Read modes from a universal file (UFF, UNV): nodes from datasets 15 or 2411, shapes from datasets 55.

    Parameters
    ----------
    path : str or os.PathLike
        The file.
    length_unit : float
        Unit of the positions, m: 1e-3 for millimetres.
    centre : array_like
        Centre of the ball, in the unit of the file.

    Returns
    -------
    Modes
        Shapes of unit modal mass: those of the file are divided by the square root of their modal masses, kg.

    Raises
    ------
    InputError
        If the file lacks nodes or modes.
    ModuleNotFoundError
        If pyuff is not installed.
    """
    import pyuff

    sets = pyuff.UFF(str(path)).read_sets()
    sets = sets if isinstance(sets, list) else [sets]
    places: dict[int, list[float]] = {}
    for data in (data for data in sets if data["type"] in (15, 2411)):
        rows = zip(data["node_nums"], data["x"], data["y"], data["z"], strict=True)
        places.update({int(number): [x, y, z] for number, x, y, z in rows})
    modes = [data for data in sets if data["type"] == 55 and data["analysis_type"] == 2]
    if not places or not modes:
        raise InputError(
            f"`{path}` has {len(places)} nodes (datasets 15, 2411) and {len(modes)} modes (datasets 55 of normal "
            "modes); export both"
        )
    numbers = np.asarray(modes[0]["node_nums"], int)
    unknown = [int(number) for number in numbers if int(number) not in places]
    if unknown:
        raise InputError(f"`{path}` has shapes at node {unknown[0]}, but not its position; export all nodes")
    shapes = []
    for data in modes:
        if not np.array_equal(np.asarray(data["node_nums"], int), numbers):
            raise InputError(f"mode {data['mode_n']} of `{path}` has other nodes than the first one")
        mass = float(data.get("modal_m") or 0.0)
        if not mass > 0:
            raise InputError(f"mode {data['mode_n']} of `{path}` has no modal mass; export it")
        parts = [np.real(np.asarray(data[part])) for part in ("r1", "r2", "r3")]
        shapes.append(np.stack(parts, axis=1) / np.sqrt(mass))
    frequencies = [float(data["freq"]) for data in modes]
    nodes = [places[int(number)] for number in numbers]
    return Modes._of(nodes, np.stack(shapes, axis=2), frequencies, length_unit, centre)


def from_csv(
    nodes: str | PathLike[str],
    shapes: str | PathLike[str],
    *,
    length_unit: float = 1.0,
    centre: ArrayLike = (0.0, 0.0, 0.0),
) -> Modes:
    """Read modes from a pair of tables, which any program can write.

    Parameters
    ----------
    nodes : str or os.PathLike
        Table with the columns ``node, x, y, z``.
    shapes : str or os.PathLike
        Table with the columns ``frequency_hz, node, x, y, z``: mass-normalised shapes, 1/sqrt(kg), a row for each mode
        and node.
    length_unit : float
        Unit of the positions, m.
    centre : array_like
        Centre of the ball, in that unit.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        If a column, a node or a row is missing.
    """
    places = {row[0]: row[1:] for row in _rows(nodes, ("node", "x", "y", "z"))}
    table: dict[float, dict[float, list[float]]] = {}
    for frequency, node, *vector in _rows(shapes, ("frequency_hz", "node", "x", "y", "z")):
        table.setdefault(frequency, {})[node] = vector
    if not table:
        raise InputError(f"`{shapes}` has no rows")
    for frequency, mode in table.items():
        if mode.keys() != places.keys():
            raise InputError(
                f"`{shapes}`: the mode at {frequency} Hz has {len(mode)} nodes, and `{nodes}` has {len(places)}; "
                "give a row for each node"
            )
    vectors = [[mode[node] for node in places] for mode in table.values()]
    moved = np.moveaxis(np.asarray(vectors, float), 0, 2)
    return Modes._of(list(places.values()), moved, list(table), length_unit, centre)


def _rows(path: str | PathLike[str], columns: tuple[str, ...]) -> list[list[float]]:
    with open(path, newline="", encoding="utf-8-sig") as file:
        reader = csv.DictReader(file, skipinitialspace=True)
        missing = [name for name in columns if name not in (reader.fieldnames or ())]
        if missing:
            raise InputError(f"`{path}` has no column `{missing[0]}`; it needs {', '.join(columns)}")
        rows = []
        for row in reader:
            try:
                rows.append([float(row[name]) for name in columns])
            except (TypeError, ValueError) as error:
                raise InputError(f"`{path}`:{reader.line_num}: {error}; give numbers") from None
        return rows
