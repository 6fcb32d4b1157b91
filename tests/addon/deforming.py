"""Ways in which Blender deforms or moves a mesh during an animation, as cases of tests. Each gets the object.

Everything is still at the first frame and has its full strength at the last.
"""

import bpy

from paradesc_blender.scene.node_groups import add_socket

FIRST, LAST = 1, 7
CASES = {}


def case(function):
    """Makes the function one of the cases."""
    CASES[function.__name__] = function
    return function


def skip_where_keyed_vertices_crash():
    """Skips a test of keyed vertices in Blender 5.2, whose threads evaluate them and free one array of positions twice.

    It crashes without the add-on, too: a sphere of 24 segments with two keys for each vertex, within a hundred frames.
    """
    if bpy.app.version >= (5, 2, 0):
        import pytest

        pytest.skip("Blender 5.2 itself crashes where vertices have keys")


def keyed(owner, name, start, end, index=-1):
    """Animates a property, a custom one or one member of an array from the first frame to the last."""
    for frame, value in ((FIRST, start), (LAST, end)):
        if name.startswith("["):
            owner[name[2:-2]] = value
        elif index < 0:
            setattr(owner, name, value)
        else:
            getattr(owner, name)[index] = value
        owner.keyframe_insert(name, index=index, frame=frame)


def linked(name, content=None):
    """A new object in the scene; without content an empty."""
    made = bpy.data.objects.new(name, content)
    bpy.context.scene.collection.objects.link(made)
    return made


def driven(owner, name, of=None, path=""):
    """Makes a property follow one of a datablock, or the frame."""
    driver = owner.driver_add(name).driver
    driver.expression = f"0.8 * (frame - {FIRST}) / {LAST - FIRST}"
    if of is not None:
        variable = driver.variables.new()
        variable.name = driver.expression = "given"
        variable.targets[0].id, variable.targets[0].data_path = of, path


def tops(target):
    """The vertices of the upper third."""
    return [item.index for item in target.data.vertices if item.co.z > 0.7]


def displacing(target):
    """A displacement that has no effect yet."""
    made = target.modifiers.new("push", "DISPLACE")
    made.mid_level, made.strength = 0.0, 0.0
    return made


def stretched_lattice(target, strength=1.0):
    """A lattice around the object, whose upper points are pulled up."""
    cage = linked("cage", bpy.data.lattices.new("cage"))
    cage.scale = (5, 5, 5)
    for point in cage.data.points:
        point.co_deform.z *= 1.6 if point.co.z > 0 else 1.0
    made = target.modifiers.new("cage", "LATTICE")
    made.object, made.strength = cage, strength
    return made


def hooked(target):
    """A hook that pulls the upper vertices."""
    made = target.modifiers.new("hook", "HOOK")
    made.object = linked("puller")
    made.vertex_indices_set(tops(target))
    return made


def stretching_nodes(target):
    """Geometry nodes that stretch the mesh along z; gives their input as owner and name, and a socket behind it."""
    tree = bpy.data.node_groups.new("stretch", "GeometryNodeTree")
    add_socket(tree, "Geometry", "geometry")
    add_socket(tree, "By", "float")
    add_socket(tree, "Geometry", "geometry", output=True)
    kinds = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeSetPosition", "GeometryNodeInputPosition")
    source, output, moved, place = map(tree.nodes.new, kinds)
    along, share = (tree.nodes.new("ShaderNodeVectorMath") for _ in range(2))
    along.operation, share.operation = "MULTIPLY", "SCALE"
    along.inputs[1].default_value = (0, 0, 1)
    for start, end in (
        (source.outputs[0], moved.inputs["Geometry"]),
        (place.outputs[0], along.inputs[0]),
        (along.outputs[0], share.inputs[0]),
        (source.outputs[1], share.inputs["Scale"]),
        (share.outputs[0], moved.inputs["Offset"]),
        (moved.outputs[0], output.inputs[0]),
    ):
        tree.links.new(start, end)
    made = target.modifiers.new("nodes", "NODES")
    made.node_group = tree
    given = source.outputs[1].identifier
    if hasattr(made, "properties"):  # since Blender 5.2
        owner, name = getattr(made.properties.inputs, given), "value"
    else:
        owner, name = made, f'["{given}"]'
    return owner, name, share.inputs["Scale"]


def pulled_key(target):
    """A shape key that pulls the upper half up."""
    target.shape_key_add(name="Basis")
    key = target.shape_key_add(name="pulled")
    for item, vertex in zip(key.data, target.data.vertices, strict=True):
        item.co.z *= 1.0 + 0.8 * max(vertex.co.z, 0.0)
    return key


def twin_of(target):
    """Another object with the same mesh, beside the first."""
    made = target.copy()
    made.name, made.location = "twin", (0, 2.4, 0)
    bpy.context.scene.collection.objects.link(made)
    return made


# ---- Keyframed modifiers


@case
def bend(target):
    made = target.modifiers.new("bend", "SIMPLE_DEFORM")
    made.deform_method = "BEND"
    keyed(made, "angle", 0.0, 2.5)


@case
def stretch(target):
    made = target.modifiers.new("stretch", "SIMPLE_DEFORM")
    made.deform_method, made.deform_axis = "STRETCH", "Z"
    keyed(made, "factor", 0.0, 0.6)


@case
def displace(target):
    keyed(displacing(target), "strength", 0.0, 0.8)


@case
def displace_by_a_changing_texture(target):
    made = displacing(target)
    made.strength, made.texture = 2.0, bpy.data.textures.new("clouds", "CLOUDS")
    keyed(made.texture, "noise_scale", 0.2, 2.0)


@case
def cast(target):
    made = target.modifiers.new("cast", "CAST")
    made.cast_type = "CUBOID"
    keyed(made, "factor", 0.0, 1.0)


@case
def wave(target):
    made = target.modifiers.new("wave", "WAVE")
    made.height = made.width = made.narrowness = 1.0
    made.speed = 0.4


@case
def warp(target):
    made = target.modifiers.new("warp", "WARP")
    made.object_from, made.object_to = linked("from"), linked("to")
    made.object_to.location, made.falloff_radius = (0, 0, 1.5), 3.0
    keyed(made, "strength", 0.0, 1.0)


@case
def hook_on_a_moving_empty(target):
    keyed(hooked(target).object, "location", 0.0, 1.5, 2)


@case
def hook_of_growing_strength(target):
    made = hooked(target)
    made.object.location = (0, 0, 1.5)
    keyed(made, "strength", 0.0, 1.0)


@case
def lattice_of_growing_strength(target):
    keyed(stretched_lattice(target), "strength", 0.0, 1.0)


@case
def lattice_that_grows(target):
    keyed(stretched_lattice(target).object, "scale", 5.0, 8.0, 2)


@case
def curve(target):
    path = bpy.data.curves.new("path", "CURVE")
    path.dimensions = "3D"
    path.splines.new("POLY").points.add(3)
    for place, point in enumerate(path.splines[0].points):
        point.co = (2 * place - 3, 0, abs(place - 1.5), 1)
    made = target.modifiers.new("path", "CURVE")
    made.object = linked("path", path)
    keyed(made.object, "location", 0.0, 2.0, 0)


@case
def array(target):
    made = target.modifiers.new("array", "ARRAY")
    made.use_relative_offset, made.use_constant_offset = False, True
    made.constant_offset_displace = (0, 0.7, 0)
    keyed(made, "count", 1, 4)


@case
def solidify(target):
    made = target.modifiers.new("shell", "SOLIDIFY")
    made.offset = 1.0
    keyed(made, "thickness", 0.01, 0.8)


@case
def modifier_that_appears(target):
    made = displacing(target)
    made.strength = 0.8
    keyed(made, "show_render", False, True)


@case
def nodes_with_a_keyframed_input(target):
    owner, name, _ = stretching_nodes(target)
    keyed(owner, name, 0.0, 0.8)
    return owner, name


@case
def nodes_with_a_keyframed_node(target):
    _, _, socket = stretching_nodes(target)
    socket.id_data.links.remove(socket.links[0])
    keyed(socket, "default_value", 0.0, 0.8)


@case
def strip_of_the_nla(target):
    bend(target)
    found = target.animation_data
    track = found.nla_tracks.new()
    track.strips.new("bend", FIRST, found.action)
    found.action = None


# ---- Drivers


@case
def driven_by_the_frame(target):
    driven(displacing(target), "strength")


@case
def driven_by_an_own_property(target):
    keyed(target, '["push"]', 0.0, 0.8)
    driven(displacing(target), "strength", target, '["push"]')


@case
def driven_by_another_object(target):
    other = linked("other")
    keyed(other, "location", 0.0, 0.8, 0)
    driven(displacing(target), "strength", other, "location[0]")


@case
def driven_by_a_keyframed_modifier(target):
    bend(target)
    driven(displacing(target), "strength", target, 'modifiers["bend"].angle')


@case
def shape_key_driven_by_another_object(target):
    other = linked("other")
    keyed(other, "location", 0.0, 1.0, 0)
    driven(pulled_key(target), "value", other, "location[0]")
    bend(target)


# ---- Poses, shapes, places


@case
def modifier_behind_an_armature(target):
    bones = linked("bones", bpy.data.armatures.new("bones"))
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    bone = bones.data.edit_bones.new("upper")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 2)
    bpy.ops.object.mode_set(mode="OBJECT")
    target.vertex_groups.new(name="upper").add(tops(target), 1.0, "REPLACE")
    target.modifiers.new("bones", "ARMATURE").object = bones
    bones.pose.bones["upper"].rotation_mode = "XYZ"
    keyed(bones.pose.bones["upper"], "rotation_euler", 0.0, 0.9, 0)
    displace(target)


@case
def shape_key(target):
    keyed(pulled_key(target), "value", 0.0, 1.0)


@case
def shape_key_and_modifier(target):
    shape_key(target)
    bend(target)


@case
def moving_vertices(target):
    skip_where_keyed_vertices_crash()
    for item in target.data.vertices:
        keyed(item, "co", item.co.z, item.co.z * (1.0 + 0.4 * max(item.co.z, 0.0)), 2)
    bend(target)


@case
def moving_object(target):
    keyed(target, "location", 0.0, 1.5, 2)


@case
def moving_object_with_a_modifier(target):
    moving_object(target)
    bend(target)


@case
def constraint_of_growing_influence(target):
    made = target.constraints.new("COPY_LOCATION")
    made.target = linked("goal")
    made.target.location = (0, 0, 2)
    keyed(made, "influence", 0.0, 1.0)
    displace(target)


@case
def baked_cloth_on_a_moving_object(target):
    displace(target)
    target.vertex_groups.new(name="held").add(tops(target), 1.0, "REPLACE")
    cloth = target.modifiers.new("cloth", "CLOTH")
    cloth.settings.vertex_group_mass = "held"
    cloth.point_cache.frame_start, cloth.point_cache.frame_end = FIRST, LAST
    assert bpy.ops.ptcache.bake_all(bake=True) == {"FINISHED"}


@case
def subdivision_behind_a_modifier(target):
    bend(target)
    target.modifiers.new("smooth", "SUBSURF").render_levels = 1


@case
def two_objects_of_one_mesh(target):
    displace(twin_of(target))
    bend(target)


@case
def object_shrunk_onto_it(target):
    wrap = twin_of(target)
    wrap.data = wrap.data.copy()
    made = wrap.modifiers.new("wrap", "SHRINKWRAP")
    made.target = target
    keyed(made, "offset", 0.0, 0.8)
    displace(target)
