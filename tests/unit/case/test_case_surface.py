"""Names of surfaces: what each says, which are one surface, and numbers of several alike."""

from __future__ import annotations

import pytest

from crackgrow.case.surface import SurfaceName, crack_name, numbered

INTERFACE = SurfaceName("interface", ("low", "top"))
FOUNDATION = SurfaceName("foundation", ("low", "bottom"))


@pytest.mark.parametrize(
    ("name", "shown", "words"),
    [
        (crack_name("flaw"), "flaw", "crack 'flaw'"),
        (INTERFACE, "low/top", "interface 'low/top'"),
        (SurfaceName("interface", ("low", "top"), 1), "low/top.1", "interface 'low/top.1'"),
        (FOUNDATION, "low.bottom", "foundation 'low.bottom'"),
    ],
)
def test_a_name_says_what_the_surface_is_of(name: SurfaceName, shown: str, words: str) -> None:
    assert (str(name), name.words) == (shown, words)


def test_an_interface_is_all_of_its_lines_and_has_no_first_body() -> None:
    line = SurfaceName("interface", ("low", "top"), 1)
    assert line.is_of(INTERFACE)
    assert line.is_of(SurfaceName("interface", ("top", "low")))
    assert not line.is_of(SurfaceName("interface", ("low", "plug")))
    assert not SurfaceName("foundation", ("low", "top")).is_of(INTERFACE)
    assert not crack_name("low/top").is_of(INTERFACE)


def test_interfaces_alone_bound_bodies() -> None:
    assert INTERFACE.bounds({"top", "plug"})
    assert not INTERFACE.bounds({"plug"})
    assert not FOUNDATION.bounds({"low"})
    assert not crack_name("low").bounds({"low"})


def test_of_several_alike_each_has_its_number() -> None:
    names = numbered([FOUNDATION, INTERFACE, FOUNDATION])
    assert [str(name) for name in names] == ["low.bottom.0", "low/top", "low.bottom.1"]
