"""Exceptions of the package."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._result import Result


class Error(Exception):
    """A computation or a file failed. The message says what, where, and the remedy.

    ``result`` has what :func:`squeakscope.integrate` had computed until then, else it is None.
    """

    result: Result | None = None


class InputError(Error, ValueError):
    """A scene, a signal or an argument is not valid."""
