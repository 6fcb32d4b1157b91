"""Every refusal of the readers of images, sequences and frames is provoked, and its sentence says what is wrong."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from paradesc.bridge import InputError, ParadescError
from paradesc.files import cache, exr, frame_baking, map_images, png, sequences
from refusals import check_all_provoked, failing, refusal


def test_images_of_other_kinds_names_and_channels_say_so(tmp_path, monkeypatch):
    values = np.zeros((4, 4), np.float32)
    for name, sentence in (("a.tif", "is none of .png, .exr"), ("a.png", "There is no image")):
        with pytest.raises(InputError, match=sentence):
            map_images.read_image(tmp_path / name)
    said = refusal(map_images.read_image, tmp_path / "a.exr", exr.encode_exr({"A": values}))
    assert "of its channels A none" in said
    assert "OpenImageIO finds it damaged (" in refusal(map_images.read_image, tmp_path / "a.png", b"junk")
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    said = refusal(map_images.read_image, tmp_path / "a.png", b"")
    assert said.endswith("it needs OpenImageIO, which is not installed; pip install paradesc[io].")
    monkeypatch.setattr(map_images, "as_stored", failing(MemoryError()))
    assert "there is not enough memory" in refusal(map_images.read_image, tmp_path / "a.png", b"")


def test_what_our_own_writers_of_images_are_given_is_looked_at():
    with pytest.raises(ValueError, match="an image has channels, all"):
        exr.encode_exr({"Y": np.zeros((4, 4)), "Z": np.zeros((4, 5))})
    with pytest.raises(ValueError, match="uint16, not"):
        png.encode_png(np.zeros((4, 4, 5), np.uint16), {})
    with pytest.raises(ValueError, match="uint8 or uint16, not"):
        png.encode_png(np.zeros((4, 4, 4)))


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
        (tmp_path / "images").mkdir()
        test_images_of_other_kinds_names_and_channels_say_so(tmp_path / "images", monkeypatch)
        test_what_our_own_writers_of_images_are_given_is_looked_at()
        (tmp_path / "frames").mkdir()
        test_sequences_that_cannot_be_told_say_why(tmp_path / "frames")

    check_all_provoked((exr, map_images, png, sequences), provoke)
