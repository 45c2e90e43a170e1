"""Folders of runs: the same name gives the same folder, different ones different folders."""

from __future__ import annotations

from crackgrow.study.plan import LONGEST, folder_names


def test_letters_are_those_that_every_file_system_takes():
    assert folder_names(["angle=30 traction=[0, -1e8]/x", "a=2 mm"]) == ["angle=30_traction=_0_-1e8_x", "a=2_mm"]


def test_runs_that_look_the_same_have_folders_of_their_own():
    assert folder_names(["a=[1]", "a=(1)", "a={1}", "A=[1]"]) == ["a=_1", "a=_1_2", "a=_1_3", "A=_1_4"]


def test_long_names_that_differ_at_their_end_only_are_told_apart_wherever_they_stand():
    one, other = f"{'a' * 200}=1", f"{'a' * 200}=2"
    folders = folder_names([one, other])
    assert len(set(folders)) == 2
    assert all(len(folder) == LONGEST for folder in folders)
    assert folder_names([other, one]) == folders[::-1]


def test_letters_of_several_bytes_count_as_such() -> None:
    (folder,) = folder_names(["\u0444" * 200])
    assert LONGEST - 1 <= len(folder.encode()) <= LONGEST
