"""``python -m turtlewire`` is the command ``turtlewire``."""

import sys

from turtlewire.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
