"""Tables of studies are read by the libraries that people have."""

import subprocess
import sys
from pathlib import Path

import pytest

import squeakscope as s

duckdb = pytest.importorskip("duckdb")
pandas = pytest.importorskip("pandas")
polars = pytest.importorskip("polars")
pyarrow = pytest.importorskip("pyarrow")
pytest.importorskip("pyarrow.feather")
pytest.importorskip("pyarrow.parquet")

TILTS = [2.0, 3.0]


def program(*words: str) -> None:
    command = [sys.executable, "-m", "squeakscope", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep over two tilts as an Arrow file, as Parquet and as CSV."""
    folder = tmp_path_factory.mktemp("tables")
    table = str(folder / "sweep.arrow")
    short = ["--min-transient", "20", "--max-transient", "20", "--measure", "10", "--exponents", "1"]
    program("sweep", "doubled-torus-3deg", "--tilt", "2:3:1", "--start", "fresh", *short, "--out", table)
    for name in ("sweep.parquet", "sweep.csv"):
        program("merge", table, "--out", str(folder / name))
    return folder


def test_results_are_tables_of_pandas_and_polars(run) -> None:
    lines = s.spectrum(run.u, run.scene.sample_rate).lines
    frequencies = [line.frequency_hz for line in lines]
    frames = (pandas.DataFrame(lines), lines.to_pandas(), polars.DataFrame(lines), lines.to_polars(), pyarrow.table(lines))
    for frame in frames:
        assert list(frame["frequency_hz"].to_numpy()) == frequencies
    assert list(lines[:2].to_pandas()["label"]) == [line.label for line in lines[:2]]


def test_arrow_files_and_their_units(folder: Path) -> None:
    with pyarrow.ipc.open_file(folder / "sweep.arrow") as file:
        table = file.read_all()
    assert table["load.tilt_deg"].to_pylist() == TILTS
    units = {field.name: (field.metadata or {}).get(b"unit") for field in table.schema}
    assert units["load.tilt_deg"] == b"deg"
    assert units["amplitude_m"] == b"m"
    assert units["largest_exponent_per_s"] == b"1/s"
    assert units["maxima_m"] == b"m"
    assert not any(name.endswith("_rad") for name in units)
    modes = table["linear"].to_pylist()[0]["modes"]
    assert sum(mode["unstable"] for mode in modes) == 4
    again = pyarrow.parquet.read_table(folder / "sweep.parquet")
    assert again.to_pydict() == table.to_pydict()


def test_other_libraries_read_the_same_numbers(folder: Path) -> None:
    arrow, parquet, csv = (str(folder / f"sweep.{ending}") for ending in ("arrow", "parquet", "csv"))
    frames = [
        pandas.read_feather(arrow),
        pandas.read_parquet(parquet),
        pandas.read_csv(csv, float_precision="round_trip"),
        polars.read_ipc(arrow).to_pandas(),
        polars.read_parquet(parquet).to_pandas(),
        polars.read_csv(csv).to_pandas(),
        duckdb.sql(f"select * from '{parquet}'").df(),
        duckdb.sql(f"select * from '{csv}'").df(),
    ]
    exponents = [spectrum["exponents_per_s"][0]["value"] for spectrum in frames[0]["exponents"]]
    assert len(exponents) == len(TILTS) and all(isinstance(value, float) for value in exponents)
    for frame in frames:
        assert list(frame["load.tilt_deg"]) == TILTS
        assert list(frame["regime"]) == list(frames[0]["regime"])
        assert list(frame["amplitude_m"]) == list(frames[0]["amplitude_m"])
        assert list(frame["largest_exponent_per_s"]) == exponents
        if "exponents" in frame:
            assert [spectrum["exponents_per_s"][0]["value"] for spectrum in frame["exponents"]] == exponents
    # CSV has the columns of one value only.
    assert ["exponents" in frame for frame in frames] == [True, True, False] * 2 + [True, False]
    lists = [len(values) for values in frames[0]["maxima_m"]]
    assert lists == [len(values) for values in frames[1]["maxima_m"]]
    # DuckDB reads an Arrow file through pyarrow.
    table = pyarrow.feather.read_table(arrow)
    found = duckdb.from_arrow(table).df()
    assert list(found["amplitude_m"]) == list(frames[0]["amplitude_m"])
