"""Signals and runs that several tests use."""

import numpy as np
import pytest

import squeakscope as s


@pytest.fixture(scope="session")
def run() -> s.Run:
    """10 ms of a periodic motion."""
    return s.run("periodic-2deg", duration=0.01)


@pytest.fixture(scope="session")
def lorenz() -> np.ndarray:
    """20,000 samples of the first coordinate of the Lorenz system, step 0.01."""

    def rhs(t: float, z: np.ndarray) -> tuple[float, float, float]:
        x, y, w = z
        return 10 * (y - x), x * (28 - w) - y, x * y - 8 / 3 * w

    t = np.arange(22_000) * 0.01
    found = s.integrate(rhs, [1.0, 1.0, 20.0], t, method="tsit5", tolerance=1e-6, max_step=0.1)
    return found.z[2000:, 0]
