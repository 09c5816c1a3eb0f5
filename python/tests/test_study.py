import numpy as np
import pytest

import squeakscope as s

QUICK = {"min_transient": 0.02, "max_transient": 0.03, "measure": 0.01, "exponents": 0}


def test_stability_at_tilts() -> None:
    stable, unstable = s.stability("doubled-torus-3deg", [0.0, 3.0])
    assert unstable.tilt_rad == pytest.approx(np.radians(3))
    assert any(mode.unstable for mode in unstable.modes)
    assert len(stable.modes) == len(unstable.modes)
    assert s.stability("doubled-torus-3deg")[0] == unstable


def test_sensitivities_agree_with_a_difference() -> None:
    scene = s.Scene.load("doubled-torus-3deg")
    mode = next(mode for mode in s.sensitivities(scene) if mode.unstable)
    load = next(p for p in mode.parameters if p.parameter == "load.load_n")

    def growth(load_n: float) -> float:
        modes = s.stability(scene.replace(**{"load.load_n": load_n}))[0].modes
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
