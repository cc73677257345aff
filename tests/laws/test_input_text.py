"""TOML from people's files: bounded before it is parsed, refused in no other way than a fault."""

from __future__ import annotations

import tomllib
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli.errors import InputError
from orchard_cli.model.input_text import MOST_PARTS, decoded, parse_toml, read_bounded

LONG = ".".join(["a"] * (MOST_PARTS + 1))


@pytest.mark.parametrize(
    "text",
    [
        f"{LONG} = 1",
        f"[{LONG}]",
        f"x = {{{LONG} = 1}}",
        ".".join(['"a.b"'] * (MOST_PARTS + 1)) + " = 1",
        " . ".join(["'a'"] * (MOST_PARTS + 1)) + " = 1",
        f"x = ['''quoted'''', {{{LONG} = 1}}, '']",
        f'x = ["""quoted\\"""", {{{LONG} = 1}}, ""]',
        f'x = ["\\\\", {{{LONG} = 1}}, ""]',
    ],
)
def test_a_key_of_too_many_parts_is_refused_unparsed(text, monkeypatch):
    tomllib.loads(text)  # it is TOML
    monkeypatch.setattr(tomllib, "loads", lambda _: pytest.fail("it was parsed"))
    with pytest.raises(InputError, match=rf"f, line 3: a key of more than {MOST_PARTS} parts"):
        parse_toml('y = """\n"""\n' + text, "f")


@pytest.mark.parametrize(
    "text",
    [
        f"# {LONG}",
        f'x = "{LONG}"',
        f"x = '{LONG}'",
        f"x = '''\n{LONG}'''''",
        f'x = """{LONG}\\""" {LONG}"""',
        "x = [" + "1.5, " * 100 + "]",
        ".".join(["a"] * MOST_PARTS) + " = 1",
    ],
)
def test_dots_that_part_no_key_are_no_fault(text):
    assert parse_toml(text, "f") == tomllib.loads(text)


@pytest.mark.parametrize("text", ["a = " + "[" * 50_000, "a = 1" + "0" * 5_000, '"""\\"' * 50_000])
def test_what_tomllib_fails_on_is_a_fault(text):
    with pytest.raises(InputError):
        parse_toml(text, "f")


@given(st.text("a.=\"'\\#[]{}\n ", max_size=60))
@settings(max_examples=300, deadline=None, derandomize=True)
def test_short_texts_parse_as_tomllib_parses_them(text):
    expected = None
    with suppress(ValueError):
        expected = tomllib.loads(text)
    if text.count(".") < MOST_PARTS:
        if expected is None:
            with pytest.raises(InputError):
                parse_toml(text, "f")
        else:
            assert parse_toml(text, "f") == expected


def test_a_file_is_read_up_to_its_bound_only(tmp_path):
    path = tmp_path / "f"
    path.write_bytes(b"\xef\xbb\xbfabc")
    assert decoded(read_bounded(path, 6), "f") == "abc"
    with pytest.raises(InputError, match="split it"):
        read_bounded(path, 5, "split it")
