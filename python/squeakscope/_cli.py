"""The command ``squeakscope``."""

import sys

from . import _squeakscope


def main() -> None:
    """Run the program with the arguments of the process."""
    sys.exit(_squeakscope.main(sys.argv))
