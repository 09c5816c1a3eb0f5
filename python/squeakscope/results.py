"""Classes of the results, one for each schema that ``--json`` has; their fields are in ``help`` and known to editors."""

from typing import Any

from ._result import class_of, definitions


def __getattr__(name: str) -> Any:
    if name not in definitions():
        raise AttributeError(f"there is no result {name!r}")
    return class_of(name)


def __dir__() -> list[str]:
    return sorted(definitions())
