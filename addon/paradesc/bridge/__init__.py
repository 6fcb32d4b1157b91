"""The interface between Python and libparadesc: plain Python, ctypes and numpy, never Blender."""

from . import origin
from .arrays import Layout, MeshArrays, SurfaceMaps
from .library import (
    Descriptor,
    InputError,
    ParadescError,
    components,
    descriptors,
    load_library,
    missing_sentence,
    unusable,
)
from .option_table import TABLE, Row
from .options import BACKENDS, CHOICES, METHODS, Options, uses_texture_space
from .rays import Hits, cast_rays
from .session import BUFFERS, Closing, Context, Field, Mesh, ProgressFunction, allowed_memory
from .uv_images import TexelMap, draw_uv_image, fill_gutter
