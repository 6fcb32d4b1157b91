"""Images of displacement and normal maps read by OpenImageIO: every kind of PNG and OpenEXR, as Blender reads them."""

import struct
import zlib

import numpy as np
import pytest

pytest.importorskip("OpenImageIO", reason="OpenImageIO is not installed")

from paradesc.bridge import InputError
from paradesc.files import exr, map_images, png

GREY, RGB, PALETTE, GREY_ALPHA, RGB_ALPHA = 0, 2, 3, 4, 6
CHANNELS = {GREY: 1, RGB: 3, PALETTE: 1, GREY_ALPHA: 2, RGB_ALPHA: 4}
DEPTHS = {GREY: (1, 2, 4, 8, 16), PALETTE: (1, 2, 4, 8), RGB: (8, 16), GREY_ALPHA: (8, 16), RGB_ALPHA: (8, 16)}
COMBINATIONS = [(kind, depth) for kind, depths in DEPTHS.items() for depth in depths]
# First column, first row, step of columns, step of rows of the seven images that an interlaced one is made of (Adam7).
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))


def filtered(rows, step, filters):
    """Bytes of rows (height, bytes) uint8, each by its filter, as the specification describes them."""
    padded = np.pad(rows.astype(int), ((1, 0), (step, 0)))
    found = b""
    for y, kind in enumerate(filters):
        row, above = padded[y + 1], padded[y]
        left, up, across = row[:-step], above[step:], above[:-step]
        distances = np.abs([up - across, left - across, left + up - 2 * across])
        paeth = np.choose(distances.argmin(axis=0), [left, up, across])
        guess = [0 * up, left, up, (left + up) // 2, paeth][kind]
        found += bytes([kind]) + ((row[step:] - guess) % 256).astype(np.uint8).tobytes()
    return found


def packed_rows(image, depth):
    """(height, bytes) uint8 of an image (height, width, channels)."""
    if depth == 16:
        return image.astype(">u2").reshape(len(image), -1).view(np.uint8)
    if depth == 8:
        return image.astype(np.uint8).reshape(len(image), -1)
    bits = (image[:, :, :1].astype(int) >> np.arange(depth - 1, -1, -1)) & 1
    return np.packbits(bits.reshape(len(image), -1).astype(np.uint8), axis=1)


def write_png(path, image, depth, kind, palette=None, interlaced=False, seed=0):
    """A PNG whose rows have all filters, by turns that chance chooses."""
    chance, content = np.random.default_rng(seed), b""
    step = max(1, image.shape[2] * depth // 8)
    parts = [image[y::down, x::across] for x, y, across, down in PASSES] if interlaced else [image]
    for part in parts:
        if part.size:
            content += filtered(packed_rows(part, depth), step, chance.integers(0, 5, len(part)))
    header = struct.pack(">IIBBBBB", image.shape[1], image.shape[0], depth, kind, 0, 0, int(interlaced))
    colors = b"" if palette is None else png.chunk(b"PLTE", palette.astype(np.uint8).tobytes())
    half = len(zlib.compress(content)) // 2
    packed = [zlib.compress(content)[:half], zlib.compress(content)[half:]]
    body = b"".join(png.chunk(b"IDAT", part) for part in packed)
    path.write_bytes(png.SIGNATURE + png.chunk(b"IHDR", header) + colors + body + png.chunk(b"IEND", b""))
    return path


def stored(path):
    """(height, width, channels) numbers of a file, top row first."""
    return map_images.as_stored(path)[0]


def sample(kind, depth, size=(19, 13), seed=1):
    """An image of numbers by chance, and a palette where it needs one."""
    chance = np.random.default_rng(seed)
    image = chance.integers(0, 2**depth, (*size, CHANNELS[kind]))
    return image, chance.integers(0, 256, (2**depth, 3)) if kind == PALETTE else None


@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize(("kind", "depth"), COMBINATIONS)
def test_every_kind_of_png_is_read_exactly(tmp_path, kind, depth, interlaced):
    image, palette = sample(kind, depth)
    found = stored(write_png(tmp_path / "x.png", image, depth, kind, palette, interlaced))
    wanted = palette[image[:, :, 0]] if palette is not None else image
    if kind == GREY and depth < 8:
        wanted = image * 255 // (2**depth - 1)
    assert found.dtype == (np.uint16 if depth == 16 else np.uint8)
    assert np.array_equal(found, wanted)


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (9, 1), (2, 2), (5, 3), (8, 8)])
def test_small_interlaced_images_have_parts_that_are_empty(tmp_path, size):
    image, _ = sample(RGB, 16, size)
    for interlaced in (False, True):
        path = write_png(tmp_path / "x.png", image, 16, RGB, interlaced=interlaced)
        assert np.array_equal(stored(path), image)


def test_images_that_paradesc_writes_are_read(tmp_path):
    image = np.random.default_rng(0).integers(0, 65536, (300, 33, 3)).astype(np.uint16)
    for quick in (False, True):
        (tmp_path / "x.png").write_bytes(png.encode_png(image, {"a": "b"}, quick))
        assert np.array_equal(stored(tmp_path / "x.png"), image)


def write_exr(path, channels, compression, kind=2):
    """An OpenEXR file by another compression, or of other numbers, than ours: lines by themselves, from the last up."""
    height, width = next(iter(channels.values())).shape
    start = exr.header(sorted(channels), width, height)
    start = start.replace(b"compression\0\x01\0\0\0\x03", b"compression\0\x01\0\0\0%c" % compression)
    start = start.replace(b"lineOrder\0\x01\0\0\0\0", b"lineOrder\0\x01\0\0\0\x01")
    start = start.replace(struct.pack("<iB3xii", 2, 0, 1, 1), struct.pack("<iB3xii", kind, 0, 1, 1))
    blocks, numbers = [], {0: "<u4", 1: "<f2", 2: "<f4"}[kind]
    for y in range(height):
        raw = b"".join(channels[name][y].astype(numbers).tobytes() for name in sorted(channels))
        packed = {0: raw, 1: by_runs(raw), 2: exr.compress(raw)}[compression]
        packed = raw if len(packed) >= len(raw) else packed
        blocks.append(struct.pack("<2i", y, len(packed)) + packed)
    first, places, content = len(start) + 8 * height, {}, b""
    for y in reversed(range(height)):
        places[y] = first + len(content)
        content += blocks[y]
    path.write_bytes(start + struct.pack(f"<{height}Q", *(places[y] for y in range(height))) + content)
    return path


def by_runs(raw):
    """The bytes as OpenEXR's run lengths, of one byte or two at a time."""
    content = np.frombuffer(raw, np.uint8)
    parted = np.concatenate([content[0::2], content[1::2]])
    parted[1:] = parted[1:] - parted[:-1] + np.uint8(128)
    found, place, parted = b"", 0, parted.tobytes()
    while place < len(parted):
        same = len(parted[place : place + 100]) - len(parted[place : place + 100].lstrip(parted[place : place + 1]))
        found += bytes([same - 1, parted[place]]) if same > 1 else b"\xff" + parted[place : place + 1]
        place += same
    return found


@pytest.mark.parametrize("compression", [0, 1, 2])
@pytest.mark.parametrize("kind", [0, 1, 2])
def test_every_kind_of_exr_is_read_exactly(tmp_path, compression, kind):
    y = np.round(np.arange(11 * 40).reshape(11, 40) // 50).astype(np.float32)
    path = write_exr(tmp_path / "x.exr", {"R": y, "G": y + 1, "B": 0 * y}, compression, kind)
    pixels, _ = map_images.read_image(path)
    assert np.array_equal(pixels[::-1], np.stack([y, y + 1, 0 * y], axis=2))


def test_exr_of_ours_is_read(tmp_path):
    values = np.random.default_rng(0).normal(size=(40, 21)).astype(np.float32)
    exr.write_exr(tmp_path / "x.exr", {"Y": values})
    pixels, fine = map_images.read_image(tmp_path / "x.exr")
    assert fine
    assert np.array_equal(pixels[::-1], np.repeat(values[:, :, None], 3, axis=2))


# ---- Beside Blender


def same_as_blender(path):
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    from paradesc_blender.scene import surface_maps

    pixels, fine = surface_maps.read_file(path)
    own, own_fine = map_images.read_image(path)
    last_bit = 0 if bpy.app.version >= (4, 0) else 2**-24  # Blender 3 rounds 16 bits otherwise
    assert np.abs(own - pixels[..., :3]).max() <= last_bit
    assert fine == own_fine


@pytest.mark.parametrize(("kind", "depth"), COMBINATIONS)
def test_png_has_the_bits_of_blender(tmp_path, kind, depth):
    image, palette = sample(kind, depth)
    same_as_blender(write_png(tmp_path / "x.png", image, depth, kind, palette, interlaced=depth > 4))


def test_all_numbers_of_16_bits_have_the_bits_of_blender(tmp_path):
    image = np.arange(65536).reshape(256, 256, 1)
    same_as_blender(write_png(tmp_path / "x.png", image, 16, GREY))


@pytest.mark.parametrize("names", ["RGB", "RGBA", "Y", "V", "R"])
@pytest.mark.parametrize("compression", [0, 1, 2])
def test_exr_has_the_bits_of_blender(tmp_path, names, compression):
    bpy = pytest.importorskip("bpy", reason="needs Blender")
    if names == "V" and bpy.app.version < (4, 0):
        pytest.skip("Blender 3 does not read a channel of any name")
    values = np.random.default_rng(0).normal(size=(4, 9, 8)).astype(np.float32).round(1)
    same_as_blender(write_exr(tmp_path / "x.exr", dict(zip(names, values, strict=False)), compression, kind=1))


def test_what_blender_writes_has_its_bits(tmp_path):
    bpy = pytest.importorskip("bpy", reason="needs Blender")

    image = bpy.data.images.new("x", 37, 21, float_buffer=True)
    image.pixels.foreach_set(np.random.default_rng(0).random(37 * 21 * 4).astype(np.float32))
    settings = bpy.context.scene.render.image_settings
    for kind, depth, codec, mode in (
        ("PNG", "16", None, "RGBA"), ("PNG", "8", None, "BW"), ("PNG", "16", None, "RGB"),
        ("OPEN_EXR", "16", "ZIPS", "RGB"), ("OPEN_EXR", "32", "RLE", "RGBA"), ("OPEN_EXR", "32", "ZIP", "BW"),
    ):  # fmt: skip
        settings.file_format, settings.color_depth, settings.color_mode = kind, depth, mode
        if codec:
            settings.exr_codec = codec
        path = tmp_path / f"x.{kind[-3:].lower()}"
        image.save_render(str(path))
        same_as_blender(path)


# ---- What cannot be read


def refused(path):
    with pytest.raises(InputError) as caught:
        map_images.read_image(path)
    assert caught.value.sentence.count(".") >= 1
    assert "\n" not in caught.value.sentence
    return caught.value.sentence


def test_what_cannot_be_read_is_one_sentence(tmp_path):
    path = tmp_path / "x.tif"
    assert "none of .png, .exr, which are read without Blender" in refused(path)
    assert "There is no image" in refused(tmp_path / "x.png")
    values = np.zeros((4, 4), np.float32)
    exr.write_exr(tmp_path / "x.exr", {"cavity.V": values, "convexity.V": values})
    assert "of its channels cavity.V, convexity.V none is the one" in refused(tmp_path / "x.exr")
    exr.write_exr(tmp_path / "x.exr", {"A": values})
    assert "of its channels A none" in refused(tmp_path / "x.exr")
    (tmp_path / "x.png").write_bytes(b"GIF89a")
    assert "OpenImageIO finds it damaged (" in refused(tmp_path / "x.png")


def test_files_that_promise_more_than_they_hold_take_no_memory(tmp_path):
    header = struct.pack(">IIBBBBB", 2**31 - 1, 2**31 - 1, 16, RGB_ALPHA, 0, 0, 0)
    body = png.chunk(b"IHDR", header) + png.chunk(b"IDAT", zlib.compress(bytes(1000))) + png.chunk(b"IEND", b"")
    (tmp_path / "x.png").write_bytes(png.SIGNATURE + body)
    assert "damaged" in refused(tmp_path / "x.png")
    whole = bytearray(exr.encode_exr({"Y": np.zeros((4, 4), np.float32)}))
    place = whole.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    whole[place : place + 16] = struct.pack("<4i", -(2**31), -(2**31), 2**31 - 1, 2**31 - 1)
    (tmp_path / "x.exr").write_bytes(whole)
    assert "damaged" in refused(tmp_path / "x.exr")


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "exr"])
def test_damaged_files_are_one_sentence_or_an_image(tmp_path, suffix):
    image, _ = sample(RGB, 8)
    path, chance = tmp_path / f"x.{suffix}", np.random.default_rng(3)
    if suffix == "png":
        write_png(path, image, 8, RGB)
    else:
        exr.write_exr(path, {"Y": image[:, :, 0].astype(np.float32)})
    whole, refusals = path.read_bytes(), 0
    for _ in range(400):
        content = bytearray(whole)
        for _ in range(chance.integers(1, 4)):
            content[chance.integers(len(content))] = chance.integers(256)
        path.write_bytes(content[: chance.integers(len(content))] if chance.random() < 0.2 else content)
        try:
            map_images.read_image(path)
        except InputError:
            refusals += 1
    assert refusals > 100
