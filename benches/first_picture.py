"""Measures the time from the start of the program to the first picture in the viewer's stream, s.

    pip install rerun-sdk==0.36.3
    python benches/first_picture.py target/release/squeakscope [SCENE ...]

A viewer without a window writes the received stream to a file. The time ends when the file contains the
first frames of the signal, of the modes and of the contact patch. Prints the minimum and the median of
several runs.
"""

import argparse
import os
import pathlib
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time

#: Entities of the first frame.
FIRST = (b"/probe/velocity", b"/modes/q", b"/joint/patch/nodes")


def listening(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def measure(program, scene, viewer, port):
    with tempfile.TemporaryDirectory() as folder:
        stream = pathlib.Path(folder) / "stream.rrd"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        receiver = subprocess.Popen(
            [viewer, "--bind", "127.0.0.1", "--port", str(port), "--save", stream],
            start_new_session=True, **quiet)
        try:
            while not listening(port):
                time.sleep(0.01)
            began = time.perf_counter()
            url = f"rerun+http://127.0.0.1:{port}/proxy"
            run = subprocess.Popen([program, "run", scene, "--connect", url], **quiet)
            try:
                while True:
                    received = stream.read_bytes() if stream.exists() else b""
                    if all(entity in received for entity in FIRST):
                        return time.perf_counter() - began
                    if time.perf_counter() - began > 30:
                        sys.exit(f"received no data of {scene} within 30 s")
                    time.sleep(0.002)
            finally:
                run.terminate()
                run.wait()
        finally:
            # The launcher installed by pip starts the viewer as a child process.
            os.killpg(receiver.pid, signal.SIGTERM)
            receiver.wait()
            while listening(port):
                time.sleep(0.01)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("program", help="release build of squeakscope")
    parser.add_argument("scenes", nargs="*", default=["tilt-ramp", "doubled-torus-3deg"])
    parser.add_argument("--viewer", default=str(pathlib.Path(sys.executable).parent / "rerun"))
    parser.add_argument("--port", type=int, default=9911)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    for scene in options.scenes:
        times = [measure(options.program, scene, options.viewer, options.port)
                 for _ in range(options.repeats)]
        print(f"{scene}: {min(times):.2f} s, median {statistics.median(times):.2f} s")


if __name__ == "__main__":
    main()
