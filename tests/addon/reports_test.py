"""The reports of operators go through Blender's translation: whole sentences, into which numbers and names are put."""

import ast

import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

import longer  # noqa: E402

from paradesc import bridge  # noqa: E402
from paradesc_blender.settings import translation  # noqa: E402
from scene import add_sphere, small_bake  # noqa: E402
from shapes import ADDON, PACKAGES  # noqa: E402

# Sentences of these are put together from what was looked up.
MARKED = "«"


def reports():
    """Every call of an operator's report() in the add-on, and the file where it stands."""
    for path in sorted(path for package in PACKAGES for path in package.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "self.report" and len(node.args) == 2:
                yield path.relative_to(ADDON), node


def own_words(node):
    """The words that a report puts into its sentence as they stand in the code, without their being looked up."""
    looked_up = {
        id(part)
        for call in ast.walk(node)
        if isinstance(call, ast.Call) and ast.unparse(call.func).rpartition(".")[2] in ("said", "label")
        for part in ast.walk(call)
    }
    return [
        part.value
        for part in ast.walk(node)
        if isinstance(part, ast.Constant) and isinstance(part.value, str) and id(part) not in looked_up
        if any(map(str.isalpha, part.value))
    ]


def test_no_report_has_words_that_cannot_be_looked_up():
    found = list(reports())
    assert len(found) > 15
    for path, call in found:
        sentence = call.args[1]
        whole = isinstance(sentence, ast.Constant)  # Blender itself looks up what stands alone
        assert whole or own_words(sentence) == [], f"{path}:{call.lineno}"


@pytest.fixture
def looked_up(monkeypatch):
    """Marks what is looked up, and notes what does not stand in the code."""
    known, unknown = longer.shown() | translation.catalog("de").keys(), []

    def marked(text, *_context):
        if text not in known and MARKED not in text:
            unknown.append(text)
        return f"«{text}»"

    monkeypatch.setattr(translation, "look_up_report", marked)
    return unknown


@pytest.mark.usefixtures("registered")
def test_every_report_is_looked_up_as_it_stands_in_the_code(looked_up, capfd, tmp_path):
    target = add_sphere(steps=8)
    settings = small_bake("cpu")
    settings.texels, settings.buffer_size = 64, bridge.Options().buffer_size
    scene = bpy.context.scene
    scene.paradesc_animation.cache_folder = str(tmp_path)
    scene.paradesc_animation.use_scene_range = False
    scene.paradesc_animation.frame_start, scene.paradesc_animation.frame_end = 1, 2
    capfd.readouterr()
    operators = bpy.ops.paradesc
    steps = (
        operators.bake,
        operators.bake_image,
        operators.bake_frames,
        operators.fit_radius,
        operators.corner_colors,
        operators.vertex_group,
        operators.sculpt_mask,
        operators.export_copies,
    )
    for step in steps:
        assert step() == {"FINISHED"}, step
        said = [line for line in capfd.readouterr().out.splitlines() if line.startswith(("Info: ", "Warning: "))]
        assert said, step
        assert all("«" in line for line in said), said
        assert not any("{" in line for line in said), said
    assert looked_up == []
    assert target.vertex_groups
