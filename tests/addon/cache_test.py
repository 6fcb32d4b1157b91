"""Frame files have the same bytes for the same content, are whole or absent, and no damage goes unnoticed."""

import hashlib
import json
import os
import struct
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from paradesc import bridge
from paradesc.core import job
from paradesc.files import cache
from shapes import as_arrays, cube_sphere


def a_frame(frame=7, key="settings", shift=0.0, count=40, **more):
    values = np.linspace(-1, 1, count).astype(np.float32) + np.float32(shift)
    values[3] = np.nan
    directions = np.arange(3 * count, dtype=np.float32).reshape(count, 3)
    info = {"object": "sphere", "radius": {"mean_curvature": 0.1}}
    given = {"mean_curvature": values, "principal_direction_max": directions, **more}
    return cache.Frame(frame, key, "positions", given, info)


def refused(path):
    """The one sentence that a file is refused with; it names the file."""
    with pytest.raises(bridge.ParadescError) as caught:
        cache.read_frame(path)
    assert str(path) in caught.value.sentence
    assert "\n" not in caught.value.sentence
    return caught.value.sentence


def rewritten(content, header=None, body=b""):
    """A file with another header and more bytes, whose checksum is right."""
    start = len(cache.MAGIC) + 8
    (length,) = struct.unpack_from("<Q", content, len(cache.MAGIC))
    fields = json.loads(content[start : start + length])
    fields.update(header or {})
    text = json.dumps(fields).encode()
    rest = content[start + length : -cache.DIGEST_BYTES] + body
    whole = cache.MAGIC + struct.pack("<Q", len(text)) + text + rest
    return whole + hashlib.sha256(whole).digest()


def test_what_was_written_is_read(tmp_path):
    written = a_frame()
    path = cache.write_frame(tmp_path / "new" / "folder", written)
    found = cache.read_frame(path)
    assert path.name == "frame_00007.pdframe"
    assert (found.frame, found.key, found.input, found.info) == (7, "settings", "positions", written.info)
    assert list(found.values) == list(written.values)
    for name, values in written.values.items():
        assert found.values[name].tobytes() == values.tobytes()
        assert found.values[name].shape == values.shape
    assert found.counts == {"mean_curvature": 39}
    assert found.vertex_count == 40


def test_same_content_is_the_same_bytes(tmp_path):
    first = cache.write_frame(tmp_path / "a", a_frame()).read_bytes()
    time.sleep(0.01)
    assert cache.write_frame(tmp_path / "b", a_frame()).read_bytes() == first
    assert cache.write_frame(tmp_path / "b", a_frame(shift=1e-6)).read_bytes() != first
    assert [path.name for path in (tmp_path / "b").iterdir()] == ["frame_00007.pdframe"]


def test_any_damaged_byte_is_found(tmp_path):
    path = cache.write_frame(tmp_path, a_frame())
    content = path.read_bytes()
    for at in range(0, len(content), 29):
        path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
        assert "damaged" in refused(path)
        assert cache.sound_frame(tmp_path, 7) is None
    for length in (0, 5, 20, len(content) // 2, len(content) - 1):
        path.write_bytes(content[:length])
        refused(path)
    path.write_bytes(content + b"x")
    refused(path)


@pytest.mark.parametrize(
    ("header", "body", "words"),
    [
        ({"version": 2}, b"", "version"),
        ({"frame": 8}, b"", "frame 8"),
        ({"frame": True}, b"", "holds frame True"),
        ({"vertex_count": 41}, b"", "header is wrong"),
        ({"vertex_count": -1}, b"", "header is wrong"),
        ({"vertex_count": 10**12}, b"", "header is wrong"),
        ({"arrays": [["mean_curvature", 1, 40]]}, b"", "too late"),
        ({"arrays": [["mean_curvature", 4, 40], ["b", 4, 40], ["c", 4, 40]]}, b"", "too early"),
        ({"arrays": [["../evil", 1, 40]]}, b"", "header is wrong"),
        ({"arrays": [["mean_curvature", 1 << 40, 40]]}, b"", "header is wrong"),
        ({"arrays": [["a:quantiles", 1, 10**9]]}, b"", "header is wrong"),
        ({"arrays": 5}, b"", "damaged"),
        ({"arrays": [[1, 1, 40]]}, b"", "damaged"),
        ({"counts": {"mean_curvature": 41}}, b"", "header is wrong"),
        ({"counts": [1]}, b"", "damaged"),
        ({"info": 3}, b"", "header is wrong"),
        ({"key": 3}, b"", "header is wrong"),
        ({}, b"more", "too late"),
    ],
    ids=str,
)
def test_header_that_lies_is_found_though_its_checksum_is_right(tmp_path, header, body, words):
    path = cache.write_frame(tmp_path, a_frame())
    path.write_bytes(rewritten(path.read_bytes(), header, body))
    assert words in refused(path)


def test_header_longer_than_the_file_is_found(tmp_path):
    path = cache.write_frame(tmp_path, a_frame())
    whole = cache.MAGIC + struct.pack("<Q", 1 << 60) + path.read_bytes()[16 : -cache.DIGEST_BYTES]
    path.write_bytes(whole + hashlib.sha256(whole).digest())
    assert "header is too long" in refused(path)


def test_what_is_no_frame_is_not_looked_at(tmp_path):
    for frame in (3, -12, 100000):
        cache.write_frame(tmp_path, a_frame(frame))
    for name in ("frame_1.npz", ".frame_00001.pdframe.ab.part", "notes.txt", "frame_x.pdframe"):
        (tmp_path / name).write_bytes(b"anything")
    assert list(cache.frames_in(tmp_path)) == [-12, 3, 100000]
    assert cache.frames_in(tmp_path / "none") == {}
    assert "no frame file" in refused(tmp_path / "frame_00001.pdframe")


def test_only_sound_frames_of_their_number_are_found(tmp_path):
    cache.write_frame(tmp_path, a_frame())
    found = cache.sound_frame(tmp_path, 7)
    assert (found.key, found.input) == ("settings", "positions")
    assert cache.sound_frame(tmp_path, 8) is None
    cache.frame_path(tmp_path, 8).write_bytes(cache.frame_path(tmp_path, 7).read_bytes())  # renamed by hand
    assert cache.sound_frame(tmp_path, 8) is None


def test_folder_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(bridge.ParadescError, match="cannot be made"):
        cache.write_frame(tmp_path / "file", a_frame())


def test_old_unfinished_files_are_swept_away_and_new_ones_stay(tmp_path):
    old, new = (tmp_path / f".frame_00001.pdframe.{name}.part" for name in ("aa", "bb"))
    for path in (old, new):
        path.write_bytes(b"half")
    os.utime(old, (time.time() - 90000,) * 2)
    cache.sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [new.name]


def test_names_of_objects_become_folders_of_their_own(tmp_path):
    folders = {
        cache.object_folder(tmp_path, name).name for name in ("Fox", "Fox.001", "Fox:001", "../Fox", "Füchsin", "")
    }
    assert len(folders) == 6
    assert "Fox" in folders
    assert not any("/" in name or ":" in name or ".." in name for name in folders)


def test_key_is_of_mesh_and_settings_but_not_of_device_or_pose():
    arrays = as_arrays(*cube_sphere(4))
    settings = job.Settings()

    def key_of(arrays=arrays, settings=settings, backend="gpu", source="deformed"):
        return cache.key_of(arrays, settings, bridge.METHODS[backend], source=source)

    key = key_of()
    assert key_of(replace(arrays, positions=2 * arrays.positions)) == key
    assert key_of(settings=replace(settings, backend="software", device_index=1), backend="software") == key
    others = [
        key_of(backend="reference"),
        key_of(backend="cpu"),
        key_of(settings=job.Settings(options=bridge.Options(samples=99))),
        key_of(source="evaluated"),
        key_of(replace(arrays, corner_uvs=arrays.corner_uvs * np.float32(0.5))),
        key_of(as_arrays(*cube_sphere(5))),
    ]
    assert len({key, *others}) == 7


# A change of any of these has to make a new key; each has another value than the default.
ALL_SETTINGS = {
    "radius": 0.07, "radius_unit": "mean-edge", "samples": 99, "buffer_size": 512, "normals": "max",
    "creases": "marked", "max_jumps": 3, "seed": 5, "relocation": "affine", "estimator": "integral",
    "variance_reduction": "none", "geodesic": "chords", "distance": "geodesic", "pattern": "stratified",
    "ellipse": "directional", "evaluate": "texel", "texels": 64, "precision": "half", "adaptive": 0.1,
    "map_descriptor": "mean_curvature", "map_sigma": 2.0, "harris_k": 0.05, "descriptors": ("curvedness",),
    "more_radii": (0.07,), "corner_threshold": 0.5, "space": "world",
}  # fmt: skip
OF_THE_MACHINE = {"backend", "device_index"}


def test_every_setting_is_part_of_the_key_but_those_of_the_machine():
    arrays = as_arrays(*cube_sphere(4))
    settings = job.Settings()
    assert ALL_SETTINGS.keys() | OF_THE_MACHINE == settings.as_dict().keys()
    keys = {"": cache.key_of(arrays, settings, "reference")}
    for name, value in ALL_SETTINGS.items():
        if hasattr(settings, name):
            other = replace(settings, **{name: value})
        else:
            other = replace(settings, options=replace(settings.options, **{name: value}))
        assert other != settings, name
        keys[name] = cache.key_of(arrays, other, "reference")
    assert len(set(keys.values())) == len(keys), keys


def test_the_first_machine_says_by_which_method_an_animation_is_baked(tmp_path):
    folder = tmp_path / "new"
    assert cache.settled_method(folder, "a" * 64, "surface samples") == "surface samples"
    assert cache.settled_method(folder, "a" * 64, "texture space") == "surface samples"
    assert cache.settled_method(folder, "b" * 64, "texture space") == "texture space", "of another animation"
    assert cache.frames_in(folder) == {}


def test_of_many_machines_at_once_one_says_the_method(tmp_path):
    methods = ["surface samples", "texture space"] * 8
    with ThreadPoolExecutor(16) as machines:
        found = list(machines.map(lambda own: cache.settled_method(tmp_path, "c" * 64, own), methods))
    assert len(set(found)) == 1


def test_a_method_that_cannot_be_read_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "METHOD_WAIT", 0)
    for content in ("", "{}", '{"method": "magic"}', "[]", "\xff"):
        (tmp_path / f"method_{16 * 'd'}.json").write_bytes(content.encode("latin-1"))
        with pytest.raises(bridge.ParadescError, match="damaged"):
            cache.settled_method(tmp_path, 64 * "d", "surface samples")


def test_one_range_over_all_frames_is_that_of_all_values(tmp_path):
    random = np.random.default_rng(3)
    everything = []
    for frame, count in enumerate((4000, 4000, 500)):
        values = (random.normal(size=count) * (1 + frame)).astype(np.float32)
        everything.append(values)
        cache.write_frame(tmp_path, cache.Frame(frame, "k", "p", {"mean_curvature": values}, {}))
    shown = cache.locked_ranges({tmp_path: "k"})["mean_curvature"]
    low, high = np.percentile(np.concatenate(everything), [2.5, 97.5])
    assert (shown.minimum, shown.diverging) == (-shown.maximum, True)
    # Ranks are kept to 1/256; two of them, at the slope of a tail, are a few per cent.
    assert shown.maximum == pytest.approx(max(-low, high), rel=0.06)
    assert cache.locked_ranges({tmp_path: "other key"}) == {}


def test_range_does_not_depend_on_who_made_which_frame(tmp_path):
    for frame in range(6):
        for folder in ("all", "even" if frame % 2 == 0 else "odd"):
            cache.write_frame(tmp_path / folder, a_frame(frame, shift=0.1 * frame))
    expected = cache.locked_ranges({tmp_path / "all": ""})
    assert cache.locked_ranges(dict.fromkeys([tmp_path / "even", tmp_path / "odd"], "")) == expected
    for path in (tmp_path / "odd").iterdir():
        path.rename(tmp_path / "even" / path.name)
    assert cache.locked_ranges({tmp_path / "even": ""}) == expected
    assert cache.locked_ranges({tmp_path / "odd": ""}) == {}


def test_damaged_frame_does_not_count_in_the_range(tmp_path):
    cache.write_frame(tmp_path, a_frame(1))
    expected = cache.locked_ranges({tmp_path: ""})
    path = cache.write_frame(tmp_path, a_frame(2, shift=9))
    path.write_bytes(path.read_bytes()[:-9])
    assert cache.locked_ranges({tmp_path: ""}) == expected


@pytest.mark.parametrize(
    "info", [{}, {"radius": 3}, {"radius": {"mean_curvature": "wide"}}, {"radius": [None]}], ids=str
)
def test_range_needs_nothing_of_what_is_for_readers(tmp_path, info):
    cache.write_frame(tmp_path, replace(a_frame(1), info=info))
    assert cache.locked_ranges({tmp_path: ""})["mean_curvature"].maximum == pytest.approx(0.95, abs=0.05)


def test_fixed_range_comes_first_and_a_damaged_one_is_one_sentence(tmp_path):
    cache.write_frame(tmp_path, a_frame(1, mean_curvature_change=np.ones(40, np.float32)))
    cache.write_fixed(tmp_path, {"": (-5.0, 5.0), "mean_curvature_change": (-1.0, 1.0)})
    shown = cache.locked_ranges({tmp_path: ""})
    assert (shown["mean_curvature"].minimum, shown["mean_curvature"].maximum) == (-5, 5)
    assert (shown["mean_curvature_change"].minimum, shown["mean_curvature_change"].maximum) == (-1, 1)
    for text in ("nonsense", "[]", '{"": [1]}', '{"": [2, 1]}', '{"": ["a", "b"]}', '{"": [NaN, 1]}'):
        (tmp_path / cache.RANGE_FILE).write_text(text)
        with pytest.raises(bridge.ParadescError, match="damaged"):
            cache.locked_ranges({tmp_path: ""})


def test_change_is_signed_about_zero_whatever_it_is_a_change_of():
    row = job.registry_row("shape_index_change")
    assert (row.name, row.is_signed, row.neutral_value) == ("shape_index", True, 0.0)
    assert not np.isfinite(row.display_minimum)
    assert job.registry_name("mean_curvature_r0.02_change") == "mean_curvature"
    assert np.isfinite(job.registry_row("shape_index").display_minimum)


def test_no_value_at_all_has_a_range_too(tmp_path):
    nothing = np.full(5, np.nan, np.float32)
    cache.write_frame(tmp_path, cache.Frame(1, "k", "p", {"mean_curvature": nothing}, {}))
    shown = cache.locked_ranges({tmp_path: ""})["mean_curvature"]
    assert shown.minimum < shown.maximum


# ---- Found by fuzzing (tests/fuzz/readers.py)


def test_a_header_that_quotes_lines_is_refused_in_one_line(tmp_path):
    path = cache.write_frame(tmp_path, a_frame())
    for header in ({"version": "1\n2"}, {"counts": {"two\nlines": -1}}):
        path.write_bytes(rewritten(cache.encode(a_frame()), header))
        refused(path)


def test_a_version_that_only_equals_ours_is_refused(tmp_path):
    path = cache.write_frame(tmp_path, a_frame())
    path.write_bytes(rewritten(cache.encode(a_frame()), {"version": True}))
    assert "version" in refused(path)


@pytest.mark.parametrize("radius", [10**400, 5e-324, float("inf"), float("nan"), -1.0, "0.1"])
def test_a_radius_that_is_none_still_gives_a_range(tmp_path, radius):
    path = cache.write_frame(tmp_path, a_frame())
    path.write_bytes(rewritten(cache.encode(a_frame()), {"info": {"radius": {"mean_curvature": radius}}}))
    shown = cache.ranges([cache.read_frame(path)])["mean_curvature"]
    assert -np.inf < shown.minimum < shown.maximum < np.inf


def test_a_fixed_range_beyond_all_floats_is_refused(tmp_path):
    (tmp_path / cache.RANGE_FILE).write_text(json.dumps({"mean_curvature": [0, 10**400]}))
    with pytest.raises(bridge.ParadescError, match="damaged"):
        cache.read_fixed(tmp_path)
