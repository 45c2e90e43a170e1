"""What a run goes on from after it was broken off: a step, to be solved again from where it came.

That is the cracks, and what the contact points remembered when the step began. It is far less than the solution, which
follows from it to the same bits. It becomes plain data (`Checkpoint`), for files that are read without running code.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

from numpy.typing import NDArray

from crackgrow.accuracy.companion import Errors, errors_of_record
from crackgrow.case.model import Case
from crackgrow.contact.coulomb import ContactMemory
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.debond import Debond, debond_on, debonds_of, names_of, place_of
from crackgrow.run.configuration import Excavated, LoadLevel
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.increments import Origin, Start
from crackgrow.run.result import Checkpoint, CrackPath, Energy, Event, event_of, event_record
from crackgrow.run.starting import new_crack

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
    factorizations: int | None = None  # of the step, where it was solved before
    doubts: tuple[str, ...] = ()  # on the advance that led to it
    errors: Errors | None = None  # with the grading of the cells that it was solved on
    time: float = 0.0  # s, at which the cracks have come here, where growth takes time; in fatigue cycles
    debonds: tuple[Debond, ...] = ()  # the cracked parts of interfaces that have a toughness

    def at_load(self, step: int) -> RunState:
        """About to make the result of a load without growth, which may be the one that it is at."""
        factorizations = self.factorizations if step == self.step else None
        return RunState(step, self.cracks, factorizations=factorizations, debonds=self.debonds)

    @property
    def paths(self) -> tuple[CrackPath, ...]:
        """The cracks as they lie, then the cracked parts of interfaces."""
        debonds = zip(names_of(self.debonds), self.debonds, strict=True)
        return (
            *(CrackPath(g.crack.name, g.crack.points, g.steps) for g in self.cracks),
            *(CrackPath(str(name), *debond.path) for name, debond in debonds),
        )


def beginning(case: Case) -> RunState:
    """Nothing is solved yet."""
    return RunState(0, tuple(map(GrowingCrack.given, case.cracks)), debonds=tuple(debonds_of(case)))


def packed(state: RunState, solution: StepSolution) -> Checkpoint:
    """The state whose step has this solution, as plain data."""
    origin, errors = solution.origin, solution.errors
    values: dict[str, Any] = {
        "events": [event_record(event) for event in state.events],
        "n_pieces": state.n_pieces,
        "factorizations": state.factorizations,
        "notes": list(solution.doubts),
        "guess": origin.guess,
        "cracks": [
            {
                "name": growing.crack.name,
                "body": growing.crack.body,
                "parent": growing.parent,
                "in_shear": growing.in_shear,
                "tips": [growing.crack.tip_at_start, growing.crack.tip_at_end],
                "gathered": list(growing.gathered),
            }
            for growing in state.cracks
        ],
        "debonds": [place_of(solution.scene.at_start.case, debond) for debond in solution.scene.debonds],
        "time": state.time,
        "start": None,
        "gone": [rock.body for rock in origin.excavated],
        "errors": None if errors is None else asdict(errors),
    }
    arrays: dict[str, NDArray[Any]] = {}
    for number, growing in enumerate(state.cracks):
        arrays[f"points{number}"], arrays[f"steps{number}"] = growing.crack.points, growing.steps
    for number, debond in enumerate(solution.scene.debonds):
        arrays[f"debond{number}"], arrays[f"debond_steps{number}"] = debond.at, debond.steps
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
    cracks: list[GrowingCrack] = []
    for number, its in enumerate(values["cracks"]):
        name, body, parent = its["name"], its["body"], its["parent"]
        started = number >= len(case.cracks)
        crack = new_crack(case, cracks, name, body, parent) if started else case.cracks[number]
        first, last = its["tips"]
        crack = replace(crack, points=arrays[f"points{number}"], tip_at_start=first, tip_at_end=last)
        at_start, at_end = its["gathered"]
        cracks.append(GrowingCrack(crack, arrays[f"steps{number}"], parent, its["in_shear"], (at_start, at_end)))
    start = None
    if (of_start := values["start"]) is not None:
        own = {name.removeprefix(START): array for name, array in arrays.items() if name.startswith(START)}
        level, energy = LoadLevel(of_start["factor"], of_start["holding"]), Energy(**of_start["energy"])
        conjugates, grown = own.pop("conjugates"), of_start["grown"]
        start = Start(level, ContactMemory(**own), energy, conjugates, of_start["round_off"], grown=grown)
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
        tuple(
            debond_on(case, place, arrays[f"debond{number}"], arrays[f"debond_steps{number}"])
            for number, place in enumerate(values["debonds"])
        ),
    )
