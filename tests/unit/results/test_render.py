"""Pictures of frames: one scale for all, sizes, limits of colours, animations, and what is refused."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from crackgrow import cli
from crackgrow.errors import CaseError
from crackgrow.results import field_picture, render, view
from crackgrow.results.atomic import OutputError
from crackgrow.results.drawn_frame import drawn_frame
from crackgrow.results.field_picture import Look
from crackgrow.results.folder import FolderError, open_run
from tests.report_runs import make_run

pytestmark = pytest.mark.physics


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of four steps with frames."""
    settings = ["output.frames=every_step", "output.fields=[displacement, stress, energy_error]"]
    return make_run(tmp_path_factory.mktemp("run"), settings)


def pixels(path: Path) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=np.int64)


def test_every_frame_is_drawn_in_the_size_asked_for_and_in_one_scale(folder: Path, tmp_path: Path) -> None:
    drawn = list(render.render(folder, look=Look(size=(600, 840)), out=tmp_path))
    assert drawn == [tmp_path / "sigma_1" / f"step_{step:04d}.png" for step in range(4)]
    first, *others, last = (pixels(path) for path in drawn)
    for picture in (first, *others, last):
        assert picture.shape == (840, 600, 3)
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 30
    bar = slice(470, 600)  # right of the specimen: its colour bar, and what that says
    np.testing.assert_array_equal(first[60:, bar], last[60:, bar])
    assert (first[60:, :470] != last[60:, :470]).any()


def test_earlier_pictures_of_the_field_go_and_others_stay(folder: Path, tmp_path: Path) -> None:
    list(render.render(folder, steps=[0, 3], look=Look(size=(200, 280)), out=tmp_path))
    list(render.render(folder, "sigma_3", steps=[0], look=Look(size=(200, 280)), out=tmp_path))
    (tmp_path / "sigma_1" / "own.png").write_text("mine")
    list(render.render(folder, steps=[1], look=Look(size=(200, 280)), out=tmp_path))
    left = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.png"))
    assert left == ["sigma_1/own.png", "sigma_1/step_0001.png", "sigma_3/step_0000.png"]


@pytest.mark.parametrize(("field", "steps", "told"), [
    ("sigma_1", [0, 7, 9], r"has no frame of step 7, 9; it has those of 0 to 3$"),
    # as numbers they would take memory, and the screen
    ("sigma_1", [range(2, 10_000), range(5000, 10**9), 2 * 10**9],
     r"has no frame of step 4 to 999999999, 2000000000; it has those of 0 to 3$"),
    ("sigma_2", None, r"no field 'sigma_2'; it has displacement, stress_xx, .*sigma_3"),
])  # fmt: skip
def test_what_is_not_there_is_refused(
    field: str, steps: list[int | range] | None, told: str, folder: Path, tmp_path: Path
) -> None:
    with pytest.raises(FolderError, match=told):
        list(render.render(folder, field, steps=steps, out=tmp_path))


def test_a_run_without_frames_has_a_report_but_no_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = make_run(tmp_path / "run", ["growth.steps=0", "output.report=false"])
    assert not (run / "report.html").exists()
    assert cli.main(["report", str(run)]) == 0
    assert capsys.readouterr().out == f"{run / 'report.html'}\n"
    assert (run / "report.html").is_file()
    with pytest.raises(FolderError, match=r"no frames to draw: run the case with output\.frames=every_step"):
        list(render.render(run))


def test_mp4_is_made_by_ffmpeg_and_refused_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Image.new("RGB", (31, 21)).save(tmp_path / "0.png")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cli.main(["render", str(tmp_path), "--mp4"]) == 3  # before anything is read
    assert "an MP4 needs ffmpeg, which is not found" in capsys.readouterr().err
    program = tmp_path / "ffmpeg"  # a stand-in: writes what it is given to its last argument, or fails
    program.write_text(
        f"#!{sys.executable}\nimport sys\nframes = sys.stdin.buffer.read()\n"
        "open(sys.argv[-1], 'wb').write(frames)\nsys.exit('bad frame' if len(frames) > 1000 else 0)\n"
    )
    program.chmod(0o755)
    render.write_mp4(tmp_path / "a.mp4", [tmp_path / "0.png"] * 2)
    assert (tmp_path / "a.mp4").read_bytes() == 2 * (tmp_path / "0.png").read_bytes()
    with pytest.raises(OutputError, match=r"cannot write .*b\.mp4: ffmpeg: bad frame"):
        render.write_mp4(tmp_path / "b.mp4", [tmp_path / "0.png"] * 50)
    assert not (tmp_path / "b.mp4").exists()


def test_view_without_a_display_says_what_to_do(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(view.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    words = f"no display to open a window on: `crackgrow render {folder}`"
    with pytest.raises(view.NoDisplayError, match=words) as told:
        view.view(folder)
    assert told.value.exit_code == 3


@pytest.mark.parametrize(("limits", "told"), [
    (("5", "-20"), "is not less than '-20'; wanted: the lower limit first"),
    (("0", "5 mm"), "'5 mm' has a unit of length; wanted: a number, in MPa, or with a unit such as 'MPa'"),
    (("nan", "5"), "'nan' is not finite"),
])  # fmt: skip
def test_limits_that_a_field_cannot_have_are_refused(limits: tuple[str, str], told: str) -> None:
    with pytest.raises(CaseError, match=re.escape(told)):
        field_picture.limits_of("sigma_1", limits, (1e6, "MPa"))


@pytest.mark.parametrize(("limits", "wanted", "signed"), [
    (("-2", "1000 kPa"), (-2e6, 1e6), False),  # in the unit of the bar, MPa, or with one
    (("-2 MPa", "2 MPa"), (-2e6, 2e6), True),
    (("0 MPa", "5 MPa"), (0.0, 5e6), False),
])  # fmt: skip
def test_colours_end_at_the_limits_and_white_between_two_of_them_is_zero(
    folder: Path, limits: tuple[str, str], wanted: tuple[float, float], signed: bool
) -> None:
    frame = drawn_frame(open_run(folder), 2, "sigma_1")
    both = replace(frame, values=np.linspace(-1e7, 1e7, len(frame.values)))
    pictures = field_picture.FieldPictures("", "sigma_1", [both], {}, Look(limits=limits))
    shown = (pictures.norm.vmin * pictures.unit[0], pictures.norm.vmax * pictures.unit[0])
    assert shown == pytest.approx(wanted)
    assert (pictures.colormap == "RdBu_r") is signed
