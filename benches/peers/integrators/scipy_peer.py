"""SciPy's integrators on Eq. (8), with the plain loop in C++ as the right-hand side.

    scipy_peer.py MODEL.bin HORIZON librhs.so     then requests `METHOD TOLERANCE`, see peer.hpp

The loop is called through Numba, which is faster than ctypes (0.6 us per call instead of 2.4 us, in
addition to the loop itself). METHOD is one of `solve_ivp` (`RK45`, `DOP853`, `Radau`, ...), or of the
older interfaces with compiled steps: `odeint` (LSODA), `ode-dop853`, `ode-dopri5`,
`ode-lsoda`, `ode-vode-adams`, `ode-vode-bdf`.
"""

import ctypes
import json
import sys
import time

import numba
import numpy as np
from scipy import integrate

MAX_STEPS = 10**8


def compiled(library, model, dim):
    """The right-hand side `f(t, y)` and its derivative, as Numba functions."""
    pointer = ctypes.c_void_p
    c_slope, c_derivative = library.model_slope, library.model_slope_derivative
    for function in (c_slope, c_derivative):
        function.argtypes, function.restype = [pointer] * 3, None

    @numba.njit("float64[::1](float64, float64[::1])")
    def slope(t, y):
        out = np.empty(dim)
        c_slope(model, y.ctypes.data, out.ctypes.data)
        return out

    @numba.njit("float64[:, ::1](float64, float64[::1])")
    def derivative(t, y):
        columns = np.empty((dim, dim))
        c_derivative(model, y.ctypes.data, columns.ctypes.data)
        return np.ascontiguousarray(columns.T)

    return slope, derivative


class Peer:
    def __init__(self, path, horizon, library):
        numbers = np.fromfile(path)
        dim, count = 2 * int(numbers[1]), int(numbers[6])
        self.starts = numbers[-count * dim:].reshape(count, dim)
        self.horizon = horizon
        library = ctypes.CDLL(library)
        library.load_model.argtypes = [ctypes.c_char_p]
        library.load_model.restype = ctypes.c_void_p
        self.model = library.load_model(path.encode())
        self.slope, self.derivative = compiled(library, self.model, dim)

    def run(self, method, tolerance, start, slope):
        """The final state."""
        absolute = tolerance * np.linalg.norm(start) / np.sqrt(len(start))
        limits = {"rtol": tolerance, "atol": absolute}
        if method == "odeint":
            return integrate.odeint(slope, start, [0, self.horizon], tfirst=True, mxstep=MAX_STEPS,
                                    **limits)[-1]
        if method.startswith("ode-"):
            _, name, *formula = method.split("-")
            more = {"method": formula[0]} if formula else {}
            jacobian = self.derivative if name == "vode" and formula == ["bdf"] else None
            solver = integrate.ode(slope, jacobian)
            solver.set_integrator(name, nsteps=MAX_STEPS, **limits, **more)
            solver.set_initial_value(start, 0)
            end = solver.integrate(self.horizon)
            assert solver.successful(), "the integration failed"
            return end
        more = {"jac": self.derivative} if method in ("Radau", "BDF", "LSODA") else {}
        result = integrate.solve_ivp(slope, (0, self.horizon), start, method=method,
                                     t_eval=[self.horizon], **limits, **more)
        assert result.success, result.message
        return result.y[:, -1]

    def answer(self, method, tolerance, count):
        """Seconds for all starts, and the final states. Optionally the number of evaluations, because
        counting in Python takes time."""
        calls = 0

        def counted(t, y):
            nonlocal calls
            calls += 1
            return self.slope(t, y)

        slope = counted if count else self.slope
        began = time.thread_time()
        ends = [self.run(method, tolerance, start, slope) for start in self.starts]
        seconds = time.thread_time() - began
        answer = {"seconds": seconds, "ends": [list(end) for end in ends]}
        return answer | {"calls": calls, "derivatives": 0} if count else answer


def main():
    peer = Peer(sys.argv[1], float(sys.argv[2]), sys.argv[3])
    seen = set()
    for line in sys.stdin:
        method, tolerance = line.split()
        try:
            # Only the first answer contains the number of evaluations.
            answer = peer.answer(method, float(tolerance), count=False)
            if line not in seen:
                seen.add(line)
                calls = peer.answer(method, float(tolerance), count=True)["calls"]
                answer |= {"calls": calls, "derivatives": 0}
        except Exception as failure:
            answer = {"failed": str(failure)}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
