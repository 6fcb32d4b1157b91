"""The scenes in which an artist tries things, and what can be asked of them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import bpy
import person

if TYPE_CHECKING:
    from drive import Run

MESHES = person.Path(__file__).resolve().parents[3] / "shared" / "meshes"


def empty() -> None:
    """Removes all objects, in object mode."""
    if bpy.context.object is not None and bpy.context.object.mode != "OBJECT":
        person.in_view(bpy.ops.object.mode_set, mode="OBJECT")
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)


def added(operator: object, **words: object) -> bpy.types.Object:
    """The object that an operator has added, seen as a whole."""
    person.in_view(operator, **words)
    made = bpy.context.view_layer.objects.active
    framed()
    return made


def framed(axis: str = "") -> None:
    """Shows what is selected, from one side if that is named."""
    if axis:
        person.in_view(bpy.ops.view3d.view_axis, type=axis)
    person.in_view(bpy.ops.view3d.view_selected)
    person.viewport().spaces[0].region_3d.view_distance *= 1.25
    undo_step()


def undo_step() -> None:
    """Keeps what a script did, as Blender does after each action of a person."""
    bpy.ops.ed.undo_push(message="by the script")


def monkey(levels: int = 2, applied: bool = False) -> bpy.types.Object:
    """Blender's monkey alone, subdivided and smooth, from the front."""
    empty()
    made = added(bpy.ops.mesh.primitive_monkey_add)
    person.in_view(bpy.ops.object.shade_smooth)
    made.modifiers.new("Subdivision", "SUBSURF").levels = levels
    if applied:
        person.in_view(bpy.ops.object.modifier_apply, modifier="Subdivision")
    framed("FRONT")
    return made


def imported(file: str) -> list[bpy.types.Object]:
    """The asset of a file alone, selected as the importer leaves it."""
    empty()
    path = str(MESHES / file)
    if file.endswith(".obj"):
        person.in_view(bpy.ops.wm.obj_import, filepath=path)
    else:
        person.in_view(bpy.ops.import_scene.gltf, filepath=path)
    framed()
    return list(bpy.context.selected_objects)


def baked(name: str) -> bool:
    """Returns whether a mesh of the scene has values of this name."""
    return any(item.type == "MESH" and name in item.data.attributes for item in bpy.context.scene.objects)


def idle() -> bool:
    """Returns whether no bake runs."""
    from paradesc_blender.bake.modal import ModalJob

    return ModalJob.running is None


def shading() -> bpy.types.View3DShading:
    """How the viewport draws."""
    return person.viewport().spaces[0].shading


def as_found() -> None:
    """Forgets what was typed, for the next task."""
    for group in (bpy.context.scene.paradesc, bpy.context.scene.paradesc_looks):
        for name in list(group.keys()):
            group.property_unset(name)


def to_bake() -> Iterator[tuple[str, tuple[int, int]]]:
    """The first button that bakes, as a person sees it: what it does, and where it is."""
    places = yield from person.buttons(wanted="ops.paradesc.bake", columns=person.COLUMNS[:1])  # they are wide
    return next(((words, place) for words, place in places.items() if "ops.paradesc.bake" in words), ("", (0, 0)))


def clicked() -> Iterator[str]:
    """Clicks on the first button that bakes, and waits for the end; gives what it does."""
    yield from person.drawn(3)
    words, place = yield from to_bake()
    if words:
        yield from person.click(*place)
        for _ in range(40):
            if not idle():
                break
            yield
        yield from person.wait(idle)
        yield from person.drawn(3)
    return words.removeprefix("bpy.ops.paradesc.")


def rendered(run: "Run", name: str) -> str:
    """Renders what the viewport sees with Cycles and one lamp; gives the name of the picture."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", 24
    scene.cycles.use_denoising = False  # which not every build has
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 900, 900, 100
    if scene.camera is None:
        lamp = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        lamp.rotation_euler, lamp.data.energy = (0.8, 0.3, 0.4), 3.0
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        for item in (lamp, scene.camera):
            bpy.context.collection.objects.link(item)
        person.in_view(bpy.ops.view3d.camera_to_view)
        scene.camera.data.clip_end = 1e5
        person.in_view(bpy.ops.view3d.camera_to_view_selected)
        person.in_view(bpy.ops.view3d.view_camera)
    file = f"{name}_rendered.png"
    scene.render.filepath = str(run.folder / file)
    bpy.ops.render.render(write_still=True)
    return file
