"""The command `lifelike`, run inside the extension: `python -m lifelike` and the console script."""

import signal
import sys

from lifelike import _lifelike


def main() -> None:
    """Run the command with the arguments of this process, and exit with its code."""
    # The command handles Ctrl-C itself; Python's handler would wait for it to return.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_lifelike.main(["lifelike", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
