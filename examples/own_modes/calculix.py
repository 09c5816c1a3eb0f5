"""Computes the modes of the hip implant of `own_modes.py` with CalculiX, for `squeakscope.modes.from_calculix`.

    apt install calculix-ccx; pip install scikit-fem==12.0.2
    python calculix.py hip.inp       # writes hip.inp, and hip.frd with 12 elastic modes of the free body
    python from_calculix.py hip.frd hip-ccx.toml

The mesh is that of `own_modes.py`; its units are mm, N, t and s, and the ball is 120 mm above the origin.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
from own_modes import MATERIAL, mesh_body
from skfem import ElementHex2

# Nodes of the element C3D20: the corners (the axes of scikit-fem's elements form a left-handed system here), and the
# pairs of corners around the nodes on the edges.
CORNERS = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
CENTRE_MM = (0.0, 0.0, 120.0)


def write_deck(path, ball, modes, elements):
    """Writes the mesh of the body (radius of the ball in m), its material and the modal analysis."""
    mesh = mesh_body("hip", ball, elements)
    material = MATERIAL["hip"]
    wanted = np.array([*CORNERS, *(0.5 * (CORNERS[a] + CORNERS[b]) for a, b in EDGES)])
    local = [int(np.argmin(abs(ElementHex2().doflocs - place).sum(axis=1))) for place in wanted]
    bricks = mesh.dofs.element_dofs[local].T
    places = 1e3 * mesh.doflocs.T + CENTRE_MM
    used = np.unique(bricks)
    with open(path, "w") as file:
        file.write("*NODE, NSET=ALL\n")
        file.writelines(f"{k + 1}, {x:.9g}, {y:.9g}, {z:.9g}\n" for k, (x, y, z) in zip(used, places[used]))
        file.write("*ELEMENT, TYPE=C3D20, ELSET=BODY\n")
        for k, brick in enumerate(bricks + 1):
            file.write(f"{k + 1}, {', '.join(map(str, brick[:10]))},\n {', '.join(map(str, brick[10:]))}\n")
        file.write(
            f"*MATERIAL, NAME=METAL\n*ELASTIC\n{1e-6 * material['young']:g}, {material['poisson']:g}\n"
            f"*DENSITY\n{1e-12 * material['density']:g}\n*SOLID SECTION, ELSET=BODY, MATERIAL=METAL\n"
            f"*STEP\n*FREQUENCY\n{modes + 6}\n*NODE FILE\nU\n*END STEP\n"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("deck", type=Path, help="input file of CalculiX to write (.inp)")
    parser.add_argument("--ball-radius-mm", type=float, default=16.0)
    parser.add_argument("--modes", type=int, default=12, help="number of elastic modes")
    parser.add_argument("--elements", type=int, default=4, help="number of elements across the body, even")
    args = parser.parse_args()
    write_deck(args.deck, 1e-3 * args.ball_radius_mm, args.modes, args.elements)
    subprocess.run(["ccx", args.deck.stem], cwd=args.deck.parent, check=True)


if __name__ == "__main__":
    main()
