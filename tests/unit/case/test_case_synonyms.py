"""Other names of keys and words lead to those of the format."""

from __future__ import annotations

import pytest

from crackgrow.case.declared import keys_of
from crackgrow.case.keys import case_keys
from crackgrow.case.model import CoulombContact, Material, Strength
from crackgrow.case.report import nearest
from crackgrow.case.synonyms import SYNONYMS


@pytest.mark.parametrize(
    ("text", "allowed", "meant"),
    [
        ("E", keys_of(Material), "young"),
        ("nu", keys_of(Material), "poisson"),
        ("rho", keys_of(Material), "density"),
        ("phi", keys_of(Strength), "friction_angle"),
        ("sigma_t", keys_of(Strength), "tension"),
        ("K_Ic", keys_of(Strength), "toughness"),
        ("mu", keys_of(CoulombContact), "friction"),
        ("phi", keys_of(CoulombContact), "friction"),
        ("circle", ("rectangle", "polygon", "disk"), "disk"),
        ("h", ("center", "width", "height"), "height"),
        ("h", ("support", "spacing"), "spacing"),
        ("E", ("strength", "directional_strength", "max_hoop_stress"), None),
    ],
)
def test_other_names_mean_the_key_that_is_allowed(text: str, allowed: object, meant: str | None):
    assert nearest(text, allowed) == meant


def test_every_meaning_is_a_key_or_word_of_the_format():
    keys = {part for key in case_keys() for part in key.name.split(".")}
    words = {"none", "bonded"}
    assert {meant for several in SYNONYMS.values() for meant in several} - keys - words == set()
    assert [name for name in SYNONYMS if name != name.lower()] == []
