"""Timers and renders write although Blender has lost track of whether Python may."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs Blender")

from live_values import NAME, baked_shape, live_settings, stretching_sphere, switch, values  # noqa: E402
from paradesc_blender.animation import sessions  # noqa: E402
from paradesc_blender.scene import arrays, ownership, writing  # noqa: E402

pytestmark = pytest.mark.usefixtures("registered")
REFUSED = f"Writing to ID classes {writing.REFUSAL}: Mesh, Mesh datablock, error setting Mesh.name"


def test_functions_are_called_at_once_where_python_may_write(monkeypatch):
    """Nothing is asked of Blender there."""
    monkeypatch.setattr(writing, "by_property", None)
    assert writing.is_allowed()
    assert writing.allowed(lambda *words, **named: (words, named))(1, two=2) == ((1,), {"two": 2})


def test_functions_are_called_by_a_property_where_nothing_may_be_written(monkeypatch):
    """Their results and errors arrive, even if one of them calls another one so."""
    monkeypatch.setattr(writing, "is_allowed", lambda: False)
    assert writing.insist(lambda: 3) == 3
    assert writing.insist(lambda: writing.insist(lambda: 4) + 1) == 5
    with pytest.raises(ZeroDivisionError):
        writing.insist(lambda: 1 / 0)
    assert writing.insist(lambda: None) is None
    assert "paradesc_asked" not in bpy.context.window_manager


def test_only_refusals_are_tried_again():
    """Another error of the same type is the function's own."""
    with pytest.raises(AttributeError, match="upper"):
        writing.insist(lambda: (3).upper())


@pytest.mark.parametrize(
    ("module", "name", "number"),
    [(ownership, "forget", 1), (arrays, "set_values", 1), (arrays, "set_values", 2)],
)
def test_values_are_complete_after_a_refusal_midway(monkeypatch, module, name, number):
    """Writing begins again where Blender has refused it, at the first frame and later."""
    target = stretching_sphere()
    function, calls = getattr(module, name), []

    def refusing(*words):
        calls.append(name)
        if len(calls) == number:
            raise AttributeError(REFUSED)
        return function(*words)

    monkeypatch.setattr(module, name, refusing)
    assert switch(target) == ""
    for frame in (1, 5):
        bpy.context.scene.frame_set(frame)
        np.testing.assert_allclose(values(target), baked_shape(target, live_settings(target)).values[NAME], atol=1e-5)
        calls.clear()
    assert target.paradesc_live.mode == "LIVE", target.paradesc_live.sentence
    assert sessions.session_at(target).seconds["write"] > 0.0
