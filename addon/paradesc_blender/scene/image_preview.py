"""Shows textures on meshes in solid viewports, drawn over the viewports' own colors. The .blend file is not changed.

Blender's own solid shading would show the active image of a material. Blender's next bake or stroke also goes into that
image, so its choice is left to the user. Only this session stores which textures are shown, by names, which are valid
after an undo, too.
"""

import atexit
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.app.handlers import persistent
from mathutils import Matrix

from ..settings import hooks, preferences
from ..settings.looks import redraw
from .arrays import read_array
from .unwrap import read_uvs

# The texture is drawn nearer to the eye by some steps of the depth buffer, which has 2^24, so that it does not flicker with the
# surface: a length would be less than a step far from the eye.
VERTEX = """
void main() {
  gl_Position = ModelViewProjectionMatrix * vec4(pos, 1.0);
  gl_Position.z -= 2e-6 * gl_Position.w;
  place = uv;
}
"""
# Viewports convert linear colors to sRGB by themselves.
FRAGMENT = """
void main() {
  FragColor = vec4(texture(image, place).rgb, 1.0);
}
"""

Key = tuple[str, str | None]  # a name and a library


@dataclass
class Shown:
    """One texture on one mesh."""

    image: Key
    mesh: Key  # that the image is of: an object made later may have the name of one that was deleted
    uv_map: str
    nearer: float  # a length in the world by which it is drawn nearer in addition
    batch: object = None  # the triangles as the graphics card has them; None: they are to be made; False: none are
    size: float = 0.0  # of the mesh

    def fits(self, target: bpy.types.Object | None, image: bpy.types.Image | None) -> bool:
        """Returns whether both are there, the mesh is the same, and the image is not another one of tiles by now."""
        if target is None or image is None or target.type != "MESH":
            return False
        return key_of(target.data) == self.mesh and can_show(image)


_shown: dict[Key, Shown] = {}
_kept: dict[str, object] = {}  # the handle of the calls that draw, and the shader


def key_of(block: bpy.types.ID) -> Key:
    """The name and library of a datablock, by which it is found again after an undo."""
    return block.name, block.library.filepath if block.library is not None else None


def can_show(image: bpy.types.Image) -> bool:
    """Returns whether the preview can show an image, which it cannot if the image is tiled."""
    return image.source != "TILED"


def show(target: bpy.types.Object, image: bpy.types.Image, uv_map: str, nearer: float = 0.0) -> None:
    """Shows an image over a UV map of the object, in place of an earlier one."""
    _shown[key_of(target)] = Shown(key_of(image), key_of(target.data), uv_map, nearer)
    if "handle" not in _kept and not bpy.app.background:
        _kept["handle"] = bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW")
        hooks.hang(FORGETTING)
        atexit.register(end)
    redraw()


def reveal(target: bpy.types.Object, image: bpy.types.Image, uv_map: str, nearer: float = 0.0) -> None:
    """Shows a bake's image, unless the preferences say otherwise."""
    if not bpy.app.background and preferences.shows_results() and can_show(image):
        show(target, image, uv_map, nearer)


def shown(target: bpy.types.Object) -> str:
    """The name of the image that is shown on an object, or ""."""
    found = _shown.get(key_of(target))
    return found.image[0] if found is not None and found.fits(target, bpy.data.images.get(found.image)) else ""


def hide(target: bpy.types.Object | None = None) -> None:
    """Stops showing an image on the object, or on all objects."""
    if target is None:
        _shown.clear()
    else:
        _shown.pop(key_of(target), None)
    redraw()


@persistent
def forget_batches(_scene: object = None, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Makes changed meshes be read again when they are drawn; all meshes if Blender does not say which changed."""
    names = None
    if isinstance(depsgraph, bpy.types.Depsgraph):
        names = {item.id.name for item in depsgraph.updates if item.is_updated_geometry}
    for (name, _), own in _shown.items():
        if names is None or name in names:
            own.batch = None


@persistent
def forget_file(*_words: object) -> None:
    """Stops showing all images, as objects in the newly opened file may have the same names."""
    _shown.clear()


CHANGES = ("depsgraph_update_post", "frame_change_post", "undo_post", "redo_post")
FORGETTING = {**dict.fromkeys(CHANGES, forget_batches), "load_post": forget_file}

# ---- Drawing


def draw() -> None:
    """Called by Blender for every viewport once it has drawn its objects."""
    context = bpy.context
    space = context.space_data
    if space.shading.type != "SOLID":
        return
    for key, own in _shown.items():
        target, image = bpy.data.objects.get(key), bpy.data.images.get(own.image)
        if not own.fits(target, image):
            continue  # until a redo brings them back
        if target.mode == "OBJECT" and target.visible_get(viewport=space) and own.batch is not False:
            try:
                draw_one(context, target, image, own)
            except Exception:  # noqa: BLE001 (an image without its file, or whatever a driver refuses, at each redraw)
                own.batch = False


def draw_one(context: bpy.types.Context, target: bpy.types.Object, image: bpy.types.Image, own: Shown) -> None:
    """Draws the texture of one object."""
    import gpu

    if own.batch is None:
        prepare(context, target, own)
    if not own.batch:
        return
    view, matrix = context.region_data.view_matrix, target.matrix_world
    size = own.size * largest_scale(matrix)
    nearer = min(own.nearer, 0.5 * size)
    if context.region_data.is_perspective:  # toward the eye, so that nothing moves on the screen
        moved = Matrix.Scale(1 - nearer / max((view @ matrix).translation.length, size, nearer), 4)
    else:
        moved = Matrix.Translation((0, 0, nearer))
    shader = made_shader()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(True)
    with gpu.matrix.push_pop():
        gpu.matrix.load_matrix(moved @ view @ matrix)
        shader.bind()
        shader.uniform_sampler("image", gpu.texture.from_image(image))
        own.batch.draw(shader)
    gpu.state.depth_mask_set(False)
    gpu.state.depth_test_set("NONE")


def largest_scale(matrix: Matrix) -> float:
    """The largest factor by which an object scales its mesh. Blender gives negative factors if it mirrors."""
    return max(map(abs, matrix.to_scale()))


def prepare(context: bpy.types.Context, target: bpy.types.Object, own: Shown) -> None:
    """Sends the triangles of the mesh as it is shown to the graphics card; none if it lacks the UV map."""
    from gpu_extras.batch import batch_for_shader

    evaluated = target.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        points, places = triangles_of(mesh, own.uv_map)
    finally:
        evaluated.to_mesh_clear()
    own.batch = batch_for_shader(made_shader(), "TRIS", {"pos": points, "uv": places}) if len(points) else False
    own.size = float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def triangles_of(mesh: bpy.types.Mesh, uv_map: str) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) positions and (n, 2) places in the UV map of triangles' corners, three in a row; none without the map.

    Without its name it is the active one.
    """
    layer = mesh.uv_layers.get(uv_map) if uv_map else mesh.uv_layers.active
    if layer is None:
        return np.empty((0, 3), np.float32), np.empty((0, 2), np.float32)
    mesh.calc_loop_triangles()
    vertices = read_array(mesh.loop_triangles, "vertices", np.int32, 3).reshape(-1)
    corners = read_array(mesh.loop_triangles, "loops", np.int32, 3).reshape(-1)
    return read_array(mesh.vertices, "co", np.float32, 3)[vertices], read_uvs(layer)[corners]


def made_shader() -> object:
    """The shader, which is made when it is first needed."""
    import gpu

    if "shader" not in _kept:
        between = gpu.types.GPUStageInterfaceInfo("paradesc_image")
        between.smooth("VEC2", "place")
        info = gpu.types.GPUShaderCreateInfo()
        info.push_constant("MAT4", "ModelViewProjectionMatrix")
        info.sampler(0, "FLOAT_2D", "image")
        info.vertex_in(0, "VEC3", "pos")
        info.vertex_in(1, "VEC2", "uv")
        info.vertex_out(between)
        info.fragment_out(0, "VEC4", "FragColor")
        info.vertex_source(VERTEX)
        info.fragment_source(FRAGMENT)
        _kept["shader"] = gpu.shader.create_from_info(info)
    return _kept["shader"]


classes = ()


def end() -> None:
    """Frees graphics memory, about which Blender would complain when it quits."""
    _shown.clear()
    _kept.pop("shader", None)


def unregister() -> None:
    """Removes the handlers and stops drawing."""
    end()
    atexit.unregister(end)
    handle = _kept.pop("handle", None)
    if handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
        hooks.take_down(FORGETTING)
