import math
import os
import pickle
import signal
import threading

import numpy as np
import pytest

import squeakscope as s

QUICK = {"min_transient": 0.02, "max_transient": 0.03, "measure": 0.01, "exponents": 0}


def test_stability_at_tilts() -> None:
    stable, unstable = s.stability("doubled-torus-3deg", [0.0, 3.0]).tilts
    assert unstable.tilt_rad == pytest.approx(np.radians(3))
    assert any(mode.unstable for mode in unstable.modes)
    assert len(stable.modes) == len(unstable.modes)
    assert s.stability("doubled-torus-3deg").tilts[0] == unstable
    assert [round(np.degrees(at.tilt_rad), 9) for at in s.stability("tilt-ramp").tilts] == [0.0, 3.0, 5.5, 6.0]


def test_sensitivities_agree_with_a_difference() -> None:
    scene = s.Scene.load("doubled-torus-3deg")
    mode = next(mode for mode in s.sensitivities(scene) if mode.unstable)
    load = next(p for p in mode.parameters if p.parameter == "load.load_n")

    def growth(load_n: float) -> float:
        modes = s.stability(scene.replace(**{"load.load_n": load_n})).tilts[0].modes
        return min(modes, key=lambda m: abs(m.frequency_hz - mode.frequency_hz)).growth_per_s

    difference = (growth(151.0) - growth(149.0)) / 2
    assert load.growth_per_unit == pytest.approx(difference, rel=1e-2)


def test_a_sweep_does_not_depend_on_threads_and_shards() -> None:
    values = {"load.tilt_deg": [1.5, 2.0]}
    whole = s.sweep("periodic-2deg", values, starts=["upward", "downward"], **QUICK)
    assert [point["load.tilt_deg"] for point in whole.points] == [1.5, 2.0, 1.5, 2.0]
    assert [point.values[0] for point in whole.points] == [1.5, 2.0, 1.5, 2.0]
    parts = [
        s.sweep("periodic-2deg", values, starts=["upward", "downward"], shard=(k, 2), threads=1, **QUICK)
        for k in (1, 2)
    ]
    merged = sorted((row for part in parts for row in part.points), key=lambda row: row.index)
    assert [row.to_dict() for row in merged] == whole.points.to_dicts()
    assert len(whole.points.to_arrow()) == 4


def test_basins_count_all_kicks() -> None:
    scene = s.Scene.load("doubled-torus-3deg").replace(nodes=28)
    found = s.basins(scene, 2, **QUICK)
    assert found.kicks == found.simulated == 2
    assert found.undecided + sum(len(a.seeds) for a in found.attractors) == 2


def test_a_branch_of_equilibria_finds_the_hopf_point() -> None:
    found = s.branch("torus-birth", interval=(0.0, 1.0), points=5, orbits=False)
    assert len(found.equilibria) >= 5 and found.parameter == "load.tilt_deg"
    unstable = [point.unstable_modes for point in found.equilibria]
    assert (len(found.bifurcations) > 0) == (unstable[0] != unstable[-1])
    # A notebook shows the figure, and the table that a copy has, too.
    shown, table = found._repr_html_(), pickle.loads(pickle.dumps(found))._repr_html_()
    assert shown.startswith("<svg") and shown.endswith(table) and table.startswith("<table")
    with pytest.raises(s.InputError):
        s.branch("torus-birth", interval=(0.0, 95.0), orbits=False)


def test_exponents_of_a_small_scene() -> None:
    found = s.lyapunov("impact-oscillator", average_time=2.0)
    assert len(found.exponents_per_s) == found.dimension
    assert found.attractor == "chaos" and found.kaplan_yorke.value > 1
    assert np.all(found.exponents_per_s.half_width >= 0)


def test_cost_of_a_small_scene() -> None:
    found = s.cost("mass-on-belt")
    assert {row.setting for row in found.settings} == {"tolerance"}
    assert all(choice.error <= choice.target for choice in found.choices)


def duffing(drive: float, damping: float = 0.3, start: tuple[float, float] = (1.0, 0.0)) -> s.System:
    """A mass between two wells, driven."""
    def rhs(t, z):
        return [z[1], -damping * z[1] + z[0] - z[0] ** 3 + drive * math.cos(1.2 * t)]

    return s.System(rhs, start, 2 * math.pi / 1.2)


def test_an_own_system_doubles_its_period_where_a_multiplier_is_minus_one() -> None:
    found = s.branch(duffing, "drive", (0.2, 0.3))
    doubling = found.bifurcations[0]
    assert doubling.kind == "period-doubling" and not found.unit
    drive = doubling["drive"]

    def with_tangents(t, z):
        x, v, a, b, c, d = z
        slope = 1 - 3 * x**2
        return [v, -0.3 * v + x - x**3 + drive * math.cos(1.2 * t), b, slope * a - 0.3 * b, d, slope * c - 0.3 * d]

    start = [*doubling.orbit.state, 1.0, 0.0, 0.0, 1.0]
    end = s.integrate(with_tangents, start, [0.0, doubling.orbit.period], tolerance=1e-11).z[-1]
    assert end[:2] == pytest.approx(start[:2], abs=1e-8)
    assert np.linalg.eigvals(end[2:].reshape(2, 2)).min() == pytest.approx(-1.0, abs=1e-6)
    # The branch of twice the period starts there.
    doubled = [point for point in found.points if point.branch == 1]
    assert doubled[0].drive_periods == 2 and doubled[0]["drive"] == pytest.approx(drive, abs=1e-3)


@pytest.mark.parametrize("points", [11, 12])
def test_an_own_system_has_its_hopf_point_and_its_cycle(points) -> None:
    def normal_form(mu):
        return s.System(lambda t, z: [mu * z[0] - z[1] - z[0] * (z[0] ** 2 + z[1] ** 2),
                                      z[0] + mu * z[1] - z[1] * (z[0] ** 2 + z[1] ** 2)], [0.1, 0.0], 2 * math.pi)

    # With 11 points one of them is the Hopf point.
    found = s.branch(normal_form, "mu", (-0.5, 0.5), points=points)
    hopf = found.bifurcations[0]
    assert hopf.kind == "hopf" and hopf["mu"] == pytest.approx(0.0, abs=1e-8)
    assert hopf.cycle.criticality == "supercritical" and hopf.frequency == pytest.approx(0.5 / math.pi)
    assert [point.unstable_modes > 0 for point in found.equilibria] == [point["mu"] > 0 for point in found.equilibria]
    assert all(math.hypot(*point.state) == pytest.approx(math.sqrt(point["mu"]), abs=1e-9) for point in found.points)


def test_a_sweep_of_an_own_system_is_that_of_separate_runs() -> None:
    options = {"min_transient": 40, "max_transient": 80, "measure": 60, "exponents": 2}
    values = {"damping": [0.3, 0.5], "drive": [0.2, 0.25]}
    found = s.sweep(duffing, values, starts=["fresh"], **options)
    assert [(row["damping"], row["drive"]) for row in found.points] == [(0.3, 0.2), (0.5, 0.2), (0.3, 0.25), (0.5, 0.25)]
    for row in found.points:
        one = s.sweep(duffing, {"damping": [row["damping"]], "drive": [row["drive"]]}, starts=["fresh"], **options)
        assert {**one.points[0].to_dict(), "index": row.index} == row.to_dict()
        period = 2 * math.pi / 1.2

        def rhs(t, z, row=row):
            return [z[1], -row["damping"] * z[1] + z[0] - z[0] ** 3 + row["drive"] * math.cos(1.2 * t)]

        x = s.integrate(rhs, [1.0, 0.0], np.linspace(0, 101 * period, 101 * 48 + 1)).z[-48:, 0]
        assert (row.amplitude, row.mean) == pytest.approx((np.ptp(x) / 2, x.mean()), abs=1e-6)
        assert row.regime == "periodic" and row.frequency == pytest.approx(1 / period, rel=1e-4)
        # Their sum is the divergence of the flow.
        assert row.exponents.exponents.sum() == pytest.approx(-row["damping"], rel=1e-3)


def test_a_continued_response_keeps_the_phase_of_the_drive() -> None:
    options = {"min_transient": 40, "max_transient": 80, "measure": 30.3, "exponents": 0}
    rows = s.sweep(duffing, {"drive": [0.2, 0.2000001]}, starts=["upward"], **options).points
    assert rows[1].mean == pytest.approx(rows[0].mean, abs=1e-4) and rows[1].transient <= rows[0].transient


def test_basins_of_an_own_system_are_those_of_its_integration() -> None:
    def start(seed):
        return np.random.default_rng(seed).uniform(-2, 2, 2)

    found = s.basins(lambda seed: duffing(0.0, start=start(seed)), 8, min_transient=20, max_transient=80, measure=20, exponents=0)
    assert found.undecided == 0 and {round(attractor.mean, 6) for attractor in found.attractors} == {-1.0, 1.0}
    for attractor in found.attractors:
        for seed in attractor.seeds:
            end = s.integrate(lambda t, z: [z[1], -0.3 * z[1] + z[0] - z[0] ** 3], start(seed), [0.0, 100.0]).z[-1, 0]
            assert end == pytest.approx(attractor.mean, abs=1e-3)


def test_errors_of_own_systems_come_back() -> None:
    def failing(drive):
        return s.System(lambda t, z: [1 / 0], [1.0], 1.0)

    quick = {"starts": ["fresh"], "max_transient": 2, "min_transient": 1, "measure": 20}
    with pytest.raises(ZeroDivisionError):
        s.sweep(failing, {"drive": [1.0]}, **quick)
    with pytest.raises(ZeroDivisionError):
        s.branch(failing, "drive", (0.0, 1.0))
    with pytest.raises(TypeError, match="unexpected keyword argument 'drave'"):
        s.branch(duffing, "drave", (0.0, 1.0))
    with pytest.raises(s.InputError, match="must return a squeakscope.System, not float"):
        s.sweep(lambda drive: drive, {"drive": [1.0]}, **quick)
    with pytest.raises(s.InputError, match="keyword arguments: `metod`"):
        s.System(lambda t, z: z, [1.0], 1.0, metod="rk4")
    with pytest.raises(s.InputError, match="period"):
        s.System(lambda t, z: z, [1.0], 0.0)


def test_ctrl_c_ends_a_study_of_an_own_system() -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        s.sweep(duffing, {"drive": [0.2]}, starts=["fresh"], min_transient=1e6, max_transient=1e6)
    timer.join()
    signal.signal(signal.SIGINT, before)
