"""Modes at the nodes of a mesh, and their interpolation onto the contact nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._errors import InputError
from .._squeakscope import Scene, model

Floats = NDArray[np.float64]

# Nodes of the mesh from which the shapes at a contact node are interpolated.
_NEIGHBOURS = 20
# A mode is one of the rigid body below this frequency relative to the highest one.
_RIGID = 1e-3
# Permitted relative deviation of the mass that the rigid-body modes give in each direction.
_MASS_TOLERANCE = 0.02
# Permitted relative deviation of a node of the surface from the radius of the ball.
_SPHERE_TOLERANCE = 0.02
# Keys and tables of a scene that the modes and their patch replace, and the description of the former body.
_REPLACED = dict.fromkeys(
    ["about", "mechanism", "controls", "body", "socket", "contact.nodes", "contact.quadrature"]
    + ["contact.stiffness_distribution", "contact.radius_factor", "contact.pressure"]
)
# Smallest plausible mass per volume of the bounding box of the nodes, kg/m^3, which that of a slender body exceeds and a
# mass in tonnes instead of kilograms does not. There is no largest one, because nodes of a surface have a thin box.
_LIGHTEST = 20.0
# Arrays of `model` that describe the contact patch.
_PATCH = ("version", "positions", "normals", "areas", "pre_stress", "stiffness")


@dataclass(frozen=True)
class Frame:
    """Units and axes of a file.

    Attributes
    ----------
    length_unit : float
        Unit of the positions, m: 1e-3 for millimetres.
    mass_unit : float
        Unit of the masses, kg: 1e3 for the tonne of the units mm, N, t, s.
    centre : array_like
        Centre of the ball, in the unit and along the axes of the file.
    axes : array_like
        Rows: unit vectors along the axes x, y and z of the scene, along the axes of the file. At zero tilt the load
        acts along z; the tilt is towards x at zero azimuth.
    """

    length_unit: float = 1.0
    mass_unit: float = 1.0
    centre: ArrayLike = (0.0, 0.0, 0.0)
    axes: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def _rotation(self) -> Floats:
        rows = np.asarray(self.axes, float)
        if rows.shape != (3, 3) or np.abs(rows @ rows.T - np.eye(3)).max() > 1e-6 or np.linalg.det(rows) < 0:
            raise InputError("axes: give three perpendicular unit vectors that form a right-handed system")
        return rows


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a body at the nodes of a mesh.

    Attributes
    ----------
    nodes : numpy.ndarray
        Positions from the centre of the ball, along the axes of the scene, m, shape (v, 3).
    shapes : numpy.ndarray
        Mass-normalised mode shapes, 1/sqrt(kg), shape (v, 3, m).
    frequencies_hz : numpy.ndarray
        Natural frequencies, ascending, without those of rigid-body modes, shape (m,).
    mass_kg : float or None
        Mass of the body, if the file has the six rigid-body modes of a free body: compare it with the true one.
    """

    nodes: Floats
    shapes: Floats
    frequencies_hz: Floats
    mass_kg: float | None

    @staticmethod
    def _of(
        path: object,
        places: Mapping[int, ArrayLike],
        modes: Sequence[tuple[float, Sequence[int], ArrayLike]],
        frame: Frame,
    ) -> Modes:
        """Modes from positions by node, and frequency, nodes and shape (nodes, 3) of each mode."""
        if not places or not modes:
            raise InputError(f"`{path}` has {len(places)} nodes and {len(modes)} modes; export both")
        numbers = sorted(modes[0][1])
        unknown = [number for number in numbers if number not in places]
        if unknown:
            raise InputError(f"`{path}` has shapes at node {unknown[0]}, but not its position; export all nodes")
        twice = [number for number, other in zip(numbers, numbers[1:], strict=False) if number == other]
        if twice:
            raise InputError(f"the first mode of `{path}` has node {twice[0]} twice; export the nodes of one part only")
        ordered = []
        for k, (_, nodes, shape) in enumerate(modes):
            if sorted(nodes) != numbers or np.shape(shape) != (len(numbers), 3):
                raise InputError(f"mode {k + 1} of `{path}` has other nodes than the first one")
            ordered.append(np.asarray(shape, float)[np.argsort(nodes)])
        positions = np.array([places[number] for number in numbers], float)
        shapes = np.stack(ordered, axis=2)
        frequencies = np.array([frequency for frequency, *_ in modes], float)
        if not all(np.isfinite(array).all() for array in (positions, shapes, frequencies)):
            raise InputError(f"a position, a shape or a frequency of `{path}` is not finite")
        axes = frame._rotation()
        positions = (positions - np.asarray(frame.centre, float)) @ axes.T * frame.length_unit
        shapes = np.einsum("ij,vjm->vim", axes, shapes) / np.sqrt(frame.mass_unit)
        elastic = frequencies > _RIGID * frequencies.max()
        if not elastic.any():
            raise InputError(f"`{path}` has no mode above the rigid-body modes")
        mass = _mass(positions, shapes[:, :, ~elastic])
        order = np.flatnonzero(elastic)[np.argsort(frequencies[elastic], kind="stable")]
        return Modes(positions, shapes[:, :, order], frequencies[order], mass)

    def at_patch(self, patch: Scene | str | PathLike[str] | Mapping[str, ArrayLike]) -> PatchModes:
        """Interpolate the shapes onto the contact nodes of a patch.

        At each contact node the shapes are the quadratic functions that fit best at the 20 nearest nodes of the mesh.
        The patch lies where the load presses, so that tilt, azimuth and load of the scene can have any values for
        which the mesh covers it.

        Parameters
        ----------
        patch : Scene, str, os.PathLike or mapping of arrays
            A scene with ball, socket and load, or its name or path; or the arrays of :func:`squeakscope.model`, or
            their file (.npz).

        Returns
        -------
        PatchModes

        Raises
        ------
        InputError
            If the surface of the mesh is not that of the ball, or does not cover the patch.
        """
        scene = None
        if isinstance(patch, Mapping):
            arrays = dict(patch)
        elif not isinstance(patch, Scene) and fspath(patch).endswith(".npz"):
            arrays = dict(np.load(patch))
        else:
            scene = patch if isinstance(patch, Scene) else Scene.load(patch)
            # The scene multiplies the stiffness of a file by its factor.
            arrays = dict(model(scene.replace(**{"contact.stiffness_factor": 1})))
        kept = {name: np.asarray(arrays[name], float) for name in _PATCH if name in arrays}
        positions = kept["positions"]
        self._check_density()
        self._check_surface(positions, scene)
        shapes = np.stack([self._at(place, self.nodes, self.shapes) for place in positions])
        # The same interpolation at the nodes of the mesh around the patch, each without itself.
        around = np.unique([np.argmin(((self.nodes - place) ** 2).sum(axis=1)) for place in positions])
        others = [np.arange(len(self.nodes)) != node for node in around]
        again = [self._at(self.nodes[a], self.nodes[o], self.shapes[o]) for a, o in zip(around, others, strict=True)]
        kept |= {"shapes": shapes, "frequencies_hz": self.frequencies_hz}
        return PatchModes(kept, _assurance(self.shapes[around], np.stack(again)), scene)

    def _check_density(self) -> None:
        """Check the units of the shapes: in the mean over the body, the square of a shape is one over the mass."""
        mass = 1 / np.median((self.shapes**2).sum(axis=1).mean(axis=0))
        density = mass / np.ptp(self.nodes, axis=0).prod()
        if density < _LIGHTEST:
            raise InputError(
                f"the shapes are those of a body of about {mass:.2g} kg, or {density:.2g} kg/m^3 of its bounding box; check "
                "mass_unit (1e3 for the units mm, N, t, s) and length_unit, and normalise the shapes to unit modal mass"
            )

    @staticmethod
    def _at(place: Floats, nodes: Floats, shapes: Floats) -> Floats:
        """The shapes at a place, from the nodes of a mesh nearest to it."""
        distance = np.linalg.norm(nodes - place, axis=1)
        nearest = np.argsort(distance, kind="stable")[:_NEIGHBOURS]
        scale = distance[nearest].max() + 1e-12
        weight = 1 / (distance[nearest] / scale + 1e-3)
        x, y, z = (nodes[nearest] - place).T / scale
        terms = [np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x]
        # Nodes on a smooth surface do not determine all terms: the smallest solution leaves out the others.
        columns = np.stack(terms, axis=1) * weight[:, None]
        values = shapes[nearest].reshape(len(nearest), -1) * weight[:, None]
        fitted = np.linalg.lstsq(columns, values, rcond=1e-3)[0][0]
        return np.asarray(fitted.reshape(shapes.shape[1:]), float)

    def _check_surface(self, positions: Floats, scene: Scene | None) -> None:
        """Check that the mesh has a surface of the radius of the ball, all around each contact node."""
        ball = np.linalg.norm(positions, axis=1).mean()
        axis = positions.mean(axis=0) / np.linalg.norm(positions.mean(axis=0))
        radii = np.linalg.norm(self.nodes, axis=1)
        directions = self.nodes / np.maximum(radii, 1e-300)[:, None]
        # The outermost nodes in the directions of the patch, which has at least the width of a few elements. Farther away
        # lie beam or stem.
        half_angle = np.arccos(np.clip((positions @ axis / np.linalg.norm(positions, axis=1)).min(), -1, 1))
        width = 2 * half_angle
        near = directions @ axis > np.cos(max(half_angle, 0.2))
        outermost = radii[near].max(initial=0.0)
        # Without nodes there, the surface may end before the patch.
        if near.any() and abs(outermost / ball - 1) > _SPHERE_TOLERANCE:
            raise InputError(
                f"the surface of the mesh is {1e3 * outermost:.4g} mm from the centre of the ball, whose radius is "
                f"{1e3 * ball:.4g} mm; check length_unit, centre and the diameter of the ball"
            )
        surface = directions[np.abs(radii / ball - 1) < _SPHERE_TOLERANCE]
        if len(surface) < _NEIGHBOURS:
            raise InputError(
                f"the mesh has {len(surface)} nodes {1e3 * ball:.4g} mm from the centre of the ball; check length_unit "
                "and centre, or export the surface of the ball"
            )
        if _covered(surface, positions / ball, width).all():
            return
        if scene is None:
            tilt, azimuth = np.degrees([np.arccos(np.clip(axis[2], -1, 1)), np.arctan2(axis[1], axis[0])])
        else:
            tilt, azimuth = scene["load.tilt_deg"], scene["load.azimuth_deg"]
        reached = [
            other
            for other in range(-90, 91)
            if _covered(surface, positions @ _turn(azimuth, other - tilt).T / ball, width).all()
        ]
        reach = f"tilts from {reached[0]} to {reached[-1]} degrees" if reached else "no tilts"
        raise InputError(
            f"the surface of the mesh does not extend all around the patch at a tilt of {tilt:.4g} degrees; at an "
            f"azimuth of {azimuth:.4g} degrees it covers {reach}; export more of the surface, or check centre and axes"
        )


def _covered(surface: Floats, places: Floats, width: float) -> NDArray[np.bool_]:
    """Whether nodes of a surface lie on all sides of each place, not farther than `width`; all on the unit sphere."""
    cosines = places @ surface.T
    nearest = np.argpartition(-cosines, _NEIGHBOURS - 1, axis=1)[:, :_NEIGHBOURS]
    near_enough = cosines.max(axis=1) >= np.cos(width)
    # Angles of the neighbours around the place in its tangent plane.
    helper = np.eye(3)[np.argmin(np.abs(places), axis=1)]
    first = np.cross(places, helper)
    second = np.cross(places, first)
    neighbours = surface[nearest]
    east, north = (np.einsum("nkx,nx->nk", neighbours, axis) for axis in (first, second))
    angles = np.sort(np.arctan2(north, east), axis=1)
    gaps = np.diff(angles, axis=1, append=angles[:, :1] + 2 * np.pi)
    return np.asarray(near_enough & (gaps.max(axis=1) < np.pi))


def _turn(azimuth: float, angle: float) -> Floats:
    """Rotation that increases the tilt towards an azimuth by an angle, both in degrees."""
    azimuth, angle = np.radians(azimuth), np.radians(angle)
    c, s = np.cos(azimuth), np.sin(azimuth)
    to_plane = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    tilt = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    return np.asarray(to_plane.T @ tilt @ to_plane)


def _mass(nodes: Floats, rigid: Floats) -> float | None:
    """Mass of a free body from its rigid-body modes, which also checks that these are mass-normalised.

    The modes ``a + b x r`` with the columns ``g = (a, b)`` of a matrix ``G`` satisfy ``G^T M G = 1`` with the mass
    matrix ``M`` of the rigid body, so that ``M = (G G^T)^-1``, whose first block is the mass times the unit matrix.
    """
    if rigid.shape[2] != 6:
        return None
    size = np.linalg.norm(nodes, axis=1).max()
    x, y, z = nodes.T / size
    zero = np.zeros_like(x)
    turns = np.stack([[zero, z, -y], [-z, zero, x], [y, -x, zero]])
    unit = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, len(x)))
    columns = np.concatenate([unit, turns.transpose(1, 0, 2)], axis=1).transpose(2, 0, 1).reshape(-1, 6)
    g = np.linalg.lstsq(columns, rigid.reshape(-1, 6), rcond=None)[0]
    inertia = np.linalg.inv(g @ g.T)[:3, :3]
    mass = float(np.trace(inertia)) / 3
    deviation = float(np.abs(inertia - mass * np.eye(3)).max()) / mass
    if not deviation < _MASS_TOLERANCE:
        raise InputError(
            f"the rigid-body modes give masses that differ by {100 * deviation:.3g} % with the direction: the shapes "
            "are not mass-normalised; normalise them to unit modal mass"
        )
    return mass


def _assurance(one: Floats, other: Floats) -> Floats:
    one, other = (shapes.reshape(-1, shapes.shape[-1]) for shapes in (one, other))
    products = (one * other).sum(axis=0) ** 2
    return np.asarray(products / np.maximum((one**2).sum(axis=0) * (other**2).sum(axis=0), 1e-300))


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
    scene : Scene or None
        The scene of the patch.
    """

    arrays: dict[str, Floats]
    assurance: Floats
    scene: Scene | None

    def save(self, path: str | PathLike[str]) -> None:
        """Write the file of modes that ``body.modes`` of a scene reads, and the scene.

        Parameters
        ----------
        path : str or os.PathLike
            The file of modes (.npz); or the scene (.toml), which is that of the patch with the modes in a file of the
            same name beside it.

        Raises
        ------
        InputError
            If the name has another ending, or the scene is not valid for these modes.
        """
        path = Path(path)
        if path.suffix not in (".npz", ".toml"):
            raise InputError(f"`{path}`: give a name that ends in .npz or .toml")
        if path.suffix == ".toml" and self.scene is None:
            raise InputError(f"`{path}`: the patch comes without a scene; call at_patch with a scene, or save an .npz")
        file = path.with_suffix(".npz").absolute()
        np.savez_compressed(file, **self.arrays)  # type: ignore[arg-type, unused-ignore]
        if path.suffix == ".toml" and self.scene is not None:
            head = {"name": path.stem, "title": f"Imported modes: {path.stem}", "body.modes": file.as_posix()}
            scene = self.scene.replace(**_REPLACED, **head)
            path.write_text(scene.text.replace(file.as_posix(), file.name), encoding="utf-8")
