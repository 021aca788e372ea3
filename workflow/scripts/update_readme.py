"""Put the tables that the workflow made between their marks in README.md; run by `make readme`."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TABLES = {name: ROOT / f"paper_figs/{name}.md" for name in ("claims", "ablations", "concealed")}


def updated(text: str, name: str, table: str) -> str:
    """The text with the part between ``<!-- name: begin -->`` and ``<!-- name: end -->`` replaced.

    Raises
    ------
    ValueError
        If the marks are not there.
    """
    pattern = re.compile(rf"(<!-- {name}: begin[^>]*-->\n).*?(<!-- {name}: end -->)", flags=re.DOTALL)
    if not pattern.search(text):
        raise ValueError(f"README.md has no marks for '{name}'")
    return pattern.sub(lambda match: f"{match[1]}\n{table.strip()}\n\n{match[2]}", text)


def main() -> None:
    """Update README.md in place, whole or not at all."""
    readme = ROOT / "README.md"
    text = readme.read_text(encoding="utf-8")
    for name, path in TABLES.items():
        if path.exists():  # the whole sealed proof is a target of its own, and may not have been computed
            text = updated(text, name, path.read_text(encoding="utf-8"))
    temporary = readme.with_suffix(".md.new")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(readme)


if __name__ == "__main__":
    main()
