"""The `orchard` program: its verbs, its exit codes, its way of saying that something is wrong."""

from __future__ import annotations

import errno
import sys
from typing import Annotated

import typer

from orchard_cli import __version__
from orchard_cli.errors import Fault, InputError, OrchardError

from .analyze import analyze
from .bench import bench
from .campaign import campaign_app
from .check import check
from .demo import demo
from .doctor import doctor
from .export import export
from .fly import fly
from .identify import identify_app
from .plan import plan
from .replay import replay
from .reproduce import reproduce
from .survey import survey_app

app = typer.Typer(
    name="orchard",
    help="Plan, fly and analyze spray missions over orchards.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
app.command()(plan)
app.command()(check)
app.command()(export)
app.command()(fly)
app.command()(analyze)
app.command()(replay)
app.command()(demo)
app.command()(bench)
app.command()(doctor)
app.add_typer(survey_app, name="survey")
app.command()(reproduce)
app.add_typer(identify_app, name="identify")
app.add_typer(campaign_app, name="campaign")


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"orchard {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Plan, fly and analyze spray missions over orchards."""


def complain(error: OrchardError) -> int:
    """Say on stderr what is wrong, one line a fault, and return the exit code."""
    lines = [str(f) for f in error.faults] if isinstance(error, InputError) else [str(error)]
    for line in lines:
        typer.echo(f"orchard: {line}", err=True)
    if error.hint:
        typer.echo(f"orchard: {error.hint}", err=True)
    return error.exit_code


def main() -> None:
    """Run a command; an expected error ends in its exit code and one line, never a traceback."""
    try:
        app()
    except OrchardError as error:
        sys.exit(complain(error))
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EIO):
            raise
        sys.exit(complain(InputError(Fault(error.filename or "stdout", error.strerror or ""))))
