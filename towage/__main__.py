"""``python -m towage`` is the command ``towage``."""

import sys

from towage.cli import main

if __name__ == "__main__":
    sys.exit(main())
