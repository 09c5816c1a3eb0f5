"""A sweep as tasks of a Dask cluster whose tables do not depend on a worker that is lost."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

distributed = pytest.importorskip("distributed", reason="Dask is not installed (pip install 'dask[distributed]')")

SHARDS = 8
SWEEP = ["sweep", "doubled-torus-3deg", "--tilt", "1:4.5:0.5", "--start", "fresh", "--exponents", "0", "--measure", "200"]


def squeakscope(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "squeakscope", *words], check=True, capture_output=True)


def shard(number: int, folder: Path) -> int:
    """A task: one shard, which continues what a lost worker has left."""
    part = str(folder / f"part-{number}.arrow")
    squeakscope(*SWEEP, "--threads", "1", "--shard", f"{number}/{SHARDS}", "--resume", "--out", part)
    return number


def lose(process: int) -> None:
    """Kill a worker and what it has started, as if its machine were lost."""
    psutil = pytest.importorskip("psutil")
    worker = psutil.Process(process)
    for child in [*worker.children(recursive=True), worker]:
        child.send_signal(signal.SIGKILL)


def test_a_sweep_survives_the_loss_of_a_worker(tmp_path: Path) -> None:
    with (
        distributed.LocalCluster(n_workers=4, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        before = client.run(os.getpid)
        tasks = client.map(shard, range(1, SHARDS + 1), folder=tmp_path, pure=False)
        # A worker that has started its shard.
        deadline = time.monotonic() + 60
        while not any(tmp_path.glob("part-*.arrow*")):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        lost = next(name for name, keys in client.processing().items() if keys)
        lose(before[lost])
        assert sorted(client.gather(tasks)) == list(range(1, SHARDS + 1))
        after = client.run(os.getpid)
    assert before[lost] not in after.values()
    squeakscope("merge", *(str(tmp_path / f"part-{k}.arrow") for k in range(1, SHARDS + 1)), "--out", str(tmp_path / "merged.arrow"))
    squeakscope(*SWEEP, "--out", str(tmp_path / "one.arrow"))
    assert (tmp_path / "merged.arrow").read_bytes() == (tmp_path / "one.arrow").read_bytes()
