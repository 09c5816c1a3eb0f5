"""Types of the extension; its docstrings are in the extension itself."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import results
from ._result import Results

_Scene: TypeAlias = Scene | str | PathLike[str]
_Systems: TypeAlias = Callable[..., System]
_Progress: TypeAlias = Callable[[float], object] | bool | None
_Floats: TypeAlias = NDArray[np.float64]
_Norm: TypeAlias = Literal["euclidean", "maximum", "manhattan"]
_Window: TypeAlias = Literal["hann", "blackman-harris"]
_Law: TypeAlias = Callable[..., ArrayLike]
_Method: TypeAlias = Literal["dop853", "tsit5", "rodas5p", "rk4", "auto"]

__version__: str

def main(words: Sequence[str]) -> int: ...
def schemas() -> dict[str, Any]: ...
@final
class Scene:
    @staticmethod
    def load(name: str | PathLike[str]) -> Scene: ...
    @staticmethod
    def parse(text: str, name: str = "scene") -> Scene: ...
    def replace(self, **values: object) -> Scene: ...
    def __getitem__(self, key: str, /) -> float: ...
    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def about(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def duration(self) -> float: ...
    @property
    def sample_rate(self) -> float: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def parameters(self) -> dict[str, float]: ...

@final
class System:
    def __new__(
        cls,
        rhs: _Law,
        z0: ArrayLike,
        period: float,
        *,
        method: _Method = "dop853",
        tolerance: float = 1e-08,
        max_step: float | None = None,
        events: Callable[[float, _Floats], ArrayLike] | None = None,
        reset: Callable[[float, _Floats, int], ArrayLike | None] | None = None,
        max_crossings: int = 1000,
        jacobian: _Law | None = None,
        autonomous: bool | None = None,
    ) -> System: ...

@final
class Contact:
    @property
    def t(self) -> _Floats: ...
    @property
    def state(self) -> NDArray[np.uint8]: ...
    @property
    def normal_force(self) -> _Floats: ...
    @property
    def friction(self) -> _Floats: ...
    @property
    def position(self) -> _Floats: ...

@final
class Samples:
    @property
    def t(self) -> _Floats: ...
    @property
    def q(self) -> _Floats: ...
    @property
    def qdot(self) -> _Floats: ...
    @property
    def u(self) -> _Floats: ...
    @property
    def v(self) -> _Floats: ...
    @property
    def tilt_deg(self) -> _Floats: ...
    @property
    def load_n(self) -> _Floats: ...
    @property
    def rotation_factor(self) -> _Floats: ...
    @property
    def contact(self) -> Contact: ...
    def __len__(self) -> int: ...

@final
class Run:
    @property
    def scene(self) -> Scene: ...
    @property
    def samples(self) -> Samples: ...
    @property
    def summary(self) -> results.RunResult: ...
    @property
    def exponents(self) -> results.RunExponents | None: ...
    @property
    def verdict(self) -> results.Verdict | None: ...
    def __getattr__(self, name: str, /) -> Any: ...
    def _repr_html_(self) -> str: ...
    def __dir__(self) -> list[str]: ...

@final
class Simulation:
    def __new__(cls, scene: _Scene) -> Simulation: ...
    def step(self, samples: int) -> Samples: ...
    def set(self, key: str, value: float) -> None: ...
    def kick(self, size: float, seed: int = 1) -> None: ...
    @property
    def scene(self) -> Scene: ...
    @property
    def time(self) -> float: ...

def scenes() -> dict[str, str]: ...
def run(
    scene: _Scene,
    *,
    duration: float | None = None,
    record: str | PathLike[str] | None = None,
    samples: bool = True,
    progress: _Progress = None,
) -> Run: ...
def model(scene: _Scene) -> dict[str, _Floats]: ...
def stability(scene: _Scene, tilts_deg: ArrayLike | None = None) -> results.StabilityResult: ...
def sensitivities(scene: _Scene, *, progress: _Progress = None) -> Results[results.ModeSensitivities]: ...
def branch(
    scene: _Scene | _Systems,
    parameter: str = "load.tilt_deg",
    interval: tuple[float, float] | None = None,
    *,
    points: int = 41,
    orbits: bool = True,
    start: float | None = None,
    progress: _Progress = None,
) -> results.Branch: ...
def sweep(
    scene: _Scene | _Systems,
    values: Mapping[str, ArrayLike],
    *,
    starts: Sequence[Literal["fresh", "upward", "downward"]] | None = None,
    min_transient: float | None = None,
    max_transient: float | None = None,
    measure: float | None = None,
    exponents: int = 3,
    shard: tuple[int, int] | None = None,
    threads: int | None = None,
    progress: _Progress = None,
) -> results.SweepResult: ...
def basins(
    scene: _Scene | _Systems,
    kicks: int = 20,
    *,
    seed: int = 1,
    min_transient: float | None = None,
    max_transient: float | None = None,
    measure: float | None = None,
    exponents: int = 3,
    threads: int | None = None,
    progress: _Progress = None,
) -> results.Basins: ...
def lyapunov(
    scene: _Scene,
    exponents: int | None = None,
    *,
    average_time: float | None = None,
    half_width: float | None = None,
    settle: float | None = None,
    tolerance: float | None = None,
    duration: float | None = None,
    progress: _Progress = None,
) -> results.SceneExponents: ...
def cost(
    scene: _Scene,
    *,
    progress: _Progress = None,
) -> results.Cost: ...
def spectrum(signal: ArrayLike, rate: float, *, window: _Window = "blackman-harris") -> results.Spectrum: ...
def spectrogram(
    signal: ArrayLike, rate: float, *, length: int = 1024, hop: float | None = None, window: _Window = "hann"
) -> results.Spectrogram: ...
def tonal_events(
    signal: ArrayLike,
    rate: float,
    *,
    low_hz: float = 200.0,
    high_hz: float = 12000.0,
    full_scale: float = 1.0,
    shortest_s: float = 0.2,
) -> results.TonalEvents: ...
def mutual_information(signal: ArrayLike, *, max_lag: int | None = None, bins: int | None = None) -> results.MutualInformation: ...
def false_neighbours(
    signal: ArrayLike,
    lag: int,
    *,
    max_dimension: int = 10,
    theiler: int | None = None,
    distance_ratio: float = 15.0,
    size_ratio: float = 2.0,
) -> results.FalseNeighbours: ...
def choose_delay(signal: ArrayLike) -> results.DelayChoice: ...
def embed(signal: ArrayLike, lag: int, dimension: int) -> _Floats: ...
def recurrence_plot(
    signal: ArrayLike,
    other: ArrayLike | None = None,
    *,
    lag: int = 1,
    dimension: int = 1,
    threshold: float | None = None,
    threshold_std: float | None = None,
    recurrence_rate: float | None = None,
    neighbours: int | None = None,
    norm: _Norm = "euclidean",
    theiler: int = 1,
) -> results.Plot: ...
def rqa(
    signal: ArrayLike,
    other: ArrayLike | None = None,
    *,
    lag: int = 1,
    dimension: int = 1,
    threshold: float | None = None,
    threshold_std: float | None = None,
    recurrence_rate: float | None = None,
    neighbours: int | None = None,
    norm: _Norm = "euclidean",
    theiler: int = 1,
    min_diagonal: int = 2,
    min_vertical: int = 2,
    line_of_identity: bool = False,
    rate_base: Literal["counted", "all"] = "counted",
    rate: float | None = None,
) -> results.Quantified: ...
def rqa_windowed(
    signal: ArrayLike,
    window: int,
    *,
    hop: int | None = None,
    lag: int = 1,
    dimension: int = 1,
    threshold: float | None = None,
    threshold_std: float | None = None,
    recurrence_rate: float | None = None,
    neighbours: int | None = None,
    norm: _Norm = "euclidean",
    theiler: int = 1,
    min_diagonal: int = 2,
    min_vertical: int = 2,
    line_of_identity: bool = False,
    rate_base: Literal["counted", "all"] = "counted",
    rate: float | None = None,
    progress: _Progress = None,
) -> Results[results.MeasuresAt]: ...
def poincare_section(
    signal: ArrayLike,
    lag: int,
    *,
    rate: float | None = None,
    level: float | None = None,
    dimension: int = 3,
    direction: Literal["rising", "falling", "both"] = "rising",
) -> results.Section: ...
def largest_exponent(
    signal: ArrayLike,
    lag: int,
    dimension: int,
    theiler: int,
    *,
    rate: float | None = None,
    method: Literal["rosenstein", "kantz"] = "rosenstein",
    radius: float = 0.05,
    horizon: int | None = None,
) -> results.Divergence: ...
def zero_one_test(
    signal: ArrayLike, *, stride: int | None = None, frequencies: int = 100, seed: int = 1
) -> results.ZeroOne: ...
def regime(
    signal: ArrayLike, rate: float | None = None, *, silence: float = 0.0, background: float = 0.0
) -> results.Verdict: ...
def analyse(
    signal: ArrayLike | str | PathLike[str],
    rate: float | None = None,
    *,
    column: str | None = None,
    start: float | None = None,
    end: float | None = None,
    calibration: str | None = None,
    unit: str = "",
    event: int | None = None,
    progress: _Progress = None,
) -> results.AnalysedFile: ...
def read_signal(
    path: str | PathLike[str],
    *,
    column: str | None = None,
    rate: float | None = None,
    start: float | None = None,
    end: float | None = None,
    skip_lines: int = 0,
) -> results.SignalOfFile: ...
def integrate(
    rhs: _Law,
    z0: ArrayLike,
    t: ArrayLike,
    *,
    method: _Method = "dop853",
    tolerance: float = 1e-08,
    max_step: float | None = None,
    events: Callable[[float, _Floats], ArrayLike] | None = None,
    reset: Callable[[float, _Floats, int], ArrayLike | None] | None = None,
    terminal: bool | Sequence[bool] | None = None,
    direction: int | Sequence[int] | None = None,
    max_crossings: int = 1000,
    jacobian: _Law | None = None,
    autonomous: bool | None = None,
    progress: _Progress = None,
) -> results.Integration: ...
def exponents(
    rhs: _Law,
    z0: ArrayLike,
    time: float,
    *,
    settle: float,
    interval: float,
    exponents: int | None = None,
    seed: int = 1,
    method: _Method = "dop853",
    tolerance: float = 1e-08,
    max_step: float | None = None,
    events: Callable[[float, _Floats], ArrayLike] | None = None,
    reset: Callable[[float, _Floats, int], ArrayLike | None] | None = None,
    max_crossings: int = 1000,
    jacobian: _Law | None = None,
    autonomous: bool | None = None,
    progress: _Progress = None,
) -> results.OwnExponents: ...
