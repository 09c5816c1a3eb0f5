"""Compares the Python package of squeakscope with other packages: the same calls from Python, on arrays.

The times are processor times of the whole call, with the conversion of its arguments and results, on one core; the
smallest of several calls after a warm-up that includes just-in-time compilation.

    apt install pocl-opencl-icd                 # OpenCL on the CPU, for PyRQA
    python3 -m venv peers && peers/bin/pip install . -r benches/peers/requirements.txt
    peers/bin/python benches/peers/from_python.py

Prints a table. `--write` also inserts it into src/guide/explanation/peers.md.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS"), "1"))

import compare
from compare import BINS, DIMENSION, GUIDE, LAG, MAX_DIMENSION, MAX_LAG, MIN_LINE, RQA_POINTS, SERIES_POINTS, THEILER

EPSILON = 6.33097  # a recurrence rate of 5 %
LONG = [25_000, 50_000, 100_000]


def timed(function, repeats):
    """Result and smallest processor time of `function`, after one warm-up call."""
    function()
    best = float("inf")
    for _ in range(max(repeats, 3)):
        began = time.process_time()
        result = function()
        best = min(best, time.process_time() - began)
    return result, best


compare.timed = timed


def rqa_ours(x, epsilon):
    import squeakscope

    def go():
        found = squeakscope.rqa(x, lag=LAG, dimension=DIMENSION, threshold=epsilon, theiler=1,
                                min_diagonal=MIN_LINE, min_vertical=MIN_LINE)
        return {"recurrence_rate": found.recurrence_rate, "determinism": found.determinism,
                "mean_diagonal": found.mean_diagonal}

    return timed(go, 7)


def ami_ours(x):
    import squeakscope

    def go():
        found = squeakscope.mutual_information(x, max_lag=MAX_LAG, bins=BINS)
        return {"first_minimum": compare.first_minimum(found.bits), "bits_at_lag_10": float(found.bits[10])}

    return timed(go, 7)


def fnn_ours(x):
    import squeakscope

    def go():
        found = squeakscope.false_neighbours(x, LAG, max_dimension=MAX_DIMENSION, theiler=THEILER)
        return {"share": [float(v) for v in found.share[:4]]}

    return timed(go, 5)


OURS = {"rqa": rqa_ours, "ami": ami_ours, "fnn": fnn_ours}


def rqa_long(states):
    """Processor time of the quantification of a long series, and the memory that it adds."""
    import squeakscope

    x = compare.lorenz(states + (DIMENSION - 1) * LAG)
    squeakscope.rqa(x[:2000], lag=LAG, dimension=DIMENSION, threshold=EPSILON)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    began = time.process_time()
    squeakscope.rqa(x, lag=LAG, dimension=DIMENSION, threshold=EPSILON)
    seconds = time.process_time() - began
    return {"seconds": seconds, "mebibytes": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024}


def worker(folder, case, name):
    """Times one program on one case, in a process of its own."""
    import numpy as np

    if case == "long":
        return print("RESULT " + json.dumps(rqa_long(int(name))))
    x = np.load(Path(folder) / f"{case}.npy")
    function = OURS[case] if name == "squeakscope" else compare.CASES[case][name]
    result, seconds = function(x, EPSILON) if case == "rqa" else function(x)
    print("RESULT " + json.dumps({"seconds": seconds, "result": result}))


def measured(folder, case, name):
    environment = dict(os.environ, POCL_MAX_PTHREAD_COUNT="1", PYOPENCL_CTX="0", POCL_MAX_COMPUTE_UNITS="1")
    command = ["taskset", "-c", "0", sys.executable, __file__, "--worker", case, "--name", str(name), "--folder", str(folder)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    for line in done.stdout.splitlines():
        if line.startswith("RESULT "):
            return json.loads(line[len("RESULT "):])
    return {"seconds": None, "failed": (done.stderr.strip().splitlines() or ["no message"])[-1]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"write {GUIDE.relative_to(compare.ROOT)}")
    for hidden in ("--worker", "--name", "--folder"):
        parser.add_argument(hidden, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        return worker(options.folder, options.worker, options.name)

    import numpy as np

    folder = Path(tempfile.mkdtemp())
    x = compare.lorenz(SERIES_POINTS)
    np.save(folder / "rqa.npy", x[: RQA_POINTS + (DIMENSION - 1) * LAG])
    for case in ("ami", "fnn"):
        np.save(folder / f"{case}.npy", x)
    table = ["| call from Python | package | processor time | result |", "|---|---|---|---|"]
    for case in OURS:
        ours = measured(folder, case, "squeakscope")
        rows = [(f"| {compare.TITLES[case]} | **squeakscope** |", ours)]
        # The other spectrograms and the programs without a Python package have no row here.
        rows += [(f"| | {name} |", measured(folder, case, name)) for name in compare.CASES[case]]
        for head, row in rows:
            ratio = f" ({row['seconds'] / ours['seconds']:.3g} x)" if row["seconds"] and row is not ours else ""
            result = row.get("failed") or compare.formatted_result(row["result"])
            table.append(f"{head} {compare.formatted_time(row['seconds'])}{ratio} | {result} |")
            print(table[-1], flush=True)
    table += ["", "| `squeakscope.rqa` of | processor time | memory in addition |", "|---|---|---|"]
    for states in LONG:
        long = measured(folder, "long", states)
        table.append(f"| {states:,} states | {compare.formatted_time(long['seconds'])} | {long['mebibytes']:.1f} MiB |")
        print(table[-1], flush=True)
    text = "\n".join(table)
    if options.write:
        before, rest = GUIDE.read_text().split("<!-- python -->", 1)
        after = rest.split("<!-- end of python -->", 1)[1]
        GUIDE.write_text(f"{before}<!-- python -->\n\nMeasured on: {compare.machine()}.\n\n{text}\n\n<!-- end of python -->{after}")


if __name__ == "__main__":
    main()
