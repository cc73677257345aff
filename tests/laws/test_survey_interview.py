"""`orchard survey new`: mistakes are mended without starting over, and nothing typed is lost."""

from __future__ import annotations

import os
import pty
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchard_cli import survey
from orchard_cli.errors import Fault
from orchard_cli.survey.interview import Interview, NotUnderstood, from_draft, numbers

HEAD = ["north", "23.45", "113.2", "20", "90", "3.5", ""]
ROWS = ["3.0 2.8 3,1", "2.3", "6.0", "0.5", "3.2 2.9", ""]
COMMAND = [sys.executable, "-c", "from orchard_cli.commands import main; main()", "survey", "new"]


def answered(texts):
    interview = Interview()
    for text in texts:
        interview.answer(text)
    return interview


def test_the_answers_make_a_survey():
    interview = answered([*HEAD, *ROWS, ""])
    assert interview.question() is None
    read = survey.parse(survey.text_of(interview.tables()).encode(), "f.toml")
    first, second = (row.trunks_site for row in read.orchard.rows)
    assert first == pytest.approx(np.array([[0, 0], [3, 0], [5.8, 0], [8.9, 0]]))
    assert second == pytest.approx(np.array([[0.5, 6], [3.7, 6], [6.6, 6]]))
    assert read.orchard.rows[1].heights.tolist() == [2.3] * 3
    assert read.wishes.limits.speed == 1.0


@given(st.lists(st.integers(1, 4), max_size=6))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_going_back_and_answering_again_changes_nothing(backs):
    """Whatever was answered, going back n and giving the same answers leads to the same place."""
    texts = [text or "1.0" for text in HEAD] + [text or "2.3" for text in ROWS]
    interview, given_so_far = Interview(), []
    queue = list(backs)
    for text in texts:
        interview.answer(text)
        given_so_far.append(text)
        if queue:
            n = min(queue.pop(), len(given_so_far))
            for _ in range(n):
                interview.back()
            for again in given_so_far[len(given_so_far) - n :]:
                interview.answer(again)
    assert interview.tables() == answered([*texts]).tables()


@pytest.mark.parametrize("text", ["95", "x", "nan", "", "1e999"])
def test_a_wrong_answer_is_asked_again(text):
    interview = answered(["north"])
    asked = interview.question()
    with pytest.raises(NotUnderstood):
        interview.answer(text)
    assert interview.question() == asked


def test_a_draft_brings_everything_back():
    interview = answered([*HEAD, *ROWS[:4]])
    again = from_draft(interview.draft())
    assert isinstance(again, Interview)
    assert (again.head, again.rows) == (interview.head, interview.rows)
    assert isinstance(from_draft('{"schema": 1}'), Fault)
    assert isinstance(from_draft("[" * 10_000), Fault)


def test_numbers_may_be_told_many_at_once():
    assert numbers("3.0 2x2,5;4", 0.1, 9, 9) == [3.0, 2.5, 2.5, 4.0]
    for text in ("99999x1", "1x1x1", "-1", "x", " "):
        with pytest.raises(NotUnderstood):
            numbers(text, 0.1, 9, 9)


def typed(path, text):
    """What happens when this is typed at a terminal: exit code and what is said."""
    ours, theirs = pty.openpty()
    with subprocess.Popen([*COMMAND, str(path)], stdin=theirs, stderr=subprocess.PIPE) as done:
        os.write(ours, text.encode())
        said = done.communicate(timeout=200)[1].decode()
    os.close(theirs)
    os.close(ours)
    return done.returncode, said


def test_at_a_terminal_a_row_is_mended_and_a_stop_keeps_what_was_typed(tmp_path):
    path = tmp_path / "north.toml"
    code, said = typed(path, "\n".join([*HEAD, *ROWS[:3]]) + "\n\x04")
    assert code == 2
    assert "keeps what was typed" in said
    assert not path.exists()
    rest = ["y", *ROWS[3:], "", "2", "5.5", "", "3x3.0", "2.2", ""]
    code, said = typed(path, "\n".join(rest) + "\n")
    assert code == 0, said
    assert [p.name for p in tmp_path.iterdir()] == ["north.toml"]
    second = survey.load(path).orchard.rows[1]
    assert second.trunks_site.tolist() == [[0.5, 5.5], [3.5, 5.5], [6.5, 5.5], [9.5, 5.5]]


def test_nothing_is_asked_where_stdin_is_no_terminal(tmp_path):
    done = subprocess.run(
        [*COMMAND, str(tmp_path / "a.toml")], stdin=subprocess.DEVNULL, capture_output=True,
        text=True, timeout=200, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "no terminal" in done.stderr
    assert len(done.stderr.splitlines()) == 1
