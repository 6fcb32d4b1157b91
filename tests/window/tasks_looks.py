"""Levels, one scale for several meshes, values as shaders read them, other languages, scales and themes of the interface."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np
import person
from scenes import as_found, clicked, empty, framed, monkey

from paradesc_blender.scene import arrays

if TYPE_CHECKING:
    from drive import Run


def colors(made: bpy.types.Object) -> np.ndarray:
    """(n,) linear values of the color that is shown."""
    return arrays.attribute_values(made.data.attributes[made.data.color_attributes.active_color.name])[:, 0]


def shown(made: bpy.types.Object) -> str:
    """The attribute whose colors are shown."""
    return made.data.color_attributes.active_color.name.removesuffix("_color")


def white(made: bpy.types.Object) -> float:
    """The value that is white in them."""
    return made.data["paradesc"]["ranges"][shown(made)][1]


def levels(run: "Run") -> Iterator[None]:
    """Contrast, brightness and invert act at once, without a bake."""
    made = monkey(2, applied=True)
    as_found()
    yield from clicked()
    looks, first = bpy.context.scene.paradesc_looks, colors(made).copy()
    for name, value in (("contrast", 0.5), ("brightness", 0.4), ("invert", True)):
        before = colors(made).copy()
        setattr(looks, name, value)
        yield from person.drawn(3)
        file = yield from run.picture(name)
        run.saw("B16", f"{name} {value} changes the colors by {np.abs(colors(made) - before).max():.2f}", np.abs(colors(made) - before).max() > 0.1, file)
    for name in ("contrast", "brightness", "invert"):
        looks.property_unset(name)
        setattr(looks, name, getattr(looks, name))
    yield from person.drawn(2)
    run.saw("B16", "back at their defaults the colors are as before", bool(np.allclose(colors(made), first, atol=1e-3)))
    name = shown(made)
    low, high = made.data["paradesc"]["ranges"][name]
    shares = np.clip((arrays.attribute_values(made.data.attributes[name]) - low) / (high - low), 0, 1)
    run.saw("B12", f"the linear color differs from the value by {np.abs(colors(made) - shares).max():.4f}", bool(np.abs(colors(made) - shares).max() < 0.01))


def one_scale(run: "Run") -> Iterator[None]:
    """A rough and a smooth mesh: the same scale by one switch."""
    made = monkey(2, applied=True)
    as_found()
    other = bpy.data.objects.new("Smooth", made.data.copy())
    bpy.context.collection.objects.link(other)
    for _ in range(2):
        smooth = other.modifiers.new("Smooth", "SMOOTH")
        smooth.iterations = 30
    bpy.context.view_layer.objects.active = other
    made.select_set(False)
    other.select_set(True)
    for name in [item.name for item in other.modifiers]:
        person.in_view(bpy.ops.object.modifier_apply, modifier=name)
    other.location.x = 3
    made.select_set(True)
    framed("FRONT")
    yield from clicked()
    looks = bpy.context.scene.paradesc_looks
    for same in (False, True):
        looks.same_scale = same
        yield from person.drawn(3)
        whites = [round(white(item), 3) for item in (made, other)]
        file = yield from run.picture(f"same_scale_{same}")
        run.saw("B18", f"same scale {same}: white is {whites}", (whites[0] == whites[1]) == same, file)
    place = yield from person.find("paradesc_looks.same_scale")
    run.saw("B18", "the switch is on the panel for several meshes", place is not None)


def interface(run: "Run") -> Iterator[None]:
    """German, scales 1.5 and 2, the light theme."""
    monkey(2)
    as_found()
    yield from clicked()
    view = bpy.context.preferences.view
    view.language = "de_DE"
    view.use_translate_interface = view.use_translate_tooltips = True
    yield from person.drawn(4)
    file = yield from run.picture("german")
    run.saw("B15", "German", None, file)
    view.language = "en_US"
    for scale in (1.5, 2.0):
        view.ui_scale = scale
        yield from person.drawn(4)
        yield from person.open_tab()
        file = yield from run.picture(f"scale_{scale:g}")
        run.saw("scale", f"interface scale {scale:g}: nothing is cut", None, file)
    view.ui_scale = 1.0
    theme = next((Path(folder) / "interface_theme" / "Blender_Light.xml" for folder in bpy.utils.preset_paths("interface_theme/..") if (Path(folder) / "interface_theme").is_dir()), None)
    found = [Path(folder) for folder in bpy.utils.preset_paths("interface_theme")]
    theme = next((path for folder in found for path in folder.glob("[Bb]lender*[Ll]ight.xml")), theme)
    if theme is not None:
        bpy.ops.script.execute_preset(filepath=str(theme), menu_idname="USERPREF_MT_interface_theme_presets")
        yield from person.drawn(4)
        file = yield from run.picture("light_theme")
        run.saw("theme", "light theme", None, file)
        bpy.ops.preferences.reset_default_theme()
    yield from person.drawn(3)


def steps(run: "Run") -> Iterator[None]:
    """One after another."""
    yield from person.alone()
    yield from person.open_tab()
    for point, task in (("B16", levels), ("B18", one_scale), ("B15", interface)):
        yield from run.tried(point, task(run))
    empty()
