"""What a surface is, and by which name results and messages know it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace
from typing import Final, Literal

_BETWEEN: Final = {"crack": "", "interface": "/", "bond": "+", "foundation": "."}


@dataclass(frozen=True, slots=True)
class SurfaceName:
    """Which surface it is: a crack, a line between two bodies, what is bonded of a cracked one, or an edge on a rigid
    foundation."""

    kind: Literal["crack", "interface", "bond", "foundation"]
    of: tuple[str, ...]  # the crack; the two bodies; the body and its edge
    number: int | None = None  # of one of several; None: there is but one, or all are meant

    def __str__(self) -> str:
        """The name in results: "crack", "first/second", "first+second", "body.edge"; and ".number" for one of many."""
        name = _BETWEEN[self.kind].join(self.of)
        return name if self.number is None else f"{name}.{self.number}"

    @property
    def words(self) -> str:
        """The name in messages."""
        return f"{self.kind} '{self}'"

    def end(self, at_end: bool) -> str:
        """The name of its end in messages, or of its start."""
        return f"the {end_word(at_end)} of {self.words}"

    @property
    def is_crack(self) -> bool:
        """Whether it is a crack."""
        return self.kind == "crack"

    def is_of(self, meant: SurfaceName) -> bool:
        """Whether it is the surface that is meant, or one of several; bodies of an interface in either order."""
        return self.kind == meant.kind and meant.of in (self.of, self.of[::-1])

    def bounds(self, bodies: Set[str]) -> bool:
        """Whether it is an interface of one of some bodies."""
        return self.kind in ("interface", "bond") and not bodies.isdisjoint(self.of)


def end_word(at_end: bool) -> Literal["start", "end"]:
    """What an end of a crack is called in results."""
    return "end" if at_end else "start"


def crack_name(name: str) -> SurfaceName:
    """That of a crack."""
    return SurfaceName("crack", (name,))


def numbered(names: Sequence[SurfaceName]) -> list[SurfaceName]:
    """Names of surfaces, those of several alike with their numbers among these."""
    counts, found = Counter(names), Counter[SurfaceName]()
    told = []
    for name in names:
        told.append(replace(name, number=found[name]) if counts[name] > 1 else name)
        found[name] += 1
    return told
