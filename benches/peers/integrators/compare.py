"""Compares the integrators and the right-hand side with public libraries on the same joint, starts and
machine.

    apt install g++ make libsundials-dev libboost-dev
    python3 -m venv peers && peers/bin/pip install -r benches/peers/integrators/requirements.txt
    peers/bin/python benches/peers/integrators/compare.py

Exports the scene, builds the peers and `cargo bench --bench integrators`, and prints the times: the
right-hand side against a plain loop in C++, and the integration of 4 ms against CVODE, Boost.odeint and
SciPy, which all call that loop. `--json FILE` writes every measured point; `--write` inserts the tables
into src/guide/explanation/peers.md.

Times are the CPU time of one thread pinned to one core; compared programs alternate. Errors are those of
the final state, relative, in the energy norm, against a reference on which methods of squeakscope and of
the peers agree; root mean square over the starts.
"""

import argparse
import json
import os
import platform
import subprocess
import tempfile
from pathlib import Path

import loop
import peers
import scene
import sweep

ROOT = Path(__file__).resolve().parents[3]
GUIDE = ROOT / "src/guide/explanation/peers.md"
BEGIN, END = "<!-- integrators -->", "<!-- end of integrators -->"

ERROR = 1e-4
#: Target speed-up over each peer.
TARGETS = {"CVODE": 6, "Boost.odeint": 2.8, "SciPy solve_ivp": 10, "SciPy odeint, ode": 4.8}
LOOP_TARGET, LOOP_NODES = 2, 64
STARTS = {"squeak": "the developed squeak", "cold": "the start state of the scene, a small kick"}


def cargo(*words):
    done = subprocess.run(["cargo", *words, "--message-format=json"], cwd=ROOT, check=True,
                          stdout=subprocess.PIPE, text=True)
    built = [json.loads(line).get("executable") for line in done.stdout.splitlines()
             if line.startswith("{")]
    return [path for path in built if path][-1]


def first_line(*command):
    return subprocess.run(command, capture_output=True, text=True).stdout.splitlines()[0].strip()


def versions():
    """Versions of the peers and of the compilers."""
    import scipy

    package = lambda name: first_line("dpkg-query", "-W", "-f", "${Version}", name)
    return {
        "g++": first_line("g++", "-dumpfullversion"),
        "rustc": first_line("rustc", "--version").split()[1],
        "SUNDIALS": package("libsundials-dev"),
        "Boost": package("libboost-dev"),
        "glibc": package("libc6"),
        "SciPy": scipy.__version__,
        "Python": platform.python_version(),
    }


def machine(core):
    model = next((line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo")
                  if line.startswith("model name")), platform.machine())
    return (f"{model}, {os.cpu_count()} cores, {core['hertz'] / 1e9:.2f} GHz, vectors of "
            f"{core['width']} doubles, {platform.system()} {platform.machine()}")


def times(ratio, target, digits=".2g"):
    return f"{ratio:{digits}} x (target {target} x{'' if ratio >= target else ': missed'})"


def loop_table(rows):
    table = ["| nodes | squeakscope, us | ns per node | plain loop, one pass, us | ratio "
             "| plain loop, faster form, us | ratio | share of the core's peak |",
             "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        us = lambda name: f"{1e6 * row[name]['minimum']:.3g} ({1e6 * row[name]['median']:.3g})"
        def ratio(name):
            found = row[name]["minimum"] / row["ours"]["minimum"]
            if row["nodes"] != LOOP_NODES:
                return f"{found:.2f} x"
            return times(found, LOOP_TARGET, ".3g")
        table.append(f"| {row['nodes']:,} | {us('ours')} "
                     f"| {1e9 * row['ours']['minimum'] / row['nodes']:.2f} "
                     f"| {us('one pass')} | {ratio('one pass')} "
                     f"| {us('passes')} | {ratio('passes')} | {100 * row['share_of_peak']:.0f} % |")
    return "\n".join(table)


def setting_of(peer, best):
    is_step = peers.settings(peer, best["method"]) is peers.STEPS
    return f"step {1e6 * best['setting']:.2g} us" if is_step else f"{best['setting']:.1e}"


def run_table(result):
    ours = result["best"][peers.OURS]["cost"]
    table = [f"| program | best method | tolerance | error | ms | evaluations | ms at {ERROR:.0e} "
             "| relative to squeakscope |",
             "|---|---|---|---|---|---|---|---|"]
    for peer, best in result["best"].items():
        is_ours = peer == peers.OURS
        if is_ours:
            ratio = f"{scene.HORIZON / best['cost']:.2g} x real time"
        else:
            ratio = times(best["cost"] / ours, TARGETS[peer])
        bold = "**" if is_ours else ""
        table.append(f"| {bold}{peer}{bold} | {best['method']} | {setting_of(peer, best)} "
                     f"| {best['error']:.1e} | {1e3 * best['seconds']:.3g} "
                     f"| {best['calls']:,.0f} | {1e3 * best['cost']:.3g} "
                     f"({1e3 * best['median_cost']:.3g}) | {ratio} |")
    return "\n".join(table)


def text_of(found):
    core = found["loop"][0]["core"]
    row = next((row for row in found["loop"] if row["nodes"] == LOOP_NODES), found["loop"][0])
    parts = [f"Measured on: {machine(core)}. "
             + ", ".join(f"{name} {version}" for name, version in found["versions"].items()) + "."]
    parts.append(
        "**The right-hand side**, us per call: minimum (and median) of many alternating "
        f"bursts.\n\n{loop_table(found['loop'])}\n\n"
        f"{row['operations_per_node']} floating-point operations per node (a fused multiply-add counts as "
        f"two) correspond to {row['flops'] / 1e9:.0f} Gflop/s at {row['nodes']} nodes, "
        f"{100 * row['share_of_peak']:.0f} % of the core's peak of "
        f"{core['peak_flops'] / 1e9:.0f} (two multiply-adds of {core['width']} lanes per cycle; "
        f"multiply-adds alone reach {core['measured_flops'] / 1e9:.0f}).")
    for result in found["runs"]:
        parts.append(f"**4 ms of `{found['scene']}`** with {result['nodes']} nodes, from "
                     f"{STARTS[result['start']]} (starts: {result['starts']}), at an error of "
                     f"{ERROR:.0e}; minimum (and median) of many alternating runs.\n\n{run_table(result)}")
    return "\n\n".join(parts)


def write(text):
    before, rest = GUIDE.read_text().split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    GUIDE.write_text(f"{before}{BEGIN}\n\n{text}\n\n{END}{after}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0],
                                     formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    parser.add_argument("--scene", default="doubled-torus-3deg", help="scene to run")
    parser.add_argument("--nodes", type=int, nargs="+", default=[16, 100],
                        help="numbers of contact nodes of the runs")
    parser.add_argument("--loop-nodes", type=int, nargs="*",
                        default=[16, 32, 64, 100, 200, 500, 1000, 2000, 5000, 10_000],
                        help="numbers of contact nodes for the right-hand side")
    parser.add_argument("--starts", nargs="*", choices=STARTS, default=list(STARTS))
    parser.add_argument("--repeats", type=int, default=3, help="repetitions per point; the median counts")
    parser.add_argument("--rounds", type=int, default=25,
                        help="alternating runs of the best methods; the minimum counts")
    parser.add_argument("--loop-rounds", type=int, default=100,
                        help="alternating bursts of the right-hand side per launch")
    parser.add_argument("--core", type=int, default=os.cpu_count() - 1, help="core to run on")
    parser.add_argument("--squeakscope", type=Path, help="existing squeakscope binary; skips the build")
    parser.add_argument("--bench", type=Path, help="existing bench binary; skips the build")
    parser.add_argument("--folder", type=Path, help="folder for models and programs")
    parser.add_argument("--json", type=Path, help="file for all measurements")
    parser.add_argument("--write", action="store_true", help=f"write {GUIDE.relative_to(ROOT)}")
    options = parser.parse_args()

    folder = (options.folder or Path(tempfile.mkdtemp())).resolve()
    squeakscope = options.squeakscope or cargo("build", "--release", "--bin", "squeakscope")
    bench = options.bench or cargo("bench", "--no-run", "--bench", "integrators",
                                   "--no-default-features")
    programs = peers.Programs(folder / "build", bench, options.core)
    export = lambda nodes: scene.Exported(folder / f"{nodes}-nodes", squeakscope, options.scene,
                                          nodes)
    methods = {peers.OURS: peers.our_methods(squeakscope), **peers.METHODS}

    found = {"scene": options.scene, "versions": versions(), "loop": [], "runs": []}
    for nodes in options.loop_nodes:
        found["loop"].append(loop.compare(programs, export(nodes), options.loop_rounds))
    print(loop_table(found["loop"]), flush=True)
    for nodes in options.nodes:
        exported = export(nodes)
        for start in options.starts:
            print(f"\n{nodes} nodes, {start}: ms at an error of {ERROR:.0e}", flush=True)
            found["runs"].append(sweep.compare(
                programs, exported, start, scene.HORIZON, methods, ERROR, options.repeats,
                options.rounds, lambda line: print(line, flush=True)))
            print(run_table(found["runs"][-1]), flush=True)
    text = text_of(found)
    print(f"\n{text}")
    if options.json:
        options.json.write_text(json.dumps(found, indent=1))
    if options.write:
        write(text)


if __name__ == "__main__":
    main()
