"""The sentences that people read in the project: those of pages, notebooks, comments and docstrings."""

import ast
import io
import json
import re
import tokenize
from pathlib import Path

from sources import ROOT

FOLDERS = ("addon", "blend_samples", "native", "shaders", "tests")
MADE = {"__pycache__", "lib", "out", "results-quick"}  # folders that are made there
SLASHES = {".cpp", ".h", ".c", ".glsl", ".frag", ".vert", ".comp", ".def", ".js"}
HASHES = {".sh", ".cmake", ".txt", ".toml", ".yaml", ".yml"}
SCOPES = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
# A sentence begins behind a blank line, behind the end of another one, or behind a dash.
BEGIN = re.compile(r"(?:\n\s*\n|(?<=[.!?:;])[)*_\"”]*\s|\s[–—]\s)[\s*_(\"“]*(?=[A-Z])")


def readable() -> list[Path]:
    """The files of the project that have sentences for people."""
    kinds = SLASHES | HASHES | {".py", ".md", ".ipynb"}
    found = [*ROOT.glob("*.*"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.*"))]
    return sorted(path for path in found if path.suffix in kinds and not MADE & set(path.parts[len(ROOT.parts) :]))


def sentences(text: str, kind: str) -> list[str]:
    """The sentences of a file, by the ending of its name."""
    found = []
    for part in parts(text, kind):
        starts = [0, *(begin.end() for begin in BEGIN.finditer(part))]
        found += [" ".join(part[start:end].split()) for start, end in zip(starts, [*starts[1:], None], strict=True)]
    return [sentence for sentence in found if sentence]


def parts(text: str, kind: str) -> list[str]:
    """The parts of a file that are written for people."""
    if kind == ".ipynb":
        cells = json.loads(text)["cells"]
        return [page("".join(cell["source"])) for cell in cells if cell["cell_type"] == "markdown"]
    if kind == ".md":
        return [page(text)]
    if kind == ".py":
        scopes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, SCOPES)]
        return [*(ast.get_docstring(node) or "" for node in scopes), *joined(python_comments(text))]
    if kind in HASHES:
        return joined(line_comments(text, "#"))
    blocks = [re.sub(r"^\s*\*", "", found, flags=re.M) for found in re.findall(r"/\*+<?(.*?)\*/", text, re.S)]
    return [*joined(line_comments(text, "//")), *blocks]


def page(text: str) -> str:
    """Paragraphs, items of lists and cells of tables; no headings, first rows and first columns, which are titles."""
    text = re.sub(r"^(```|\$\$).*?^\1", "", text, flags=re.M | re.S)
    text = re.sub(r"^#+ .*$|^\s*!\[.*$|^\|.*\n\|[ :|-]+$", "", text, flags=re.M)
    text = re.sub(r"^\|[^|\n]*", "", text, flags=re.M)
    text = re.sub(r"^\s*(?:[-*>]|\d+\.) ", "\n\n", text, flags=re.M)
    return re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text).replace("|", "\n\n")


Comment = tuple[int, int, bool, str]  # row, column, whether the row has nothing else, words


def python_comments(text: str) -> list[Comment]:
    """The comments of Python."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    marked = [token for token in tokens if token.type == tokenize.COMMENT]
    return [(*token.start, not token.line[: token.start[1]].strip(), token.string.lstrip("#: ")) for token in marked]


def line_comments(text: str, mark: str) -> list[Comment]:
    """Comments from a mark to the end of a line."""
    found = []
    for row, line in enumerate(text.splitlines()):
        if comment := re.search(rf"(?:^|(?<=\s)){mark}+[!<]* ?(.*)$", line):
            found.append((row, comment.start(), not line[: comment.start()].strip(), comment[1]))
    return found


def joined(comments: list[Comment]) -> list[str]:
    """The texts of comments; those in successive rows that begin in one column are one."""
    found, last = [], None
    for row, column, alone, words in comments:
        if alone and last == (row - 1, column):
            found[-1] += f"\n{words}"
        else:
            found.append(words)
        last = (row, column)
    return found
