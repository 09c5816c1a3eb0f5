"""Computes the modes of a user-defined body for squeakscope with the finite elements of scikit-fem.

    pip install scikit-fem==12.0.2
    squeakscope model patch.toml --out patch.npz     # exports the contact nodes
    python own_modes.py patch.npz hip.npz            # computes the modes at these nodes
    squeakscope run hip.toml                         # the scene that uses hip.npz

The body is the head, neck and stem of a hip implant: a ball on a bent stem of elliptical section.
`--body beam` uses the ball on a straight round beam instead. squeakscope can mesh that body itself,
which allows a comparison of the two programs. The function `write` shows what any finite-element
program must provide: frequencies and mass-normalised shapes at the contact nodes of squeakscope.
"""

import argparse

import numpy as np
from scipy.sparse.linalg import eigsh
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex, MeshHex2
from skfem.helpers import ddot, dot, eye, sym_grad, trace

# Cobalt-chrome for the hip, steel for ball and beam; SI units throughout.
MATERIAL = {
    "hip": dict(young=220e9, poisson=0.30, density=8300.0),
    "beam": dict(young=207e9, poisson=0.30, density=7800.0),
}
LENGTH = {"hip": 0.150, "beam": 0.200}  # length of the stem outside the ball, m
NECK = {"hip": 8e-3, "beam": 10e-3}  # radius of the stem at the ball, m


def section(body, along):
    """Semi-axes of the stem section (m) at distances along the stem (m)."""
    if body == "beam":
        return NECK[body] + 0 * along, NECK[body] + 0 * along
    stations = [0.0, 0.030, 0.050, 0.150]  # start of the neck, its end, shoulder, tip
    return (
        np.interp(along, stations, [NECK[body], NECK[body], 13e-3, 5e-3]),
        np.interp(along, stations, [NECK[body], NECK[body], 9e-3, 5e-3]),
    )


def centre_line(body, along):
    """Lateral offset (m), depth (m) and slope (rad) of the centre line at distances along the stem (m)."""
    if body == "beam":
        return 0 * along, along, 0 * along
    fine = np.linspace(0.0, LENGTH[body], 2001)
    turn = np.clip((fine - 0.030) / 0.030, 0.0, 1.0)
    slope = np.radians(45.0) * turn * turn * (3.0 - 2.0 * turn)
    step = np.diff(fine, prepend=0.0)
    return tuple(
        np.interp(along, fine, values)
        for values in (np.cumsum(np.sin(slope) * step), np.cumsum(np.cos(slope) * step), slope)
    )


def disc(u, v):
    """Maps the square [-1, 1]^2 to the unit disc; nearly linear inside to avoid folded elements."""
    size = np.maximum(abs(u), abs(v))
    with np.errstate(invalid="ignore", divide="ignore"):
        angle = np.where(
            abs(u) >= abs(v), np.pi / 4 * v / u, np.pi / 2 - np.pi / 4 * u / v
        )
    angle = np.where((abs(u) >= abs(v)) & (u < 0), angle + np.pi, angle)
    angle = np.where((abs(u) < abs(v)) & (v < 0), angle + np.pi, angle)
    angle = np.where(size == 0, 0.0, angle)
    part = size**2
    return (
        (1 - part) * 0.75 * u + part * size * np.cos(angle),
        (1 - part) * 0.75 * v + part * size * np.sin(angle),
    )


def mesh_body(body, ball, n):
    """Meshes a ball of radius `ball` (m) about the origin on a stem below it with quadratic hexahedra.

    The mesh is a column of bricks whose top cube is mapped to the ball.
    """
    neck = NECK[body]
    depth = np.sqrt(ball**2 - neck**2)
    side = np.linspace(-1, 1, n + 1)
    stem = int(np.ceil(LENGTH[body] / (1.6 * neck) * n / 4)) * 2
    column = MeshHex.init_tensor(
        side, side, np.concatenate([np.linspace(-1 - stem, -1, stem + 1)[:-1], side])
    )
    mesh = MeshHex2.from_mesh(column)
    u, v, w = mesh.doflocs
    places = np.empty_like(mesh.doflocs)

    below = w <= -1
    x, y = disc(u[below], v[below])
    along = (-1 - w[below]) / stem * LENGTH[body]
    half_x, half_y = section(body, along)
    aside, down, slope = centre_line(body, along)
    places[:, below] = (
        aside + np.cos(slope) * half_x * x,
        half_y * y,
        -depth - down + np.sin(slope) * half_x * x,
    )

    u, v, w = u[~below], v[~below], w[~below]
    size = np.maximum(np.maximum(abs(u), abs(v)), abs(w))
    outside = np.array([u, v, w]) / np.maximum(size, 1e-12)
    # A cubed sphere whose lower edge is moved to the neck.
    cube = np.tan(np.pi / 4 * outside)
    round_ = np.hypot(cube[0], cube[1])
    polar = np.arctan2(round_, cube[2])
    edge = np.arctan2(round_ / np.maximum(abs(cube[:2]).max(axis=0), 1e-12), -1.0)
    corner = np.pi - np.arcsin(neck / ball)
    lower = np.pi / 2 + (polar - np.pi / 2) * (corner - np.pi / 2) / (edge - np.pi / 2)
    polar = np.where(polar > np.pi / 2, lower, polar)
    azimuth = np.arctan2(cube[1], cube[0])
    sphere = ball * np.array(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)]
    )
    # The bottom of the inner cubes is flat.
    x, y = disc(outside[0], outside[1])
    flat = np.array([neck * x, neck * y, np.full_like(x, -depth)])
    surface = np.where(outside[2] <= -1 + 1e-9, flat, sphere)
    high = 0.5 * (ball - depth) + 0.3 * (ball + depth) * w
    straight = np.array([0.5 * ball * u, 0.5 * ball * v, high])
    places[:, ~below] = (1 - size**2) * straight + size**2 * (size * surface)
    return MeshHex2(doflocs=places, t=mesh.t)


@BilinearForm
def stiffness(u, v, p):
    strain = sym_grad(u)
    stress = 2 * p.shear * strain + eye(p.lame * trace(strain), 3)
    return ddot(stress, sym_grad(v))


@BilinearForm
def mass(u, v, p):
    return p.density * dot(u, v)


def modes_of(basis, material, count):
    """Elastic free-free modes: frequencies (Hz), mass-normalised shapes (dofs, modes), mass matrix."""
    young, poisson = material["young"], material["poisson"]
    shear = young / (2 * (1 + poisson))
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    k = stiffness.assemble(basis, shear=shear, lame=lame)
    m = mass.assemble(basis, density=material["density"])
    # The negative shift makes the matrix definite. The first six eigenvectors are rigid-body motions.
    squares, shapes = eigsh(k.tocsc(), count + 6, m.tocsc(), sigma=-((2 * np.pi * 300) ** 2))
    order = np.argsort(squares)[6:]
    return np.sqrt(squares[order]) / (2 * np.pi), shapes[:, order], m.tocsr()


def rows_at(basis, points):
    """Interpolation rows (points, 3, dofs) for the displacement at surface points (n, 3)."""
    mapping, mesh = basis.mapping, basis.mesh
    middles = mesh.p[:, mesh.t].mean(axis=1).T
    rows = np.zeros((len(points), 3, basis.N))
    for row, point in zip(rows, points):
        # Choose the element in which the local coordinates of the point exceed [0, 1] least.
        near = np.argsort(np.linalg.norm(middles - point, axis=1))[:12]
        local = np.full((3, len(near), 1), 0.5)
        for _ in range(30):
            miss = point[:, None, None] - mapping.F(local, tind=near)
            local = local + np.einsum("ijkl,jkl->ikl", mapping.invDF(local, tind=near), miss)
            local = np.clip(local, -1, 2)
        outside = np.maximum(local - 1, -local).max(axis=(0, 2))
        best = int(np.argmin(outside))
        if outside[best] > 1e-2:
            raise SystemExit(f"the point {point} is not on the body")
        for i in range(basis.Nbfun):
            value = basis.elem.gbasis(mapping, local[:, [best]], i, tind=near[[best]])[0]
            row[:, basis.element_dofs[i, near[best]]] += value.reshape(3)
    return rows


def surface_of(basis, shapes):
    """The surface as triangles for display: vertices, triangles, shapes (vertices, 3, modes)."""
    mesh = basis.mesh
    facets = mesh.boundary_facets()
    corners = mesh.facets[:, facets].T
    # The corners circulate around each facet; outwards is away from the centre of its element.
    middle = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1).T
    a, b, c = (mesh.p[:, corners[:, k]].T for k in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - middle) < 0
    corners[inwards] = corners[inwards, ::-1]
    used, renamed = np.unique(corners, return_inverse=True)
    renamed = renamed.reshape(corners.shape)
    triangles = np.concatenate([renamed[:, [0, 1, 2]], renamed[:, [0, 2, 3]]])
    return mesh.p[:, used].T, triangles, shapes[basis.nodal_dofs[:, used].T, :]


def write(path, patch, hz, rows, shapes, surface, extra):
    """Writes the contact nodes of squeakscope and the modes computed here."""
    kept = ["positions", "normals", "areas", "pre_stress", "stiffness"]
    vertices, triangles, surface_shapes = surface
    np.savez_compressed(
        path,
        **{name: patch[name] for name in kept},
        frequencies_hz=hz,
        shapes=np.einsum("nxd,dm->nxm", rows, shapes),
        surface_vertices=vertices.astype(np.float32),
        surface_triangles=triangles.astype(np.int16),
        surface_shapes=surface_shapes.astype(np.float32),
        **extra,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("patch", help="file from `squeakscope model` for the same ball and load")
    parser.add_argument("out", help="output file")
    parser.add_argument("--body", choices=["hip", "beam"], default="hip")
    parser.add_argument("--modes", type=int, default=12)
    parser.add_argument("--elements", type=int, default=4, help="number of elements across the body, even")
    parser.add_argument(
        "--mass",
        action="store_true",
        help="also write the mass matrix, which lets squeakscope check the shapes (larger file)",
    )
    args = parser.parse_args()
    patch = np.load(args.patch)
    ball = np.linalg.norm(patch["positions"], axis=1).mean()
    basis = Basis(mesh_body(args.body, ball, args.elements), ElementVector(ElementHex2()), intorder=4)
    hz, shapes, m = modes_of(basis, MATERIAL[args.body], args.modes)
    extra = {}
    if args.mass:
        extra = dict(
            mass_data=m.data, mass_indices=m.indices, mass_indptr=m.indptr, dof_shapes=shapes
        )
    rows = rows_at(basis, patch["positions"])
    write(args.out, patch, hz, rows, shapes, surface_of(basis, shapes), extra)
    print(f"{basis.N} degrees of freedom, {args.modes} modes:", *(f"{f:.1f}" for f in hz), "Hz")


if __name__ == "__main__":
    main()
