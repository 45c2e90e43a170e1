"""Where the benchmarks read and write."""

from __future__ import annotations

from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
REFERENCES = ROOT / "tests" / "verification" / "references"
