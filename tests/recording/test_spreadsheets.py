"""Spreadsheets: which sheet is read, and what is refused."""

import zipfile
from xml.sax.saxutils import escape

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camid.errors import InputError
from camid.recording.options import Reading
from camid.recording.read import read_recordings
from camid.recording.sheets import tables_of_sheets
from tests.support.recordings import COUNT, T, U, Y, check_one_line, read, refusal


def workbook(path, sheets):
    """A minimal .xlsx: lists of rows by the names of the sheets."""

    def cell(value):
        if isinstance(value, str):
            return f'<c t="inlineStr"><is><t>{escape(value)}</t></is></c>'
        return f"<c><v>{value!r}</v></c>"

    main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006"
    kind = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    count = range(1, len(sheets) + 1)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{package}/content-types">'
            '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
            f'<Override PartName="/xl/workbook.xml" ContentType="{kind}.sheet.main+xml"/>'
            + "".join(
                f'<Override PartName="/xl/worksheets/sheet{k}.xml" ContentType="{kind}.worksheet+xml"/>' for k in count
            )
            + "</Types>",
        )
        relations = f'<Relationships xmlns="{package}/relationships">'
        archive.writestr(
            "_rels/.rels",
            f'{relations}<Relationship Id="r1" Type="{office}/officeDocument" Target="xl/workbook.xml"/>'
            "</Relationships>",
        )
        archive.writestr(
            "xl/workbook.xml",
            f'<workbook xmlns="{main}" xmlns:r="{office}"><sheets>'
            + "".join(f'<sheet name="{n}" sheetId="{k}" r:id="r{k}"/>' for k, n in zip(count, sheets, strict=True))
            + "</sheets></workbook>",
        )
        archive.writestr(
            "xl/_rels/workbook.xml.rels",
            relations
            + "".join(
                f'<Relationship Id="r{k}" Type="{office}/worksheet" Target="worksheets/sheet{k}.xml"/>' for k in count
            )
            + "</Relationships>",
        )
        for k, rows in zip(count, sheets.values(), strict=True):
            body = "".join(f"<row>{''.join(cell(v) for v in row)}</row>" for row in rows)
            archive.writestr(
                f"xl/worksheets/sheet{k}.xml",
                f'<worksheet xmlns="{main}"><sheetData>{body}</sheetData></worksheet>',
            )


def rows_of(gain=1.0, header=("t", "u", "y"), units=None):
    body = [[float(t), gain * float(u), float(y)] for t, u, y in zip(T, U, Y, strict=True)]
    return [list(header), *([units] if units else []), *body]


def test_sheets(tmp_path):
    path = tmp_path / "a.xlsx"
    workbook(path, {"notes": [["made by hand"]], "first": rows_of(), "second": [["Run 2"], *rows_of(2.0)]})
    assert "the sheets first, second all have these columns; say group: first under recording" in refusal(path)
    found = read(path, group="/")
    assert [one.experiment for one in found] == ["first", "second"]
    np.testing.assert_array_equal(found[1].columns["u"], 2 * U)
    np.testing.assert_array_equal(read(path, group="second")[0].columns["u"], 2 * U)
    assert "no sheet 'third'; known here: notes, first, second" in refusal(path, group="third")
    assert "a spreadsheet file has no separator" in refusal(path, separator=";")
    workbook(path, {"notes": [["made by hand"]], "first": rows_of()})
    assert "the sheet 'first' of 2 is read" in read(path)[0].warnings[0]


def test_one_sheet_with_units_without_names_and_with_a_wrong_cell(tmp_path):
    path = tmp_path / "a.xlsx"
    workbook(path, {"Sheet1": rows_of(units=["ms", "V", "mm"])})
    (found,) = read(path)
    assert found.period == pytest.approx(2e-5)
    np.testing.assert_allclose(found.columns["y"], 1e-3 * Y)
    workbook(path, {"Sheet1": rows_of()[1:]})
    assert "row 1: the first row holds numbers, not names; say header: false" in refusal(path)
    reading = Reading(header=False, columns=("t", "u", "y"))
    assert len(read_recordings(path, "t", ("u", "y"), (), reading, {"u": "zoh"})[0]) == COUNT
    wrong = rows_of()
    wrong[8][2] = "x"
    workbook(path, {"Sheet1": wrong})
    assert "row 9, column 'y': 'x' where a number should be" in refusal(path)


cell_values = st.sampled_from(["", "t", "u", "mm", "-", 1.0, 2.5, -3.0, True]) | st.floats(-9.0, 9.0) | st.dates()


@given(
    st.dictionaries(
        st.sampled_from(["A", "B"]), st.lists(st.lists(cell_values, min_size=1, max_size=4), min_size=1, max_size=8)
    ),
    st.sampled_from([None, "/", "A", "C"]),
    st.booleans(),
)
@settings(max_examples=200, deadline=None)
def test_any_sheets_are_read_or_refused_in_one_line(sheets, group, header):
    sheets = {name: rows for name, rows in sheets.items() if any(c != "" for row in rows for c in row)}
    reading = Reading(group=group, header=header, columns=() if header else ("t", "u"))
    try:
        tables = tables_of_sheets(sheets, "a.xlsx", ["t", "u"], reading)
        for table in tables:
            assert len({len(column) for column in table.columns.values()}) <= 1
            for column in table.columns:
                table.column(column)
    except InputError as refused:
        check_one_line(refused)
