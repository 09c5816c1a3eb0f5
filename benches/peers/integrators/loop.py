"""Compares the right-hand side of squeakscope and the plain loop in C++, alternating on one core."""

import numpy as np

#: Approximate duration of one burst of calls, s.
BURST = 3e-4
#: Number of program starts, because the memory placement of a run affects its time.
LAUNCHES = 5
#: Initial estimate of the cost of a call, s per node.
GUESS = 4e-9


def operations(modes):
    """Floating-point operations of the right-hand side per node, counted in `crates/joint/src/contact_force.rs`,
    `friction.rs` and `dual.rs`. A fused multiply-add counts as two operations; any other addition,
    multiplication, division, square root or maximum as one; negations, comparisons and integer
    operations as none."""
    rows = 2 * modes * (1 + 3 + 3)  # radial displacement; three velocities; three forces
    gap = 2 + 1 + 1  # pre-stress + stiffness u_r; lift-off; area
    speed = 1 + 2 + 2 + 1 + 1  # squares; floor; root
    # Bound, n, its rounding, the remainder, its square; even and odd.
    exponential = 1 + 2 + 1 + 2 + 1 + 4 + 5
    # Both exponentials and their denominators; 1 - exp; the sliding factor; the ratio.
    ratio = 2 * (exponential + 1) + 5 + 5 + 4
    force = 1 + 2 + 2  # drag; its components; the radial force
    return rows + gap + speed + ratio + force


def alternated(programs, exported, rounds):
    """Seconds per call of squeakscope and of both forms of the plain loop, `rounds` each."""
    ours, plain = programs.ours(exported, "squeak"), programs.plain(exported, "squeak")
    clients = {"ours": (ours, "force"), "one pass": (plain, "one-pass"),
              "passes": (plain, "passes")}
    calls = {name: max(1, round(BURST / (GUESS * exported.nodes))) for name in clients}
    seconds = {name: [] for name in clients}
    forces = {}
    for round_number in range(rounds + 1):
        for name, (program, what) in clients.items():
            answer = program.ask(what, calls[name])
            forces[name] = np.array(answer["force"])
            if round_number:  # the first one is the warm-up
                seconds[name].append(answer["seconds"])
    size = np.linalg.norm(forces["ours"])
    for name, force in forces.items():
        difference = np.linalg.norm(force - forces["ours"]) / size
        assert difference < 1e-9, f"{name} computes another force: {difference:.1e}"
    core = core_of(plain)
    for program in (ours, plain):
        program.close()
    return seconds, core


def core_of(plain):
    """Frequency and measured peak of the core: maximum of several, because of other load."""
    answers = [plain.ask("core", 0) for _ in range(15)]
    return {"hertz": max(answer["hertz"] for answer in answers),
            "measured_flops": max(answer["flops"] for answer in answers),
            "width": answers[0]["width"]}


def compare(programs, exported, rounds):
    """Median and minimum of each, s, and squeakscope's share of the core's peak."""
    seconds, core = alternated(programs, exported, rounds)
    for _ in range(1, LAUNCHES):
        more, again = alternated(programs, exported, rounds)
        seconds = {name: seconds[name] + more[name] for name in seconds}
        core = {name: max(core[name], again[name]) for name in core}
    found = {name: {"median": float(np.median(s)), "minimum": min(s)}
             for name, s in seconds.items()}
    # Two fused multiply-adds per cycle, two operations each.
    core["peak_flops"] = 2 * 2 * core["width"] * core["hertz"]
    modes = len(exported.model["omega"])
    done = operations(modes) * exported.nodes / found["ours"]["minimum"]
    return {
        "nodes": exported.nodes, **found, "core": core, "operations_per_node": operations(modes),
        "flops": done, "share_of_peak": done / core["peak_flops"],
        "share_of_measured_peak": done / core["measured_flops"],
    }
