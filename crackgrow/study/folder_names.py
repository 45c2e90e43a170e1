"""Names of the folders of a study's runs: made of what a run varies, so that it is found again among other runs."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Iterable
from typing import Final

LONGEST: Final = 120  # bytes: file systems take 255


def folder_names(names: Iterable[str]) -> list[str]:
    """A folder for each run, by its name; runs whose folders would be the same are counted: `_2`, `_3`."""
    met: Counter[str] = Counter()
    found = []
    for name in names:
        folder = folder_name(name)
        met[folder.lower()] += 1  # some file systems take capitals for the same
        count = met[folder.lower()]
        found.append(folder if count == 1 else f"{folder}_{count}")
    return found


def folder_name(name: str) -> str:
    """Such as angle=30_friction=0.2, in letters that every file system takes; a long name ends in its checksum."""
    words = re.sub(r"[^\w.=+-]+", "_", name).strip("_")
    if len(words.encode()) <= LONGEST:
        return words
    checksum = f"_{zlib.crc32(name.encode()):08x}"
    return words.encode()[: LONGEST - len(checksum)].decode(errors="ignore") + checksum
