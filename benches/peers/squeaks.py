"""Compares the search for tonal events with librosa's pyin and piptrack on the same recordings.

    python3 -m venv peers && peers/bin/pip install -r benches/peers/requirements.txt
    cargo run --release --example squeak_recordings -- /tmp/tuning 3
    cargo run --release --example squeak_recordings -- /tmp/judging 5 judging
    peers/bin/python benches/peers/squeaks.py tune /tmp/tuning
    peers/bin/python benches/peers/squeaks.py judge /tmp/judging --write

`tune` searches the settings of both peers on the recordings for tuning, and prints the best; they are the constants PYIN
and PIPTRACK below. `judge` scores all programs and prints the counts as CSV; `--write` also stores them in
benches/peers/squeaks.csv, from which the guide's table and figure are made (tests/it/squeaks/study.rs).

Neither peer reports events, so both get what they lack: pitches of consecutive frames are linked to events, which
end where the level is 10 dB below the loudest 100 ms, as in the definition of the truth; for piptrack, peaks are
measured against the noise floor of their own band, the partials of an event are joined to it, and lines of the mains
are dropped.
"""

import argparse
import csv
import itertools
import sys
from collections import defaultdict
from pathlib import Path

import librosa
import numpy as np
import soundfile

RESULTS = Path(__file__).with_name("squeaks.csv")
LOW_HZ, HIGH_HZ = 200.0, 12_000.0
HOP_S = 0.01

# Found by `tune`.
PYIN = {"frame_s": 0.023, "switch": 0.01, "voiced": 0.6, "jump": 0.01, "shortest_s": 0.2}
PIPTRACK = {"frame_s": 0.093, "floor": "band", "threshold": 5.0, "jump": 0.005, "shortest_s": 0.4}


def load(folder):
    """Recordings of a folder: (name, set, samples, rate, squeaks), squeaks as rows start, end, frequency."""
    rows = defaultdict(list)
    with open(folder / "truth.csv") as file:
        for row in csv.DictReader(file):
            rows[row["file"], row["set"]].append(row)
    for (name, part), squeaks in rows.items():
        samples, rate = soundfile.read(folder / name)
        keys = ("start_s", "end_s", "frequency_hz")
        yield name, part, samples, rate, [[float(s[k]) for k in keys] for s in squeaks if s["start_s"]]


def score(squeaks, events):
    """Counts as in tests/it/squeaks/score.rs: squeaks, found, false events, recordings with a false event."""
    left = list(squeaks)
    for start, end, frequency in events:
        for squeak in left:
            if (
                abs(start - squeak[0]) <= 0.1
                and abs(end - squeak[1]) <= 0.1
                and abs(frequency / squeak[2] - 1) <= 0.005
            ):
                left.remove(squeak)
                break
    found = len(squeaks) - len(left)
    false = len(events) - found
    return np.array([1, len(squeaks), found, false, false > 0])


def event(times, frequencies, powers):
    """The event of a track of frames: its ends are 10 dB below its loudest 100 ms."""
    width = max(1, min(len(powers), round(0.1 / HOP_S)))
    loudest = np.convolve(powers, np.ones(width) / width, "valid").max()
    loud = np.flatnonzero(powers >= 0.1 * loudest)
    inside = slice(loud[0], loud[-1] + 1)
    weights = powers[inside]
    return times[inside][0], times[inside][-1], np.sum(weights * frequencies[inside]) / np.sum(weights)


def pyin_frames(samples, rate, frame_s, switch):
    """Pitch (nan if unvoiced), probability and power of each frame."""
    if rate > 50_000:
        samples, rate = librosa.resample(samples, orig_sr=rate, target_sr=rate / 2), rate / 2
    frame, hop = 2 * round(frame_s * rate / 2), round(HOP_S * rate)
    high = min(HIGH_HZ, 0.45 * rate)
    # Rumble below all pitches would hide them.
    spectrum = np.fft.rfft(samples)
    spectrum[: int(0.8 * LOW_HZ * len(samples) / rate)] = 0
    samples = np.fft.irfft(spectrum, len(samples))
    pitch, _, probability = librosa.pyin(
        samples, fmin=LOW_HZ, fmax=high, sr=rate, frame_length=frame, hop_length=hop, switch_prob=switch
    )
    power = librosa.feature.rms(y=samples, frame_length=frame, hop_length=hop)[0] ** 2
    return np.arange(len(pitch)) * hop / rate, pitch, probability, power[: len(pitch)]


def pyin_events(frames, voiced, jump, shortest_s, **_):
    """Runs of frames with a pitch that changes little from frame to frame."""
    times, pitch, probability, power = frames
    events, run = [], []
    for k in range(len(times) + 1):
        goes_on = k < len(times) and np.isfinite(pitch[k])
        if goes_on and run and abs(pitch[k] / pitch[run[-1]] - 1) > jump:
            goes_on = False
        if not goes_on and run:
            if times[run[-1]] - times[run[0]] >= shortest_s and probability[run].mean() >= voiced:
                events.append(event(times[run], pitch[run], power[run]))
            run = []
        if k < len(times) and np.isfinite(pitch[k]):
            run.append(k)
    return events


def piptrack_frames(samples, rate, frame_s, floor, threshold):
    """Peaks of each frame: frequencies and powers."""
    frame, hop = 2 * round(frame_s * rate / 2), round(HOP_S * rate)
    size = np.abs(librosa.stft(samples, n_fft=frame, hop_length=hop))
    if floor == "time":
        noise = np.median(size, axis=1)
        bins = np.arange(len(noise))
    else:
        average = np.median(size, axis=1)
        bins = np.arange(len(average))
        edges = bins[:, None] * 2 ** np.array([-1 / 6, 1 / 6])
        noise = np.array([np.median(average[int(a) : int(b) + 2]) for a, b in edges])
    pitches, sizes = librosa.piptrack(
        S=size, sr=rate, n_fft=frame, fmin=LOW_HZ, fmax=min(HIGH_HZ, 0.45 * rate), ref=threshold * noise[:, None]
    )
    times = np.arange(size.shape[1]) * hop / rate
    peaks = [np.flatnonzero(column) for column in pitches.T]
    return times, [(pitches[p, k], sizes[p, k] ** 2) for k, p in enumerate(peaks)]


def piptrack_events(frames, jump, shortest_s, **_):
    """Peaks of consecutive frames linked to tracks; partials and lines of the mains removed."""
    times, peaks = frames
    tracks, open_tracks = [], []
    for k, (frequencies, powers) in enumerate(peaks):
        open_tracks = [track for track in open_tracks if k - track[-1][0] <= 5]
        free = list(open_tracks)
        for m in np.argsort(-powers):
            near = [t for t in free if abs(frequencies[m] / t[-1][1] - 1) <= jump]
            if near:
                track = min(near, key=lambda t: abs(t[-1][1] - frequencies[m]))
                free.remove(track)
            else:
                track = []
                tracks.append(track)
                open_tracks.append(track)
            track.append((k, frequencies[m], powers[m]))
    events = []
    for track in tracks:
        frames_of = np.array([point[0] for point in track])
        length = times[frames_of[-1]] - times[frames_of[0]]
        # A track with a peak in fewer than half of its frames is noise.
        if length >= shortest_s and len(track) >= 0.5 * length / HOP_S:
            frequencies, powers = np.array([point[1:] for point in track]).T
            events.append(event(times[frames_of], frequencies, powers))
    events = [e for e in events if e[1] - e[0] >= shortest_s and not is_mains(e, times[-1])]
    return [e for e in events if not any(is_partial(e, other) for other in events)]


def is_mains(found, length_s):
    """Whether an event is a multiple of 50 or 60 Hz that sounds for most of the recording."""
    start, end, frequency = found
    near = min(abs(frequency - mains * round(frequency / mains)) for mains in (50, 60))
    return end - start > 0.9 * length_s and near < 2.0


def is_partial(found, base):
    """Whether an event is a higher partial of another that sounds at the same time."""
    order = round(found[2] / base[2])
    together = min(found[1], base[1]) - max(found[0], base[0])
    near = abs(found[2] / (order * base[2]) - 1) < 0.01 if order else False
    return 2 <= order <= 6 and near and together > 0.5 * (found[1] - found[0])


def choices(**lists):
    """All combinations of settings."""
    return [dict(zip(lists, values)) for values in itertools.product(*lists.values())]


METHODS = {
    "piptrack": (
        piptrack_frames,
        piptrack_events,
        choices(frame_s=[0.046, 0.093], floor=["time", "band"], threshold=[3.0, 4.0, 5.0, 6.0, 9.0]),
        choices(jump=[0.003, 0.005, 0.01, 0.02], shortest_s=[0.15, 0.2, 0.3, 0.4]),
    ),
    "pyin": (
        pyin_frames,
        pyin_events,
        choices(frame_s=[0.023, 0.046], switch=[0.01]),
        choices(voiced=[0.0, 0.1, 0.3, 0.6], jump=[0.01, 0.02, 0.05], shortest_s=[0.15, 0.2, 0.3]),
    ),
}


def tune(folder):
    """Prints the best settings: by the mean of recall and precision at 10 dB or more and of the share of recordings
    without squeaks that have no event."""
    recordings = list(load(folder))
    for name, (frames_of, events_of, outer, inner) in METHODS.items():
        ranking = []
        for first in outer:
            frames = [frames_of(samples, rate, **first) for _, _, samples, rate, _ in recordings]
            for second in inner:
                loud, other = np.zeros(5), np.zeros(5)
                for (_, part, _, _, squeaks), data in zip(recordings, frames):
                    counts = score(squeaks, events_of(data, **second))
                    if part in ("10 dB", "20 dB", "30 dB"):
                        loud += counts
                    elif not part.endswith("dB"):
                        other += counts
                precision = loud[2] / max(1, loud[2] + loud[3])
                value = (loud[2] / loud[1] + precision + 1 - other[4] / other[0]) / 3
                ranking.append((value, loud[2] / loud[1], precision, other[4] / other[0], {**first, **second}))
            print(name, first, max(ranking, key=lambda r: r[0]), flush=True)
        ranking.sort(key=lambda r: -r[0])
        print(f"best of {name}:", *ranking[:3], sep="\n    ", flush=True)


def judge(folder, write):
    """Scores all programs."""
    own = defaultdict(list)
    with open(folder / "found.csv") as file:
        for row in csv.DictReader(file):
            own[row["file"]].append([float(row[k]) for k in ("start_s", "end_s", "frequency_hz")])
    counts = defaultdict(lambda: np.zeros(5, int))
    for name, part, samples, rate, squeaks in load(folder):
        counts["squeakscope", part] += score(squeaks, own[name])
        for program, chosen in (("piptrack", PIPTRACK), ("pyin", PYIN)):
            frames_of, events_of, outer, inner = METHODS[program]
            frames = frames_of(samples, rate, **{key: chosen[key] for key in outer[0]})
            counts[program, part] += score(squeaks, events_of(frames, **{key: chosen[key] for key in inner[0]}))
    lines = ["program,set,recordings,squeaks,found,false_events,with_false"]
    lines += [",".join(map(str, [*key, *values])) for key, values in sorted(counts.items(), key=lambda c: c[0][0])]
    text = "\n".join(lines) + "\n"
    sys.stdout.write(text)
    if write:
        RESULTS.write_text(text)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("task", choices=["tune", "judge"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    if arguments.task == "tune":
        tune(arguments.folder)
    else:
        judge(arguments.folder, arguments.write)
