"""The C interface of native/include/paradesc, declared for ctypes: same names, same order, same types."""

from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    c_char_p,
    c_double,
    c_float,
    c_int32,
    c_int64,
    c_uint8,
    c_uint32,
    c_void_p,
)

from .option_table import TABLE, Row

ABI_VERSION = 1

STATUS_OK = 0
STATUS_UNKNOWN = 1
STATUS_INVALID_ARGUMENT = 2
STATUS_INVALID_OPERATION = 3
STATUS_OUT_OF_MEMORY = 4
STATUS_UNSUPPORTED = 5
STATUS_CANCELLED = 6
STATUS_DEVICE_LOST = 7

MASK_NO_FACE = 1
MASK_BOUNDARY = 2
MASK_LOW_COVERAGE = 4
MASK_NO_TEXEL = 8

Float32Pointer = POINTER(c_float)
Int32Pointer = POINTER(c_int32)
Uint8Pointer = POINTER(c_uint8)
ContextPointer = c_void_p
MeshPointer = c_void_p
FieldPointer = c_void_p

# int32_t (*pdesc_progress)(void *user, const char *stage, double fraction)
Progress = CFUNCTYPE(c_int32, c_void_p, c_char_p, c_double)


# The members of pdesc_options that the table of options lacks, with their places.
BESIDE_TABLE = [(0, "radius", c_double), (7, "seam_error", c_int32), (22, "buffers", c_int32)]


def of_row(row: Row) -> tuple[int, str, type]:
    """The place, name and type of an option in pdesc_options, where a choice is a number."""
    whole = c_uint32 if row.unsigned else c_int32
    kind = whole if row.choices else {int: whole, float: c_double, str: c_char_p}[type(row.default)]
    return row.place, row.name, kind


class DescriptorInfo(Structure):
    """pdesc_descriptor_info"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("name", c_char_p),
        ("label", c_char_p),
        ("description", c_char_p),
        ("length_power", c_int32),
        ("is_signed", c_int32),
        ("neutral_value", c_double),
        ("display_minimum", c_double),
        ("display_maximum", c_double),
        ("components", c_int32),
        ("map_degree", c_int32),
    ]


class ContextOptions(Structure):
    """pdesc_context_options"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("backend", c_int32),
        ("device_index", c_int32),
        ("threads", c_int32),
        ("memory_limit", c_int64),
    ]


class MeshInput(Structure):
    """pdesc_mesh_input"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("vertex_count", c_int32),
        ("corner_count", c_int32),
        ("triangle_count", c_int32),
        ("positions", Float32Pointer),
        ("corner_vertices", Int32Pointer),
        ("triangle_corners", Int32Pointer),
        ("corner_uvs", Float32Pointer),
        ("corner_normals", Float32Pointer),
        ("triangle_smooth", Uint8Pointer),
        ("sharp_edges", Int32Pointer),
        ("sharp_edge_count", c_int32),
        ("progress", Progress),
        ("user", c_void_p),
    ]


class MeshReport(Structure):
    """pdesc_mesh_report"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("vertex_count", c_int32),
        ("triangle_count", c_int32),
        ("loose_vertices", c_int32),
        ("welded_vertices", c_int32),
        ("degenerate_triangles", c_int32),
        ("zero_uv_area_triangles", c_int32),
        ("flipped_triangles", c_int32),
        ("nonmanifold_edges", c_int32),
        ("nonmanifold_vertices", c_int32),
        ("boundary_edges", c_int32),
        ("charts", c_int32),
        ("seam_edges", c_int32),
        ("self_seam_edges", c_int32),
        ("unlinked_edges", c_int32),
        ("parts", c_int32),
        ("uv_remapped", c_int32),
        ("diagonal", c_float),
        ("mean_edge", c_float),
        ("copied_triangles", c_int32),
        ("opposed_edges", c_int32),
        ("inward_parts", c_int32),
    ]


class ComputeOptions(Structure):
    """pdesc_options: the table of options, and a few members that are none."""

    _fields_ = [("struct_size", c_uint32), *(member[1:] for member in sorted([*BESIDE_TABLE, *map(of_row, TABLE)]))]


class FieldReport(Structure):
    """pdesc_field_report"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("radius", c_double),
        ("coverage_mean", c_double),
        ("undefined_vertices", c_int32),
        ("boundary_vertices", c_int32),
        ("low_coverage_vertices", c_int32),
        ("overlapping_texels", c_int32),
        ("covered_texels", c_int32),
        ("bare_triangles", c_int32),
        ("radius_in_texels", c_double),
        ("seconds_prepare", c_double),
        ("seconds_bake", c_double),
        ("seconds_evaluate", c_double),
        ("seconds_total", c_double),
        ("private_layout", c_int32),
        ("places", c_int32),
        ("refined_share", c_double),
        ("buffer_megabytes", c_double),
        ("cut_charts", c_int32),
        ("backend", c_int32),
        ("memory_megabytes", c_double),
        ("crease_edges", c_int32),
    ]


class Memory(Structure):
    """pdesc_memory"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("mesh", c_int64),
        ("host", c_int64),
        ("device", c_int64),
        ("total", c_int64),
        ("allowed", c_int64),
    ]


class UvImageInput(Structure):
    """pdesc_uv_image_input"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("size", c_int32),
        ("triangle_count", c_int32),
        ("value_count", c_int32),
        ("components", c_int32),
        ("threads", c_int32),
        ("uvs", Float32Pointer),
        ("triangle_values", Int32Pointer),
        ("values", Float32Pointer),
        ("map", Float32Pointer),
        ("map_size", c_int32),
        ("map_uvs", Float32Pointer),
        ("progress", Progress),
        ("user", c_void_p),
        ("numbers", c_int32),
    ]


class RaysInput(Structure):
    """pdesc_rays_input"""

    _fields_ = [
        ("struct_size", c_uint32),
        ("vertex_count", c_int32),
        ("triangle_count", c_int32),
        ("ray_count", c_int32),
        ("threads", c_int32),
        ("positions", Float32Pointer),
        ("triangle_vertices", Int32Pointer),
        ("rays", Float32Pointer),
        ("reach", c_double),
        ("progress", Progress),
        ("user", c_void_p),
    ]


# Each struct with its C name; pdesc_<name>_init fills it with defaults.
STRUCTS: dict[type[Structure], str] = {
    DescriptorInfo: "pdesc_descriptor_info",
    ContextOptions: "pdesc_context_options",
    MeshInput: "pdesc_mesh_input",
    MeshReport: "pdesc_mesh_report",
    ComputeOptions: "pdesc_options",
    FieldReport: "pdesc_field_report",
    Memory: "pdesc_memory",
    UvImageInput: "pdesc_uv_image_input",
    RaysInput: "pdesc_rays_input",
}

# name: (restype, argtypes), in the header's order, which has the names of the arguments
FUNCTIONS: dict[str, tuple[object, list[object]]] = {
    "pdesc_abi_version": (c_int32, []),
    "pdesc_version": (c_char_p, []),
    "pdesc_last_error": (c_char_p, []),
    "pdesc_descriptor_info_init": (None, [POINTER(DescriptorInfo)]),
    "pdesc_descriptor_count": (c_int32, []),
    "pdesc_descriptor_get": (c_int32, [c_int32, POINTER(DescriptorInfo)]),
    "pdesc_context_options_init": (None, [POINTER(ContextOptions)]),
    "pdesc_context_create": (c_int32, [POINTER(ContextOptions), POINTER(ContextPointer)]),
    "pdesc_context_destroy": (None, [ContextPointer]),
    "pdesc_context_backend": (c_int32, [ContextPointer]),
    "pdesc_context_device": (c_char_p, [ContextPointer]),
    "pdesc_context_fallback": (c_char_p, [ContextPointer]),
    "pdesc_mesh_input_init": (None, [POINTER(MeshInput)]),
    "pdesc_mesh_report_init": (None, [POINTER(MeshReport)]),
    "pdesc_mesh_create": (c_int32, [ContextPointer, POINTER(MeshInput), POINTER(MeshPointer)]),
    "pdesc_mesh_set_positions": (c_int32, [MeshPointer, Float32Pointer, c_int32]),
    "pdesc_mesh_set_displacement": (c_int32, [MeshPointer, Float32Pointer, c_int32, c_int32, c_double, c_double]),
    "pdesc_mesh_set_normal_map": (c_int32, [MeshPointer, Float32Pointer, c_int32, c_int32, Float32Pointer, c_int32]),
    "pdesc_mesh_get_report": (c_int32, [MeshPointer, POINTER(MeshReport)]),
    "pdesc_mesh_destroy": (None, [MeshPointer]),
    "pdesc_options_init": (None, [POINTER(ComputeOptions)]),
    "pdesc_mesh_backend": (c_int32, [MeshPointer, POINTER(ComputeOptions), Int32Pointer]),
    "pdesc_compute": (
        c_int32,
        [MeshPointer, POINTER(ComputeOptions), POINTER(c_char_p), c_int32, Progress, c_void_p, POINTER(FieldPointer)],
    ),
    "pdesc_memory_init": (None, [POINTER(Memory)]),
    "pdesc_mesh_memory": (
        c_int32,
        [MeshPointer, POINTER(ComputeOptions), POINTER(c_char_p), c_int32, c_int32, POINTER(Memory)],
    ),
    "pdesc_mesh_buffer_size": (c_int32, [MeshPointer]),
    "pdesc_mesh_read_buffer": (c_int32, [MeshPointer, c_char_p, Float32Pointer, c_int64]),
    "pdesc_mesh_layout": (c_int32, [MeshPointer, Float32Pointer, c_int32]),
    "pdesc_field_report_init": (None, [POINTER(FieldReport)]),
    "pdesc_field_get_report": (c_int32, [FieldPointer, POINTER(FieldReport)]),
    "pdesc_field_warnings": (c_char_p, [FieldPointer]),
    "pdesc_field_device": (c_char_p, [FieldPointer]),
    "pdesc_field_values": (c_int32, [FieldPointer, c_char_p, Float32Pointer, c_int32]),
    "pdesc_field_seam_error": (c_int32, [FieldPointer, c_char_p, Float32Pointer, c_int32]),
    "pdesc_field_mask": (c_int32, [FieldPointer, Uint8Pointer, c_int32]),
    "pdesc_mesh_near_seam": (c_int32, [MeshPointer, c_double, Uint8Pointer, c_int32]),
    "pdesc_field_map_size": (c_int32, [FieldPointer]),
    "pdesc_field_map": (c_int32, [FieldPointer, c_char_p, Float32Pointer, c_int64]),
    "pdesc_field_destroy": (None, [FieldPointer]),
    "pdesc_uv_image_input_init": (None, [POINTER(UvImageInput)]),
    "pdesc_uv_image_draw": (c_int32, [POINTER(UvImageInput), Float32Pointer, c_int64]),
    "pdesc_uv_image_fill_gutter": (c_int32, [Float32Pointer, c_int64, c_int32, c_int32, c_int32, c_int32, c_int32]),
    "pdesc_rays_input_init": (None, [POINTER(RaysInput)]),
    "pdesc_rays_cast": (c_int32, [POINTER(RaysInput), Int32Pointer, Float32Pointer, c_int32]),
    "pdesc_rays_values": (
        c_int32,
        [POINTER(RaysInput), Int32Pointer, Float32Pointer, Float32Pointer, c_int32, Float32Pointer, c_int64],
    ),
}
