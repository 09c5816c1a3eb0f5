"""Work and precision: each method of each peer over its tolerances, and the cost at one error."""

import numpy as np

import peers

#: An error below which a method need not be followed, and how many times dearer than another one
#: of the same peer it may become.
ENOUGH, TOO_DEAR = 2e-6, 4


class Reference:
    """The ends to compare with; methods of other families agree on them, ours included."""

    def __init__(self, programs):
        ends = lambda peer, method, knob: np.array(programs[peer].ask(method, knob)["ends"])
        self.ends = ends("Boost.odeint", "fehlberg78-fixed", 4e-8)
        self.others = {
            "odeint's fehlberg78": self.errors(ends("Boost.odeint", "fehlberg78", 1e-13)),
            "CVODE's adams-newton": self.errors(ends("CVODE", "adams-newton", 1e-12)),
            "our tsit54": self.errors(ends(peers.OURS, "tsit54", 1e-12)),
        }
        self.others = {name: float(errors.max()) for name, errors in self.others.items()}
        assert max(self.others.values()) < 1e-8, self.others

    def errors(self, ends):
        """Relative error of each end in [omega q | dq/dt], whose square is energy."""
        return (np.linalg.norm(ends - self.ends, axis=1) / np.linalg.norm(self.ends, axis=1))

    def error(self, ends):
        """Root of the mean square over the starts: what one start hits by luck averages out."""
        with np.errstate(over="ignore", invalid="ignore"):
            error = np.sqrt(np.mean(self.errors(np.array(ends, dtype=float)) ** 2))
        return float(error) if np.isfinite(error) else float("inf")


def point(program, method, knob, reference, repeats):
    """One work-precision point, a start; `None` where the method fails."""
    answers = [program.ask(method, knob) for _ in range(repeats)]
    if "failed" in answers[0]:
        return None
    count = len(reference.ends)
    return {
        "knob": knob,
        "error": reference.error(answers[0]["ends"]),
        "seconds": float(np.median([answer["seconds"] for answer in answers])) / count,
        "calls": answers[0]["calls"] / count,
        "derivatives": answers[0]["derivatives"] / count,
    }


def curve(program, peer, method, reference, repeats, limit):
    """Its points from loose to tight, up to `limit` seconds."""
    points = []
    for knob in peers.knobs(peer, method):
        found = point(program, method, float(knob), reference, repeats)
        if found:
            points.append(found)
            if found["error"] < ENOUGH or found["seconds"] > limit:
                break
    return points


def bracket(points, error):
    """Of the points worth having (none cheaper is better, and the method is stable there) the last
    above the error and the first below; `None` if the method does not get there, the same one
    twice if it is always below."""
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
    """Seconds at an error between two points, by a straight line in logarithms."""
    if above["error"] <= error or above is below:
        return below["seconds"]
    share = np.log(above["error"] / error) / np.log(above["error"] / below["error"])
    return float(above["seconds"] ** (1 - share) * below["seconds"] ** share)


def best_method(curves, error):
    """The method that costs least at the error, with its bracket."""
    found = {}
    for method, points in curves.items():
        pair = bracket(points, error)
        if pair:
            found[method] = pair
    method = min(found, key=lambda method: cost(*found[method], error))
    return method, found[method]


def duel(programs, best, error, rounds, count):
    """Each peer's best method once more, all in turn, so that what disturbs the machine disturbs
    all of them. Returns for each the better point of its bracket with the least time, and the
    cost at the error by the least and by the median times."""
    seconds = {peer: [[], []] for peer in best}
    for _ in range(rounds):
        for peer, (method, pair) in best.items():
            for place, p in enumerate(pair):
                answer = programs[peer].ask(method, p["knob"])
                seconds[peer][place].append(answer["seconds"] / count)
    result = {}
    for peer, (method, pair) in best.items():
        by = lambda middle: [dict(p, seconds=float(middle(s)))
                             for p, s in zip(pair, seconds[peer])]
        least, median = by(np.min), by(np.median)
        result[peer] = {"method": method, **least[1], "cost": cost(*least, error),
                        "median_cost": cost(*median, error)}
    return result


def compare(programs, exported, start, horizon, methods, error, repeats, rounds, tell):
    """All of it for one set of starts."""
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
                limit = min(limit, TOO_DEAR * cost(*pair, error))
            least = min((p["error"] for p in points), default=float("inf"))
            tell(f"  {peer:18} {method:18} "
                 + (f"{1e3 * cost(*pair, error):8.3f} ms" if pair else "   given up")
                 + f"   least error {least:.1e}")
        best[peer] = best_method(curves[peer], error)
        least = min(p["error"] for points in curves[peer].values() for p in points)
        assert least < 1e-5, f"{peer} does not reach the same solution: {least:.1e}"
    result = duel(asked, best, error, rounds, len(reference.ends))
    for program in set(asked.values()):
        program.close()
    return {"nodes": exported.nodes, "start": start, "starts": len(reference.ends),
            "reference": reference.others, "curves": curves, "best": result}
