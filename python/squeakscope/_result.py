"""Results of the library as frozen objects."""

from __future__ import annotations

import copy
import functools
import html
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Generic, TypeVar, overload

import numpy as np

from ._errors import InputError

# Rows of a table that are shown in a notebook.
_SHOWN = 20


class Estimates(np.ndarray):
    """An array of estimated values, with the half-widths of their 95 % intervals beside it.

    Examples
    --------
    >>> found = Result({"exponents_per_s": [{"value": 0.9, "half_width": 0.02}, {"value": -14.6, "half_width": 0.01}]})
    >>> found.exponents_per_s.sum().round(1), found.exponents_per_s.half_width
    (np.float64(-13.7), array([0.02, 0.01]))
    """

    #: Half-widths of the intervals, of the shape of the values; None for a part of the array.
    half_width: np.ndarray | None = None


class Result:
    """A result of the library: its fields are attributes, which cannot be changed.

    Names of fields contain their units, such as ``frequency_hz``. Lists of numbers are read-only NumPy arrays, lists of
    estimates :class:`Estimates`, lists of results :class:`Results`. A result is also a mapping of its fields.

    Examples
    --------
    >>> line = Result({"frequency_hz": 4100.0, "label": "f1"})
    >>> line.frequency_hz
    4100.0
    >>> line.to_dict()
    {'frequency_hz': 4100.0, 'label': 'f1'}
    """

    __slots__ = ("_fields", "_panel", "_wrapped")
    # Schema of its fields; None for fields of any kind.
    _schema: str | None = None
    _fields: dict[str, Any]
    _wrapped: dict[str, Any]
    # Returns the figures of the result as SVG.
    _panel: Callable[[], str] | None

    def __init__(self, fields: dict[str, Any], panel: Callable[[], str] | None = None) -> None:
        object.__setattr__(self, "_fields", fields)
        object.__setattr__(self, "_panel", panel)
        object.__setattr__(self, "_wrapped", {})

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in self._wrapped:
            if name not in self._fields:
                fields = ", ".join(self._fields)
                raise AttributeError(f"the result has no field {name!r}; it has {fields}")
            known = properties(self._schema).get(name, {})
            self._wrapped[name] = wrap(self._fields[name], referred(known))
        return self._wrapped[name]

    def __getitem__(self, name: str) -> Any:
        if name not in self._fields:
            raise KeyError(name)
        return self.__getattr__(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def keys(self) -> list[str]:
        """Return the names of the fields."""
        return list(self._fields)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a result cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a result cannot be changed")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._fields]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Result) and self.to_dict() == other.to_dict()

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, tuple[dict[str, Any], str | None]]:
        return wrap, (self._fields, self._schema)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as a dictionary of plain numbers, strings, lists and dictionaries."""
        return {name: _plain(value) for name, value in self._fields.items()}

    def __repr__(self) -> str:
        fields = (f"{name}={_short(value)}" for name, value in self._fields.items())
        return f"{type(self).__name__}({', '.join(fields)})"

    def _repr_html_(self) -> str:
        rows = (
            f"<tr><th>{html.escape(name)}</th><td>{html.escape(_short(value))}</td></tr>"
            for name, value in self._fields.items()
        )
        return f"{self._panel() if self._panel else ''}<table>{''.join(rows)}</table>"


# Not a base class: its methods would hide fields, such as `values`.
Mapping.register(Result)


Row = TypeVar("Row", bound=Result, covariant=True)


class Results(Generic[Row]):
    """A list of results of one kind, which is also a table.

    pandas and polars read it: ``pandas.DataFrame(results)`` or ``results.to_pandas()``, ``polars.DataFrame(results)``
    or ``results.to_polars()``. DuckDB and others do so through the Arrow interface, if pyarrow is installed.
    """

    __slots__ = ("_rows",)
    _rows: tuple[Row, ...]

    def __init__(self, rows: Sequence[dict[str, Any]] = (), schema: str | None = None) -> None:
        self._rows = tuple(class_of(schema)(row) for row in rows)

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Row: ...
    @overload
    def __getitem__(self, index: slice) -> Results[Row]: ...
    def __getitem__(self, index: int | slice) -> Row | Results[Row]:
        if isinstance(index, slice):
            rows = self._rows[index]
            return Results([row._fields for row in rows], rows[0]._schema if rows else None)
        return self._rows[index]

    def __iter__(self) -> Iterator[Row]:
        return iter(self._rows)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Results) and self._rows == other._rows

    __hash__ = None  # type: ignore[assignment]

    def to_dicts(self) -> list[dict[str, Any]]:
        """Return the results as dictionaries."""
        return [row.to_dict() for row in self._rows]

    def to_arrow(self) -> Any:
        """Return the results as a pyarrow.Table, a column for each field.

        Raises
        ------
        ModuleNotFoundError
            If pyarrow is not installed.
        """
        import pyarrow

        return pyarrow.Table.from_pylist([row._fields for row in self._rows])

    def to_pandas(self) -> Any:
        """Return the results as a pandas.DataFrame, a column for each field.

        Raises
        ------
        ModuleNotFoundError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self.to_dicts())

    def to_polars(self) -> Any:
        """Return the results as a polars.DataFrame, a column for each field.

        Raises
        ------
        ModuleNotFoundError
            If polars is not installed.
        """
        import polars

        return polars.DataFrame(self.to_dicts(), infer_schema_length=None)

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __repr__(self) -> str:
        return f"Results({list(self._rows[:3])}{', ...' if len(self) > 3 else ''})"

    def _repr_html_(self) -> str:
        names = list(dict.fromkeys(name for row in self._rows for name in row._fields))
        head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(_short(row._fields.get(name)))}</td>" for name in names) + "</tr>"
            for row in self._rows[:_SHOWN]
        )
        more = f"<p>{len(self) - _SHOWN} more rows</p>" if len(self) > _SHOWN else ""
        return f"<table><tr>{head}</tr>{body}</table>{more}"


@functools.cache
def definitions() -> dict[str, Any]:
    """Return the JSON schemas of all results, by their names."""
    from . import _squeakscope

    return _squeakscope.schemas()


def properties(name: str | None) -> dict[str, Any]:
    """Return the schemas of the fields of a result, of which some may be absent."""
    schema = definitions().get(name or "", {})
    options = [option for key in ("oneOf", "anyOf") for option in schema.get(key, ())]
    found = [properties(referred(option)) if "$ref" in option else option.get("properties", {}) for option in options]
    return {field: value for part in (schema.get("properties", {}), *found) for field, value in part.items()}


def referred(schema: dict[str, Any]) -> str | None:
    """Return the name of the schema that a value, or each item of a list, has."""
    options = [schema, *schema.get("anyOf", ())]
    for part in options + [option.get("items", {}) for option in options]:
        if "$ref" in part:
            return str(part["$ref"]).rpartition("/")[2]
    return None


@functools.cache
def class_of(name: str | None) -> type[Any]:
    """Return the class of the results with a schema; its docstring describes the fields."""
    schema = definitions().get(name or "")
    if schema is None:
        return Result
    fields = properties(name).items()
    described = (f"{field}\n    {value.get('description', '').replace(chr(10), ' ')}" for field, value in fields)
    text = "\n".join([schema.get("description", ""), "", "Attributes", "----------", *described])
    return type(str(name), (Result,), {"__slots__": (), "__doc__": text, "__module__": "squeakscope.results", "_schema": name})


def wrap(value: Any, schema: str | None = None, panel: Callable[[], str] | None = None) -> Any:
    """Return a serialised value as a result, results, a read-only array or itself."""
    if isinstance(value, dict):
        return class_of(schema)(value, panel)
    if isinstance(value, np.ndarray):
        return _frozen(value)
    if not isinstance(value, list):
        return value
    if value and all(isinstance(item, dict) and item.keys() == {"value", "half_width"} for item in value):
        estimates = np.array([item["value"] for item in value]).view(Estimates)
        estimates.half_width = _frozen(np.array([item["half_width"] for item in value]))
        return _frozen(estimates)
    if all(isinstance(item, dict) for item in value):
        return Results(value, schema and schema.removeprefix("Array_of_"))
    if _is_numeric(value):
        return _frozen(np.array(value))
    return tuple(wrap(item) for item in value)


def progress_bar() -> Callable[[float], None]:
    """Return a function that shows a share of work as a bar, in a notebook or on a terminal."""
    try:
        from tqdm.auto import tqdm
    except ModuleNotFoundError:
        raise InputError("progress: True needs tqdm; install it, or give a function") from None
    bar = tqdm(total=1.0, bar_format="{percentage:3.0f} % |{bar}| {elapsed}, {remaining} left")

    def show(share: float) -> None:
        # Not by update: a sum of differences can exceed 1.
        bar.n = share
        bar.refresh()
        if share >= 1.0:
            bar.close()

    return show


def _frozen(array: Any) -> Any:
    array.flags.writeable = False
    return array


def _is_numeric(value: list[Any]) -> bool:
    if all(isinstance(item, (int, float)) for item in value):
        return True
    return all(
        isinstance(item, list) and len(item) == len(value[0]) and _is_numeric(item) for item in value
    )


def _plain(value: Any) -> Any:
    if isinstance(value, Result):
        return value.to_dict()
    return value.tolist() if isinstance(value, np.ndarray) else copy.deepcopy(value)


def _short(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"array of {' x '.join(map(str, value.shape))}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
        return f"[{len(value)} results]"
    if isinstance(value, list):
        return f"[{len(value)} values]" if len(value) > 4 else f"[{', '.join(map(_short, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(value)}}}"
    return repr(value)
