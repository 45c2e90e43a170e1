"""A run judged from what it has written alone, by nothing of the program that has written it."""

from __future__ import annotations

import re
from collections.abc import Callable

from tests.stability.judge.balance import judge_energies, judge_forces
from tests.stability.judge.contact import judge_contact
from tests.stability.judge.court import Court
from tests.stability.judge.paths import judge_paths
from tests.stability.judge.tips import judge_tips
from tests.stability.judge.written import WrittenRun

DONE = ("completed", "arrested", "broke_through")

CHECKS: tuple[Callable[[Court], None], ...] = (judge_contact, judge_forces, judge_energies, judge_paths, judge_tips)


def judged(run: WrittenRun) -> Court:
    """All checks that what is there allows."""
    court = Court(run)
    court.check("bug", float(run.exit_code not in (0, 2, 3) or "Traceback" in run.errors), 0.5, 0)
    if run.exit_code == 0:
        court.check("status", float(run.summary.get("status") not in DONE), 0.5, 0)
    if run.exit_code in (2, 3):
        court.check("no reason", float(not re.search(r"\S+: \S+", run.errors)), 0.5, 0)
    solved = len(run.tables) == 6 and len(run.tables["steps"]) and run.exit_code in (0, 3)
    for check in CHECKS if solved else ():
        check(court)
    return court
