"""Exceptions of the package."""


class Error(Exception):
    """A computation or a file failed. The message says what, where, and the remedy."""


class InputError(Error, ValueError):
    """A scene, a signal or an argument is not valid."""
