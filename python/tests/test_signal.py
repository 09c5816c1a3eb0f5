import subprocess
import sys
from json import loads

import numpy as np
import pytest

import squeakscope as s

RATE = 48_000.0


def tone(frequency: float, count: int, amplitude: float = 0.3) -> np.ndarray:
    return amplitude * np.sin(2 * np.pi * frequency * np.arange(count) / RATE)


def test_spectrum_interpolates_the_line() -> None:
    found = s.spectrum(tone(4117.0, 4800), RATE)
    assert found.lines[0].frequency_hz == pytest.approx(4117.0, abs=1e-3)
    assert found.frequency_hz.shape == found.amplitude.shape == (2401,)
    assert found.amplitude.max() == pytest.approx(0.3, rel=0.1)


def test_spectrogram_follows_a_change() -> None:
    signal = np.concatenate([tone(3000.0, 9600), tone(6000.0, 9600)])
    found = s.spectrogram(signal, RATE, length=512)
    assert found.amplitude.shape == (len(found.time_s), len(found.frequency_hz)) and len(found.frequency_hz) == 257
    peaks = found.frequency_hz[np.argmax(found.amplitude, axis=1)]
    assert peaks[0] == pytest.approx(3000, abs=100) and peaks[-1] == pytest.approx(6000, abs=100)


def test_tonal_events_are_found_in_noise() -> None:
    noise = 0.01 * np.random.default_rng(1).standard_normal(96_000)
    noise[24_000:72_000] += tone(2500.0, 48_000)
    found = s.tonal_events(noise, RATE)
    assert len(found.events) == 1
    assert found.events[0].frequency_hz == pytest.approx(2500, abs=2)
    assert found.events[0].start_s == pytest.approx(0.5, abs=0.05)


def test_embedding_is_a_view_of_the_signal() -> None:
    signal = np.arange(10.0)
    vectors = s.embed(signal, 3, 2)
    assert np.shares_memory(vectors, signal) and not vectors.flags.writeable
    assert np.array_equal(vectors, np.stack([signal[:7], signal[3:]], axis=1))
    assert np.array_equal(s.embed(signal[::2], 1, 2), np.stack([signal[:8:2], signal[2::2]], axis=1))
    with pytest.raises(s.InputError, match="lag: give a whole number of at least 1, not 0"):
        s.embed(signal, 0, 2)


@pytest.mark.parametrize("convert", [list, lambda x: x.astype(np.float32), lambda x: np.repeat(x, 2)[::2]])
def test_any_array_is_accepted(convert) -> None:
    signal = np.round(100 * np.sin(0.3 * np.arange(600))) / 128
    expected = s.rqa(signal, lag=3, dimension=2)
    assert s.rqa(convert(signal), lag=3, dimension=2) == expected


def recurrences(signal, lag, dimension, threshold, order) -> np.ndarray:
    n = len(signal) - (dimension - 1) * lag
    states = np.stack([signal[c * lag : c * lag + n] for c in range(dimension)], axis=1)
    distance = np.linalg.norm(states[:, None] - states[None], ord=order, axis=2)
    return distance <= threshold


@pytest.mark.parametrize(("norm", "order"), [("euclidean", 2), ("maximum", np.inf), ("manhattan", 1)])
def test_recurrence_matches_its_definition(norm: str, order: float) -> None:
    signal = np.random.default_rng(2).standard_normal(300).cumsum()
    expected = recurrences(signal, 2, 3, 1.5, order)
    plot = s.recurrence_plot(signal, lag=2, dimension=3, threshold=1.5, norm=norm)
    off = ~np.eye(len(expected), dtype=bool)
    assert np.array_equal(plot.recurrent & off, expected & off)
    found = s.rqa(signal, lag=2, dimension=3, threshold=1.5, norm=norm)
    assert found.states == len(expected) and found.threshold == 1.5
    assert found.recurrence_rate == pytest.approx(expected[off].mean())
    # Diagonal lines of one triangle; the plot is symmetric.
    n = len(expected)
    lengths: list[int] = []
    for k in range(1, n):
        line = np.concatenate([[0], np.diagonal(expected, k).astype(int), [0]])
        lengths += list(np.flatnonzero(np.diff(line) == -1) - np.flatnonzero(np.diff(line) == 1))
    for shortest in (2, 5):
        det = s.rqa(signal, lag=2, dimension=3, threshold=1.5, norm=norm, min_diagonal=shortest).determinism
        long = [length for length in lengths if length >= shortest]
        assert det == pytest.approx(sum(long) / sum(lengths))


def test_line_of_identity_and_rate_base() -> None:
    signal = np.random.default_rng(3).standard_normal(200)
    expected = recurrences(signal, 1, 1, 0.3, 2)
    off = ~np.eye(200, dtype=bool)
    with_identity = s.rqa(signal, threshold=0.3, line_of_identity=True)
    assert with_identity.recurrence_rate == pytest.approx(expected.mean())
    assert with_identity.longest_diagonal == 200
    over_all = s.rqa(signal, threshold=0.3, rate_base="all")
    assert over_all.recurrence_rate == pytest.approx((expected & off).mean())
    with pytest.raises(s.InputError, match="line_of_identity"):
        s.rqa(signal, theiler=5, line_of_identity=True)
    with pytest.raises(s.InputError, match="give one of"):
        s.rqa(signal, threshold=0.3, recurrence_rate=0.1)
    with pytest.raises(s.InputError, match="euclidean"):
        s.rqa(signal, norm="taxicab")


def test_windows_equal_the_parts() -> None:
    signal = np.sin(0.2 * np.arange(1000)) + 0.1 * np.sin(np.arange(1000))
    windows = s.rqa_windowed(signal, 400, hop=300, lag=5, dimension=2, threshold=0.2)
    assert len(windows) == 3 and windows[1].time == 500
    part = s.rqa(signal[300:700], lag=5, dimension=2, threshold=0.2)
    assert windows[1].determinism == part.determinism


def test_delay_of_the_lorenz_system(lorenz: np.ndarray) -> None:
    chosen = s.choose_delay(lorenz)
    information = s.mutual_information(lorenz, max_lag=50)
    assert 10 < chosen.lag_samples < 25
    assert information.bits.shape == (51,) and information.bits[0] == information.bits.max()
    false = s.false_neighbours(lorenz, chosen.lag_samples, max_dimension=5)
    assert false.share[0] > 0.5 and false.share[2] < 0.02


def test_chaos_of_the_lorenz_system(lorenz: np.ndarray) -> None:
    found = s.largest_exponent(lorenz, 16, 3, 75, rate=100.0)
    assert found.region.exponent_per_s == pytest.approx(0.906, rel=0.15)
    assert s.zero_one_test(lorenz, stride=16).k > 0.9
    assert s.zero_one_test(np.sin(0.7 * np.arange(2000))).k < 0.1
    assert s.regime(lorenz[:8000], 100.0).regime == "chaotic"
    assert s.regime(tone(4000.0, 8000), RATE).regime == "periodic"


def test_section_of_a_sine() -> None:
    section = s.poincare_section(np.sin(0.1 * np.arange(1000)), 16)
    assert section.points.shape[1] == 3
    assert np.allclose(section.points[:, 1], section.level)
    assert np.diff(section.time) == pytest.approx(2 * np.pi / 0.1, abs=1e-6)


def test_complete_analysis() -> None:
    found = s.analyse(tone(1234.0, 24_000), RATE)
    assert found.verdict.regime == "periodic"
    assert found.spectrum.lines[0].frequency_hz == pytest.approx(1234, abs=0.01)
    with pytest.raises(s.InputError, match="too few"):
        s.analyse(tone(1234.0, 100), RATE)
    with pytest.raises(s.InputError, match="rate: give"):
        s.analyse(tone(1234.0, 24_000))


def test_complete_analysis_of_a_file(tmp_path) -> None:
    path, calibrator = tmp_path / "squeak.npz", tmp_path / "calibrator.npz"
    np.savez(path, rate=RATE, left=tone(4100.0, 48_000), right=tone(500.0, 48_000))
    np.savez(calibrator, rate=RATE, left=tone(1000.0, 48_000, amplitude=0.1))
    found = s.analyse(path, column="left", start=0.1)
    assert found.file == str(path) and found.signal.start_s == pytest.approx(0.1)
    assert found.events[0].frequency_hz == pytest.approx(4100, abs=0.1)
    assert found.level_reference == "full-scale"
    assert found.events[0].level_db == pytest.approx(20 * np.log10(0.3), abs=0.3)
    # The program gives the same.
    json = tmp_path / "found.json"
    words = ["analyse", str(path), "--column", "left", "--from", "0.1", "--json", str(json)]
    subprocess.run([sys.executable, "-m", "squeakscope", *words], check=True, capture_output=True)
    program = loads(json.read_text())
    assert program["events"] == found.to_dict()["events"]
    # 0.1 is 94 dB: 0.3 is 9.54 dB more.
    calibrated = s.analyse(str(path), column="left", calibration=f"94dB={calibrator}")
    assert calibrated.sound_levels.equivalent_level_db == pytest.approx(103.54, abs=0.01)
    assert calibrated.events[0].level_db == pytest.approx(103.54, abs=0.3)
    assert calibrated.level_reference == "sound-pressure"
    for words, reason in (
        ({}, "choose one with --column"),
        ({"column": "left", "calibration": "94"}, "calibration: give"),
        ({"column": "left", "calibration": "50mV/Pa"}, "not in V"),
    ):
        with pytest.raises(s.InputError, match=reason):
            s.analyse(path, **words)
    with pytest.raises(s.InputError, match="No such file"):
        s.analyse(tmp_path / "missing.wav")


def test_lines_above_the_header_of_a_text_are_skipped(tmp_path) -> None:
    path = tmp_path / "bench.csv"
    path.write_text("bench 3, 4\nt,v\n" + "".join(f"{k / 1000},{k}\n" for k in range(600)))
    found = s.read_signal(path, column="v", skip_lines=1)
    assert found.rate_hz == pytest.approx(1000) and found.samples[-1] == 599


def test_a_background_is_no_broadband_motion() -> None:
    noise = 0.05 * np.random.default_rng(3).standard_normal(8000)
    signal = tone(2100.0, 8000) + noise
    floor = [
        next(part for part in s.regime(signal, RATE, background=power).evidence if part.criterion == "broadband floor")
        for power in (0.0, float(np.mean(noise**2)))
    ]
    assert floor[0] != floor[1]
    with pytest.raises(s.InputError, match="background: give"):
        s.regime(signal, RATE, background=-1.0)


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (lambda x: x[:, None], r"shape is \(2000, 1\); give one dimension"),
        (lambda x: None, "not None"),
        (lambda x: 1.0, r"give an array of shape \(n,\)"),
        (lambda x: np.ma.masked_greater(x, 5.0), "masked samples"),
        (lambda x: x + 1j, "complex numbers"),
        (lambda x: ["a", "b"], "give an array of numbers"),
        (lambda x: np.where(np.arange(2000) == 7, np.nan, x), "sample 7 is NaN"),
        (lambda x: np.where(np.arange(2000) == 7, np.inf, x), "sample 7 is inf"),
    ],
)
def test_samples_that_are_not_numbers_are_refused(lorenz, wrong, reason) -> None:
    for call in (s.choose_delay, lambda x: s.spectrum(x, 1.0), lambda x: s.integrate(lambda t, z: z, x, [0.0, 1.0])):
        with pytest.raises(s.InputError, match=reason):
            call(wrong(lorenz[:2000]))


def test_counts_are_whole_and_name_their_argument(lorenz) -> None:
    for call in (
        lambda: s.rqa(lorenz, lag=-1),
        lambda: s.false_neighbours(lorenz, -1),
        lambda: s.zero_one_test(lorenz, stride=-1),
        lambda: s.largest_exponent(lorenz, -1, 3, 10),
    ):
        with pytest.raises(s.InputError, match="(lag|stride): give a whole number of at least 1, not -1"):
            call()


def test_times_have_a_unit_where_a_rate_is_given(lorenz) -> None:
    plain, timed = s.rqa(lorenz[:1000]), s.rqa(lorenz[:1000], rate=100.0)
    assert plain.mean_diagonal == pytest.approx(100 * timed.mean_diagonal_s)
    assert not any(name.endswith(("_s", "_hz")) for name in plain) and plain.divergence == 0.01 * timed.divergence_per_s
    assert not any(name.endswith(("_s", "_hz")) for name in s.regime(lorenz[:1000]))


def test_states_recur_as_their_delay_vectors(lorenz) -> None:
    states = s.embed(lorenz[:800], 16, 3)
    choices = {"threshold": 3.0, "theiler": 20}
    assert s.rqa(states, **choices) == s.rqa(lorenz[:800], lag=16, dimension=3, **choices)
    plot = s.recurrence_plot(states, threshold=3.0)
    assert np.array_equal(plot.recurrent, s.recurrence_plot(lorenz[:800], lag=16, dimension=3, threshold=3.0).recurrent)
    windows = s.rqa_windowed(states, 300, hop=200, **choices)
    assert windows[1].determinism == s.rqa(states[200:500], **choices).determinism
    with pytest.raises(s.InputError, match="lag, dimension: states"):
        s.rqa(states, lag=2)


def test_cross_recurrence_matches_its_definition(lorenz) -> None:
    x, y = s.embed(lorenz[:300], 5, 2), s.embed(lorenz[400:600], 5, 2)
    expected = np.linalg.norm(x[:, None] - y[None], axis=2) <= 4.0
    plot = s.recurrence_plot(lorenz[:300], lorenz[400:600], lag=5, dimension=2, threshold=4.0)
    assert np.array_equal(plot.recurrent, expected) and plot.rate == pytest.approx(expected.mean())
    found = s.rqa(x, y, threshold=4.0)
    assert found.recurrence_rate == pytest.approx(expected.mean()) and found.states == len(x)
    # All diagonals, above and below the main one.
    lengths: list[int] = []
    for k in range(1 - len(x), len(y)):
        line = np.concatenate([[0], np.diagonal(expected, k).astype(int), [0]])
        lengths += list(np.flatnonzero(np.diff(line) == -1) - np.flatnonzero(np.diff(line) == 1))
    long = [length for length in lengths if length >= 2]
    assert found.determinism == pytest.approx(sum(long) / sum(lengths))
    assert s.recurrence_plot(x, y, recurrence_rate=0.1).rate == pytest.approx(0.1, abs=1e-3)
    with pytest.raises(s.InputError, match="other: it has 1 coordinates, and the signal has 2"):
        s.rqa(x, lorenz[:50])
