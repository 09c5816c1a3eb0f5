"""Readers of modes that use libraries of other projects."""

from __future__ import annotations

import importlib
from os import PathLike, fspath
from typing import Any

import numpy as np

from .._errors import InputError
from ._formats import frequency_hz, punch_modes
from ._modes import Floats, Frame, Modes

_Path = str | PathLike[str]


# The requirements of pyNastran exclude NumPy 2, with which it works up to version 2.3.
_NASTRAN = "'numpy<2.4' scipy cpylog docopt-ng && pip install --no-deps pyNastran"


def _library(name: str, packages: str) -> Any:
    try:
        return importlib.import_module(name)
    # A library that is older than NumPy lacks what was removed there.
    except (ModuleNotFoundError, AttributeError) as error:
        raise ModuleNotFoundError(f"{error}; install it with `pip install {packages}`") from error


def from_uff(path: _Path, **frame: Any) -> Modes:
    """Read modes from a universal file (UFF, UNV): nodes from datasets 15 or 2411, shapes from datasets 55 or 2414.

    Parameters
    ----------
    path : str or os.PathLike
        The file.
    **frame
        Units and axes, as for :class:`Frame`.

    Returns
    -------
    Modes
        Shapes of unit modal mass: those of the file are divided by the square root of their modal masses.

    Raises
    ------
    InputError
        If the file cannot be read, or lacks nodes or modes.
    ModuleNotFoundError
        If pyuff is not installed.
    """
    pyuff = _library("pyuff", "pyuff")
    try:
        sets = pyuff.UFF(fspath(path)).read_sets()
    # The library raises a bare Exception for a file that does not exist.
    except Exception as error:
        raise InputError(f"{fspath(path)} cannot be read as a universal file ({error}); check its path and content") from error
    places: dict[int, Floats] = {}
    modes = []
    for data in sets if isinstance(sets, list) else [sets]:
        if data["type"] in (15, 2411):
            rows = np.stack([data[axis] for axis in "xyz"], axis=1)
            places.update(zip(map(int, data["node_nums"]), rows, strict=True))
        elif data["type"] in (55, 2414) and data["analysis_type"] == 2:
            if data["type"] == 55:
                frequency, mass = data["freq"], data.get("modal_m")
                shape = np.stack([np.real(data[part]) for part in ("r1", "r2", "r3")], axis=1)
            elif data["dataset_location"] == 1 and data["result_type"] == 8:
                frequency, mass = data["record12_field2"], data["record12_field4"]
                shape = np.array(data["data_at_node"])[:, :3]
            else:
                # Results on elements, or other ones than displacements.
                continue
            if not float(mass or 0.0) > 0:
                raise InputError(f"the mode of {frequency} Hz of `{path}` has no modal mass; export it")
            nodes = [int(node) for node in data["node_nums"]]
            modes.append((float(frequency), nodes, shape / np.sqrt(float(mass))))
    return Modes._of(path, places, modes, Frame(**frame))


def from_nastran(path: _Path, geometry: _Path | None = None, **frame: Any) -> Modes:
    """Read modes from a result file of Nastran: .op2 (``PARAM,POST,-1``), or .pch (``DISPLACEMENT(PUNCH)``).

    Parameters
    ----------
    path : str or os.PathLike
        The result file.
    geometry : str or os.PathLike, optional
        The bulk data (.bdf, .dat) with the nodes. Not needed if an .op2 contains them.
    **frame
        Units and axes, as for :class:`Frame`.

    Returns
    -------
    Modes
        Shapes of unit modal mass: those of an .op2 are divided by the square root of their generalised masses; those
        of a .pch need the normalisation MASS, which is the default of Nastran.

    Raises
    ------
    InputError
        If the file lacks nodes or modes, or the displacements have other axes than the positions.
    ModuleNotFoundError
        If pyNastran is not installed.
    """
    punch = fspath(path).lower().endswith(".pch")
    if punch:
        modes: list[Any] = punch_modes(path)
        if geometry is None:
            raise InputError(f"`{path}` has no positions; give the bulk data as geometry")
        model = None
    else:
        model = _library("pyNastran.op2.op2_geom", _NASTRAN).read_op2_geom(fspath(path), debug=None)
        modes = _eigenvectors(path, model)
    if geometry is not None:
        bulk = _library("pyNastran.bdf.bdf", _NASTRAN)
        model = bulk.read_bdf(fspath(geometry), debug=None, punch=_is_bulk_only(geometry))
    assert model is not None
    turned = [number for number, node in model.nodes.items() if node.Cd() != 0]
    if turned:
        raise InputError(f"the displacements of node {turned[0]} of `{path}` have axes of their own; set its CD to 0")
    places = {int(number): node.get_position() for number, node in model.nodes.items()}
    return Modes._of(path, places, modes, Frame(**frame))


def _is_bulk_only(path: _Path) -> bool:
    """Whether a file of Nastran has no executive and case control."""
    with open(path, encoding="utf-8", errors="replace") as file:
        return not any(line.upper().startswith(("CEND", "BEGIN BULK")) for line in file)


def _eigenvectors(path: _Path, model: Any) -> list[tuple[float, list[int], Floats]]:
    if len(model.eigenvectors) != 1:
        raise InputError(f"`{path}` has shapes of {len(model.eigenvectors)} subcases; export one with normal modes")
    (vectors,) = model.eigenvectors.values()
    grids = vectors.node_gridtype[:, 1] == 1
    nodes = [int(number) for number in vectors.node_gridtype[grids, 0]]
    masses: dict[int, float] = {}
    for table in model.eigenvalues.values():
        masses.update(zip(map(int, table.mode), map(float, table.generalized_mass), strict=True))
    modes = []
    for k, (number, squared) in enumerate(zip(vectors.modes, vectors.eigns, strict=True)):
        mass = masses.get(int(number), 1.0)
        if not mass > 0:
            raise InputError(f"mode {number} of `{path}` has no generalised mass; normalise the shapes to MASS")
        modes.append((frequency_hz(float(squared)), nodes, vectors.data[k, grids, :3].astype(float) / np.sqrt(mass)))
    return modes


def from_ansys(path: _Path, **frame: Any) -> Modes:
    """Read modes from a result file of a modal analysis of Ansys (.rst).

    Parameters
    ----------
    path : str or os.PathLike
        The file. Its shapes are normalised to unit modal mass unless ``MODOPT`` says otherwise.
    **frame
        Units and axes, as for :class:`Frame`.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        If the file is not that of a modal analysis.
    ModuleNotFoundError
        If ansys-mapdl-reader is not installed.
    """
    result = _library("ansys.mapdl.reader", "ansys-mapdl-reader").read_binary(fspath(path))
    # The kind of analysis is 2 for modes.
    if result._resultheader["kan"] != 2:
        raise InputError(f"`{path}` is not the result of a modal analysis; export one (ANTYPE,MODAL)")
    places = dict(zip(map(int, result.mesh.nnum), result.mesh.nodes[:, :3], strict=True))
    modes = []
    for k, frequency in enumerate(result.time_values):
        numbers, shape = result.nodal_solution(k)
        # Nodes without degrees of freedom have no displacement.
        moves = np.isfinite(shape[:, :3]).all(axis=1)
        modes.append((float(frequency), [int(number) for number in numbers[moves]], shape[moves, :3]))
    return Modes._of(path, places, modes, Frame(**frame))
