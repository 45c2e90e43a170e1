"""Other names of keys and words lead to those of the format."""

from __future__ import annotations

import pytest

from crackgrow.case.keys import case_keys
from crackgrow.case.report import nearest
from crackgrow.case.scene import CONTACT, CRITERION, MATERIAL, STRENGTH
from crackgrow.case.synonyms import SYNONYMS


@pytest.mark.parametrize(
    ("text", "allowed", "meant"),
    [
        ("E", MATERIAL.fields, "young"),
        ("nu", MATERIAL.fields, "poisson"),
        ("rho", MATERIAL.fields, "density"),
        ("phi", STRENGTH.fields, "friction_angle"),
        ("sigma_t", STRENGTH.fields, "tension"),
        ("K_Ic", STRENGTH.fields, "toughness"),
        ("mu", CONTACT.spec.fields, "friction"),
        ("phi", CONTACT.spec.fields, "friction"),
        ("circle", ("rectangle", "polygon", "disk"), "disk"),
        ("h", ("center", "width", "height"), "height"),
        ("h", ("support", "spacing"), "spacing"),
        ("E", CRITERION.words, None),
    ],
)
def test_other_names_mean_the_key_that_is_allowed(text: str, allowed: object, meant: str | None):
    assert nearest(text, allowed) == meant


def test_every_meaning_is_a_key_or_word_of_the_format():
    keys = {part for key in case_keys() for part in key.name.split(".")}
    words = {"none", "bonded"}
    assert {meant for several in SYNONYMS.values() for meant in several} - keys - words == set()
    assert [name for name in SYNONYMS if name != name.lower()] == []
