"""Compares the analyses of squeakscope with public libraries on the same data and machine.

Measures times (shortest of several, after a warm-up that includes just-in-time compilation) and results
of recurrence quantification, mutual information, false nearest neighbours and the spectrogram.

    apt install pocl-opencl-icd                 # OpenCL on the CPU, for PyRQA
    python3 -m venv peers && peers/bin/pip install -r benches/peers/requirements.txt
    peers/bin/python benches/peers/compare.py   # also builds and runs `cargo bench --bench peers`

Prints a table. `--write` also inserts it into src/guide/explanation/peers.md.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GUIDE = ROOT / "src/guide/explanation/peers.md"

RQA_POINTS, LAG, DIMENSION = 10_000, 16, 5
MIN_LINE = 2
SERIES_POINTS, MAX_LAG, BINS = 50_000, 100, 64
MAX_DIMENSION, THEILER, R_TOL, A_TOL = 8, 16, 15.0, 2.0
STFT_SAMPLES, STFT_WINDOW, STFT_HOP = 1_000_000, 1024, 256


def lorenz(count, dt=0.01, skip=10_000):
    """x of the Lorenz system (10, 28, 8/3), classical Runge-Kutta."""
    import numpy as np

    def slope(s):
        x, y, z = s
        return np.array([10 * (y - x), x * (28 - z) - y, x * y - 8 / 3 * z])

    state, out = np.array([1.0, 1.0, 20.0]), np.empty(count)
    for i in range(-skip, count):
        k1 = slope(state)
        k2 = slope(state + dt / 2 * k1)
        k3 = slope(state + dt / 2 * k2)
        k4 = slope(state + dt * k3)
        state = state + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if i >= 0:
            out[i] = state[0]
    return out


def timed(function, repeats):
    """Result and shortest time of `function`, after one warm-up call."""
    function()
    best = float("inf")
    for _ in range(repeats):
        began = time.perf_counter()
        result = function()
        best = min(best, time.perf_counter() - began)
    return result, best


def embedded(x, lag, dimension):
    import numpy as np

    count = len(x) - (dimension - 1) * lag
    return np.stack([x[c * lag : c * lag + count] for c in range(dimension)], axis=1)


# ---- recurrence quantification -------------------------------------------------------------


def rqa_numba(x, epsilon):
    """One compiled sweep over the upper triangle: a straightforward implementation."""
    import numba
    import numpy as np

    @numba.njit(fastmath=True, cache=False)
    def sweep(points, limit):
        n, m = points.shape
        diagonal, vertical = np.zeros(n + 1, np.int64), np.zeros(n + 1, np.int64)
        run = np.zeros(n, np.int64)
        recurrent = 0
        for i in range(n):
            column = 0
            for j in range(i + 1, n):
                d = 0.0
                for c in range(m):
                    t = points[i, c] - points[j, c]
                    d += t * t
                k = j - i
                if d <= limit:
                    recurrent += 1
                    run[k] += 1
                    column += 1
                else:
                    if run[k] > 0:
                        diagonal[run[k]] += 1
                        run[k] = 0
                    if column > 0:
                        vertical[column] += 1
                        column = 0
            if column > 0:
                vertical[column] += 1
        for k in range(n):
            if run[k] > 0:
                diagonal[run[k]] += 1
        return recurrent, diagonal, vertical

    points = embedded(x, LAG, DIMENSION)

    def go():
        n = len(points)
        recurrent, diagonal, _ = sweep(points, epsilon**2)
        length = np.arange(n + 1)
        long = diagonal[MIN_LINE:] @ length[MIN_LINE:]
        return {
            "recurrence_rate": recurrent / (n * (n - 1) / 2),
            "determinism": long / recurrent,
            "mean_diagonal": long / diagonal[MIN_LINE:].sum(),
        }

    return timed(go, 5)


def rqa_pyrqa(x, epsilon):
    from pyrqa.computation import RQAComputation
    from pyrqa.metric import EuclideanMetric
    from pyrqa.neighbourhood import FixedRadius
    from pyrqa.settings import Settings
    from pyrqa.time_series import TimeSeries

    series = TimeSeries(x, embedding_dimension=DIMENSION, time_delay=LAG)
    settings = Settings(series, neighbourhood=FixedRadius(epsilon),
                        similarity_measure=EuclideanMetric, theiler_corrector=1)

    def go():
        result = RQAComputation.create(settings).run()
        return {
            "recurrence_rate": float(result.recurrence_rate),
            "determinism": float(result.determinism),
            "mean_diagonal": float(result.average_diagonal_line),
        }

    return timed(go, 3)


def rqa_pyunicorn(x, epsilon):
    from pyunicorn.timeseries import RecurrencePlot

    def go():
        plot = RecurrencePlot(x, dim=DIMENSION, tau=LAG, metric="euclidean", threshold=epsilon,
                              silence_level=2)
        result = {
            "recurrence_rate": plot.recurrence_rate(),
            "determinism": plot.determinism(l_min=MIN_LINE),
            "mean_diagonal": plot.average_diaglength(l_min=MIN_LINE),
        }
        plot.max_diaglength(), plot.diag_entropy(), plot.laminarity(v_min=MIN_LINE)
        plot.average_vertlength(), plot.max_vertlength(), plot.mean_recurrence_time()
        return result

    return timed(go, 2)


def rqa_accrqa(x, epsilon):
    import accrqa
    import numpy as np

    one = lambda value, kind: np.array([value], dtype=kind)
    arguments = (one(LAG, np.int32), one(DIMENSION, np.int32), one(MIN_LINE, np.int32),
                 one(epsilon, np.float64), accrqa.accrqaDistance("euclidean"))

    def go():
        diagonal = accrqa.DET(x, *arguments, tidy_data=False).ravel()
        accrqa.LAM(x, *arguments, tidy_data=False)
        return {
            "recurrence_rate": float(diagonal[4]),
            "determinism": float(diagonal[0]),
            "mean_diagonal": float(diagonal[1]),
        }

    return timed(go, 3)


# ---- mutual information --------------------------------------------------------------------


def ami_numba(x):
    import numba
    import numpy as np

    @numba.njit
    def table(index, lag, bins):
        joint = np.zeros((bins, bins))
        for i in range(len(index) - lag):
            joint[index[i], index[i + lag]] += 1
        return joint

    def go():
        low, high = x.min(), x.max()
        index = np.minimum((BINS * (x - low) / (high - low)).astype(np.int64), BINS - 1)
        bits = []
        for lag in range(MAX_LAG + 1):
            joint = table(index, lag, BINS)
            p = joint / joint.sum()
            q = p.sum(axis=1)[:, None] * p.sum(axis=0)[None, :]
            seen = p > 0
            bits.append(float((p[seen] * np.log2(p[seen] / q[seen])).sum()))
        return {"first_minimum": first_minimum(bits), "bits_at_lag_10": bits[10]}

    return timed(go, 3)


def ami_numpy(x):
    import numpy as np

    def go():
        bits = []
        edges = np.linspace(x.min(), x.max(), BINS + 1)
        for lag in range(MAX_LAG + 1):
            joint, _, _ = np.histogram2d(x[: len(x) - lag], x[lag:], bins=[edges, edges])
            p = joint / joint.sum()
            q = p.sum(axis=1)[:, None] * p.sum(axis=0)[None, :]
            seen = p > 0
            bits.append(float((p[seen] * np.log2(p[seen] / q[seen])).sum()))
        return {"first_minimum": first_minimum(bits), "bits_at_lag_10": bits[10]}

    return timed(go, 1)


def ami_neurokit(x):
    import neurokit2

    def go():
        lag, _ = neurokit2.complexity_delay(x, delay_max=MAX_LAG, method="fraser1986")
        return {"first_minimum": int(lag)}

    return timed(go, 1)


def first_minimum(bits):
    for lag in range(1, len(bits) - 1):
        if bits[lag - 1] > bits[lag] <= bits[lag + 1]:
            return lag
    return None


# ---- false nearest neighbours --------------------------------------------------------------


def fnn_scipy(x):
    """Kennel's two criteria with cKDTree, without a Theiler window, which its k-nearest query lacks."""
    import numpy as np
    from scipy.spatial import cKDTree

    workers = len(os.sched_getaffinity(0))

    def go():
        share, size = [], x.std()
        for m in range(1, MAX_DIMENSION + 1):
            count = len(x) - m * LAG
            points = embedded(x, LAG, m)[:count]
            distance, place = cKDTree(points).query(points, k=2, workers=workers)
            near, other = distance[:, 1], place[:, 1]
            growth = np.abs(x[m * LAG :][:count] - x[m * LAG :][other])
            false = (growth > R_TOL * near) | (np.hypot(growth, near) > A_TOL * size)
            share.append(float(false.mean()))
        return {"share": share[:4]}

    return timed(go, 1)


def fnn_neurokit(x):
    import neurokit2

    def go():
        _, info = neurokit2.complexity_dimension(
            x, delay=LAG, dimension_max=MAX_DIMENSION, method="fnn", R=R_TOL, A=A_TOL
        )
        return {"share": [float(v) for v in info["f3"][:4]]}

    return timed(go, 1)


# ---- spectrogram ---------------------------------------------------------------------------


def stft_librosa(x):
    import librosa
    import numpy as np

    def go():
        columns = np.abs(librosa.stft(x, n_fft=STFT_WINDOW, hop_length=STFT_HOP, center=False,
                                      window="hann"))
        return {"columns": int(columns.shape[1])}

    return timed(go, 5)


def stft_scipy(x):
    import numpy as np
    from scipy.signal import ShortTimeFFT
    from scipy.signal.windows import hann

    transform = ShortTimeFFT(hann(STFT_WINDOW, sym=False), STFT_HOP, fs=1.0)

    def go():
        return {"columns": int(np.abs(transform.stft(x)).shape[1])}

    return timed(go, 5)


CASES = {
    "rqa": {"numba, one sweep": rqa_numba, "PyRQA (PoCL)": rqa_pyrqa, "pyunicorn": rqa_pyunicorn,
            "AccRQA": rqa_accrqa},
    "ami": {"numba": ami_numba, "numpy": ami_numpy, "neurokit2": ami_neurokit},
    "fnn": {"SciPy cKDTree": fnn_scipy, "neurokit2": fnn_neurokit},
    "stft": {"librosa": stft_librosa, "SciPy": stft_scipy},
}

TITLES = {
    "rqa": f"full recurrence quantification, {RQA_POINTS:,} states, m = {DIMENSION}, Euclidean",
    "ami": f"mutual information, {SERIES_POINTS:,} samples, {MAX_LAG + 1} lags, {BINS} bins",
    "fnn": f"false neighbours, {SERIES_POINTS:,} samples, m = 1 to {MAX_DIMENSION}",
    "stft": f"spectrogram, {STFT_SAMPLES:,} samples, window {STFT_WINDOW}, hop {STFT_HOP}",
}


def worker(folder, case, name, epsilon):
    """Times one peer on one case, in a separate process to keep the peers independent."""
    import numpy as np

    x = np.load(Path(folder) / f"{case}.npy")
    function = CASES[case][name]
    result, seconds = function(x, epsilon) if case == "rqa" else function(x)
    print("RESULT " + json.dumps({"seconds": seconds, "result": result}))


def run_peer(folder, case, name, epsilon, cores):
    environment = dict(os.environ, OMP_NUM_THREADS=str(cores), NUMBA_NUM_THREADS=str(cores),
                       POCL_MAX_PTHREAD_COUNT=str(cores), PYOPENCL_CTX="0",
                       POCL_MAX_COMPUTE_UNITS=str(cores))
    command = ["taskset", "-c", f"0-{cores - 1}", sys.executable, __file__, "--worker", case,
               "--name", name, "--folder", str(folder), "--epsilon", repr(epsilon)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    for line in done.stdout.splitlines():
        if line.startswith("RESULT "):
            return json.loads(line[len("RESULT "):])
    reason = (done.stderr.strip().splitlines() or ["no message"])[-1]
    return {"seconds": None, "result": {}, "failed": reason}


def run_ours(folder, cores):
    command = ["taskset", "-c", f"0-{cores - 1}", "cargo", "bench", "--quiet", "--bench", "peers",
               "--no-default-features", "--", str(folder)]
    environment = dict(os.environ, RAYON_NUM_THREADS=str(cores))
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True,
                          check=True)
    line = [line for line in done.stdout.splitlines() if line.startswith("{")][-1]
    return json.loads(line)


def machine():
    model = next((line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo")
                  if line.startswith("model name")), platform.machine())
    return f"{model}, {os.cpu_count()} cores, {platform.system()} {platform.machine()}"


def formatted_time(seconds):
    if seconds is None:
        return "failed"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def formatted_result(result):
    text = []
    for key, value in result.items():
        numbers = value if isinstance(value, list) else [value]
        words = ", ".join("none" if v is None else f"{v:.6g}" for v in numbers)
        text.append(f"{key.replace('_', ' ')} {words}")
    return "; ".join(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"write {GUIDE.relative_to(ROOT)}")
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    parser.add_argument("--name", help=argparse.SUPPRESS)
    parser.add_argument("--folder", help=argparse.SUPPRESS)
    parser.add_argument("--epsilon", type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        return worker(options.folder, options.worker, options.name, options.epsilon)

    import numpy as np

    folder = Path(tempfile.mkdtemp())
    x = lorenz(SERIES_POINTS)
    np.save(folder / "rqa.npy", x[: RQA_POINTS + (DIMENSION - 1) * LAG])
    np.save(folder / "ami.npy", x)
    np.save(folder / "fnn.npy", x)
    np.save(folder / "stft.npy", np.random.default_rng(1).standard_normal(STFT_SAMPLES))

    ours = {cores: run_ours(folder, cores) for cores in (1, 2)}
    epsilon = ours[1]["rqa"]["result"]["epsilon"]
    table = ["| task | tool | one core | two cores | result |", "|---|---|---|---|---|"]
    for case, peers in CASES.items():
        one, two = ours[1][case], ours[2][case]
        table.append(f"| {TITLES[case]} | **squeakscope** | **{formatted_time(one['seconds'])}** | "
                     f"**{formatted_time(two['seconds'])}** | {formatted_result(one['result'])} |")
        for name in peers:
            first, second = (run_peer(folder, case, name, epsilon, cores) for cores in (1, 2))
            result = first.get("failed") or formatted_result(first["result"])
            ratio = lambda theirs, own: (f" ({theirs['seconds'] / own['seconds']:.3g} x)"
                                         if theirs["seconds"] else "")
            table.append(f"| | {name} | {formatted_time(first['seconds'])}{ratio(first, one)} | "
                         f"{formatted_time(second['seconds'])}{ratio(second, two)} | {result} |")
            print(table[-1], flush=True)
    text = "\n".join(table)
    print(f"\n{machine()}\n\n{text}")
    if options.write:
        before, rest = GUIDE.read_text().split("<!-- table -->", 1)
        after = rest.split("<!-- end of table -->", 1)[1]
        GUIDE.write_text(f"{before}<!-- table -->\n\nMeasured on: {machine()}.\n\n{text}\n\n"
                         f"<!-- end of table -->{after}")


if __name__ == "__main__":
    main()
