"""The command line: the only place that prints.

Exit codes: 0 done, 2 the case is wrong, 3 it can't be solved or written as asked, 130 interrupted, 1 a bug (which
shows its traceback), paths that `compare` finds further apart than the tolerance, or a NO of `stability`.
"""

from crackgrow.cli.command_line import main

__all__ = ["main"]
