"""The third step: what is believed of the rig, as a form, a chain and a text."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from nicegui import events, ui

from camid.studio import declaration

if TYPE_CHECKING:
    from camid.studio.page import Page
    from camid.studio.project import Project

PARTS = {
    "recording": "Recording",
    "input": "Input",
    "plant": "Plant",
    "sensor": "Sensor",
    "start": "Start",
}


def structure(project: Project) -> Any:
    """What the form consists of, without the values in it."""
    if (content := _content(project.simulation)) is None:
        return (project.simulation != "", project.columns is None)
    fields = declaration.fields_of(content, _names(project))
    return [(field.path, field.label, *(field.choices or ())) for field in fields]


def draw(page: Page) -> None:
    """The chain, the columns in use over time, the form, and the text; :func:`update` fills in what they hold."""
    project = page.work.project
    page.chosen["form"] = {}
    if not project.simulation:
        if project.columns is not None:
            page.button("Write a first simulation", page.work.draft)
        return
    # What is wrong in the text may leave nothing to show; the text is there to be corrected.
    content = _content(project.simulation)
    if content is not None:
        ui.label("A first guess: correct what you know better.").classes("studio-note")
        page.chosen["chain"] = ui.element("div").classes("studio-chain").props('role="img"')
        page.chosen["curves"] = ui.element("div")
        page.chosen["drawn"] = (None, None)
        _form(page, content)
    _text(page)


def update(page: Page) -> None:
    """Fill in what changed, and leave the fields where they are: somebody may be typing in the next one."""
    project = page.work.project
    content = _content(project.simulation)
    if content is None or not page.chosen.get("form"):
        return
    for field in declaration.fields_of(content, _names(project)):
        kept, element = page.chosen["form"].get(field.path, (None, None))
        if kept is not None and kept.value != field.value:
            page.chosen["form"][field.path] = (field, element)
            element.set_value(field.value)
    if page.chosen["text"] != project.simulation:  # what is typed and not used yet stays
        page.chosen["text"] = project.simulation
        page.chosen["yaml"].set_value(project.simulation)
    chain = declaration.chain_of(content)
    shown = [declaration.column_of(content, part) for part in ("time", "input", "sensor")]
    before = page.chosen["drawn"]
    page.chosen["drawn"] = (chain, shown)
    if before[0] != chain:
        page.chosen["chain"].clear()
        with page.chosen["chain"]:
            _chain(chain)
    if before[1] != shown:
        page.chosen["curves"].clear()
        with page.chosen["curves"]:
            _curves(page, *shown)


def _names(project: Project) -> list[str]:
    return (project.columns or {"names": []})["names"]


def _content(text: str) -> Any:
    """What the text holds; None where it is no mapping."""
    from ruamel.yaml.error import YAMLError

    try:
        content = declaration.parsed(text)
    except (YAMLError, ValueError, RecursionError):
        return None
    return content if isinstance(content, dict) else None


def _chain(chain: list[declaration.Block]) -> None:
    for k, block in enumerate(chain):
        if k:
            ui.element("span").classes("studio-arrow").props('aria-hidden="true"')
        with ui.element("div").classes(f"studio-block {block.name}"):
            ui.label(block.name).classes("studio-block-name")
            for line in block.lines:
                ui.label(line)


def _curves(page: Page, *columns: str | None) -> None:
    """Input and output of the recording over time."""
    curves = (page.work.project.columns or {"curves": {}})["curves"]
    shown = [name for name in columns[1:] if name in curves]
    if not shown:
        return
    time = curves.get(columns[0])
    height = 100.0 / len(shown)
    axis = {"axisLabel": {"color": "#888"}, "axisLine": {"lineStyle": {"color": "#888"}}}
    split = {"splitLine": {"lineStyle": {"color": "#8884"}}}
    series = [
        {
            "type": "line",
            "name": name,
            "xAxisIndex": k,
            "yAxisIndex": k,
            "showSymbol": False,
            "lineStyle": {"width": 1.5, "color": ("#E69F00", "#0A84C6")[k - len(shown)]},
            "data": [[k if time is None else time[k], v] for k, v in enumerate(curves[name])],
        }
        for k, name in enumerate(shown)
    ]
    grids = [
        {"left": 64, "right": 16, "top": f"{10 + k * height}%", "height": f"{height - 22}%"} for k in range(len(shown))
    ]
    unit = "row" if time is None else "s"
    ui.echart(
        {
            "animation": False,
            "grid": grids,
            "xAxis": [
                {"type": "value", "gridIndex": k, "scale": True, "name": unit, **axis, **split}
                for k in range(len(shown))
            ],
            "yAxis": [
                {
                    "type": "value",
                    "gridIndex": k,
                    "scale": True,
                    "splitNumber": 3,
                    "name": name,
                    "nameTextStyle": {"color": "#888"},
                    **axis,
                    **split,
                }
                for k, name in enumerate(shown)
            ],
            "series": series,
        }
    ).classes(f"studio-curves of-{len(shown)}").props('role="img" aria-label="Input and output over time"')


def _form(page: Page, content: Any) -> None:
    from camid.draft.templates import TEMPLATES

    work, project = page.work, page.work.project
    fields = declaration.fields_of(content, (project.columns or {"names": []})["names"])
    for part, title in PARTS.items():
        with ui.element("fieldset").classes("studio-part"):
            with ui.element("legend"):
                ui.label(title)
            with ui.element("div").classes("studio-fields"):
                for field in fields:
                    if field.part == part:
                        _field(page, field)
                if part == "plant":

                    def templated(event: events.ValueChangeEventArguments) -> None:
                        page.begin(work.draft, event.value or None)

                    names = {"": "numerator and denominator", **{n: t.title for n, t in TEMPLATES.items()}}
                    again = (
                        ui.select(names, label="Begin again with", on_change=templated)
                        .props('outlined dense hint="writes all guesses anew"')
                        .mark("template")
                    )
                    page.rests(again)


def _field(page: Page, field: declaration.Field) -> None:
    work, form = page.work, page.chosen["form"]

    def change(value: Any) -> None:
        text = "" if value is None else str(value)
        kept = form[field.path][0]
        if text != kept.value:
            form[field.path] = (replace(kept, value=text), element)
            page.begin(work.change, field.path, text)

    if field.choices is not None:
        choices = {**field.choices, **({} if field.value in field.choices else {field.value: field.value})}
        element: Any = ui.select(
            choices, label=field.label, value=field.value, on_change=lambda event: change(event.value)
        )
    else:
        element = ui.input(field.label, value=field.value)
        element.on("change", lambda: change(element.value))
    element.props("outlined dense").mark(".".join(field.path))
    element.props["hint"] = field.hint
    page.rests(element)
    form[field.path] = (field, element)


def _text(page: Page) -> None:
    """The simulation as it is given to the commands."""
    work, project = page.work, page.work.project
    wrong = "simulation" in project.errors
    with ui.expansion("As text (YAML), with the reasons of all guesses", value=wrong).classes("studio-more"):
        area = ui.textarea(value=project.simulation).props('outlined rows=24 input-class="studio-yaml"')
        page.chosen["yaml"], page.chosen["text"] = area, project.simulation
        page.button("Use this text", lambda: work.take_simulation(area.value), main=False)
