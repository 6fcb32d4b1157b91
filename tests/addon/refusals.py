"""Provokes refusals of files, and tells which of a module's a test provokes: which lines that raise have run."""

import ast
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from paradesc.bridge import InputError


def refusal(read, path, content):
    """The sentence by which a reader refuses a file with this content, bytes or text."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as found:
        read(path)
    said = found.value.sentence
    assert str(path) in said
    assert "\n" not in said
    assert said.endswith(".")
    assert not said.endswith("..")
    return said


def failing(error):
    """A reader that fails whatever it reads."""

    def fails(_path):
        raise error

    return fails


def raising_lines(modules):
    """Each line of the modules that raises something of its own, by file and number."""
    found = set()
    for module in modules:
        tree = ast.parse(Path(module.__file__).read_text(encoding="utf-8"))
        nodes = (node for node in ast.walk(tree) if isinstance(node, ast.Raise) and node.exc is not None)
        found |= {(module.__file__, node.lineno) for node in nodes}
    return found


@contextmanager
def lines_run(modules):
    """The lines of the modules that run meanwhile, by file and number."""
    files, seen = {module.__file__ for module in modules}, set()

    def trace(frame, event, _):
        if frame.f_code.co_filename not in files:
            return None
        if event == "line":
            seen.add((frame.f_code.co_filename, frame.f_lineno))
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield seen
    finally:
        sys.settrace(before)


def check_all_provoked(modules, provoke):
    """Fails with the lines that raise and that provoke() does not reach."""
    wanted = raising_lines(modules)
    with lines_run(modules) as seen:
        provoke()
    assert wanted
    assert not wanted - seen, sorted(wanted - seen)
