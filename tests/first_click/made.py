"""Ten assets that the project makes itself, each as the active object: hard ones with a UV map, as they are traded."""

import math

import bmesh
import bpy
from mathutils import Matrix, Vector, noise


def box(form: bmesh.types.BMesh, size: tuple[float, float, float], place: tuple[float, float, float]) -> None:
    """Adds a box."""
    matrix = Matrix.Translation(place) @ Matrix.Diagonal((*size, 1))
    bmesh.ops.create_cube(form, size=1, matrix=matrix)


def kept(form: bmesh.types.BMesh, name: str, smooth: bool = False, uv_map: bool = True) -> bpy.types.Object:
    """The form as the active object, unwrapped."""
    mesh = bpy.data.meshes.new(name)
    bmesh.ops.recalc_face_normals(form, faces=form.faces)
    form.to_mesh(mesh)
    form.free()
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    bpy.context.view_layer.objects.active = made
    made.select_set(True)
    for face in mesh.polygons:
        face.use_smooth = smooth
    if uv_map:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.uv.smart_project(island_margin=0.01)
        bpy.ops.object.mode_set(mode="OBJECT")
    return made


def applied(made: bpy.types.Object, kind: str, **words: object) -> bpy.types.Object:
    """The object with a modifier applied."""
    modifier = made.modifiers.new(kind, kind)
    for word, value in words.items():
        setattr(modifier, word, value)
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    return made


def displaced(form: bmesh.types.BMesh, size: float, depth: float, scale: float = 1.0) -> None:
    """Moves every vertex along its normal by noise of several sizes."""
    form.normal_update()
    moves = [(vertex, vertex.normal * depth * noise.fractal(vertex.co / size, 1.0, 2.0, 5)) for vertex in form.verts]
    for vertex, move in moves:
        vertex.co = (vertex.co + move) * scale


def lathed(profile: list[tuple[float, float]], sides: int, name: str, flutes: int = 0) -> bpy.types.Object:
    """A turned form from (radius, height) pairs, with grooves along it between a tenth and nine tenths of its height."""
    form = bmesh.new()
    top = profile[-1][1]
    rings = []
    for radius, height in profile:
        ring = []
        for side in range(sides):
            angle = 2 * math.pi * side / sides
            groove = 0.12 * abs(math.sin(flutes * angle / 2)) if flutes and 0.15 < height / top < 0.85 else 0.0
            ring.append(form.verts.new((radius * (1 - groove) * math.cos(angle), radius * (1 - groove) * math.sin(angle), height)))
        rings.append(ring)
    for low, high in zip(rings, rings[1:]):
        for side in range(sides):
            form.faces.new((low[side], low[side - 1], high[side - 1], high[side]))
    form.faces.new(rings[0])
    form.faces.new(rings[-1])
    return kept(form, name, smooth=True)


def fine(profile: list[tuple[float, float]], step: float) -> list[tuple[float, float]]:
    """The profile with points not farther apart than the step."""
    points = [profile[0]]
    for begin, end in zip(profile, profile[1:]):
        count = max(round(math.dist(begin, end) / step), 1)
        points += [tuple(a + (b - a) * k / count for a, b in zip(begin, end)) for k in range(1, count + 1)]
    return points


def crate() -> bpy.types.Object:
    """Planks between beams, low-poly."""
    form = bmesh.new()
    for axis in range(3):
        for one in (-1, 1):
            for other in (-1, 1):
                size, place = [0.16] * 3, [one * 0.92, other * 0.92]
                size[axis] = 2.0
                place.insert(axis, 0)
                box(form, tuple(size), tuple(place))
    for side in (-1, 1):
        for plank in range(4):
            height = -0.63 + 0.42 * plank
            box(form, (0.08, 1.7, 0.4), (side * 0.9, 0, height))
            box(form, (1.7, 0.08, 0.4), (0, side * 0.9, height))
            box(form, (1.7, 0.4, 0.08), (0, height, side * 0.9))
    return kept(form, "crate")


def house() -> bpy.types.Object:
    """Walls, a roof that juts out, a chimney, windows and a door, low-poly."""
    form = bmesh.new()
    box(form, (4, 3, 2.2), (0, 0, 1.1))
    for side in (-1, 1):
        roof = [(-2.3, 0, 3.7), (2.3, 0, 3.7), (2.3, side * 1.9, 2.0), (-2.3, side * 1.9, 2.0)]
        top = [form.verts.new(place) for place in roof]
        low = [form.verts.new(Vector(place) - Vector((0, 0, 0.15))) for place in roof]
        form.faces.new(top)
        form.faces.new(low)
        for k in range(4):
            form.faces.new((top[k], top[k - 1], low[k - 1], low[k]))
        box(form, (0.1, 0.15, 1.4), (side * 1.98, 0, 2.8))
        for place in (-1.2, 0.0, 1.2):
            box(form, (0.7, 0.12, 0.8), (place, side * 1.5, 1.2))
            box(form, (0.84, 0.2, 0.1), (place, side * 1.5, 0.76))
    box(form, (0.5, 0.5, 1.4), (1.1, 0.6, 3.6))
    box(form, (0.12, 0.9, 1.7), (2.0, 0, 0.85))
    return kept(form, "house")


def stone() -> bpy.types.Object:
    """A boulder with cracks."""
    form = bmesh.new()
    bmesh.ops.create_icosphere(form, subdivisions=7, radius=1)
    displaced(form, 0.5, 0.22)
    for vertex in form.verts:
        near, far = noise.voronoi(vertex.co * 1.6)[0][:2]
        vertex.co *= 1 - 0.08 * math.exp(-(((far - near) / 0.05) ** 2))
    return kept(form, "stone", smooth=True)


def rock() -> bpy.types.Object:
    """A coarse rock of flat facets, as games have it."""
    form = bmesh.new()
    bmesh.ops.create_icosphere(form, subdivisions=4, radius=1)
    for vertex in form.verts:
        vertex.co *= 0.75 + 0.25 * noise.voronoi(vertex.co * 1.3)[0][0]
    displaced(form, 0.8, 0.2)
    return kept(form, "rock")


def car() -> bpy.types.Object:
    """A body of large smooth faces with wheel arches and joints."""
    form = bmesh.new()
    box(form, (4.2, 1.8, 0.7), (0, 0, 0.6))
    box(form, (2.0, 1.5, 0.6), (-0.2, 0, 1.2))
    made = kept(form, "car", smooth=True, uv_map=False)
    applied(made, "REMESH", mode="VOXEL", voxel_size=0.05)
    applied(made, "SMOOTH", iterations=10)
    for place in (-1.3, 1.3):
        bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.42, depth=2.2, location=(place, 0, 0.35), rotation=(math.pi / 2, 0, 0))
        wheel = bpy.context.active_object
        bpy.context.view_layer.objects.active = made
        applied(made, "BOOLEAN", object=wheel, operation="DIFFERENCE")
        bpy.data.objects.remove(wheel)
    applied(made, "REMESH", mode="VOXEL", voxel_size=0.025)
    made.select_set(True)
    return made


def creature() -> bpy.types.Object:
    """A head with folds and pores."""
    bpy.ops.mesh.primitive_monkey_add()
    made = bpy.context.active_object
    applied(made, "SUBSURF", levels=4)
    form = bmesh.new()
    form.from_mesh(made.data)
    displaced(form, 0.18, 0.035)
    displaced(form, 0.04, 0.008)
    form.to_mesh(made.data)
    form.free()
    return made


def gear() -> bpy.types.Object:
    """Teeth, a hub and a bore, with a chamfer."""
    form = bmesh.new()
    teeth, ring = 18, []
    for tooth in range(teeth):
        for share, radius in ((0.0, 0.85), (0.3, 0.85), (0.42, 1.05), (0.78, 1.05), (0.9, 0.85)):
            angle = 2 * math.pi * (tooth + share) / teeth
            ring.append(form.verts.new((radius * math.cos(angle), radius * math.sin(angle), 0)))
    bottom = form.faces.new(ring)
    made = bmesh.ops.extrude_face_region(form, geom=[bottom])["geom"]
    bmesh.ops.translate(form, vec=(0, 0, 0.3), verts=[item for item in made if isinstance(item, bmesh.types.BMVert)])
    made = kept(form, "gear", uv_map=False)
    for radius, operation in ((0.35, "UNION"), (0.2, "DIFFERENCE")):
        bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=radius, depth=0.6, location=(0, 0, 0.15))
        tool = bpy.context.active_object
        bpy.context.view_layer.objects.active = made
        applied(made, "BOOLEAN", object=tool, operation=operation)
        bpy.data.objects.remove(tool)
    applied(made, "BEVEL", width=0.012, segments=2, limit_method="ANGLE")
    made.select_set(True)
    form = bmesh.new()
    form.from_mesh(made.data)
    mesh, name = made.data, made.name
    bpy.data.objects.remove(made)
    bpy.data.meshes.remove(mesh)
    return kept(form, name)


def vase() -> bpy.types.Object:
    """A turned form with rims and grooves."""
    profile = [(0.3, 0), (0.42, 0.05), (0.3, 0.12), (0.6, 0.5), (0.72, 0.9), (0.68, 0.95), (0.72, 1.0), (0.6, 1.3), (0.28, 1.7)]
    return lathed(fine([*profile, (0.25, 1.9), (0.38, 2.0), (0.33, 2.0), (0.2, 1.85)], 0.02), 128, "vase")


def column() -> bpy.types.Object:
    """A fluted shaft with base and capital."""
    profile = [(0.7, 0), (0.7, 0.2), (0.6, 0.3), (0.65, 0.4), (0.5, 0.5), (0.42, 4.5), (0.55, 4.6), (0.5, 4.7), (0.7, 4.8), (0.7, 5)]
    return lathed(fine(profile, 0.03), 192, "column", flutes=20)


def helmet() -> bpy.types.Object:
    """A shell with a crest, a brim and a slit."""
    form = bmesh.new()
    bmesh.ops.create_uvsphere(form, u_segments=96, v_segments=64, radius=1)
    bmesh.ops.delete(form, geom=[vertex for vertex in form.verts if vertex.co.z < -0.45], context="VERTS")
    for vertex in form.verts:
        ridge = math.exp(-((vertex.co.y / 0.09) ** 2)) * max(vertex.co.z + 0.2, 0)
        brim = math.exp(-(((vertex.co.z + 0.36) / 0.07) ** 2))
        vertex.co *= 1 + 0.12 * ridge + 0.12 * brim
    made = kept(form, "helmet", smooth=True)
    applied(made, "SOLIDIFY", thickness=0.06)
    return applied(made, "SUBSURF", levels=1)


BUILDERS = {build.__name__: build for build in (crate, stone, car, creature, gear, vase, column, helmet, rock, house)}
