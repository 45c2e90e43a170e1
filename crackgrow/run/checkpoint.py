"""What a run goes on from after it was broken off: a step, to be solved again from where it came.

That is the cracks, and what the contact points remembered when the step began. It is far less than the solution, which
follows from it to the same bits. It becomes plain data (`Checkpoint`), for files that are read without running code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from numpy.typing import NDArray

from crackgrow.accuracy.companion import Errors, errors_of_record, record_of
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import ContactMemory
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Excavated
from crackgrow.run.increments import FROM_REST, Origin, Start
from crackgrow.run.load_level import LoadLevel
from crackgrow.run.result import Checkpoint, Energy, Event, event_of, event_record
from crackgrow.run.starting import new_crack

Arrays = Mapping[str, NDArray[Any]]

START = "start_"
"""What names of the arrays of a start begin with."""


@dataclass(frozen=True, slots=True, eq=False)
class RunState:
    """A run that is about to make the result of a step."""

    step: int
    cracks: tuple[GrowingCrack, ...]
    events: tuple[Event, ...] = ()  # of the advance that has made the cracks
    n_pieces: int = 0  # of rock at the start; 0: not counted yet
    origin: Origin | None = None  # of the step's solution; None: there is none yet
    factorizations: int = 1  # of the step, rejected directions of growth included
    notes: tuple[str, ...] = ()  # on how its solution was found
    errors: Errors | None = None  # with the grading of the cells that it was solved on
    time: float = 0.0  # s, at which the cracks have come here, where growth takes time


def beginning(case: Case) -> RunState:
    """Nothing is solved yet."""
    return RunState(0, tuple(map(GrowingCrack.given, case.cracks)))


def packed(state: RunState) -> Checkpoint:
    """The state as plain data."""
    origin = state.origin or FROM_REST
    values: dict[str, Any] = {
        "events": [event_record(event) for event in state.events],
        "n_pieces": state.n_pieces,
        "factorizations": state.factorizations,
        "notes": list(state.notes),
        "guess": origin.guess,
        "tips": [[g.crack.tip_at_start, g.crack.tip_at_end] for g in state.cracks],
        "started": [[g.crack.name, g.crack.body, g.parent, g.in_shear] for g in state.cracks if g.steps.min() > 0],
        "gathered": [list(g.gathered) for g in state.cracks],
        "time": state.time,
        "start": None,
        "gone": [rock.body for rock in origin.excavated],
        "errors": None if state.errors is None else record_of(state.errors),
    }
    arrays: dict[str, NDArray[Any]] = {}
    for number, growing in enumerate(state.cracks):
        arrays[f"points{number}"], arrays[f"steps{number}"] = growing.crack.points, growing.steps
    if origin.start is not None:
        start = origin.start
        values["start"] = {
            **start.level._asdict(), "grown": start.grown, "energy": asdict(start.energy), "round_off": start.round_off
        }  # fmt: skip
        of_start = {**start.memory.arrays, "conjugates": start.conjugates}
        arrays.update({f"{START}{name}": array for name, array in of_start.items()})
    arrays.update({f"gone{number}": rock.forces for number, rock in enumerate(origin.excavated)})
    return Checkpoint(state.step, values, arrays)


def restored(case: Case, checkpoint: Checkpoint) -> RunState:
    """The state that was packed in an earlier run of the case."""
    values, arrays = checkpoint.values, checkpoint.arrays
    cracks = list(map(GrowingCrack.given, case.cracks))
    for name, body, parent, in_shear in values["started"]:
        new = GrowingCrack.given(new_crack(case, cracks, name, body, parent))
        cracks.append(replace(new, parent=parent, in_shear=in_shear))
    for number, (growing, tips) in enumerate(zip(cracks, values["tips"], strict=True)):
        crack = replace(growing.crack, points=arrays[f"points{number}"], tip_at_start=tips[0], tip_at_end=tips[1])
        cracks[number] = replace(growing, crack=crack, steps=arrays[f"steps{number}"])
    for number, lengths in enumerate(values["gathered"]):
        cracks[number] = replace(cracks[number], gathered=tuple(lengths))
    start = None if values["start"] is None else _start(values["start"], arrays)
    excavated = tuple(Excavated(body, arrays[f"gone{number}"]) for number, body in enumerate(values["gone"]))
    return RunState(
        checkpoint.step,
        tuple(cracks),
        tuple(event_of(record) for record in values["events"]),
        values["n_pieces"],
        Origin(values["guess"], start, excavated),
        values["factorizations"],
        tuple(values["notes"]),
        None if values["errors"] is None else errors_of_record(values["errors"]),
        values["time"],
    )


def _start(values: Mapping[str, Any], arrays: Arrays) -> Start:
    own = {name.removeprefix(START): array for name, array in arrays.items() if name.startswith(START)}
    conjugates = own.pop("conjugates")
    return Start(
        LoadLevel(values["factor"], values["holding"]),
        ContactMemory(**own),
        Energy(**values["energy"]),
        conjugates,
        values["round_off"],
        values["grown"],
    )
