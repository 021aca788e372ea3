"""Files that were made to hurt: small ones that unpack to gigabytes, circles, pipes, text that is code elsewhere."""

import gzip
import os
import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pandas as pd

from tests.support import linear_rig as rig

SCRIPT = "<script>alert(1)</script>"
# Of one cell in the last row and column.
SHEET = (
    '<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>'
    '<row r="1"><c r="A1"><v>1</v></c></row><row r="1048576"><c r="XFD1048576"><v>1</v></c></row>'
    "</sheetData></worksheet>"
)
OPEN_XML = "http://schemas.openxmlformats.org/"
WORKBOOK = {
    "[Content_Types].xml": f'<Types xmlns="{OPEN_XML}package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="xml" ContentType="application/xml"/></Types>',
    "_rels/.rels": f'<Relationships xmlns="{OPEN_XML}package/2006/relationships"><Relationship Id="r1" '
    f'Type="{OPEN_XML}officeDocument/2006/relationships/officeDocument" Target="xl/workbook.xml"/></Relationships>',
    "xl/workbook.xml": f'<workbook xmlns="{OPEN_XML}spreadsheetml/2006/main" '
    f'xmlns:r="{OPEN_XML}officeDocument/2006/relationships">'
    '<sheets><sheet name="a" sheetId="1" r:id="r1"/></sheets></workbook>',
    "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{OPEN_XML}package/2006/relationships"><Relationship Id="r1" '
    f'Type="{OPEN_XML}officeDocument/2006/relationships/worksheet" Target="worksheets/sheet1.xml"/></Relationships>',
    "xl/worksheets/sheet1.xml": SHEET,
}


def good_yaml():
    """Text of a simulation that is right."""
    path = Path("good.yaml")
    rig.write_yaml(rig.simulation(), path)
    text = path.read_text()
    path.unlink()
    return text


def simulations(owned):
    """Texts of hostile simulation files, by names; ``owned`` is a file that code in one of them would make."""
    good = good_yaml()
    laughs = "a: &a [lol, lol, lol, lol, lol, lol, lol, lol, lol]\n"
    for before, name in zip("abcdefghi", "bcdefghij", strict=True):
        laughs += f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n"
    nested = "&a [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]"
    for before, name in zip("abcdefgh", "bcdefghi", strict=True):
        nested += f", &{name} [{', '.join([f'*{before}'] * 9)}]"
    return {
        "billion-laughs": laughs + good,
        "billion-laughs-inside": good.replace("plant:", f"plant:\n  covariance: [{nested}]"),
        "billion-laughs-merged": good
        + "k0: &k0 {a: 1}\n"
        + "".join(f"k{i}: &k{i} {{<<: [*k{i - 1}, *k{i - 1}]}}\n" for i in range(1, 60)),
        "nested-lists": good.replace("[300.0]", "[" * 3000 + "1" + "]" * 3000),
        "nested-open": good + "effects: " + "[" * 100_000,
        "nested-maps": good + "effects: " + "{a: " * 20_000,
        "nested-dashes": good + "effects:\n" + "- " * 2000 + "1\n",
        "circle": good.replace("[300.0]", "&x [*x]"),
        "code": good.replace("[300.0]", f"!!python/object/apply:os.system ['touch {owned}']"),
        "long-integer": good.replace("300.0", "9" * 100_000),
        "infinite-exponent": good.replace("300.0", "1e999999999"),
        "zero-byte": good + "\0",
        "large": good + "# " + "x" * 5_000_000,
        "base-sixty": good.replace("300.0", "1:" * 5000 + "1"),
        "binary": good.replace("column: u", "column: !!binary aGVsbG8="),
        "set": good.replace("column: u", "column: !!set {a, b}"),
        "two-documents": good + "---\n" + good,
    }


def _archived(path, content, repeated):
    if path.suffix == ".gz":
        with gzip.open(path, "wb") as file:
            file.write(b"t,u,y\n")
            for _ in range(repeated):
                file.write(content)
    else:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("a.csv", "w") as file:
            file.write(b"t,u,y\n")
            for _ in range(repeated):
                file.write(content)


def _png(width, height):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" * 999)) + chunk(b"IEND", b"")
    )


def recordings(folder, *, unpacked):
    """Hostile recordings in a folder; the archives unpack to more than ``unpacked`` bytes."""
    import h5py
    import pyarrow as pa
    import pyarrow.parquet as pq
    import scipy.io

    zeros = b"0,0,0\n" * 200_000
    repeated = unpacked // len(zeros) + 2
    _archived(folder / "bomb.csv.gz", zeros, repeated)
    _archived(folder / "bomb.csv.zip", zeros, repeated)
    with h5py.File(folder / "bomb.h5", "w") as file:
        file.create_dataset("t", shape=(10**11,), chunks=(1000,), dtype="f8")
        file["u"] = file["y"] = np.arange(5.0)
    with h5py.File(folder / "circle.h5", "w") as file:
        file["t"] = file["u"] = file["y"] = np.arange(5.0)
        file["around"] = file["/"]
    with h5py.File(folder / "elsewhere.h5", "w") as file:
        file["t"], file["u"] = np.arange(5.0), np.arange(5.0)
        file["y"] = h5py.ExternalLink("bomb.h5", "/y")
    with h5py.File(folder / "virtual.h5", "w") as file:
        layout = h5py.VirtualLayout(shape=(5,), dtype="f8")
        layout[:] = h5py.VirtualSource("bomb.h5", "y", shape=(5,))
        file["t"], file["u"] = np.arange(5.0), np.arange(5.0)
        file.create_virtual_dataset("y", layout)
    column = np.zeros(10**6)
    with pq.ParquetWriter(folder / "bomb.parquet", pa.schema([(n, pa.float64()) for n in "tuy"])) as writer:
        for _ in range(unpacked // (24 * 10**6) + 1):
            writer.write_table(pa.table(dict.fromkeys("tuy", column)), row_group_size=10**6)
    many = np.zeros(unpacked // 24 + 1000)
    scipy.io.savemat(folder / "bomb.mat", dict.fromkeys("tuy", many), do_compression=True)
    scipy.io.savemat(folder / "sizes.mat", {"t": np.arange(5.0), "u": np.arange(5.0), "y": np.arange(5.0)})
    data = (folder / "sizes.mat").read_bytes()
    (folder / "sizes.mat").write_bytes(data.replace(struct.pack("<ii", 1, 5), struct.pack("<ii", 2**15, 2**16)))
    with zipfile.ZipFile(folder / "far.xlsx", "w") as archive:
        for name, content in WORKBOOK.items():
            archive.writestr(name, content)
    (folder / "one-line.csv").write_bytes(b"t,u,y\n" + b"1," * 2_000_000)
    (folder / "open-quote.csv").write_bytes(b't,u,y\n0,1,"' + b"x" * 3_000_000)
    (folder / "long-cell.csv").write_bytes(b't,u,y\n0,1,"' + b"x" * 300_000 + b'"\n1,2,3\n2,3,4\n')
    names = ",".join(f"c{i}" for i in range(50_000))
    (folder / "many-columns.csv").write_text(f"{names}\n" + "\n".join([",".join("1" * 50_000)] * 3))
    (folder / "unsorted.csv").write_text("t,u,y\n3,1,2\n2,1,3\n1,1,4\n")
    (folder / "zeros.csv").write_bytes(b"\0" * 10_000)
    os.mkfifo(folder / "pipe.csv")
    return sorted(p for p in folder.iterdir() if p.is_file() or p.name == "pipe.csv")


def videos(folder):
    """Folders of hostile pictures, and what is no video."""
    for name, size in (("huge", (100_000, 100_000)), ("broken", (3000, 3000))):
        (folder / name).mkdir()
        for k in range(3):
            (folder / name / f"{k:03}.png").write_bytes(_png(*size))
    (folder / "list.m3u8").write_text("#EXTM3U\n#EXTINF:1,\nfile:///etc/hostname\n#EXT-X-ENDLIST\n")
    (folder / "concat.ffconcat").write_text("ffconcat version 1.0\nfile /etc/hostname\n")
    os.mkfifo(folder / "pipe.mp4")
    return [folder / name for name in ("huge", "broken", "list.m3u8", "concat.ffconcat", "pipe.mp4")]


def named(columns):
    """A recording whose three columns have these names."""
    table = rig.recording()
    return pd.DataFrame(dict(zip(columns, (table["t"], table["u"], table["y"]), strict=True)))
