"""Programs that read YAML 1.1 take `on` for true: what they write is read, and they read what is written."""

from __future__ import annotations

import yaml

from crackgrow.case.dump import dump_case
from crackgrow.case.load import read_case

TEXT = """
title: A plate
plane: strain
bodies: {rock: {shape: {rectangle: {center: [0, 0], width: 4, height: 3}}, material: {young: 1e10, poisson: 0.2}}}
supports: [{KEY: {edge: bottom}, displacement: {x: 0, y: 0}}]
loads: [{KEY: {edge: top, from: 0, to: 1}, traction: [0, 1e6]}]
"""


def settings(text: str) -> dict:
    return read_case(text, "case.yaml", "case").to_dict()


def test_along_is_another_spelling_of_on():
    assert settings(TEXT.replace("KEY", "along")) == settings(TEXT.replace("KEY", "on"))


def test_what_pyyaml_makes_of_on_is_read():
    once_more = yaml.safe_dump(yaml.safe_load(TEXT.replace("KEY", "on")))
    assert "true:" in once_more
    assert settings(once_more) == settings(TEXT.replace("KEY", "on"))


def test_pyyaml_reads_what_is_written():
    written = dump_case(read_case(TEXT.replace("KEY", "along"), "case.yaml", "case"))
    found = yaml.safe_load(written)
    assert found["loads"][0]["on"] == {"body": "rock", "edge": "top", "from": 0.0, "to": 1.0}
    assert settings(yaml.safe_dump(found)) == settings(written)
