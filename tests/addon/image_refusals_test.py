"""Every refusal of the readers of images, sequences and frames is provoked, and its sentence says what is wrong."""

import struct
import zlib
from types import SimpleNamespace

import numpy as np
import pytest

from map_images_test import write_exr, write_png
from paradesc.bridge import InputError, ParadescError
from paradesc.files import (
    cache,
    exr,
    exr_reading,
    frame_baking,
    inflating,
    map_images,
    png,
    png_reading,
    sequences,
)
from refusals import check_all_provoked, failing, refusal

GREY = np.arange(16).reshape(4, 4, 1)


def of_chunks(*chunks, header=(4, 4, 8, png_reading.GREY, 0, 0, 0)):
    """A .png of these chunks after its header."""
    return png.SIGNATURE + b"".join(png.chunk(*row) for row in ((b"IHDR", struct.pack(">IIBBBBB", *header)), *chunks))


def rows(first=b"\0", count=4):
    return zlib.compress((first + bytes(4)) * count)


def png_files(folder):
    """Damaged files with what is wrong with them."""
    whole = write_png(folder / "whole.png", GREY, 8, png_reading.GREY).read_bytes()
    end = (b"IEND", b"")
    yield b"junk", "it is no PNG file"
    yield of_chunks(end), "it has no image"
    yield whole.replace(b"IDAT", b"IDAX"), "it is damaged: a checksum does not fit"
    yield whole[: len(whole) // 2], "it ends too early"
    yield png.SIGNATURE + png.chunk(b"IHDR", b"short"), "its header is damaged"
    for header in ((0, 4, 8, 0, 0, 0, 0), (4, 4, 3, 0, 0, 0, 0), (4, 4, 8, 7, 0, 0, 0), (4, 4, 8, 0, 0, 0, 2)):
        yield of_chunks(header=header), "its header is damaged"
    yield of_chunks((b"IDAT", rows()), end, header=(1 << 20, 1 << 20, 8, 0, 0, 0, 0)), "it ends too early"
    yield of_chunks((b"IDAT", rows(count=3)), end), "it ends too early"
    yield of_chunks((b"IDAT", b"junk"), end), "it is damaged"
    yield of_chunks((b"IDAT", rows(b"\5")), end), "it is damaged: it has an unknown filter"
    colors = (4, 4, 8, png_reading.PALETTE, 0, 0, 0)
    yield of_chunks((b"IDAT", rows()), end, header=colors), "it is damaged: a color is missing"
    yield of_chunks((b"PLTE", b""), (b"IDAT", rows()), end, header=colors), "it is damaged: a color is missing"


def exr_files(folder):
    """The same of OpenEXR."""
    values = {"Y": np.arange(16, dtype=np.float32).reshape(4, 4)}
    whole, plain = exr.encode_exr(values), write_exr(folder / "plain.exr", values, 0).read_bytes()
    packed = write_exr(folder / "packed.exr", {"Y": np.zeros((4, 40), np.float32)}, 2).read_bytes()
    first = struct.unpack_from("<Q", packed, len(exr.header(["Y"], 40, 4)))[0]  # the place of a block
    kind = struct.pack("<iB3xii", 2, 0, 1, 1)
    window = whole.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
    channels = whole.index(b"channels\0chlist\0") + len(b"channels\0chlist\0")
    table = len(exr.header(["Y"], 4, 4))
    yield b"", "it ends too early, or is damaged"
    yield bytes(100), "it is no OpenEXR file"
    yield whole[:4] + b"\2\2" + whole[6:], "it has tiles, several parts or deep pixels"
    yield whole[:9], "it ends too early"
    yield whole[:channels] + struct.pack("<i", -1) + whole[channels + 4 :], "it is damaged"
    yield whole.replace(b"dataWindow", b"dataWandow"), "it is damaged: its header lacks an attribute"
    yield (
        whole.replace(b"compression\0\1\0\0\0\3", b"compression\0\1\0\0\0\4"),
        "it has PIZ compression; save it with ZIP",
    )
    yield whole.replace(b"compression\0\1\0\0\0\3", b"compression\0\1\0\0\0\x63"), "it has an unknown compression"
    yield whole[:window] + struct.pack("<4i", 3, 0, 0, 3) + whole[window + 16 :], "it has no pixels"
    yield whole.replace(kind, struct.pack("<iB3xii", 2, 0, 2, 1)), 'its channel "Y" has fewer pixels than others'
    yield whole.replace(kind, struct.pack("<iB3xii", 9, 0, 1, 1)), 'its channel "Y" has fewer pixels than others'
    yield whole[: channels + 4] + b"\0" + whole[channels + 5 :], "it has no channels"
    yield (
        whole[:window] + struct.pack("<4i", 0, 0, 99999, 99999) + whole[window + 16 :],
        "it ends too early, or is damaged",
    )
    yield plain[:-5], "it ends too early, or is damaged"
    yield plain[:table] + plain[table : table + 8] * 4 + plain[table + 32 :], "it is damaged: lines are missing"
    for line in range(4):  # wherever the first place points to
        place = struct.unpack_from("<Q", plain, table + 8 * line)[0]
        plain = plain[: place + 4] + struct.pack("<i", 12) + plain[place + 8 :]
    yield plain, "it is damaged"
    size = struct.unpack_from("<i", packed, first + 4)[0]
    short = zlib.compress(bytes(8)).ljust(size, b"\0")
    yield packed[: first + 8] + short + packed[first + 8 + size :], "it is damaged"
    yield packed[: first + 8] + b"x" * size + packed[first + 8 + size :], "it is damaged"


def test_images_that_cannot_be_read_say_why(tmp_path):
    for suffix, files in ((".png", png_files), (".exr", exr_files)):
        for number, (content, sentence) in enumerate(files(tmp_path)):
            said = refusal(map_images.read_image, tmp_path / f"a{suffix}", content)
            assert f"cannot be read: {sentence}" in said, (suffix, number)


def test_images_of_other_kinds_names_and_channels_say_so(tmp_path, monkeypatch):
    values = np.zeros((4, 4), np.float32)
    for name, sentence in (("a.tif", "is none of .png, .exr"), ("a.png", "There is no image")):
        with pytest.raises(InputError, match=sentence):
            map_images.read_image(tmp_path / name)
    said = refusal(map_images.read_image, tmp_path / "a.exr", exr.encode_exr({"A": values}))
    assert "of its channels A none" in said
    for error, sentence in (
        (MemoryError(), "there is not enough memory"),
        (OSError(5, "Input/output error"), "Input/output"),
    ):
        monkeypatch.setitem(map_images.READERS, ".png", failing(error))
        assert f"cannot be read: {sentence}" in refusal(map_images.read_image, tmp_path / "a.png", b"")


def test_what_our_own_writers_of_images_are_given_is_looked_at():
    with pytest.raises(ValueError, match="an image has channels, all"):
        exr.encode_exr({"Y": np.zeros((4, 4)), "Z": np.zeros((4, 5))})
    with pytest.raises(ValueError, match="uint16, not"):
        png.encode_png16(np.zeros((4, 4, 3), np.uint8), {})
    with pytest.raises(ValueError, match="uint8, not"):
        png.encode_png(np.zeros((4, 4, 4), np.uint8))


def test_sequences_that_cannot_be_told_say_why(tmp_path):
    for name in ("a_1.ply", "b_1.ply"):
        (tmp_path / name).write_bytes(b"")
    for given, sentence in (
        (tmp_path, "are both frame 1; say by #### where the number is"),
        (tmp_path / "none" / "a_#.ply", "There is no folder"),
        (tmp_path / "c_#.ply", "has a number in its name"),
    ):
        with pytest.raises(InputError, match=sentence):
            sequences.frames_of(given)


def full(*_words, **_more):
    raise OSError(28, "No space left on device")


def test_frames_that_the_system_refuses_say_why(tmp_path, monkeypatch):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(ParadescError, match=r"The folder .* cannot be made: File exists"):
        cache.settled_method(tmp_path / "file", "a" * 16, "cpu")
    with pytest.raises(ParadescError, match="cannot be read: "):
        cache.frames_in(tmp_path / "file")
    with pytest.raises(ParadescError, match="cannot be read: "):
        cache.read_frame(tmp_path)
    monkeypatch.setattr(type(tmp_path), "open", full)
    with pytest.raises(ParadescError, match="cannot be written: No space left"):
        cache.settled_method(tmp_path, "a" * 16, "cpu")
    monkeypatch.undo()
    request = SimpleNamespace(settings=SimpleNamespace(space="world"))
    with pytest.raises(InputError, match="Frames are measured in object space"):
        frame_baking.Baker("a", "a", request)


def test_every_refusal_of_images_and_sequences_is_provoked_above(tmp_path, monkeypatch):
    def provoke():
        test_images_that_cannot_be_read_say_why(tmp_path)
        (tmp_path / "images").mkdir()
        test_images_of_other_kinds_names_and_channels_say_so(tmp_path / "images", monkeypatch)
        test_what_our_own_writers_of_images_are_given_is_looked_at()
        (tmp_path / "frames").mkdir()
        test_sequences_that_cannot_be_told_say_why(tmp_path / "frames")

    check_all_provoked((exr, exr_reading, inflating, map_images, png, png_reading, sequences), provoke)
