"""The second step, for clips: what the marker looks like, where it is, and how long a pixel is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import events, ui

from camid.studio.marker import APPEARANCES, CLICKS, Marker
from camid.studio.project import FRAME, PREVIEW

if TYPE_CHECKING:
    from camid.studio.page import Page

NEXT = {"region": "now the opposite corner", "scale": "now the other end of the line"}


def draw(page: Page) -> None:
    """The first frame with what is chosen on it, the choices in words, and what was tracked."""
    project, work = page.work.project, page.work
    if project.frame is None:
        page.button("Look at the clip", work.look_at_clip)
        return
    _image(page)
    _choices(page)
    with ui.element("div").classes("studio-buttons"):
        page.button("Find the marker again", work.look_at_clip, main=False)
        page.button("Track the marker", work.track)
    if project.tracked is not None:
        found = project.tracked
        ui.label(
            f"{found['rows']} of {found['frames']} frames with the marker ({found['marker']}), "
            f"{found['effective_rate']:.4g} frames per second, positions in {found['unit']}"
        ).classes("studio-fact")
        page.picture(PREVIEW, "Path of the marker, x and y over time")


def _image(page: Page) -> None:
    """The frame, which takes clicks."""
    project = page.work.project
    frame, marker = project.frame, project.marker
    assert frame is not None
    meaning = page.chosen.setdefault("click", "region")
    says = ui.label(_sentence(frame, marker, meaning)).classes("studio-fact").mark("marker-sentence")

    def chosen(event: events.ValueChangeEventArguments) -> None:
        page.chosen["click"] = event.value
        marker.corner = None
        says.set_text(_sentence(frame, marker, event.value))

    async def clicked(event: events.MouseEventArguments) -> None:
        meaning = page.chosen["click"]
        if page.work.busy and meaning in {"region", "colour"}:  # after which the marker is looked for
            ui.notify("Something is running: wait for its end, or cancel it.", type="warning")
            return
        x = min(max(event.image_x, 0.0), frame["width"] - 0.01)
        y = min(max(event.image_y, 0.0), frame["height"] - 0.01)
        colour = _colour_at(page, x, y) if meaning == "colour" else ""
        more = marker.click(meaning, x, y, colour)
        if more or meaning in {"scale", "origin"}:
            image.set_content(_overlay(frame, marker))
            says.set_text(_sentence(frame, marker, meaning))
        else:
            page.begin(page.work.look_at_clip)

    ui.radio(CLICKS, value=meaning, on_change=chosen).props("dense").classes("studio-clicks").mark("clicks")
    image = ui.interactive_image(
        page.address(FRAME), content=_overlay(frame, marker), on_mouse=clicked, cross="#999999", sanitize=False
    )
    image.classes("studio-frame").mark("frame").props('alt="The first frame of the clip"')


def _sentence(frame: dict[str, Any], marker: Marker, meaning: str) -> str:
    """What is seen on the image, or what the next click is for."""
    if marker.corner is not None or (meaning == "scale" and len(marker.ends) == 1):
        return f"First point taken; {NEXT[meaning]}."
    if meaning == "scale" and marker.pixels:
        return f"The line is {marker.pixels:.1f} px long: type its length below."
    if "problem" in frame:
        return f"Not found yet: {frame['problem']}"
    found = frame["marker"]
    return f"Found: {found['what']} at x {found['x']:.1f}, y {found['y']:.1f} px. Correct it if it is not the marker."


def _overlay(frame: dict[str, Any], marker: Marker) -> str:
    """SVG over the image, made of numbers alone; white on black is seen on any picture."""
    unit = max(frame["width"], frame["height"]) / 400.0
    shapes = []
    if (found := frame.get("marker")) is not None:
        left, top, width, height = found["region"]
        x, y = found["x"] + 0.5, found["y"] + 0.5
        shapes.append(
            f'<rect x="{left + 0.5:.2f}" y="{top + 0.5:.2f}" width="{width:.2f}" height="{height:.2f}" {{}}/>'
        )
        shapes.append(f'<path d="{_cross(x, y, 6.0 * unit)}" {{}}/>')
    if marker.corner is not None:
        shapes.append(f'<path d="{_cross(*marker.corner, 5.0 * unit)}" {{}}/>')
    if marker.ends:
        ends = " L ".join(f"{x:.2f} {y:.2f}" for x, y in marker.ends)
        crosses = " ".join(_cross(x, y, 4.0 * unit) for x, y in marker.ends)
        shapes.append(f'<path d="M {ends} {crosses}" {{}}/>')
    if marker.origin is not None:
        x, y = marker.origin
        shapes.append(
            f'<path d="{_cross(x, y, 9.0 * unit)}" {{}}/><circle cx="{x:.2f}" cy="{y:.2f}" r="{4 * unit:.2f}" {{}}/>'
        )
    strokes = [f'fill="none" stroke="{c}" stroke-width="{w * unit:.3f}"' for c, w in (("black", 3.0), ("white", 1.2))]
    return "".join(shape.replace("{}", stroke) for stroke in strokes for shape in shapes)


def _cross(x: float, y: float, size: float) -> str:
    return f"M {x - size:.2f} {y:.2f} H {x + size:.2f} M {x:.2f} {y - size:.2f} V {y + size:.2f}"


def _colour_at(page: Page, x: float, y: float) -> str:
    """Mean colour of the pixels around a point of the frame, ``#rrggbb``."""
    import cv2

    image = cv2.imread(str(page.work.project.folder / FRAME))
    if image is None:
        return ""
    around = image[max(int(y) - 1, 0) : int(y) + 2, max(int(x) - 1, 0) : int(x) + 2]
    blue, green, red = (round(float(v)) for v in around.reshape(-1, 3).mean(axis=0))
    return f"#{red:02x}{green:02x}{blue:02x}"


def _choices(page: Page) -> None:
    """The same choices as fields, for those who do not click."""
    marker = page.work.project.marker

    def keep(name: str) -> Any:
        return lambda event: setattr(marker, name, event.value)

    with ui.element("div").classes("studio-fields"):
        ui.select(APPEARANCES, label="The marker is", value=marker.appearance, on_change=keep("appearance")).props(
            "outlined dense"
        )
        ui.input("Colour", value=marker.colour, on_change=keep("colour")).props(
            'outlined dense hint="a name such as red, or #rrggbb"'
        )
        ui.input(
            "Region", value=" ".join(map(str, marker.region or ())), on_change=lambda e: _region(marker, e.value)
        ).props('outlined dense hint="x y width height in px; empty: found"')
        ui.number("Length of the line", value=marker.length, min=0, on_change=keep("length")).props(
            'outlined dense hint="between the two points"'
        )
        ui.input("Unit", value=marker.unit, on_change=keep("unit")).props('outlined dense hint="m, cm, mm, …"')
        ui.checkbox("y points up", value=marker.upwards, on_change=keep("upwards"))
    with (
        ui.expansion("Part of the clip, and frames without time stamps").classes("studio-more"),
        ui.element("div").classes("studio-fields"),
    ):
        for name, label in (("start", "Start in s"), ("end", "End in s"), ("frame_rate", "Frames per second")):
            ui.number(label, value=getattr(marker, name), on_change=keep(name)).props("outlined dense")


def _region(marker: Marker, text: str) -> None:
    """Take a region that is typed as four numbers."""
    words = text.replace(",", " ").split()
    if not words:
        marker.region = None
    elif len(words) == 4 and all(word.isdecimal() for word in words):
        left, top, width, height = map(int, words)
        marker.region = (left, top, width, height)
