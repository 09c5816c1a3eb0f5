"""Readers of modes in text files."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .._errors import InputError
from ._modes import Frame, Modes

_Path = str | PathLike[str]
#: Frequency (Hz), nodes and shape of each mode.
Shapes = list[tuple[float, list[int], list[list[float]]]]


def from_csv(nodes: _Path, shapes: _Path, **frame: Any) -> Modes:
    """Read modes from a pair of tables, which any program can write.

    Parameters
    ----------
    nodes : str or os.PathLike
        Table with the columns ``node, x, y, z``.
    shapes : str or os.PathLike
        Table with the columns ``frequency_hz, node, x, y, z``: mass-normalised shapes, a row for each mode and node;
        the rows of a mode follow each other.
    **frame
        Units and axes, as for :class:`Frame`.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        If a column, a node or a row is missing.
    """
    places = {int(row[0]): row[1:] for row in _numbers(nodes, ("node", "x", "y", "z"))}
    modes: Shapes = []
    for frequency, node, *vector in _numbers(shapes, ("frequency_hz", "node", "x", "y", "z")):
        _append(modes, frequency, int(node), vector)
    return Modes._of(shapes, places, modes, Frame(**frame))


def _append(modes: Shapes, frequency: float, node: int, vector: list[float]) -> None:
    """Append the displacement of a node to the last mode, or to a new one."""
    # Modes of equal frequency follow each other: the second begins with the first node again.
    if not modes or modes[-1][0] != frequency or modes[-1][1][0] == node:
        modes.append((frequency, [], []))
    modes[-1][1].append(node)
    modes[-1][2].append(vector)


def _rows(path: _Path, columns: tuple[str, ...]) -> Iterator[tuple[int, list[str]]]:
    """Number and columns of each row of a table, whose header may have other columns and spaces."""
    with open(path, newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file, skipinitialspace=True)
        names = [name.strip() for name in next(reader, [])]
        missing = [name for name in columns if name not in names]
        if missing:
            raise InputError(f"`{path}` has no column `{missing[0]}`; it needs {', '.join(columns)}")
        places = [names.index(name) for name in columns]
        for row in reader:
            if row:
                yield reader.line_num, [row[place] if place < len(row) else "" for place in places]


def _numbers(path: _Path, columns: tuple[str, ...]) -> Iterator[list[float]]:
    for line, row in _rows(path, columns):
        try:
            yield [float(word) for word in row]
        except ValueError as error:
            raise InputError(f"`{path}`:{line}: {error}; give numbers") from None


_FREQUENCY = re.compile(r"Freq\s*=\s*([-+.\dEe]+)")


def from_abaqus(path: _Path, **frame: Any) -> Modes:
    """Read modes from the CSV report of an Abaqus output database, or from a results file (.fil) in text form.

    The report, in Abaqus/Viewer: Report > Field output with the variable U (at unique nodal positions) of all frames of
    the frequency step, format CSV; or ``session.writeFieldReport`` with ``COMMA_SEPARATED_VALUES``. The step needs
    ``*FREQUENCY, NORMALIZATION=MASS``. The results file: ``*FILE FORMAT, ASCII`` and, in the frequency step,
    ``*NODE FILE, GLOBAL=YES`` with ``U``.

    Parameters
    ----------
    path : str or os.PathLike
        The report, with the columns ``Frame, Node Label, X, Y, Z, U-U1, U-U2, U-U3``; or the results file.
    **frame
        Units and axes, as for :class:`Frame`.

    Returns
    -------
    Modes
        Shapes of unit modal mass: those of a results file are divided by the square root of their generalised masses.

    Raises
    ------
    InputError
        If the file is another one of Abaqus, or lacks a column, a frequency, nodes or modes.
    """
    ending = Path(path).suffix.lower()
    if ending == ".fil":
        return Modes._of(path, *_results_file(path), Frame(**frame))
    if ending in (".odb", ".dat"):
        raise InputError(f"`{path}` is neither a CSV report (of field output U) nor an ASCII results file; export one")
    columns = ("Frame", "Node Label", "X", "Y", "Z", "U-U1", "U-U2", "U-U3")
    places: dict[int, list[float]] = {}
    modes: dict[str, tuple[float, list[int], list[list[float]]]] = {}
    for line, (name, *words) in _rows(path, columns):
        found = _FREQUENCY.search(name)
        if found is None:
            # The frame of the undeformed body comes first.
            if "Mode" in name:
                raise InputError(f"`{path}`:{line}: the frame `{name}` has no `Freq =`; report a frequency step")
            continue
        try:
            frequency, (node, *numbers) = float(found[1]), [float(word) for word in words]
        except ValueError as error:
            raise InputError(f"`{path}`:{line}: {error}; give numbers") from None
        places[int(node)] = numbers[:3]
        mode = modes.setdefault(name, (frequency, [], []))
        mode[1].append(int(node))
        mode[2].append(numbers[3:])
    return Modes._of(path, places, list(modes.values()), Frame(**frame))


_HEAD = re.compile(r"I..\d+I..(\d+)")
_ITEM = re.compile(r"I..(-?\d+)|D(.{22})")


def _results_file(path: _Path) -> tuple[dict[int, list[float]], Shapes]:
    """Nodes (records 1901) and modes (records 1980, each followed by records 101) of a results file of Abaqus."""
    # Records follow each other in lines of 80 characters, which may have lost their blanks.
    with open(path, encoding="latin-1") as file:
        text = "".join(line.rstrip("\r\n").ljust(80) for line in file)
    if not text.startswith("*I"):
        raise InputError(f"`{path}` is binary; write it in text form (*FILE FORMAT, ASCII)")
    places: dict[int, list[float]] = {}
    modes: Shapes = []
    # Factor to unit modal mass; `None` outside a mode.
    factor: float | None = None
    for number, record in enumerate(text.split("*")):
        head = _HEAD.match(record)
        if head is None or head[1] not in ("101", "1901", "1980", "2001"):
            continue
        try:
            items = [float((a or b).replace("D", "E")) for a, b in _ITEM.findall(record, head.end())]
            if head[1] == "2001":
                factor = None
            elif head[1] == "1901":
                places[int(items[0])] = [items[1], items[2], items[3]]
            elif head[1] == "1980":
                factor = items[2] ** -0.5
                modes.append((frequency_hz(items[1]), [], []))
            elif factor is not None:
                modes[-1][1].append(int(items[0]))
                modes[-1][2].append([factor * items[1], factor * items[2], factor * items[3]])
        except (ValueError, IndexError, ZeroDivisionError, TypeError):
            raise InputError(
                f"record {number} of `{path}` (key {head[1]}) lacks a number, a component or a generalised mass above 0; "
                "write the file again, of a solid model"
            ) from None
    return places, modes


def from_calculix(path: _Path, **frame: Any) -> Modes:
    """Read modes from a result file of CalculiX (.frd) of a ``*FREQUENCY`` step with ``*NODE FILE`` and ``U``.

    CalculiX normalises the shapes to unit modal mass.

    Parameters
    ----------
    path : str or os.PathLike
        The file, in text form.
    **frame
        Units and axes, as for :class:`Frame`.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        If the file lacks nodes or modes, or is binary.
    """
    places: dict[int, list[float]] = {}
    modes: Shapes = []
    for frequency, node, vector in _frd_rows(path):
        if frequency is None:
            places[node] = vector
        else:
            _append(modes, frequency, node, vector)
    return Modes._of(path, places, modes, Frame(**frame))


def _frd_rows(path: _Path) -> Iterator[tuple[float | None, int, list[float]]]:
    """Nodes of an .frd file with their positions, and with the displacements of each mode and its frequency."""
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = enumerate(file, 1)
        for number, head in lines:
            key = head[:6].strip()
            if key not in ("2C", "100C"):
                continue
            if head[73:75].strip() not in ("0", "1"):
                raise InputError(f"`{path}`:{number}: the file is binary; write it in text form (*NODE FILE)")
            width = 5 if head[73:75].strip() == "0" else 10
            # The kind of analysis is 2 for modes.
            frequency, is_read = (None, True) if key == "2C" else (float(head[12:24]), False)
            for number, line in lines:
                if line.startswith(" -3"):
                    break
                if line.startswith(" -4"):
                    is_read = head[57:58] == "2" and line[5:13].strip() == "DISP"
                elif line.startswith(" -1") and is_read:
                    try:
                        vector = [float(line[3 + width + 12 * k :][:12]) for k in range(3)]
                        yield frequency, int(line[3 : 3 + width]), vector
                    except ValueError:
                        raise InputError(f"`{path}`:{number}: give a node and three numbers of 12 columns") from None


def frequency_hz(eigenvalue: float) -> float:
    """Frequency of an eigenvalue (rad²/s²); rigid-body modes, whose eigenvalues are rounding errors, have 0."""
    return float(np.sqrt(max(eigenvalue, 0.0)) / (2 * np.pi))


def punch_modes(path: _Path) -> Shapes:
    """Modes of a punch file of Nastran."""
    modes: Shapes = []
    reads = False
    with open(path, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            # Columns 73 to 80 number the lines.
            line = line.rstrip("\n")[:72]
            if line.startswith("$EIGENVECTOR"):
                reads = True
            elif line.startswith("$EIGENVALUE =") and reads:
                modes.append((frequency_hz(float(line.split("=")[1].split()[0])), [], []))
            elif line.startswith("$TITLE"):
                # The head of the next result.
                reads = False
            elif reads and modes and not line.startswith(("$", "-CONT-")):
                try:
                    node, vector = int(line[:10]), [float(line[18 + 18 * k :][:18]) for k in range(3)]
                except ValueError:
                    raise InputError(f"`{path}`:{number}: give a node and three numbers of 18 columns") from None
                modes[-1][1].append(node)
                modes[-1][2].append(vector)
    return modes
