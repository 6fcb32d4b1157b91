"""Sentences of pages, notebooks, comments and docstrings name their subject first."""

import json
import re
from pathlib import Path

import pytest

from prose import readable, sentences
from sources import relative

# These words put off the subject of a statement, or leave it out. Only a question may begin so.
LATE = re.compile(r"(?:Of|What|Where)\b(?!.*\?[)*_\"”]*$)")
WRONG = {
    "page.md": "# What it is\n\nA radius is a length.\nWhat is smaller does not count.\n",
    "list.md": "- Good.\n- Where it ends, nothing is.\n",
    "table.md": "| What | Where |\n| --- | --- |\n| What it is | here. Of these, two. |\n",
    "cells.ipynb": json.dumps({"cells": [{"cell_type": "markdown", "source": ["**All.** What is\n", "there."]}]}),
    "docstring.py": 'def f():\n    """What a panel draws."""\n',
    "comment.py": "x = 1  # Of the box\n",
    "lines.cpp": "// The first line ends here. Where the\n// second begins, x.\nint x;\n",
    "trailing.h": "int x; // What it is\nint y; // the other one\n",
    "block.glsl": "/* What a\n * block says. */\n",
    "script.sh": "run --all # Where it runs\n",
}
RIGHT = {
    "page.md": "# What it is\n\nA part of what is there, where it is. What is it?\n\n```\nWhat code says.\n```\n",
    "table.md": "| What | Where |\n| --- | --- |\n| What it is | here |\n",
    "code.py": 'WORDS = "What a string says."  # words of what\n',
}


def test_no_sentence_begins_with_of_what_or_where():
    found, count = [], 0
    for path in readable():
        each = sentences(path.read_text(encoding="utf-8"), path.suffix)
        count += len(each)
        found += [f"{relative(path)}: {sentence[:100]}" for sentence in each if LATE.match(sentence)]
    assert count > 10_000
    assert not found, "\n".join(found)


def late(files: dict[str, str], name: str) -> list[str]:
    """The sentences of an example that begin late."""
    return [sentence for sentence in sentences(files[name], Path(name).suffix) if LATE.match(sentence)]


@pytest.mark.parametrize("name", WRONG)
def test_such_a_sentence_is_found_in_every_kind_of_file(name):
    assert len(late(WRONG, name)) == 1


@pytest.mark.parametrize("name", RIGHT)
def test_titles_questions_and_code_may_begin_so(name):
    assert late(RIGHT, name) == []
