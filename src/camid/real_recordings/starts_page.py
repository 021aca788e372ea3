"""The page on what diagnoses of the real recordings owe to their starts."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from camid.number_text import number, with_deviation

TEXT = """# Real recordings from other starts

Whether a diagnosis depends on what it starts from: each [real recording](real_recordings.md) is diagnosed from nominal
plants whose natural frequencies, damping ratios, real poles and static gain are off by up to a half, drawn uniformly,
and the second pendulum from several rows on. *Same first name* is the share of the draws that name the most frequent
one first. Errors are those on rows that were not fitted, over the standard deviation of the output.

```sh
.venv/bin/snakemake -c2 recordings_starts       # an hour; the tables it writes hold each diagnosis, and its seconds
```

## Nominal plants off by up to a half

{draws}

## The second pendulum, read from several times on

{windows}
"""


def starts_page(draws: Mapping[str, pd.DataFrame], windows: pd.DataFrame) -> str:
    """Markdown of the page.

    Parameters
    ----------
    draws : mapping of str to DataFrame
        Of each recording, as of :func:`camid.real_recordings.starts.first_names`.
    windows : DataFrame
        As of :func:`camid.real_recordings.starts.names_by_first_row`.
    """
    lines = [_line(name.replace("_", " "), table) for name, table in draws.items()]
    rows = [
        {
            "from (s)": f"{row['start']:g}",
            "first name": row["first"] or "none",
            "its first parameter": with_deviation(row["value"], row["deviation"]) if row["first"] else "",
            "error (%)": number(100.0 * row["error"], 2),
        }
        for row in windows.fillna({"first": ""}).to_dict("records")
    ]
    return TEXT.format(draws=_markdown(lines), windows=_markdown(rows))


def _line(name: str, table: pd.DataFrame) -> dict[str, str]:
    names = table["first"].fillna("")
    first = str(names.mode().iloc[0])
    errors = 100.0 * table["error"]
    return {
        "recording": name,
        "draws": str(len(table)),
        "first name": first or "none",
        "same first name": f"{100.0 * float((names == first).mean()):.0f} %",
        "error (%)": " to ".join(dict.fromkeys((number(errors.min(), 3), number(errors.max(), 3)))),
    }


def _markdown(rows: list[dict[str, str]]) -> str:
    return pd.DataFrame(rows).to_markdown(index=False, disable_numparse=True)
