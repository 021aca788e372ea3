"""The law of an effect, which its class states in LaTeX, as text for a terminal."""

from __future__ import annotations

import re

NAMES = "alpha beta gamma delta epsilon varepsilon zeta theta kappa mu xi pi rho sigma tau varphi psi omega"
LETTERS = dict(zip(NAMES.split(), "αβγδεεζθκμξπρστφψω", strict=True))
SIGNS = {"leq": "≤", "geq": "≥", "sim": "~", "int": "∫", "sum": "Σ", "ell": "ℓ", "quad": "  ", "left": "", "right": ""}
DOTTED = "\u0307"
INDEX = {"0": "₀", "1": "₁", "2": "₂", "3": "₃"}
POWER = {"2": "²", "3": "³", "4": "⁴", "5": "⁵"}


def law_text(latex: str) -> str:
    """A line of text for an equation in the LaTeX that effects use."""
    text = latex.replace("\n", " ")
    text = re.sub(r"\\math(?:rm|cal)\{([^{}]*)\}", lambda m: m[1], text)
    text = re.sub(r"\\dot\s*\\?(\w+)", lambda m: LETTERS.get(m[1], m[1]) + DOTTED, text)
    text = re.sub(r"\\([a-zA-Z]+)", _word, text)
    text = re.sub(r"\\[,;: ]", " ", text)
    before = ""
    while before != text:  # from the inside out
        before = text
        text = re.sub(r"_\{([^{}]*)\}", lambda m: f"_({m[1]})", text)
        text = re.sub(r"\^\{([^{}]*)\}", lambda m: f"^({m[1]})", text)
        text = re.sub(r"⟨sqrt⟩\s*\{([^{}]*)\}", r"sqrt(\1)", text)
        text = re.sub(r"⟨frac⟩\s*\{([^{}]*)\}\s*\{([^{}]*)\}", lambda m: f"{_bracketed(m[1])}/{_bracketed(m[2])}", text)
    text = re.sub(r"_(\d)(?!\d)", lambda m: INDEX.get(m[1], m[0]), text)
    text = re.sub(r"\^(\d)(?!\d)", lambda m: POWER.get(m[1], m[0]), text)
    text = re.sub(r"(?<=[)+\-\w])(sgn|tanh)(?=\()", r" \1", text)
    text = re.sub(r"\b(sin|cos)(?=[^\W\d])", r"\1 ", text)
    text = re.sub(r"([(]) +| +([,)])", r"\1\2", text)
    return re.sub(r" {3,}", "  ", text).strip()


def _word(match: re.Match[str]) -> str:
    word = match[1]
    if word in ("frac", "sqrt"):
        return f"⟨{word}⟩"
    return LETTERS.get(word, SIGNS.get(word, word))


def _bracketed(part: str) -> str:
    return part if re.fullmatch(r"\w+", part.strip()) else f"({part.strip()})"
