"""The project's own source files, and where their functions begin and end."""

import ast
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# The folders and endings that count, and the language that lizard is told: GLSL is near enough to C for it.
KINDS = {
    "C++": ("native/src", (".cpp", ".h", ".c"), "text.cpp"),
    "GLSL": ("shaders", (".glsl", ".h"), "text.c"),
    "Python": ("addon", (".py",), None),
}


@dataclass(frozen=True, order=True)
class Function:
    """A function from its signature to its closing brace."""

    lines: int
    path: str
    name: str
    start: int

    def __str__(self) -> str:
        return f"{self.path}:{self.start} {self.name}, {self.lines} lines"


def files(kind: str) -> list[Path]:
    """The source files of a language."""
    folder, endings, _ = KINDS[kind]
    return sorted(path for path in (ROOT / folder).rglob("*") if path.suffix in endings)


def relative(path: Path) -> str:
    """The path as people write it."""
    return path.relative_to(ROOT).as_posix()


def functions(kind: str) -> list[Function]:
    """Every function of a language, the longest first."""
    found = []
    for path in files(kind):
        found += python_functions(path) if kind == "Python" else other_functions(path, KINDS[kind][2])
    return sorted(found, reverse=True)


def other_functions(path: Path, name: str) -> list[Function]:
    """Functions of C, C++ and GLSL."""
    import lizard

    listed = lizard.analyze_file.analyze_source_code(name, path.read_text()).function_list
    where = relative(path)
    return [Function(item.end_line - item.start_line + 1, where, item.name, item.start_line) for item in listed]


def python_functions(path: Path) -> list[Function]:
    """Functions and methods, each with what is defined inside, and without the lines of its docstring."""
    return [
        Function(node.end_lineno - node.lineno + 1 - docstring_lines(node), relative(path), node.name, node.lineno)
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]


def docstring_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """The number of lines that documentation takes, which may be as long as it needs to be."""
    return len((ast.get_docstring(node, clean=False) or "").splitlines())
