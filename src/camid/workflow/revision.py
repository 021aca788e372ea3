"""Which state of the sources a result was computed with."""

from __future__ import annotations

import subprocess

SOURCES = ("Snakefile", "config", "src", "workflow")


def revision() -> str:
    """The commit that is checked out, with a word where the sources were changed since; "unknown" outside a clone."""
    try:
        head, changes = (
            subprocess.run(["git", *command], capture_output=True, text=True, check=True).stdout.strip()
            for command in (["rev-parse", "--short=10", "HEAD"], ["status", "--porcelain", "--", *SOURCES])
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return f"{head} + changes" if changes else head
