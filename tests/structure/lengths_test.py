"""Functions and files are short enough to be read at a glance."""

import pytest

from sources import KINDS, files, functions, relative

LONGEST = 60  # lines of a function
SHORT = 30  # nine functions in ten are shorter
FILE = 450  # a file is shorter
# If there are fewer functions for each file, the parser has missed some.
PARSED = 0.5


@pytest.fixture(params=KINDS)
def kind(request):
    """A language whose functions can be told apart here."""
    if request.param != "Python":
        pytest.importorskip("lizard", reason="lizard, which finds functions of C++ and GLSL, is not installed")
    return request.param


def test_the_parser_finds_functions(kind):
    assert len(functions(kind)) > PARSED * len(files(kind)) > 0


def test_no_function_is_longer_than_60_lines(kind):
    long = [str(item) for item in functions(kind) if item.lines > LONGEST]
    assert not long, "\n".join(long)


def test_nine_functions_in_ten_are_shorter_than_30_lines(kind):
    found = functions(kind)
    long = [item for item in found if item.lines >= SHORT]
    assert len(long) <= len(found) / 10, "\n".join(map(str, long))


@pytest.mark.parametrize("language", KINDS)
def test_every_file_is_shorter_than_450_lines(language):
    lengths = {relative(path): len(path.read_text().splitlines()) for path in files(language)}
    long = {path: lines for path, lines in lengths.items() if lines >= FILE}
    assert lengths
    assert not long, long
