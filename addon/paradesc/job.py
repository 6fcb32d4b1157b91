"""One bake from arrays to arrays: what the operator, the command line and the tests all run. Never imports bpy."""

import threading
from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import numpy as np

from . import bridge
from .bridge import abi
from .corners import ATTRIBUTE, THRESHOLD, WINDOW_REACH, Corners, find_corners

ProgressFunction = Callable[[str, float], bool]


@dataclass
class Settings:
    """What to compute, how and where."""

    descriptors: tuple[str, ...] = ("mean_curvature",)
    options: bridge.Options = field(default_factory=bridge.Options)
    backend: str = "auto"
    device_index: int = -1
    corner_threshold: float = THRESHOLD  # of the largest Harris response

    def as_dict(self) -> dict[str, object]:
        """Flat, of plain types: for JSON and for Blender's custom properties."""
        flat: dict[str, object] = {"descriptors": list(self.descriptors)}
        flat.update(asdict(self.options))
        flat.update(backend=self.backend, device_index=self.device_index, corner_threshold=self.corner_threshold)
        return flat


@dataclass
class Results:
    """Everything that one bake leaves behind."""

    settings: Settings
    values: dict[str, np.ndarray]  # each (vertex_count,) float32, NaN where undefined
    coverage: np.ndarray  # (vertex_count,) float32
    mask: np.ndarray  # (vertex_count,) uint8 bits abi.MASK_*
    mesh_report: dict[str, float | int]
    field_report: dict[str, float | int]
    backend: str
    device: str
    fallback: str  # why "auto" did not get a better device, or ""
    warnings: list[str]
    near_seam: np.ndarray | None = None  # (vertex_count,) bool, with seam_error only
    seam_error: dict[str, np.ndarray] = field(default_factory=dict)  # each (vertex_count,) float32
    corners: Corners | None = None  # with the descriptor harris only

    @property
    def extras(self) -> dict[str, np.ndarray]:
        """What is written beside the descriptors, each (vertex_count,) float32."""
        painted = {} if self.corners is None else {ATTRIBUTE: self.corners.painted}
        return {"coverage": self.coverage, **painted}

    @property
    def radius(self) -> float:
        """The radius in units of the positions."""
        return float(self.field_report["radius"])


def check_descriptors(names: tuple[str, ...]) -> None:
    """Refuses an empty list, a name that the registry lacks, and one asked for twice."""
    known = [row.name for row in bridge.descriptors()]
    if not names:
        raise bridge.ParadescError(abi.STATUS_INVALID_ARGUMENT, "No descriptor is chosen; choose at least one.")
    for name in names:
        if name not in known:
            sentence = f'There is no descriptor "{name}"; choose from {", ".join(known)}.'
            raise bridge.ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)
        if names.count(name) > 1:
            sentence = f'The descriptor "{name}" is asked for twice.'
            raise bridge.ParadescError(abi.STATUS_INVALID_ARGUMENT, sentence)


def run(arrays: bridge.MeshArrays, settings: Settings, progress: ProgressFunction | None = None) -> Results:
    """Computes the descriptors of a mesh; raises ParadescError, also (STATUS_CANCELLED) when progress returns False."""
    check_descriptors(settings.descriptors)
    with bridge.Context(settings.backend, settings.device_index) as context:
        if arrays.corner_uvs is None and context.backend != "reference":
            raise bridge.ParadescError(
                abi.STATUS_INVALID_ARGUMENT,
                "The mesh has no UV map; unwrap it, or choose the backend reference, which needs none.",
            )
        with context.mesh(arrays) as mesh, mesh.compute(settings.descriptors, settings.options, progress) as result:
            results = Results(
                settings=settings,
                values={name: result.values(name) for name in settings.descriptors},
                coverage=result.values("coverage"),
                mask=result.mask(),
                mesh_report=mesh.report(),
                field_report=result.report(),
                backend=context.backend,
                device=context.device,
                fallback=context.fallback,
                warnings=result.warnings(),
            )
            if settings.options.seam_error and context.backend != "reference":
                results.near_seam = mesh.near_seam(results.radius)
                results.seam_error = {name: result.seam_error(name) for name in settings.descriptors}
    if "harris" in results.values:
        results.corners = find_corners(
            arrays.positions,
            arrays.triangle_vertices,
            results.values["harris"],
            WINDOW_REACH * settings.options.map_sigma * results.radius,
            settings.corner_threshold,
        )
    return results


class Worker:
    """Runs one bake on a thread of its own, so that a window stays alive; ask it from the main thread."""

    def __init__(self, arrays: bridge.MeshArrays, settings: Settings) -> None:
        self.stage = "start"
        self.fraction = 0.0
        self._cancelled = threading.Event()
        self._results: Results | None = None
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, args=(arrays, settings), name="paradesc", daemon=True)

    def start(self) -> None:
        """Starts the thread."""
        self._thread.start()

    @property
    def done(self) -> bool:
        """True once results() will not wait."""
        return not self._thread.is_alive()

    def cancel(self) -> None:
        """Asks the native call to stop at its next tile."""
        self._cancelled.set()

    def results(self) -> Results:
        """Waits for the end; gives the results or raises what went wrong. Cancelled is cancelled, however late."""
        self._thread.join()
        if self._cancelled.is_set():
            raise bridge.ParadescError(abi.STATUS_CANCELLED, "Cancelled.")
        if self._error is not None:
            raise self._error
        if self._results is None:
            raise bridge.ParadescError(abi.STATUS_UNKNOWN, "The computation ended without results.")
        return self._results

    def _run(self, arrays: bridge.MeshArrays, settings: Settings) -> None:
        try:
            self._results = run(arrays, settings, self._progress)
        except Exception as error:  # noqa: BLE001 (raised again on the main thread by results())
            self._error = error

    def _progress(self, stage: str, fraction: float) -> bool:
        self.stage, self.fraction = stage, fraction
        return not self._cancelled.is_set()
