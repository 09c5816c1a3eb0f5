import os
import signal
import threading
import time

import numpy as np
import pytest

import squeakscope as s


def test_a_run_has_samples_and_results(run: s.Run) -> None:
    n = 2000
    assert len(run.samples) == n
    assert run.t.shape == run.u.shape == run.v.shape == run.tilt_deg.shape == (n,)
    assert run.q.shape == run.qdot.shape and run.q.shape[0] == n
    assert np.allclose(np.diff(run.t), 1 / run.scene.sample_rate)
    assert np.all(run.tilt_deg == 2.0)
    # The velocity is the derivative of the displacement.
    slope = np.gradient(run.u, run.t)
    assert np.max(np.abs(slope - run.v)[1:-1]) < 0.05 * np.max(np.abs(run.v))
    assert run.summary.simulated_s == pytest.approx(0.01)
    assert run.simulated_s == run.summary.simulated_s
    assert "periodic-2deg" in repr(run)
    # The figures of the command, then the table.
    assert run._repr_html_().startswith("<svg") and run._repr_html_().endswith("</table>")
    assert {"t", "u", "q", "lines", "contact", "verdict", "scene"} <= set(dir(run))


def test_snapshots_of_the_contact_agree(run: s.Run) -> None:
    contact = run.contact
    k, m = contact.state.shape
    assert contact.t.shape == (k,) and m == 100
    assert contact.normal_force.shape == (k, m) and contact.friction.shape == (k, m, 3)
    assert contact.position.shape == (m, 3)
    # A separated node carries no force.
    assert np.all(contact.normal_force[contact.state == 2] == 0)
    assert np.all(contact.normal_force[contact.state != 2] > 0)


def test_a_run_has_the_facts_of_its_lesson() -> None:
    summary = s.run("negative-slope", duration=0.1, samples=False).summary
    facts = {fact.name: fact for fact in summary.facts}
    assert facts["vibration"].measured == "growth" and facts["vibration"].agrees is True
    rate = facts["growth rate, while small"]
    assert rate.measured == pytest.approx(rate.predicted, rel=0.01) and rate.unit == "1/s"


def test_lines_of_a_longer_run() -> None:
    lines = s.run("doubled-torus-3deg", duration=0.05, samples=False).lines
    assert 1000 < lines[0].frequency_hz < 20_000
    assert isinstance(lines, s.Results) and lines[0].label


def test_a_run_has_a_type_of_motion_with_its_evidence() -> None:
    run = s.run("periodic-2deg", duration=0.1, samples=False)
    assert run.motion == run.verdict.regime == "periodic"
    assert run.verdict.evidence[0].contribution > 0


def test_a_recording_is_written_and_read_as_a_signal(tmp_path) -> None:
    path = tmp_path / "out.rrd"
    shares: list[float] = []
    run = s.run("periodic-2deg", duration=0.005, record=path, progress=shares.append)
    assert path.stat().st_size > 10_000
    assert all(0 <= share <= 1 for share in shares)
    found = s.read_signal(path)
    assert found.name == "probe/displacement"
    assert found.samples.shape == run.u.shape
    # Recordings are in um.
    assert np.allclose(found.samples, 1e6 * run.u, rtol=1e-6, atol=1e-9)


def test_an_exception_of_the_progress_ends_the_run() -> None:
    def stop(share: float) -> None:
        raise RuntimeError("enough")

    began = time.perf_counter()
    with pytest.raises(RuntimeError, match="enough"):
        s.run("doubled-torus-3deg", duration=50.0, samples=False, progress=stop)
    assert time.perf_counter() - began < 20


def test_a_bar_ends_full_and_without_warnings(capfd, recwarn) -> None:
    shares: list[float] = []
    s.run("doubled-torus-3deg", duration=0.02, samples=False, progress=shares.append)
    assert shares[-1] == 1.0 and shares == sorted(shares)
    s.run("doubled-torus-3deg", duration=0.02, samples=False, progress=True)
    assert "100 %" in capfd.readouterr().err
    assert not [warning for warning in recwarn if "clamping" in str(warning.message)]


def test_ctrl_c_ends_a_run() -> None:
    # A shell starts background processes with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        s.run("doubled-torus-3deg", duration=50.0, samples=False)
    timer.join()
    signal.signal(signal.SIGINT, before)


def test_a_simulation_is_stepped_and_changed() -> None:
    simulation = s.Simulation("periodic-2deg")
    first = simulation.step(1000)
    assert len(first) == 1000 and simulation.time == pytest.approx(1000 / 200e3)
    simulation.set("tilt_deg", 3.0)
    simulation.kick(1e-3, seed=7)
    second = simulation.step(500)
    assert np.all(second.tilt_deg == pytest.approx(3.0))
    assert second.t[0] == pytest.approx(first.t[-1] + 1 / 200e3)
    # The kick shows in the modal velocities.
    assert np.max(np.abs(second.qdot[0])) > 3e-4
    with pytest.raises(s.InputError, match="out of range"):
        simulation.set("tilt_deg", 95.0)


def test_a_simulation_repeats_a_run(run: s.Run) -> None:
    simulation = s.Simulation("periodic-2deg")
    parts = [simulation.step(n).u for n in (1, 999, 1000)]
    assert np.array_equal(np.concatenate(parts), run.u)
