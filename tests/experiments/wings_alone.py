"""The pairs of flaws of `flaw_pairs` with wings alone: the critical load of each increment, and what they meet.

    python -m tests.experiments.wings_alone

Writes wings_alone.md beside this file (ten minutes).
"""

from __future__ import annotations

from pathlib import Path

from crackgrow.run import grow
from tests.experiments import flaw_pairs

FRICTION = 0.6
INCREMENTS = 24
SETTINGS = (
    "growth.initiation=tips",
    "growth.increment=2",
    "growth.link_distance=1",
    f"growth.steps={INCREMENTS}",
    "loading=critical",
)
STRENGTH = 2.09  # MPa: what the rock bears in compression

HEAD = f"""# Wings alone

Made by `python -m tests.experiments.wings_alone`: the pairs of flaws of [flaw_pairs.md](flaw_pairs.md), where cracks go
on at their tips only, at the critical load of each of {INCREMENTS} increments of 2 mm. Loads are in MPa.

A wing of a closed flaw takes more load the longer it gets (K_I falls with its length), until it feels the other flaw.
With the values of the tests (K_Ic 0.0443 MPa sqrt(m), flaws of 12 mm, friction {FRICTION}) that is more than the
{STRENGTH} MPa that the rock bears in compression: by linear elastic fracture mechanics no pair links by wings alone
below its strength. At 105 degrees they link, as in the tests, but at a load that the tests have not reached.

"""


def row(angle: int) -> str:
    """The line of a pair in the table."""
    loads, met = [], ""
    for result in grow(flaw_pairs.scene(angle, FRICTION, 1.0).with_(*SETTINGS)):
        loads.append(result.load_factor)
        met = ", ".join(event.met for event in result.events)
        if met:
            break
    print(angle, [round(load, 2) for load in loads], met, flush=True)
    first = f"{loads[0]:.2f} | {loads[1]:.2f} | {max(loads):.2f}"
    return f"| {angle} | {flaw_pairs.MEASURED[angle]} | {first} | {len(loads) - 1} | {met or 'nothing'} |"


def main() -> None:
    """Solve all pairs, and write the table."""
    titles = "| bridge | tests | first increment | second | largest load | increments | met |"
    lines = [titles, "|---|---|---|---|---|---|---|", *(row(angle) for angle in flaw_pairs.MEASURED)]
    (Path(__file__).parent / "wings_alone.md").write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
