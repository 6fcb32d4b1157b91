"""A car: a tin toy with fenders, doors, sunken windows, lamps and wheels."""

import math

import bpy
import numpy as np

from .parts import build, ramp
from .solids import FAR, Solid, box, cone, disk, ellipsoid, ring

WHEELS = (-0.6, 0.6)  # where they stand along y


def car(step: float = 0.0125) -> bpy.types.Object:
    """A tin toy car, 2 long: fenders, doors and a hood between grooves, sunken windows, wheels. It looks along -y."""
    solid = Solid((0, -1.12, 0), (0.56, 1.12, 0.86), step, mirrored=True)
    add_body(solid)
    engrave_body(solid)
    add_fittings(solid)
    add_wheels(solid)
    points, quads = solid.mesh()
    return build("car", points, quads)


def add_body(solid: Solid) -> None:
    """Body, hood, cabin, fenders and running boards; then the wheels' arches."""
    solid.add(ellipsoid((0, 0.02, 0.32), (0.36, 0.97, 0.19), power=3.4))
    solid.add(ellipsoid((0, -0.5, 0.42), (0.26, 0.47, 0.17), power=2.3), 0.06)
    solid.add(ellipsoid((0, 0.55, 0.42), (0.29, 0.43, 0.2), power=2.3), 0.06)
    solid.add(ellipsoid((0, 0.1, 0.5), (0.325, 0.54, 0.31), power=2.6), 0.05)
    solid.add(ellipsoid((0.35, -0.6, 0.27), (0.15, 0.35, 0.25), power=2.3), 0.025)
    solid.add(ellipsoid((0.35, 0.6, 0.28), (0.16, 0.36, 0.26), power=2.3), 0.025)
    solid.add(box((0.37, 0, 0.15), (0.085, 0.4, 0.022), 0.015), 0.02)
    solid.cut(box((0, 0, 0), (1, 2, 0.12)))
    for y in WHEELS:
        solid.cut(disk((0.5, y, 0.2), 0, 0.215, 0.2), 0.012)


def outline(u: np.ndarray, v: np.ndarray, center: tuple, half: tuple, rounding: float, lean: float = 0.0) -> np.ndarray:
    """The distance to a rectangle with round corners, negative inside; lean narrows it upwards."""
    u = np.abs(u - center[0]) + lean * (v - center[1])
    a, b = u - half[0] + rounding, np.abs(v - center[1]) - half[1] + rounding
    return np.sqrt(np.maximum(a, 0) ** 2 + np.maximum(b, 0) ** 2) + np.minimum(np.maximum(a, b), 0) - rounding


def windows(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> list[np.ndarray]:
    """The distances to two side windows, seen from the side, to the one in front and the one behind."""
    return [
        outline(y, z, (-0.1, 0.63), (0.15, 0.066), 0.045, 0.3),
        outline(y, z, (0.295, 0.63), (0.13, 0.066), 0.045, 0.3),
        outline(x, z, (0, 0.64), (0.185, 0.068), 0.05, 0.3),
        outline(x, z, (0, 0.65), (0.15, 0.055), 0.05, 0.3),
    ]


def engrave_body(solid: Solid) -> None:
    """Sunken windows with a frame, and grooves around the doors, the hood and the trunk."""
    out, toward, up = solid.even_out()
    x, y, z = solid.axes()
    side, front, back, top = ramp(out, 0.5, 0.7), ramp(toward, -0.4, -0.6), ramp(toward, 0.4, 0.6), ramp(up, 0.3, 0.5)
    high, low = ramp(z, 0.52, 0.54), ramp(z, 0.2, 0.23)
    panes = zip(windows(x, y, z), (side, side, front, back), strict=True)
    for pane, where in panes:
        frame = np.clip(1 - np.abs(pane - 0.016) / 0.02, 0, 1)
        solid.sink(where * high * (0.025 * np.clip(0.5 - pane / 0.02, 0, 1) - 0.008 * frame))
    lines = ((outline(y, z, (-0.095, 0.45), (0.2, 0.29), 0.07), side * low * ramp(z, 0.74, 0.72)),
             (outline(x, y, (0, -0.62), (0.17, 0.25), 0.08, -0.12), top * ramp(y, -0.3, -0.36)),
             (outline(x, y, (0, 0.74), (0.17, 0.14), 0.08), top * ramp(y, 0.56, 0.6)))  # fmt: skip
    for line, where in lines:
        solid.sink(where * 0.018 * np.clip(1.3 - np.abs(line) / 0.014, 0, 1))
    slots = (
        np.clip(1.2 - np.abs((z * 26) % 1 - 0.5) * 5, 0, 1)
        * ramp(x, 0.16, 0.13)
        * ramp(z, 0.26, 0.28)
        * ramp(z, 0.45, 0.43)
    )
    solid.sink(0.03 * slots * front * ramp(y, -0.75, -0.8))


def add_fittings(solid: Solid) -> None:
    """Lamps, bumpers, door handles, a strip along the hood and a spare key of tin toys."""
    solid.add(ellipsoid((0.33, -0.87, 0.4), (0.1, 0.12, 0.1)), 0.02)
    solid.add(ring((0.33, -0.965, 0.4), 1, 0.078, 0.02), 0.006)
    solid.cut(disk((0.33, -1.0, 0.4), 1, 0.066, 0.06, 0.01))
    solid.add(ellipsoid((0.33, -0.935, 0.4), (0.072, 0.035, 0.072)))
    solid.add(ellipsoid((0.37, 0.93, 0.36), (0.045, 0.05, 0.06)), 0.01)
    for y, way in ((-1.03, 1), (1.03, -1)):
        solid.add(cone((0, y, 0.2), (0.33, y + 0.03 * way, 0.2), 0.034, 0.034, (1, 1.4, 1)), 0.01)
        solid.add(cone((0.33, y + 0.03 * way, 0.2), (0.44, y + 0.14 * way, 0.2), 0.034, 0.03, (1, 1.4, 1)), 0.01)
        solid.add(cone((0.17, y, 0.15), (0.17, y, 0.27), 0.03, 0.03, (1, 1, 1)), 0.01)
        solid.add(cone((0.2, y, 0.2), (0.2, y + 0.2 * way, 0.22), 0.03, 0.03))
    solid.add(cone((0.345, 0.03, 0.5), (0.345, 0.11, 0.5), 0.018, 0.018), 0.01)
    solid.add(cone((0, -0.9, 0.5), (0, -0.38, 0.6), 0.012, 0.02), 0.015)


def add_wheels(solid: Solid) -> None:
    """Tires with treads, and caps with bolts, on an axle."""
    for y in WHEELS:
        center = (0.4, y, 0.2)
        tire = Solid((0.3, y - 0.22, 0), (0.52, y + 0.22, 0.42), solid.step)
        tire.values[:] = FAR
        tire.add(ring(center, 0, 0.132, 0.064))
        tx, ty, tz = tire.axes()
        angle = np.arctan2(tz - 0.2, ty - y)
        reach = np.sqrt((tz - 0.2) ** 2 + (ty - y) ** 2)
        tire.sink(0.012 * (reach > 0.165) * np.clip(2.4 * np.cos(22 * angle + 30 * np.abs(tx - 0.4)), 0, 1))
        where = tuple(slice(round((low - base) / solid.step), round((low - base) / solid.step) + size)
                      for low, base, size in zip(tire.lower, solid.lower, tire.values.shape, strict=True))  # fmt: skip
        here = solid.values[where]
        solid.values[where] = np.minimum(here, tire.values[tuple(slice(size) for size in here.shape)])
        solid.add(disk((0.4, y, 0.2), 0, 0.115, 0.03, 0.01))
        solid.add(ring((0.435, y, 0.2), 0, 0.09, 0.014), 0.006)
        solid.add(ellipsoid((0.435, y, 0.2), (0.03, 0.055, 0.055)), 0.008)
        for k in range(5):
            turn = 2 * math.pi * k / 5
            solid.add(
                ellipsoid((0.43, y + 0.072 * math.cos(turn), 0.2 + 0.072 * math.sin(turn)), (0.012, 0.012, 0.012))
            )
        solid.add(cone((0, y, 0.2), (0.4, y, 0.2), 0.04, 0.04))


def car_parts(centers: np.ndarray) -> np.ndarray:
    """(n,) what faces with these centers (n, 3) belong to: 0 paint, 1 rubber, 2 glass, 3 chrome."""
    x, y, z = np.abs(centers[:, 0]), centers[:, 1], centers[:, 2]
    reach = np.hypot(np.abs(y) - WHEELS[1], z - 0.2)
    found = np.zeros(len(centers), int)
    first, second, front, back = (pane < 0 for pane in windows(centers[:, 0], y, z))
    found[(first | second) & (x > 0.24)] = 2
    found[(front & (y < -0.2) & (y > -0.42) | back & (y > 0.4)) & (x < 0.24) & (z > 0.57)] = 2
    found[(reach < 0.205) & (x > 0.3)] = 1
    found[(reach < 0.116) & (x > 0.3)] = 3
    bumper = (np.abs(y) > 0.93) & (z < 0.28) & ((np.abs(y) > 1.0) | (x < 0.44) & (np.abs(z - 0.2) < 0.045))
    lamp = (np.hypot(x - 0.33, z - 0.4) < 0.102) & (y < -0.93)
    handle = (np.abs(y - 0.07) < 0.07) & (np.abs(z - 0.5) < 0.022) & (x > 0.343)
    found[bumper | lamp | handle] = 3
    return found
