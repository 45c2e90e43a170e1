"""Short runs whose reports are looked at."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from itertools import islice
from pathlib import Path

from PIL import Image

from crackgrow.errors import SolveError
from crackgrow.results.writer import RunWriter
from crackgrow.run import grow
from crackgrow.run.loop import for_each
from crackgrow.run.result import RunEnd, StepResult
from tests.scenes import shipped_case

CASES = Path(__file__).resolve().parents[1] / "cases"
COARSE = ("numerics.spacing=4", "growth.steps=3", "output.frames=none", "output.figures=false")
HOSTILE = '<script>document.title = "owned"</script> & "quotes" </title>'


def make_run(folder: Path, overrides: Sequence[str] = (), failing: str = "", case: str = "compression30") -> Path:
    """Run a coarse scene into a folder; with `failing`, break it off for this reason after its second step."""
    scene = shipped_case(case, [*COARSE, *overrides])
    writer = RunWriter(scene, folder)
    writer.begin()
    try:
        writer.finish(for_each(broken_off(grow(scene), failing) if failing else grow(scene), writer.add))
    except SolveError as error:
        writer.break_off(error)
    return folder


def broken_off(steps: Generator[StepResult, None, RunEnd], reason: str) -> Generator[StepResult, None, RunEnd]:
    """The first two steps, then the failure."""
    yield from islice(steps, 2)
    raise SolveError(reason)


def paint(folder: Path, steps: Sequence[int], size: tuple[int, int] = (60, 90)) -> None:
    """Pictures as `crackgrow render` leaves them, a shade of grey for each step."""
    (folder / "render" / "sigma_1").mkdir(parents=True)
    for step in steps:
        Image.new("RGB", size, (40 * step % 256,) * 3).save(folder / "render" / "sigma_1" / f"step_{step:04d}.png")
