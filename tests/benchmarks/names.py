"""The error that a run by a name states, on scenes whose K is known: what it was worth, and what it cost.

python -m tests.benchmarks.names                all scenes at draft, standard and fine: names.md
python -m tests.benchmarks.names --only grown   those of scenes whose name has the word, printed
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from crackgrow.case.accuracy import PRESETS
from tests.benchmarks.paths import HERE
from tests.benchmarks.tables import number, table
from tests.benchmarks.target_scenes import SCENES
from tests.benchmarks.targets import Pair, counts_of, measured, truth_of

TEXT = HERE / "names.md"
KEPT = (
    "pairs",
    "true error within the bound",
    "pairs whose truth is good enough to judge what is expected",
    "of them expected over error in the median",
    "of them within a half and twice",
    "cost in the median",
    "cost in nine of ten pairs at most",
)
WORDS = """# The error that a run by a name states

Written by `python -m tests.benchmarks.names`: the scenes of [targets.md](targets.md), one step each. Error: the worst
tip, K_I and K_II together, over the largest K; expected and bound: the same of what the run states. Cost is the CPU of
the step over that of the same step whose error is not measured. A run with growth measures now and then: of 22 steps
of `compression30` five.
"""
HEADER = (
    "scene", "kind", "name", "unknowns", "CPU s", "error, %", "expected, %", "bound, %", "expected over error", "cost",
)  # fmt: skip


def pairs_of(scene: str) -> dict[str, Pair]:
    """The scene at every name."""
    truth = truth_of(scene)
    return {name: measured(scene, name, truth) for name in PRESETS}


def row(name: str, pair: Pair) -> list[str]:
    """A line of the table."""
    percents = [number(100.0 * value) for value in (pair.error, pair.expected, pair.bound)]
    size = [f"{pair.unknowns:,}", f"{pair.seconds:.1f}"]
    return [
        pair.scene, SCENES[pair.scene].kind, name, *size, *percents, number(pair.effectivity),
        number(pair.cost),
    ]  # fmt: skip


def text_of(scenes: Sequence[dict[str, Pair]]) -> str:
    """What it comes to, name by name, and the table."""
    counts = {name: counts_of([pairs[name] for pairs in scenes]) for name in PRESETS}
    summary = [[what, *(counts[name][what] for name in PRESETS)] for what in KEPT]
    lines = [row(*pair) for pairs in scenes for pair in pairs.items()]
    return f"{WORDS}\n{table(('what', *PRESETS), summary)}\n{table(HEADER, lines)}"


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", default="")
    only = parser.parse_args().only
    scenes = []
    for scene in SCENES:
        if only in scene:
            scenes.append(pairs_of(scene))
            print(*(" ".join(row(*pair)) for pair in scenes[-1].items()), sep="\n", flush=True)
    if not only:
        TEXT.write_text(text_of(scenes))


if __name__ == "__main__":
    main()
