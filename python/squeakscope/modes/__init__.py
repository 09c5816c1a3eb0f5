"""Modes of a body from other finite-element programs.

A program exports nodes and mode shapes; :meth:`Modes.at_patch` interpolates the shapes onto the contact nodes of a
scene with ball, socket and load, and :meth:`PatchModes.save` writes a scene that is ready to run::

    found = from_uff("hip.unv", length_unit=1e-3, centre=(0, 0, 120))
    found.at_patch("joint.toml").save("hip.toml")     # and hip.npz

================== ===================================================== =============
function           files                                                 needs
================== ===================================================== =============
`from_uff`         universal files (UFF, UNV)                            pyuff
`from_nastran`     Nastran .op2; .pch with the nodes of a .bdf           pyNastran
`from_ansys`       Ansys .rst                                            ansys-mapdl-reader
`from_abaqus`      the CSV report of an Abaqus output database           nothing
`from_calculix`    CalculiX .frd                                         nothing
`from_csv`         two tables, which any program can write               nothing
================== ===================================================== =============
"""

from ._formats import from_abaqus, from_calculix, from_csv
from ._libraries import from_ansys, from_nastran, from_uff
from ._modes import Frame, Modes, PatchModes

__all__ = [
    "Frame",
    "Modes",
    "PatchModes",
    "from_abaqus",
    "from_ansys",
    "from_calculix",
    "from_csv",
    "from_nastran",
    "from_uff",
]
