"""The command line: `dualcam ...`, or `python -m dualcam ...`."""

import sys

from dualcam.cli import main

__all__ = ["main"]

if __name__ == "__main__":
    sys.exit(main())
