"""The pixels of Blender's window, which fills the screen, by Blender or by xwd; opens all of the add-on's panels."""

import subprocess
import tempfile
from pathlib import Path

import bpy
import numpy as np

# Words of 4 bytes in the header of what xwd writes.
SIZE, WIDTH, HEIGHT, BITS_PER_PIXEL, BYTES_PER_LINE, COLORS = 0, 4, 5, 11, 12, 19
BYTES_PER_COLOR = 12


def pixels() -> np.ndarray:
    """(height, width, 3) uint8, top row first."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "screen.png")
        bpy.ops.screen.screenshot(filepath=path)
        seen = pixels_of(path)
    return seen if seen.any() else pixels_of_root()


def pixels_of(file: str) -> np.ndarray:
    """(height, width, 3) uint8 of an image file, top row first."""
    image = bpy.data.images.load(file)
    width, height = image.size
    found = np.array(image.pixels[:], np.float32).reshape(height, width, 4)[::-1, :, :3]
    bpy.data.images.remove(image)
    return np.round(255 * found).astype(np.uint8)


def pixels_of_root() -> np.ndarray:
    """(height, width, 3) uint8 of all that is on the screen, top row first."""
    written = subprocess.run(["xwd", "-root", "-silent"], check=True, capture_output=True).stdout
    header = np.frombuffer(written, ">u4", 25)
    size = int(header[BITS_PER_PIXEL]) // 8  # 4, or 3 where windows differ in their visuals
    if size not in (3, 4):
        raise RuntimeError(f"xwd gives {header[BITS_PER_PIXEL]} bits a pixel; 24 or 32 are needed.")
    height, row = int(header[HEIGHT]), int(header[BYTES_PER_LINE])
    start = int(header[SIZE]) + BYTES_PER_COLOR * int(header[COLORS])
    rows = np.frombuffer(written, np.uint8, height * row, start).reshape(height, row)[:, : size * int(header[WIDTH])]
    return rows.reshape(height, -1, size)[..., 2::-1].copy()


def open_panels() -> None:
    """Opens the add-on's sub-panels, which are closed for those who have just installed it."""
    import paradesc_blender

    for module in paradesc_blender.modules():
        for cls in module.classes:
            if issubclass(cls, bpy.types.Panel) and hasattr(cls, "bl_parent_id"):
                bpy.utils.unregister_class(cls)
                cls.bl_options = set()
                bpy.utils.register_class(cls)
