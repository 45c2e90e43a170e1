"""`python -m crackgrow`."""

from __future__ import annotations

import sys

from crackgrow.cli import main

if __name__ == "__main__":
    sys.exit(main())
