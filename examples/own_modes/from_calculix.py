"""Writes a scene with the modes of `calculix.py`: python from_calculix.py hip.frd hip-ccx.toml"""

import sys
from pathlib import Path

from squeakscope import modes

result, scene = sys.argv[1:]
found = modes.from_calculix(result, length_unit=1e-3, mass_unit=1e3, centre=(0, 0, 120))
print(f"{found.mass_kg:.4f} kg; {len(found.frequencies_hz)} modes from {found.frequencies_hz[0]:.1f} Hz")
at_patch = found.at_patch(Path(__file__).with_name("joint.toml"))
print(f"assurance {at_patch.assurance.min():.4f}")
at_patch.save(scene)
