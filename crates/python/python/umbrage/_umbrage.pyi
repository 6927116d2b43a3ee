"""Types of the compiled half; its docs are in the module."""

from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal, final, overload

from numpy.typing import ArrayLike, NDArray

import numpy as np

from .picture import Picture

__all__ = [
    "Camera",
    "Frame",
    "Instance",
    "Light",
    "RaycastingScene",
    "Scene",
    "__version__",
    "get_threads",
    "open",
    "set_threads",
]

__version__: str

@final
class Camera:
    def __new__(
        cls,
        position: ArrayLike,
        target: ArrayLike,
        up: ArrayLike | None = None,
        *,
        fov_degrees: float = 40.0,
        half_height: float | None = None,
    ) -> Camera: ...
    @staticmethod
    def from_intrinsics(
        intrinsics: ArrayLike, extrinsics: ArrayLike | None = None, *, width: int, height: int
    ) -> Camera: ...
    @property
    def size(self) -> tuple[int, int] | None: ...
    def intrinsics(self, width: int | None = None, height: int | None = None) -> NDArray[np.float64]: ...
    @property
    def extrinsics(self) -> NDArray[np.float64]: ...
    @property
    def position(self) -> list[float]: ...
    @property
    def forward(self) -> list[float]: ...
    def rays(
        self, width: int | None = None, height: int | None = None, nthreads: int = 0
    ) -> NDArray[np.float64]: ...

@final
class Light:
    @staticmethod
    def sun(direction: ArrayLike) -> Light: ...
    @staticmethod
    def suns(directions: ArrayLike) -> list[Light]: ...
    @staticmethod
    def point(position: ArrayLike) -> Light: ...
    @staticmethod
    def spot(position: ArrayLike, target: ArrayLike, degrees: float) -> Light: ...

@final
class Frame:
    @property
    def vertices(self) -> NDArray[np.float32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def cameras(self) -> list[tuple[str, Camera]]: ...
    @property
    def lights(self) -> list[Light]: ...
    @property
    def seconds(self) -> float: ...
    @property
    def origin(self) -> list[float]: ...

@final
class Instance:
    @property
    def name(self) -> str: ...
    @property
    def vertices(self) -> NDArray[np.float32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def world_from_object(self) -> NDArray[np.float64]: ...

@final
class Scene:
    @property
    def duration(self) -> float: ...
    @property
    def origin(self) -> list[float]: ...
    @property
    def animations(self) -> list[str]: ...
    @property
    def variants(self) -> list[str]: ...
    @property
    def objects(self) -> list[str]: ...
    @property
    def warnings(self) -> list[str]: ...
    def at(self, seconds: float, nthreads: int = 0) -> Frame: ...
    def instances(self, seconds: float, nthreads: int = 0) -> list[Instance]: ...
    def render(
        self,
        seconds: float | None = None,
        width: int | None = None,
        height: int | None = None,
        *,
        samples: int = 1,
        camera: Camera | int | str | None = None,
        lights: Light | str | Sequence[Light | str] | None = None,
        background: str = "sky",
        bounces: int = 0,
        exposure: float | Literal["auto"] | None = None,
        nthreads: int = 0,
    ) -> Picture: ...

@final
class InstancedScene:
    INVALID_ID: int
    def __new__(cls, nthreads: int = 0) -> InstancedScene: ...
    def add_mesh(self, vertex_positions: ArrayLike | Any, triangle_indices: ArrayLike | None = None) -> int: ...
    def update_mesh(self, mesh_id: int, vertex_positions: ArrayLike) -> None: ...
    def set_instances(
        self, mesh_ids: int | ArrayLike, world_from_mesh: ArrayLike, *, mask: int | ArrayLike | None = None
    ) -> None: ...
    def cast_rays(
        self,
        rays: ArrayLike,
        nthreads: int = 0,
        *,
        mask: int | ArrayLike | None = None,
        keys: Sequence[str] | None = None,
    ) -> dict[str, NDArray[Any]]: ...
    def scan(
        self,
        origin: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: float = 0.0,
        t_max: float = ...,
        each: bool = False,
        mask: int | ArrayLike | None = None,
        nthreads: int = 0,
        keys: Sequence[str] | None = None,
    ) -> dict[str, NDArray[Any]]: ...
    def lit(
        self,
        lights: Light | str | Sequence[Light | str],
        *,
        points: ArrayLike | None = None,
        faces: bool = False,
        geometry_ids: ArrayLike | None = None,
        primitive_ids: ArrayLike | None = None,
        mask: int | ArrayLike | None = None,
        nthreads: int = 0,
    ) -> NDArray[np.bool_]: ...

class MovingScene:
    INVALID_ID: int
    def __new__(
        cls, vertex_positions: ArrayLike, triangle_indices: ArrayLike, seconds: ArrayLike, *, nthreads: int = 0
    ) -> MovingScene: ...
    def update(self, vertex_positions: ArrayLike, seconds: ArrayLike) -> None: ...
    def pose(self, seconds: float) -> NDArray[np.float32]: ...
    def cast_rays(
        self, rays: ArrayLike, seconds: float | ArrayLike, nthreads: int = 0, *, keys: Sequence[str] | None = None
    ) -> dict[str, NDArray[Any]]: ...

class RaycastingScene:
    INVALID_ID: int
    def __new__(cls, nthreads: int = 0, *, origin: ArrayLike | None = None) -> RaycastingScene: ...
    def add_triangles(
        self, vertex_positions: ArrayLike | Any, triangle_indices: ArrayLike | None = None, *, mask: int = 0xFFFFFFFF
    ) -> int: ...
    def remove(self, geometry_id: int) -> None: ...
    def update_vertices(self, geometry_id: int, vertex_positions: ArrayLike) -> None: ...
    def set_transform(self, geometry_id: int, world_from_object: ArrayLike) -> None: ...
    def triangle_slice(self, geometry_id: int) -> slice: ...
    def object_positions(
        self, geometry_ids: ArrayLike, primitive_ids: ArrayLike, primitive_uvs: ArrayLike
    ) -> NDArray[np.float64]: ...
    def omitted(self) -> dict[str, int]: ...
    def cast_rays(
        self,
        rays: ArrayLike,
        nthreads: int = 0,
        *,
        mask: ArrayLike | None = None,
        keys: Sequence[str] | None = None,
    ) -> dict[str, NDArray[Any]]: ...
    @property
    def last_structures(self) -> list[str]: ...
    def test_occlusions(
        self,
        rays: ArrayLike,
        tnear: float = 0.0,
        tfar: float = ...,
        nthreads: int = 0,
        *,
        mask: ArrayLike | None = None,
    ) -> NDArray[np.bool_]: ...
    def count_intersections(
        self, rays: ArrayLike, nthreads: int = 0, *, mask: ArrayLike | None = None
    ) -> NDArray[np.int32]: ...
    def list_intersections(
        self, rays: ArrayLike, nthreads: int = 0, *, mask: ArrayLike | None = None
    ) -> dict[str, NDArray[Any]]: ...
    def scan(
        self,
        origin: ArrayLike,
        directions: ArrayLike,
        *,
        returns: int | None = None,
        t_min: float = 0.0,
        t_max: float = ...,
        each: bool = False,
        mask: ArrayLike | None = None,
        nthreads: int = 0,
        keys: Sequence[str] | None = None,
    ) -> dict[str, NDArray[Any]]: ...
    def scan_any(
        self,
        origin: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: float = 0.0,
        t_max: float = ...,
        each: bool = False,
        mask: ArrayLike | None = None,
        nthreads: int = 0,
    ) -> NDArray[np.bool_]: ...
    def see(
        self,
        camera: Camera,
        width: int | None = None,
        height: int | None = None,
        nthreads: int = 0,
        *,
        mask: int = 0xFFFFFFFF,
        keys: Sequence[str] | None = None,
    ) -> dict[str, NDArray[Any]]: ...
    @overload
    @staticmethod
    def create_rays_pinhole(
        intrinsic_matrix: ArrayLike, extrinsic_matrix: ArrayLike, width_px: int, height_px: int
    ) -> NDArray[np.float32]: ...
    @overload
    @staticmethod
    def create_rays_pinhole(
        fov_deg: float, center: ArrayLike, eye: ArrayLike, up: ArrayLike, width_px: int, height_px: int
    ) -> NDArray[np.float32]: ...
    @staticmethod
    def create_rays_lidar(
        elevations_deg: ArrayLike,
        columns: int | ArrayLike,
        world_from_sensor: ArrayLike | None = None,
        *,
        period: float = 0.0,
        velocity: ArrayLike | None = None,
        angular_velocity_deg: ArrayLike | None = None,
    ) -> NDArray[np.float64]: ...
    def compute_closest_points(self, query_points: ArrayLike, nthreads: int = 0) -> dict[str, NDArray[Any]]: ...
    def compute_distance(self, query_points: ArrayLike, nthreads: int = 0) -> NDArray[np.float64]: ...
    def compute_signed_distance(
        self, query_points: ArrayLike, nthreads: int = 0, nsamples: int = 1
    ) -> NDArray[np.float64]: ...
    def compute_occupancy(
        self, query_points: ArrayLike, nthreads: int = 0, nsamples: int = 1
    ) -> NDArray[np.float32]: ...
    def compute_winding_numbers(self, query_points: ArrayLike, nthreads: int = 0) -> NDArray[np.float64]: ...
    def list_overlapping(self, boxes: ArrayLike, nthreads: int = 0) -> dict[str, NDArray[Any]]: ...
    def compute_thickness(
        self, points: ArrayLike, geometry_ids: ArrayLike, primitive_ids: ArrayLike, nthreads: int = 0
    ) -> NDArray[np.float64]: ...
    def lit(
        self,
        lights: Light | str | Sequence[Light | str],
        *,
        points: ArrayLike | None = None,
        faces: bool = False,
        geometry_ids: ArrayLike | None = None,
        primitive_ids: ArrayLike | None = None,
        facing: bool = False,
        mask: ArrayLike | None = None,
        nthreads: int = 0,
    ) -> NDArray[np.bool_]: ...
    def incidence(
        self,
        lights: Light | str | Sequence[Light | str],
        *,
        points: ArrayLike | None = None,
        faces: bool = False,
        geometry_ids: ArrayLike | None = None,
        primitive_ids: ArrayLike | None = None,
        nthreads: int = 0,
    ) -> NDArray[np.float32]: ...
    def lit_areas(
        self,
        lights: Light | str | Sequence[Light | str],
        *,
        samples: int = 64,
        mask: ArrayLike | None = None,
        nthreads: int = 0,
    ) -> dict[str, NDArray[np.float64]]: ...
    def render(
        self,
        camera: Camera | str | None = None,
        width: int | None = None,
        height: int | None = None,
        *,
        samples: int = 1,
        lights: Light | str | Sequence[Light | str] | None = None,
        background: str = "sky",
        exposure: float | Literal["auto"] | None = None,
        nthreads: int = 0,
    ) -> Picture: ...

def open(
    address: str | PathLike[str],
    *,
    clip: str | None = None,
    ground: str | None = None,
    variant: str | None = None,
    hide: Sequence[str] | None = None,
    sequence_fps: float = 24.0,
    allow_outside: bool = False,
) -> Scene: ...
def set_threads(n: int) -> None: ...
def get_threads() -> int: ...
