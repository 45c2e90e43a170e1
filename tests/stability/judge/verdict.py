"""A run judged from what it has written alone, by nothing of the program that has written it."""

from __future__ import annotations

import re
from collections.abc import Callable

from tests.stability.judge.balance import judge_energies, judge_forces
from tests.stability.judge.contact import judge_contact
from tests.stability.judge.court import Court
from tests.stability.judge.paths import judge_paths
from tests.stability.judge.tips import judge_tips
from tests.stability.judge.written import TIME_LIMIT, WrittenRun

DONE = ("completed", "arrested", "broke_through")

CHECKS: tuple[Callable[[Court], None], ...] = (judge_contact, judge_forces, judge_energies, judge_paths, judge_tips)


def outcome(run: WrittenRun) -> str:
    """How a run ended: a status of summary.json, or refused, unsolved, crashed, time limit."""
    if run.exit_code == TIME_LIMIT:
        return "time limit"
    if run.exit_code == 2:
        return "refused"
    if run.exit_code == 3:
        return "unsolved"
    return str(run.summary.get("status", "crashed")) if run.exit_code == 0 else "crashed"


def judged(run: WrittenRun) -> Court:
    """All checks that what is there allows."""
    court = Court(run)
    court.check("traceback", float(run.exit_code not in (0, 2, 3, TIME_LIMIT) or "Traceback" in run.errors), 0.5, 0)
    court.check("warning of Python", float(bool(re.search(r"\w+Warning: ", run.errors))), 0.5, 0)
    if run.exit_code == 0:
        court.check("status", float(run.summary.get("status") not in DONE), 0.5, 0)
    if run.exit_code == 3:
        court.check("no reason", float(not re.search(r"crackgrow: \S+", run.errors)), 0.5, 0)
    solved = len(run.tables) == 6 and len(run.tables["steps"]) and run.exit_code in (0, 3)
    for check in CHECKS if solved else ():
        check(court)
    return court
