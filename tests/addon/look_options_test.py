"""The command line's colors: maps and ranges, asked for and refused; and what legends say."""

import argparse
import json
from dataclasses import replace

import numpy as np
import pytest

from paradesc.commands.look_options import add_look_options, look_of
from paradesc.core import legend
from paradesc.core.color_maps import Levels, Look, ValueRange

QUICK = ("--radius", "0.06", "--samples", "64", "--buffer", "256", "--backend", "software")


def parsed(*words, otherwise=None):
    """The look of these words."""
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_look_options(parser)
    return look_of(parser.parse_args(list(words)), otherwise)


def test_no_option_is_the_automatic_look():
    look = parsed()
    assert look == Look("auto", None, {}, True, None)


def test_ranges_are_of_all_or_of_one_descriptor():
    look = parsed("--range=-1:2.5", "--range", "curvedness=0:3", "--color-map", "heat", "--neutral", "0.5")
    assert look == Look("heat", None, {"": (-1.0, 2.5), "curvedness": (0.0, 3.0)}, True, 0.5)
    assert parsed("--percentile", "0", "--asymmetric") == Look("auto", 0.0, {}, False)


def test_what_is_not_given_is_taken_from_elsewhere():
    scene = Look("heat", 5.0, {}, False, 1.0)
    assert parsed(otherwise=scene) == scene
    assert parsed("--color-map", "auto", otherwise=scene) == Look("auto", 5.0, {}, False, 1.0)
    assert parsed("--range", "0:1", otherwise=scene) == Look("heat", None, {"": (0.0, 1.0)}, False, 1.0)


@pytest.mark.slow
def test_picture_and_report_have_the_colors_asked_for(paradesc, sphere_obj, tmp_path):
    words = ["--output", "out.ply", "--json", "out.json", "--color-map", "grey", "--range=0:1"]
    process = paradesc("bake", sphere_obj, *QUICK, *words)
    assert process.returncode == 0, process.stderr
    row = json.loads((tmp_path / "out.json").read_text())["objects"][0]["descriptors"]["mean_curvature"]
    assert (row["shown_minimum"], row["shown_maximum"], row["color_map"]) == (0.0, 1.0, "grey")
    content = (tmp_path / "out.ply").read_bytes()
    place = content.index(b"end_header\n") + len(b"end_header\n") + 12
    colors = np.frombuffer(content, np.uint8, 3, place).astype(int)
    assert np.ptp(colors) <= 1
    assert abs(colors[0] - 188) <= 2  # H is 1/2 on this sphere, by sampling within 2 %: as light that is 188 of 255


@pytest.mark.parametrize(
    ("words", "word"),
    [
        (["--color-map", "jet"], "jet"),
        (["--range", "2:1"], "above"),
        (["--range", "1"], "two numbers"),
        (["--range", "0:inf"], "two numbers"),
        (["--neutral", "nan"], "nan"),
        (["--range", "pointiness=0:1"], "pointiness"),
        (["--percentile", "50"], "below 50"),
        (["--percentile", "2", "--range", "0:1"], "--range"),
    ],
    ids=str,
)
def test_bad_colors_are_one_sentence(paradesc, sphere_obj, tmp_path, words, word):
    process = paradesc("bake", sphere_obj, *QUICK, "--output", "out.ply", *words)
    assert process.returncode == 2
    assert word in process.stderr
    assert len(process.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out.ply").exists()


def test_legend_counts_from_end_to_end_through_the_neutral_value():
    assert legend.ticks("mean_curvature", ValueRange(-1, 3, True, 0.0)) == [(0.0, "-1"), (0.25, "0"), (1.0, "3")]
    assert legend.ticks("curvedness", ValueRange(0, 0.5, False)) == [(0.0, "0"), (0.5, "0.25"), (1.0, "0.5")]
    assert legend.ticks("curvedness", ValueRange(-1e-17, 1, False))[0] == (0.0, "0")
    assert legend.ticks("mean_curvature", ValueRange(-0.01, 3, True, 0.0))[1][1] == "1.49"  # 0 would be written over the end


def test_legend_of_a_mask_goes_from_0_to_1_whatever_value_is_white():
    shown = ValueRange(0.1, 0.596, False, map_name="grey")
    assert legend.ticks("convexity_r0.02", shown) == [(0.0, "0"), (1.0, "1")]
    assert legend.ticks("cavity", replace(shown, levels=Levels(invert=True))) == [(0.0, "1"), (1.0, "0")]
    assert len(legend.ticks("curvedness", shown)) == 3


def test_masks_have_the_names_of_their_buttons():
    named = {"cavity": "Cavity", "convexity": "Edge Wear", "ambient_openness": "Openness"}
    assert {name: legend.label(name) for name in named} == named
    assert legend.title("convexity_r0.02", "") == "Edge Wear, radius 0.02"


def test_legend_is_named_with_unit_and_radius():
    assert legend.title("mean_curvature", "1/length") == "Mean Curvature (1/length)"
    assert legend.title("shape_index_r0.02", "") == "Shape Index, radius 0.02"
    assert legend.unit_of("gaussian_curvature_r0.02", "mean_curvature") == "1/length^2"
    assert legend.unit_of("gradient_magnitude", "mean_curvature") == "1/length^2"
