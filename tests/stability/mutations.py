"""Case files with something wrong in them, made from good ones by a seed: what people, programs and accidents write."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from crackgrow.cli.start import template_text, templates
from tests.stability.yaml_sites import Site, sites
from tests.unit.case.scenes import EVERYTHING, text_of

Rng = np.random.Generator
CASES = Path(__file__).parents[2] / "cases"

_NUMBER = re.compile(r"[-+]?[.0-9]+([eE][-+]?[0-9]+)?( \S+)?")  # perhaps with a unit
TYPES = ["[1, 2]", "{a: 1}", "~", "", "a text", "true", "''", '"5"', "[]", "{}", "[[1]]", "5", "-", "none", "!!str 5"]
UNITS = [
    "3 parsec",
    "5 kg",
    "1 mm",
    "2 MPa",
    "4 deg",
    "1 m/s^2",
    "2500 kg/m^3",
    "5mm",
    "mm",
    "5 mm mm",
    "1 MPa^2",
    "7 M",
]
NUMBERS = [
    "1e308", "-1e308", "1e400", "1e-320", "1e61", "1e60", "1e-61", ".inf", "-.inf", ".nan", "inf", "0", "-0.0", "-1",
    "9" * 400, "1" + "0" * 30, "0x10", "1_000", "017", "1e", "--1", "1.2.3", "0." + "0" * 300 + "1", "1e+12", "1e-12",
]  # fmt: skip
WORDS = ["strian", "STRAIN", "bothh", "on", "yes", "newton", "rigid", "critical", "../../escape", "..", "a b", "\u202e"]
FORMULAS = [
    "__import__('os').system('true')", "x**9**9**9", "(" * 200 + "x" + ")" * 200, "x.real", "lambda: x", "1/0", "x^2",
    "-" * 500 + "x", "sin(x, y)", "log(-1)", "9**9**9", "x if y else 1", "1e999*x", "x" + "+x" * 400,
]  # fmt: skip
FILES = ["../../../../etc/passwd", "/dev/zero", "outline.geojson", "/etc/passwd.json", "a\\0.wkt", "x" * 5000 + ".wkt"]
NAMES = ["../escape", "..", "/tmp/x", "a/b", "CON", "x" * 65, "a\u0301", "-a", ".hidden", "a b", "0", "~", "a.b", "ü"]
PIECES = [
    b":", b"- ", b"[", b"]", b"{", b"}", b"&a ", b"*a", b"'", b'"', b"\n", b"  ", b"? ", b"| ", b"> ", b"%", b"---\n",
    b"\xff", b"\0", b"\x1b[2J", b"\xe2\x80\xa8", b"\xed\xa0\x80", b"<<: ", b"#", b"\t", b"\r", b"\xef\xbb\xbf",
]  # fmt: skip
TAGS = ["!!python/object/apply:os.system [touch, escaped]", "!!python/name:os.system", "!!binary AAAA", "!x 1",
        "!!python/object/new:subprocess.Popen [[touch, it]]", "!!set {a, b}", "!!timestamp 2001-01-01"]  # fmt: skip


def _pick(text: str, rng: Rng, wanted: Callable[[Site], bool]) -> Site:
    found = [site for site in sites(text) if wanted(site)]
    return found[rng.integers(len(found))]


def _any(words: list[str], rng: Rng) -> str:
    return words[rng.integers(len(words))]


def _replaced(text: str, start: int, end: int, new: str) -> str:
    return text[:start] + new + text[end:]


def _is_number(text: str) -> Callable[[Site], bool]:
    return lambda site: site.scalar and bool(_NUMBER.fullmatch(text[site.start : site.end]))


def misspelt_key(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: len(site.key) > 1)
    letters, place = list(site.key), int(rng.integers(len(site.key) - 1))
    kind = rng.integers(3)
    if kind == 0:
        del letters[place]
    elif kind == 1:
        letters[place] = "q"
    else:
        letters[place : place + 2] = letters[place : place + 2][::-1]
    return _replaced(text, site.key_start, site.key_end, "".join(letters))


def other_key(text: str, rng: Rng) -> str:
    site, other = (_pick(text, rng, lambda site: bool(site.key)) for _ in range(2))
    return _replaced(text, site.key_start, site.key_end, other.key)


def dropped_key(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: bool(site.key))
    end = site.end
    if site.flow:
        while text[end : end + 1] in (",", " "):
            end += 1
    return _replaced(text, site.key_start, end, "")


def repeated_key(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: bool(site.key))
    between = ", " if site.flow else "\n" + " " * site.column
    return _replaced(text, site.key_start, site.key_start, text[site.key_start : site.end] + between)


def added_key(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: bool(site.key))
    between = ", " if site.flow else "\n" + " " * site.column
    return _replaced(text, site.key_start, site.key_start, f"{_any(['speed', 'frict', '7', '<<'], rng)}: 1{between}")


def other_type(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: True)
    return _replaced(text, site.start, site.end, _any(TYPES, rng) + ("" if site.scalar else "\n"))


def other_unit(text: str, rng: Rng) -> str:
    site = _pick(text, rng, _is_number(text))
    return _replaced(text, site.start, site.end, f'"{_any(UNITS, rng)}"')


def extreme_number(text: str, rng: Rng) -> str:
    site = _pick(text, rng, _is_number(text))
    return _replaced(text, site.start, site.end, _any(NUMBERS, rng))


def scaled_number(text: str, rng: Rng) -> str:
    site = _pick(text, rng, _is_number(text))
    factor = [-1, 10, 1e3, 1e6, 0.1, 1e-3, 1e-6, 1 + 1e-9, 2][rng.integers(9)]
    digits = text[site.start : site.end].split()[0]
    return _replaced(text, site.start, site.start + len(digits), f"{float(digits) * factor!r}")


def other_word(text: str, rng: Rng) -> str:
    site = _pick(
        text, rng, lambda site: site.scalar and not _is_number(text)(site) and site.key not in ("title", "source")
    )
    return _replaced(text, site.start, site.end, '"' + _any(WORDS, rng) + '"')


def other_name(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: site.parent in ("bodies", "cracks"))
    return _replaced(text, site.key_start, site.key_end, '"' + _any(NAMES, rng) + '"')


def formula(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: site.key == "displacement" or site.key == "title")
    new = f'{{x: "{_any(FORMULAS, rng)}"}}\n' if site.key == "displacement" else f'"{_any(FORMULAS, rng)}"'
    return _replaced(text, site.start, site.end, new)


def outline_file(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: site.key == "shape")
    return _replaced(text, site.start, site.end, f'{{file: "{_any(FILES, rng)}"}}\n' + " " * site.column)


def list_item(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: not site.key)
    value = text[site.start : site.end].rstrip()
    return _replaced(text, site.start, site.end, _any(["", f"{value}, {value}", "~", f"[{value}]"], rng))


def swapped(text: str, rng: Rng) -> str:
    first, second = sorted((_pick(text, rng, lambda site: site.scalar) for _ in range(2)), key=lambda site: site.start)
    if first.end > second.start:
        return text[::-1]
    middle = text[first.end : second.start]
    return (
        text[: first.start]
        + text[second.start : second.end]
        + middle
        + text[first.start : first.end]
        + text[second.end :]
    )


def line(text: str, rng: Rng) -> str:
    lines = text.splitlines(keepends=True)
    place, kind = int(rng.integers(len(lines))), int(rng.integers(4))
    lines[place] = ["", lines[place] * 2, "  " + lines[place], lines[place].lstrip(" ")][kind]
    return "".join(lines)


def truncated(text: str, rng: Rng) -> str:
    return text[: rng.integers(len(text))]


def tag(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: True)
    return _replaced(text, site.start, site.end, _any(TAGS, rng) + ("" if site.scalar else "\n"))


def alias(text: str, rng: Rng) -> str:
    site = _pick(text, rng, lambda site: site.scalar and bool(site.key))
    if rng.integers(2):
        return _replaced(text, site.start, site.start, "&a ") + "\nme: &me [*me, *a]\n"
    width, depth = int(rng.integers(2, 9)), int(rng.integers(5, 40))
    levels = (f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * width)}]" for n in range(1, depth))
    return "\n".join(["a0: &a0 [x, x]", *levels, text])


def nested(text: str, rng: Rng) -> str:
    site, depth = _pick(text, rng, lambda site: site.scalar), int(10 ** rng.uniform(1, 4))
    opening, closing = [("[", "]"), ("{a: ", "}"), ("[[", "]]")][rng.integers(3)]
    closed = closing * depth if rng.integers(2) else ""
    return _replaced(text, site.start, site.end, opening * depth + "1" + closed)


def large(text: str, rng: Rng) -> str:
    """Much of something: padding, names, points, texts."""
    n, kind = int(10 ** rng.uniform(2, 4)), int(rng.integers(6))
    if kind == 0:
        return text + "# " + "x" * int(10 ** rng.uniform(5, 6.5)) + "\n"
    if kind == 1:
        return text + "".join(f"key{k}: 1\n" for k in range(n))
    site = _pick(text, rng, lambda site: site.key == ("title" if kind == 2 else "shape"))
    if kind == 2:
        return _replaced(text, site.start, site.end, "x" * 10 * n)
    angles = np.linspace(0, 2 * np.pi, n, endpoint=False)
    radius = np.ones(n) if kind == 3 else rng.uniform(0.5, 1.5, n)
    points = ", ".join(f"[{r * np.cos(a):.9g}, {r * np.sin(a):.9g}]" for r, a in zip(radius, angles, strict=True))
    shape = f"{{polygon: [{points}]}}"
    if kind == 5:
        holes = ", ".join(f"{{disk: {{center: [{k}, 0], radius: 0.3}}}}" for k in range(min(n, 300)))
        shape = f"{{rectangle: {{center: [0, 0], width: 1e4, height: 100}}, holes: [{holes}]}}"
    return _replaced(text, site.start, site.end, shape + "\n" + " " * site.column)


def many_cracks(text: str, rng: Rng) -> str:
    n = int(10 ** rng.uniform(1, 3))
    places = rng.uniform(-10, 10, (n, 3))
    law = "contact: {friction: 0.3, cohesion: 0}"
    cracks = "".join(
        f"  c{k}: {{path: {{center: [{x:.3f}, {y:.3f}], length: 1, angle: {9 * a:.1f}}}, {law}}}\n"
        for k, (x, y, a) in enumerate(places)
    )
    site = next((site for site in sites(text) if site.key == "cracks"), None)
    return (
        text + "\ncracks:\n" + cracks
        if site is None
        else _replaced(text, site.start, site.start, cracks.lstrip() + "  ")
    )


def encoding(text: str, rng: Rng) -> bytes:
    return text.encode(_any(["utf-16", "utf-32", "utf-8-sig", "utf-7", "cp037"], rng))


def pieces(text: str, rng: Rng) -> bytes:
    data = bytearray(text.encode())
    for _ in range(rng.integers(1, 4)):
        start = int(rng.integers(len(data)))
        data[start : start + int(rng.integers(12))] = PIECES[rng.integers(len(PIECES))] * int(rng.integers(4))
    return bytes(data)


def garbage(text: str, rng: Rng) -> bytes:
    data = text.encode()
    place = int(rng.integers(len(data)))
    return data[:place] + rng.bytes(int(rng.integers(1, 200))) + data[place:]


KINDS: Mapping[str, Callable[[str, Rng], str | bytes]] = {
    mutate.__name__: mutate
    for mutate in (misspelt_key, other_key, dropped_key, repeated_key, added_key, other_type, other_unit,
                   extreme_number, scaled_number, other_word, other_name, formula, outline_file, list_item, swapped,
                   line, truncated, tag, alias, nested, large, many_cracks, encoding, pieces, garbage)
}  # fmt: skip


def good_cases() -> dict[str, str]:
    """Texts of good cases by name: all that are shipped, the templates, and one with everything in it."""
    shipped = {file.stem: file.read_text(encoding="utf-8") for file in sorted(CASES.glob("*.yaml"))}
    return shipped | {f"new {name}": template_text(name) for name in templates()} | {"everything": text_of(EVERYTHING)}


def mutant(number: int, good: Mapping[str, str], seed: int = 1) -> tuple[str, str, bytes]:
    """The kind, the good case and the bytes of a mutant; the same number makes the same one."""
    rng = np.random.default_rng([seed, number])
    names = list(good)
    kind, name = list(KINDS)[number % len(KINDS)], names[rng.integers(len(names))]
    made = KINDS[kind](good[name], rng)
    return kind, name, made if isinstance(made, bytes) else made.encode("utf-8", "surrogatepass")
