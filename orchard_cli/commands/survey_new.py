"""`orchard survey new`: a survey by questions, in the terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchard_cli.errors import Fault, InputError

if TYPE_CHECKING:
    from rich.console import Console

    from orchard_cli.survey import Survey
    from orchard_cli.survey.interview import Interview

_LARGEST_DRAFT = 1_000_000  # bytes
_HELP = "Enter takes what is in [brackets], < goes back one question, Ctrl-C stops and keeps all."


def new(
    file: Annotated[Path, typer.Argument(help="Survey TOML to write.")],
) -> None:
    """Write a survey row by row, by questions."""
    from rich.console import Console

    from orchard_cli import survey as surveys

    _refuse_bad_places(file)
    console = Console(stderr=True)
    draft = draft_path(file)
    interview = _begun(draft, console)
    console.print(_HELP, markup=False, highlight=False)
    try:
        text = _asked(interview, file.name, draft, console)
    except (KeyboardInterrupt, EOFError):
        console.print()
        raise InputError(
            Fault(str(draft), "keeps what was typed", f"go on with orchard survey new {file}")
        ) from None
    surveys.save(text, file)
    draft.unlink(missing_ok=True)
    console.print(f"{file} is written; next: orchard plan {file}", markup=False, highlight=False)


def draft_path(file: Path) -> Path:
    """Where unfinished answers are kept: beside the survey."""
    return file.with_name(f".{file.name}.draft")


def _refuse_bad_places(file: Path) -> None:
    if file.suffix.lower() != ".toml":
        raise InputError(Fault(str(file), "is no name of a survey TOML", "end it with .toml"))
    if os.path.lexists(file):
        raise InputError(Fault(str(file), "is there already", "choose another name"))
    if not file.parent.is_dir():
        raise InputError(Fault(str(file.parent), "is no folder", "make it first"))
    if sys.stdin is None or not sys.stdin.isatty():
        raise InputError(
            Fault("stdin", "is no terminal, so nothing can be asked", "write the TOML by hand")
        )


def _begun(draft: Path, console: Console) -> Interview:
    """The draft that a stopped session left, if it is wanted; else nothing answered."""
    from orchard_cli.model.input_text import decoded, read_bounded
    from orchard_cli.survey.interview import Interview, from_draft

    if not os.path.lexists(draft):
        return Interview()
    told = from_draft(decoded(read_bounded(draft, _LARGEST_DRAFT), draft.name))
    if not isinstance(told, Interview):
        raise InputError(Fault(str(draft), told.what, "remove that file"))
    rows = sum(bool(row) for row in told.rows)
    console.print(f"{draft} keeps {len(told.head)} answers and {rows} rows.", markup=False)
    if typer.confirm("Go on with them?", default=True, err=True):
        return told
    return Interview()


def _asked(interview: Interview, name: str, draft: Path, console: Console) -> str:
    """Ask until a survey stands that can be read: its text."""
    from orchard_cli import survey as surveys

    while True:
        _ask_all(interview, draft, console)
        text = surveys.text_of(interview.tables(), ("Written by orchard survey new.",))
        try:
            _review(surveys.parse(text.encode(), name), console)
            faults = ""
        except InputError as error:
            faults = str(error)
            console.print(faults, style="red", markup=False, highlight=False)
        wish = _line("Enter writes it; 2 mends row 2; 0 the questions before; + adds a row; -2 "
                     "removes row 2" if not faults else "Mend a row (2), 0, + or -2")  # fmt: skip
        if not wish and not faults:
            return text
        if wish == "<":
            interview.more = True
            interview.back()
        elif wish:
            _mend(interview, wish, draft, console)


def _ask_all(interview: Interview, draft: Path, console: Console) -> None:
    while (asked := interview.question()) is not None:
        last = asked.key == "distance_m"
        usual = f" [{asked.usual}]" if asked.usual else " [no more rows]" if last else ""
        _take(interview, _line(asked.text + usual), console)
        _keep(interview, draft)


def _take(interview: Interview, typed: str, console: Console) -> None:
    from orchard_cli.survey.interview import NotUnderstood

    if typed == "<":
        interview.back()
        return
    try:
        interview.answer(typed)
    except NotUnderstood as error:
        console.print(str(error), style="red", markup=False, highlight=False)


def _mend(interview: Interview, wish: str, draft: Path, console: Console) -> None:
    """Change one row, or the questions before the rows, without the rest."""
    if wish == "+":
        interview.more = True
        return
    rows, number = interview.rows, wish.removeprefix("-")
    if not number.isdecimal() or len(number) > 4 or int(number) > len(rows):
        console.print(f"there are rows 1 to {len(rows)}", style="red", highlight=False)
    elif wish == "0":
        interview.head = _again(interview.head, console)
    elif wish.startswith("-") and len(rows) > 1 and int(number) > 1:
        del rows[int(number) - 1]
    elif not wish.startswith("-"):
        rows[int(number) - 1] = _row_again(interview, int(number), console)
    else:
        console.print("row 1 is the origin: mend it instead", style="red", highlight=False)
    _keep(interview, draft)


def _again(head: list[str], console: Console) -> list[str]:
    from orchard_cli.survey.interview import HEAD

    answers: list[str] = []
    while len(answers) < len(HEAD):
        asked = HEAD[len(answers)]
        typed = _line(f"{asked.text} [{head[len(answers)]}]") or head[len(answers)]
        _collect(answers, typed, asked.read, console)
    return answers


def _row_again(interview: Interview, number: int, console: Console) -> list[str]:
    """Row `number` once more, with its answers to take by Enter."""
    from orchard_cli.survey.interview import row_questions

    old = interview.rows[number - 1]
    answers: list[str] = []
    while (asked := row_questions(number, answers, None)) is not None:
        usual = old[len(answers)]
        typed = _line(f"{asked.text} [{usual}]") or usual
        _collect(answers, typed, asked.read, console)
    return answers


def _collect(
    answers: list[str], typed: str, read: Callable[[str], object], console: Console
) -> None:
    from orchard_cli.survey.interview import NotUnderstood

    if typed == "<":
        answers[-1:] = []
        return
    try:
        read(typed)
    except NotUnderstood as error:
        console.print(str(error), style="red", markup=False, highlight=False)
    else:
        answers.append(typed)


def _line(prompt: str) -> str:
    """One line from the terminal; the prompt goes to stderr with the rest of the talk."""
    sys.stderr.write(f"{prompt}: ")
    sys.stderr.flush()
    return input().strip()


def _keep(interview: Interview, draft: Path) -> None:
    from orchard_cli.survey import save

    save(interview.draft(), draft, replace=True)


def _review(survey: Survey, console: Console) -> None:
    from .survey_input import show

    show(survey, console)
