"""Exact rays, scans, shadows and pictures of triangles that may all move between two frames.

``RaycastingScene`` holds meshes and answers what rays (``cast_rays``), directions from one origin (``scan``), cameras (``see``)
and lights (``lit``) find among them. ``open`` reads scenes of files. ``umbrage.trimesh`` has trimesh's ray queries.
"""

from ._umbrage import (
    Camera,
    Frame,
    Instance,
    InstancedScene,
    Light,
    MovingScene,
    RaycastingScene,
    Scene,
    __version__,
    get_threads,
    open,
    set_threads,
)
from .picture import Picture

__all__ = [
    "Camera",
    "Frame",
    "Instance",
    "InstancedScene",
    "Light",
    "MovingScene",
    "Picture",
    "RaycastingScene",
    "Scene",
    "__version__",
    "get_threads",
    "open",
    "set_threads",
]
