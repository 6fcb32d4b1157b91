"""Recognizes files that are not of the kind their name says: a pointer, a web page, an archive, or text in UTF-16."""

import re

FIRST_BYTES = 1024
BEGINNINGS = (
    (b"version https://git-lfs", "it is a pointer of Git LFS, and not the file itself, which git lfs pull fetches"),
    (b"\x1f\x8b", "it is compressed by gzip; unpack it first"),
    (b"PK\x03\x04", "it is a .zip; unpack it first"),
    (b"BZh", "it is compressed by bzip2; unpack it first"),
    (b"\xfd7zXZ", "it is compressed by xz; unpack it first"),
    (b"7z\xbc\xaf", "it is a .7z; unpack it first"),
    (b"\xff\xfe", "it is text in UTF-16; save it as UTF-8"),
    (b"\xfe\xff", "it is text in UTF-16; save it as UTF-8"),
)
WEB_PAGE = re.compile(rb"(?:\xef\xbb\xbf)?\s*<(?:!doctype html|html|\?xml|head|body)", re.IGNORECASE)
XML = (".vtp", ".gii")
# Two letters, each with a zero byte before or after it.
WIDE_TEXT = re.compile(rb"(?:[\t\n\r -~]\0){2}|(?:\0[\t\n\r -~]){2}")
MNI = re.compile(rb"[Pp]\s+[-+.\deE]+\s+[-+.\deE]+\s+[-+.\deE]+\s")
# The first bytes of the other formats; files sometimes have a name with the wrong ending.
OTHERS = ((b"ply", ".ply"), (b"glTF", ".glb"), (b"solid ", ".stl"), (b"OFF", ".off"))
TEXTS = (".obj", ".off")


def fault(suffix: str, first: bytes) -> str:
    """Says what a file is instead, if this suffix does not fit its first bytes; else ""."""
    found = next((sentence for beginning, sentence in BEGINNINGS if first.startswith(beginning)), "")
    if found:
        return found
    if not first:
        return "it is empty"
    page = WEB_PAGE.match(first)
    if page and not (suffix in XML and page[0].endswith(b"?xml")):
        return "it is a web page, and not the file itself; fetch that"
    if suffix != ".stl" and WIDE_TEXT.match(first):
        return "it is text in UTF-16; save it as UTF-8"
    if suffix == ".obj" and MNI.match(first):
        return "it is a surface of the MNI tools, and no Wavefront file; convert it to .ply"
    for beginning, other in OTHERS if suffix in (*TEXTS, ".ply") else ():  # a binary .stl may begin with any words
        if suffix != other and first.startswith(beginning) and not first[len(beginning) :][:1].isalpha():
            return f"it begins as a {other}; rename it"
    if suffix in TEXTS and b"\0" in first:
        return "it is not text, which files of this kind are"
    return ""
