"""The command line: a module a command.

Exit code 0: done. 2: the input is wrong, and one line says what, where and how to fix it.
"""

from __future__ import annotations

import atexit
import gc
import sys
import warnings
from io import TextIOWrapper

import click

from camid import __version__
from camid.cli import (
    bode,
    compare,
    design,
    diagnose,
    effects,
    example,
    identify,
    init,
    join,
    order,
    poles,
    residuals,
    simulate,
    step,
    studio,
    track,
)
from camid.errors import InputError
from camid.number_text import printable

# An interpreter that ends looks through all that it holds, more than half a second after a diagnosis.
atexit.register(gc.freeze)

INTERRUPTED = 130
CUT_SHORT = (
    "a file ends too soon, most likely one of Python's own that a full disk cut short; "
    "remove the folders __pycache__ of Python's packages and try again"
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="camid")
def cli() -> None:
    """Identify the dynamics of machines from what a camera sees of them."""


for command in (
    bode.bode,
    compare.compare,
    design.design,
    diagnose.diagnose,
    effects.effects,
    example.example,
    identify.identify,
    init.init,
    join.join,
    order.order,
    poles.poles,
    residuals.residuals,
    simulate.simulate,
    step.step,
    studio.studio,
    track.track,
):
    cli.add_command(command)


def _message(error: Exception) -> str:
    """One line for an error that the user can fix."""
    sentence = str(error)
    if isinstance(error, click.ClickException):
        sentence = f"{' '.join(error.format_message().split())} (see camid --help)"
    elif isinstance(error, OSError):  # no right to read, a name that is too long, a full disk
        sentence = f"{error.filename or 'cannot read or write'}: {error.strerror or error}"
    # Names of files and columns may hold anything, line breaks too.
    return printable(sentence)


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit code; errors are one line on the error stream."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without · or ² shows ? instead
    try:
        with warnings.catch_warnings():
            # A start that overflows is dropped; what becomes of the others is judged at the end.
            warnings.simplefilter("ignore", RuntimeWarning)
            return int(cli.main(args=arguments, prog_name="camid", standalone_mode=False) or 0)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return 2
    except (InputError, OSError, click.ClickException) as error:
        click.echo(f"camid: error: {_message(error)}", err=True)
        return 2
    except MemoryError:
        click.echo("camid: error: there is not enough memory; cut the recording, or leave out columns", err=True)
        return 2
    except (click.Abort, KeyboardInterrupt) as error:
        if isinstance(
            error.__cause__ or error.__context__, EOFError
        ):  # click takes it for the end of a terminal's input
            click.echo(f"camid: error: {CUT_SHORT}", err=True)
            return 2
        click.echo("camid: interrupted; no file is half-written", err=True)
        return INTERRUPTED
