"""Work-precision curves of all methods of all peers, and the cost at one error."""

import numpy as np

import peers

#: Error at which a curve ends, and maximum cost of a method relative to the cheapest of the same
#: peer.
MIN_ERROR, MAX_COST_RATIO = 2e-6, 4


class Reference:
    """Reference final states, on which methods of different families agree, including squeakscope's."""

    def __init__(self, programs):
        ends = lambda peer, method, setting: np.array(programs[peer].ask(method, setting)["ends"])
        self.ends = ends("Boost.odeint", "fehlberg78-fixed", 4e-8)
        self.others = {
            "odeint's fehlberg78": self.errors(ends("Boost.odeint", "fehlberg78", 1e-13)),
            "CVODE's adams-newton": self.errors(ends("CVODE", "adams-newton", 1e-12)),
            "squeakscope's tsit5": self.errors(ends(peers.OURS, "tsit5", 1e-12)),
        }
        self.others = {name: float(errors.max()) for name, errors in self.others.items()}
        assert max(self.others.values()) < 1e-8, self.others

    def errors(self, ends):
        """Relative error of each final state in the energy norm of [omega q | dq/dt]."""
        return (np.linalg.norm(ends - self.ends, axis=1) / np.linalg.norm(self.ends, axis=1))

    def error(self, ends):
        """Root mean square over the starts, which averages out accidentally small errors."""
        with np.errstate(over="ignore", invalid="ignore"):
            error = np.sqrt(np.mean(self.errors(np.array(ends, dtype=float)) ** 2))
        return float(error) if np.isfinite(error) else float("inf")


def point(program, method, setting, reference, repeats):
    """One work-precision point, per start; `None` if the method fails."""
    answers = [program.ask(method, setting) for _ in range(repeats)]
    if "failed" in answers[0]:
        return None
    count = len(reference.ends)
    return {
        "setting": setting,
        "error": reference.error(answers[0]["ends"]),
        "seconds": float(np.median([answer["seconds"] for answer in answers])) / count,
        "calls": answers[0]["calls"] / count,
        "derivatives": answers[0]["derivatives"] / count,
    }


def curve(program, peer, method, reference, repeats, limit):
    """Points of a method from loose to tight, up to `limit` seconds."""
    points = []
    for setting in peers.settings(peer, method):
        found = point(program, method, float(setting), reference, repeats)
        if found:
            points.append(found)
            if found["error"] < MIN_ERROR or found["seconds"] > limit:
                break
    return points


def bracket(points, error):
    """The points of the stable Pareto front that bracket the error: the last above and the first below.
    `None` if the method does not reach the error; the same point twice if it is always below."""
    front, best = [], float("inf")
    for p in sorted(points, key=lambda p: p["seconds"]):
        if p["error"] < min(best, 1):
            front.append(p)
            best = p["error"]
    below = next((i for i, p in enumerate(front) if p["error"] <= error), None)
    if below is None:
        return None
    return front[max(below - 1, 0)], front[below]


def cost(above, below, error):
    """Seconds at an error between two points, by log-log interpolation."""
    if above["error"] <= error or above is below:
        return below["seconds"]
    share = np.log(above["error"] / error) / np.log(above["error"] / below["error"])
    return float(above["seconds"] ** (1 - share) * below["seconds"] ** share)


def best_method(curves, error):
    """The method with the lowest cost at the error, with its bracket."""
    found = {}
    for method, points in curves.items():
        pair = bracket(points, error)
        if pair:
            found[method] = pair
    method = min(found, key=lambda method: cost(*found[method], error))
    return method, found[method]


def time_alternating(programs, best, error, rounds, count):
    """Times the best methods of all peers again, alternating, which exposes them to the same load.
    Returns for each the more accurate point of its bracket with the minimum time, and the cost at the
    error from the minimum and from the median times."""
    seconds = {peer: [[], []] for peer in best}
    for _ in range(rounds):
        for peer, (method, pair) in best.items():
            for place, p in enumerate(pair):
                answer = programs[peer].ask(method, p["setting"])
                seconds[peer][place].append(answer["seconds"] / count)
    result = {}
    for peer, (method, pair) in best.items():
        by = lambda middle: [dict(p, seconds=float(middle(s)))
                             for p, s in zip(pair, seconds[peer])]
        least, median = by(np.min), by(np.median)
        result[peer] = {"method": method, **least[1], "cost": cost(*least, error),
                        "median_cost": cost(*median, error)}
    return result


def compare(programs, exported, start, horizon, methods, error, repeats, rounds, report):
    """The complete comparison for one set of starts."""
    asked = programs.integrators(exported, start, horizon)
    reference = Reference(asked)
    curves, best = {}, {}
    for peer, names in methods.items():
        curves[peer], limit = {}, float("inf")
        for method in names:
            points = curve(asked[peer], peer, method, reference, repeats, limit)
            curves[peer][method] = points
            pair = bracket(points, error)
            if pair:
                limit = min(limit, MAX_COST_RATIO * cost(*pair, error))
            least = min((p["error"] for p in points), default=float("inf"))
            report(f"  {peer:18} {method:18} "
                 + (f"{1e3 * cost(*pair, error):8.3f} ms" if pair else "   abandoned")
                 + f"   smallest error {least:.1e}")
        best[peer] = best_method(curves[peer], error)
        least = min(p["error"] for points in curves[peer].values() for p in points)
        assert least < 1e-5, f"{peer} does not reach the same solution: {least:.1e}"
    result = time_alternating(asked, best, error, rounds, len(reference.ends))
    for program in set(asked.values()):
        program.close()
    return {"nodes": exported.nodes, "start": start, "starts": len(reference.ends),
            "reference": reference.others, "curves": curves, "best": result}
