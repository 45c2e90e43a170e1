"""The CSV tables: one header, rows that grow with the steps, numbers in full precision."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from zlib import crc32

from crackgrow.results import declarations
from crackgrow.results.atomic import append_text, write_text
from crackgrow.results.declarations import PHASES
from crackgrow.run.result import STATE_NAMES, CrackPath, Event, History, StepResult

Value = str | bool | int | float

TIPS = declarations.TIPS.header
PATHS = declarations.PATHS.header
CONTACT = declarations.CONTACT.header
EVENTS = declarations.EVENTS.header
REACTIONS = declarations.REACTIONS.header
STEPS = declarations.STEPS.header


Mark = tuple[int, int]
"""How far a table goes: number of bytes, and their CRC-32."""


class Table:
    """Rows in memory and on disk: the file is complete after every `write`, which appends what is new."""

    def __init__(self, path: Path, columns: Sequence[str]) -> None:
        self.path = path
        self.mark: Mark = (0, 0)  # of the file as it was written last
        self._lines = [",".join(columns)]
        self._n_written = 0  # lines on disk as they are here

    def extend(self, rows: Iterable[Sequence[Value]]) -> None:
        """Append rows, values in the order of the columns."""
        self._lines.extend(",".join(format_value(value) for value in row) for row in rows)

    def replace_last(self, row: Sequence[Value]) -> None:
        """Replace the last row."""
        self._lines[-1] = ",".join(format_value(value) for value in row)
        self._n_written = 0

    def write(self) -> None:
        """Bring the file up to date; raises OutputError."""
        new = "".join(f"{line}\n" for line in self._lines[self._n_written :])
        if self._n_written and append_text(self.path, new):
            before = self.mark
        else:
            before, new = (0, 0), "\n".join(self._lines) + "\n"
            write_text(self.path, new)
        self._n_written = len(self._lines)
        data = new.encode()
        self.mark = (before[0] + len(data), crc32(data, before[1]))

    def cut(self, mark: Sequence[int]) -> None:
        """Take over what the file has up to a mark that fits, and drop the rest; raises OutputError."""
        self._lines = self.path.read_bytes()[: mark[0]].decode().removesuffix("\n").split("\n")
        self._n_written = 0
        self.write()


def fits(path: Path, mark: Sequence[int]) -> bool:
    """Whether a file begins as a table did that had this mark."""
    data = path.read_bytes()[: mark[0]] if path.is_file() else b""
    return (len(data), crc32(data)) == tuple(mark)


def format_value(value: Value) -> str:
    """One cell: the shortest text that reads back to the same float; true and false; text quoted where it must be."""
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"' if any(sign in value for sign in ',"\n\r') else value
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, float) else str(int(value))


def csv_text(columns: Sequence[str], rows: Iterable[Iterable[Value | None]]) -> str:
    """A whole table, as studies write theirs: empty where there is no value, and for nan."""
    lines = [columns, *([_or_empty(value) for value in row] for row in rows)]
    return "".join(",".join(format_value(value) for value in line) + "\n" for line in lines)


def _or_empty(value: Value | None) -> Value:
    return "" if value is None or value != value else value  # nan alone is not itself


def tip_rows(result: StepResult) -> list[tuple[Value, ...]]:
    """Rows of tips.csv: m, Pa, Pa sqrt(m), degrees; the point is the tip before its advance."""
    return [
        (
            int(result.step),
            tip.crack,
            tip.tip,
            *(float(coordinate) for coordinate in tip.point),
            float(tip.K_I),
            float(tip.K_II),
            float(tip.sigma_1),
            float(tip.sigma_3),
            tip.criterion,
            float(tip.kink_deg),
            bool(tip.advanced),
            float(result.load_factor),
            float(tip.K_I_error),
            float(tip.K_II_error),
            float(tip.K_radius),
            tip.K_note,
            float(tip.K_I_faces),
            float(tip.K_II_faces),
            float(tip.K_I_spread),
            float(tip.K_II_spread),
            float(tip.cell_size),
            float(tip.kink_error_deg),
            float(tip.velocity),
            float(tip.K_error_expected),
        )
        for tip in result.tips
    ]


def path_rows(cracks: Iterable[CrackPath]) -> list[tuple[Value, ...]]:
    """Rows of paths.csv: vertices from start to end, m, with the step whose advance made them."""
    return [
        (crack.name, vertex, x, y, step)
        for crack in cracks
        for vertex, ((x, y), step) in enumerate(zip(crack.points.tolist(), crack.steps.tolist(), strict=True))
    ]


def contact_rows(result: StepResult) -> list[tuple[Value, ...]]:
    """Rows of contact.csv: m and Pa, state as a word."""
    contact = result.contact
    numbers = (contact.normal_traction, contact.tangential_traction, contact.opening, contact.slip)
    columns = zip(
        contact.crack,
        contact.s.tolist(),
        contact.points.tolist(),
        *(values.tolist() for values in numbers),
        contact.state.tolist(),
        contact.mean_opening.tolist(),
        contact.mean_slip.tolist(),
        strict=True,
    )
    return [
        (int(result.step), crack, s, x, y, normal, tangential, opening, slip, STATE_NAMES[state], *means)
        for crack, s, (x, y), normal, tangential, opening, slip, state, *means in columns
    ]


def reaction_rows(result: StepResult) -> list[tuple[Value, ...]]:
    """Rows of reactions.csv: N per metre of thickness, on the rock; of an interface on its first body."""
    return [(int(result.step), item.where, *item.force, float(result.load_factor)) for item in result.reactions]


def history_columns(history: History) -> tuple[str, ...]:
    """Columns of history.csv, those of the case's own points and reactions among them."""
    return ("step", "increment", "load_factor", *history.columns)


def history_rows(result: StepResult) -> list[tuple[Value, ...]]:
    """Rows of history.csv: the increments of a step in turn, the last one being the step's."""
    history = result.history
    if history is None:
        return []
    rows = zip(history.load_factor.tolist(), history.values.tolist(), strict=True)
    return [(int(result.step), number, factor, *values) for number, (factor, values) in enumerate(rows)]


def event_rows(events: Iterable[Event]) -> list[tuple[Value, ...]]:
    """Rows of events.csv: the step whose advance made the event, the place in m."""
    return [
        (int(event.step), event.kind, event.crack, event.tip, *(float(x) for x in event.point), event.met)
        for event in events
    ]


def step_row(result: StepResult, seconds_frames: float) -> tuple[Value, ...]:
    """The row of steps.csv; `seconds_frames` is what writing the step's frames took, added to the output phase."""
    seconds = {phase: float(result.seconds.get(phase, 0.0)) for phase in PHASES}
    seconds["output"] += seconds_frames
    energy = result.energy
    return (
        int(result.step),
        int(result.n_dofs),
        int(result.n_contact),
        int(result.contact_iterations),
        int(result.factorizations),
        float(result.residual),
        float(result.penetration),
        *seconds.values(),
        float(result.load_factor),
        result.contact_status,
        float(result.complementarity),
        float(result.overlap),
        float(energy.work),
        float(energy.strain),
        float(energy.dissipated),
        float(energy.released),
        float(energy.error),
        float(result.load_displacement),
        float(result.crack_length),
        float(result.overlap_share),
        float(result.load_factor_error),
        float(result.goal_error),
        float(result.time),
    )
