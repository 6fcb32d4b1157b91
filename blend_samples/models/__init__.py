"""Assets as artists bring them, made by code alone and the same at every run: MODELS, each a function of no arguments.

Each adds one object to the scene, selects it alone, and returns it. unwrap() gives the active object a UV map.
The house consists of blocks that penetrate each other. Each other asset is one closed surface, whose thin places may
share an edge.
"""

from collections.abc import Callable

import bpy

from .car import car, car_parts
from .crate import crate
from .creature import caterpillar, creature
from .parts import unwrap
from .simple import column, gear, helmet, house, rock, vase
from .stone import stone

MAKERS = (crate, stone, car, creature, gear, vase, column, helmet, rock, house, caterpillar)
MODELS: dict[str, Callable[[], bpy.types.Object]] = {make.__name__: make for make in MAKERS}

__all__ = [*MODELS, "MODELS", "car_parts", "unwrap"]
