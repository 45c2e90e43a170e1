"""What a step costs: a small model, fitted to measurements (tests/benchmarks/cost.py writes its table, cost.json).

Seconds and memory are sums of positive terms in N = dofs / 10^4, S, the same of the tip functions alone, R = N - S,
contact points and tips; S^2/R is what all tip functions over an element make with each other. The terms are those of a
support of 2; where other ones have more or fewer patches meet on an element, N, R and S count for more or less. Seconds
are those of the machine of the measurements, times how much longer a probe takes here.

`outlook` guesses them from lengths and areas alone, before anything is laid out.
"""

from __future__ import annotations

import json
import os
import time
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.blas import single_threaded
from crackgrow.case.accuracy import AUTO, preset_of
from crackgrow.case.features import line_length
from crackgrow.case.model import Case, Crack, CriticalLoad, LoadHistory, Stages
from crackgrow.cover.gathered import RADIUS
from crackgrow.limits import allowed
from crackgrow.plan.overview import estimated_nodes
from crackgrow.plan.sizes import Sizes
from crackgrow.results.units import duration, memory_text
from crackgrow.run.aim import measures_by_name
from crackgrow.run.checkpoint import beginning
from crackgrow.run.layout import cells_of
from crackgrow.run.scene import halvings_at_first, make_scene

TERMS: Final = ("1", "N", "N^1.5", "S", "S^2/R", "contact", "contact N^0.5", "tips", "critical contact", "held N",
         "halved")  # fmt: skip
LATER_TERMS: Final = (*TERMS, "advancing", "advancing, halved")
MEMORY_TERMS: Final = ("1", "N", "N^1.25", "S", "S^2/R", "held N")
STATIC_SHARE: Final = 0.03  # of the first step that another load factor on the same cracks takes
IMPLICIT_SOLVES: Final = 3.0  # of a step whose direction is corrected at the new tip
WITH_OTHER: Final = 1.5  # of memory: the cells of a name, and those that K is held against
WITH_OTHER_OF_TARGET: Final = (4.0, 6.0)  # over that of a target's first cells: those of all rounds; kinks in growth
MEASURED: Final = 1.9  # of the CPU of a step: with K held against other cells (tests/benchmarks/names.md)
PROBE_SIZE, PROBE_REPEATS = 260, 7
USUAL_PAIRS = 115.0  # of patches on an element, by the dofs of the patches, at a support of 2
USUAL_PAIRS_HERE = 256.0  # on each element
CONTAINER_MEMORY = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))  # bytes
CROWDING = 0.6  # power of the pairs that seconds grow with: supports of 1.5 to 3 in compression30 and two_flaws

CARRIERS_AT_A_TIP: Final = (16, 3)  # of its functions: one for each patch, or gathered
CELLS_TO_GATHER: Final = RADIUS + 4.0  # that a crack is long: so far round each of its tips patches reach, about
SPACINGS_OF_A_POINT: Final = 2.0  # along a crack, of contact points
CUT_MORE: Final = 0.3  # of elements, where cells of several sizes meet
MEET_MORE: Final = 0.6  # of pairs of patches on an element there
MOST_SHARE: Final = 0.9  # of the machine's memory: others need some, too


@dataclass(frozen=True, slots=True)
class Cost:
    """An estimate, good within a factor of two."""

    first_step: float  # s of CPU
    later_step: float  # s of CPU, of each
    n_later: int  # steps after the first one
    memory: float  # MiB, at most

    @property
    def total(self) -> float:
        """Seconds of CPU of the whole run, without files and pictures."""
        return self.first_step + self.n_later * self.later_step

    @property
    def words(self) -> str:
        """The seconds of the first step, and of the others."""
        later = f", {duration(self.later_step, 2)} each of {self.n_later} more" if self.n_later else ""
        return f"{duration(self.first_step, 2)} of CPU for the first step{later}"

    def memory_warning(self, share: float) -> str:
        """What to say where the run takes more than a share of the memory of this machine; empty where it does not."""
        available = machine_memory()
        if self.memory <= share * available:
            return ""
        return (
            f"the run needs about {memory_text(self.memory)} of memory, and this machine has {memory_text(available)}: "
            "it would be killed or stand still; use a larger numerics.spacing, a smaller specimen, or "
            "numerics.accuracy draft"
        )


def estimated_cost(case: Case, sizes: Sizes) -> Cost:
    """What a run of the case will take on this machine; measures the machine for a moment, the first time."""
    table = json.loads((files("crackgrow.plan") / "cost.json").read_text(encoding="utf-8"))
    slower, terms = _probe_here() / table["probe"], terms_of(case, sizes)
    static = case.growth is None and isinstance(case.loading, LoadHistory | Stages)
    history = case.last_step + 1 if static else 1
    share = 1.0 if isinstance(case.loading, Stages) else STATIC_SHARE
    plain, later = slower * float(terms @ table["first"]), slower * float(later_terms_of(case, sizes) @ table["later"])
    held_first, held_later = held_against(case, sizes)
    first, later = (1.0 + held_first) * plain, later + held_later * plain
    return Cost(
        first_step=first,
        later_step=share * first if case.growth is None else later,
        n_later=case.growth.steps if case.growth is not None else history - 1,
        memory=float(memory_terms_of(case, sizes) @ table["memory"]),
    )


def _is_held(case: Case, sizes: Sizes) -> bool:
    """Whether K is held against that of other cells."""
    return sizes.n_tips > 0 and (case.numerics.target is not None or measures_by_name(case, sizes.n_dofs))


def held_against(case: Case, sizes: Sizes) -> tuple[float, float]:
    """What it takes to hold K against that of other cells: in the first step, and in each later one in the mean.

    In parts of the first step without it. It is done each time that what has grown is twice as long.
    """
    n = 0 if case.growth is None else case.growth.steps
    more = MEASURED - 1.0 if _is_held(case, sizes) else 0.0
    return more, more * ((n + 1).bit_length() - 1) / max(n, 1)


def terms_of(case: Case, sizes: Sizes) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The values (11,) of TERMS, each the larger the more patches meet on an element."""
    n, s, contact = sizes.n_dofs / 1e4, _singular(sizes), sizes.n_contact / 100
    critical = isinstance(case.loading, CriticalLoad)
    touching = [contact, contact * n**0.5, sizes.n_tips / 10, contact * critical, _held_first(case) * n]
    crowding = float((sizes.n_pairs / (2 * sizes.n_patches * USUAL_PAIRS)) ** CROWDING)
    return crowding * np.array([1.0, n, n**1.5, s, s**2 / (n - s), *touching, sizes.n_halved / 1e4])


def later_terms_of(case: Case, sizes: Sizes) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The values (13,) of LATER_TERMS: each tip that advances leaves a kink, with small cells round it or not."""
    growth = case.growth
    one, implicit = growth is None or growth.advance != "all", growth is not None and growth.direction == "implicit"
    advancing = (min(sizes.n_tips, 1) if one else sizes.n_tips) / 10
    solves = IMPLICIT_SOLVES if implicit else 1.0
    return solves * np.append(terms_of(case, sizes), [advancing, advancing * (sizes.n_halved > 0)])


def memory_terms_of(case: Case, sizes: Sizes) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The values (6,) of MEMORY_TERMS: the first one is the program itself, the others grow with what patches make."""
    n, s = sizes.n_dofs / 1e4, _singular(sizes)
    parts = np.array([n, n**1.25, s, s**2 / (n - s), _held_first(case) * n])
    return np.append(1.0, _with_other(case, sizes) * parts * sizes.n_pairs / (sizes.n_elements * USUAL_PAIRS_HERE))


def _with_other(case: Case, sizes: Sizes) -> float:
    """How many times the memory of the first cells is taken, as K is held against that of others."""
    if not _is_held(case, sizes):
        return 1.0
    grows = case.growth is not None and case.growth.steps > 0
    return WITH_OTHER if case.numerics.target is None else WITH_OTHER_OF_TARGET[grows]


def _held_first(case: Case) -> bool:
    """Whether held loads act alone at first, and the others in parts: those that friction has to remember."""
    laws = [crack.contact for crack in case.cracks]
    rough = any(law is not None and law.friction > 0.0 for law in laws)
    return case.growth is not None and rough and any(load.held for load in case.loads)


def _singular(sizes: Sizes) -> float:
    """S: dofs / 10^4 of the tip functions, of which many meet on an element where tips are close."""
    return 8 * sizes.n_singular / 1e4


def machine_memory() -> float:
    """MiB that a program on this machine can have: what is built in, or allowed to it or to its container."""
    most = [allowed("AS"), allowed("DATA")]
    if hasattr(os, "sysconf"):
        most.append(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    texts = (path.read_text(encoding="ascii").strip() for path in CONTAINER_MEMORY if path.is_file())
    most += [int(text) for text in texts if text.isdigit()]  # "max" where there is no limit
    return min(most) / 2**20


def probe() -> float:
    """CPU seconds of some small dense factorizations and a loop: how slow the machine is, in a few hundredths."""
    matrix = np.eye(PROBE_SIZE) * PROBE_SIZE + np.ones((PROBE_SIZE, PROBE_SIZE))
    found = []
    with single_threaded():  # as a step is solved: threads that wait for each other take CPU time, too
        for _ in range(PROBE_REPEATS):
            start = time.process_time()
            np.linalg.cholesky(matrix)
            sum(k * k for k in range(20_000))
            found.append(time.process_time() - start)
    return min(found)


@cache
def _probe_here() -> float:
    """The probe of this machine, taken once: estimates of one process differ by what is estimated, not by noise."""
    return probe()


@dataclass(frozen=True, slots=True)
class Outlook:
    """How large the first step is, about, and what the run takes."""

    n_dofs: int
    cost: Cost

    @property
    def words(self) -> str:
        """What to expect, on a line."""
        return f"about {memory_text(self.cost.memory)} of memory, {self.cost.words}"

    @property
    def needs(self) -> str:
        """How large it is, and the memory that it takes."""
        return f"about {self.n_dofs} dofs, {memory_text(self.cost.memory)} of memory"

    @property
    def warning(self) -> str:
        """What to say where the machine has less memory than that; empty where it has enough."""
        return self.cost.memory_warning(MOST_SHARE)


def outlook(case: Case) -> Outlook:
    """What a run of the case is about to take; good to a factor of two, and made in hundredths of a second."""
    support, spacing = case.numerics.support, case.numerics.spacing
    uniform, more = estimated_nodes(case), _n_halved(case)
    nodes = uniform + more
    share = more / nodes  # of cells among others of another size: more of them are cut, more patches meet on each
    tips = sum(crack.tip_at_start + crack.tip_at_end for crack in case.cracks)
    tiles = 1 if support % 1.0 == 0.0 else 4 if support % 0.5 == 0.0 else 9  # of a cell, cut by the edges of patches
    elements = round(nodes * tiles * (1.0 + CUT_MORE * share))
    pairs = round(elements * (2.0 * support) ** 4 * (1.0 + MEET_MORE * share))
    halvings = halvings_at_first(case)
    singular = sum(_carriers(case, crack, halvings.at_tips(number)) for number, crack in enumerate(case.cracks))
    lines = [crack.points for crack in case.cracks if crack.contact is not None]
    lines += [line for interface in case.interfaces for line in interface.lines]
    length = sum(map(line_length, lines))
    points = round(length / (SPACINGS_OF_A_POINT * spacing))
    n_dofs = 2 * nodes + 8 * singular
    cells = ((spacing, uniform), (0.5 * spacing, more))
    sizes = Sizes(n_dofs, nodes, singular, tips, elements, pairs, points, 0, (), (), cells=cells)
    return Outlook(n_dofs, estimated_cost(case, sizes))


def _carriers(case: Case, crack: Crack, halvings: int) -> int:
    """Of the functions of a crack's tips, at which cells are halved so often for a target."""
    numerics, cells = case.numerics, line_length(crack.points) / case.numerics.spacing
    if numerics.refine.tips != AUTO:
        halvings = max(halvings, numerics.refine.tips)
    elif numerics.target is None:
        halvings = max(int(np.ceil(np.log2(preset_of(numerics.accuracy).per_crack / cells))), 0)
    cells *= 2.0**halvings
    gathers = numerics.gathers_tip_functions and bool(cells >= CELLS_TO_GATHER)
    return CARRIERS_AT_A_TIP[gathers] * (crack.tip_at_start + crack.tip_at_end)


def _n_halved(case: Case) -> int:
    """How many cells more there are since some are halved."""
    refine = case.numerics.refine
    if (refine.tips, refine.kinks, refine.corners) == (0, 0, 0):
        return 0  # a lattice of many cells is not laid out to learn that
    scene = make_scene(case)
    return cells_of(scene, beginning(scene.case).cracks).n - scene.lattice.cells.n
