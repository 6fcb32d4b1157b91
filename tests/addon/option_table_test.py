"""A row of the table of options is all that an option needs in Python: it is found wherever options are."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from shapes import ADDON

SCRIPT = """
import argparse, ctypes, importlib.util, sys
from types import SimpleNamespace
import paradesc
NAME = "paradesc.bridge.option_table"
spec = importlib.util.spec_from_file_location(NAME, sys.argv[1] + "/paradesc/bridge/option_table.py")
sys.modules[NAME] = table = importlib.util.module_from_spec(spec)
spec.loader.exec_module(table)
more = {"limits": {"min": 1, "max": 9}, "words": {"metavar": "N"}}
table.TABLE += (table.Row(24, "hue", "method", 3, "hue", "Hue", "What hue is", "hue of the samples", **more),)

from paradesc import bridge
from paradesc.bridge import abi, options
from paradesc.commands.options import add_computation_options, settings_of
from paradesc.core import choices, members
from paradesc.files import preset_rules
from paradesc.numpy_api import options as of_compute

assert bridge.Options().hue == 3
assert abi.ComputeOptions._fields_[-1] == ("hue", ctypes.c_int32)
assert options.native_options(bridge.Options(hue=5)).hue == 5
words = {"name": "Hue", "description": "What hue is", "default": 3, "min": 1, "max": 9}
assert members.method_members()["hue"].words == words
rule = preset_rules.rules()["settings"]["hue"]
assert (rule.kind, rule.words["max"], rule.default) == ("int", 9, 3)
known = preset_rules.rules()["settings"] | preset_rules.rules()["image"]
values = {name: one.default for name, one in known.items()} | {"backend": "cpu", "device_index": -1, "space": "object"}
assert choices.settings_of(SimpleNamespace(**values | {"hue": 7})).options.hue == 7
parser = argparse.ArgumentParser()
add_computation_options(parser)
assert "hue of the samples" in parser.format_help()
given = parser.parse_args(["--hue", "4"])
assert settings_of(given).options.hue == 4
assert of_compute.settings_of("mean_curvature", 0.1, {"hue": 6}).options.hue == 6
of_compute.check_names(paradesc.compute, ["hue"])
"""


def test_a_new_row_is_in_c_panel_presets_command_line_and_compute():
    words = [sys.executable, "-c", SCRIPT, str(ADDON)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ADDON), str(Path(np.__file__).parents[1])])}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
