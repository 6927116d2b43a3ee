"""Queries of trimesh meshes: rays, with the methods and signatures of ``trimesh.ray.ray_triangle.RayMeshIntersector``, and distances,
with those of ``trimesh.proximity.ProximityQuery``.

    mesh.ray = umbrage.trimesh.RayMeshIntersector(mesh)
    closest, distance, triangle = umbrage.trimesh.ProximityQuery(mesh).on_surface(points)

Answers are those of `RaycastingScene`: exact for the mesh's vertices as rounded to float32, without an offset. So a ray that starts on
a triangle hits that only if it starts on the ray's near side of it, a matter of rounding; start it where you mean. Vertices of a mesh
that is far from the origin of its coordinates are rounded after they are counted from a point near it.
"""

from __future__ import annotations

import numpy as np

from ._umbrage import RaycastingScene

__all__ = ["ProximityQuery", "RayMeshIntersector"]

# Nothing is special about them; another one is taken where a ray passes an edge or a corner.
_DIRECTIONS = np.random.default_rng(20).normal(size=(16, 3))

# The largest coordinate of a mesh that isn't far, in diagonals of its box.
_MOST_DIAGONALS = 512

# Weights nearer to 0 than this may be those of an edge.
_EDGE = 1e-6


class _Mesh:
    """A mesh, and its triangles as they were last looked at."""

    def __init__(self, mesh, *, nthreads: int = 0) -> None:
        self.mesh = mesh
        self._nthreads = nthreads
        self._scene = None
        self._origin = np.zeros(3)
        self._hash = None

    def _current(self) -> RaycastingScene:
        # Objects that aren't trimesh's have an identity for a hash: they are taken anew each time.
        of_content = hash(self.mesh) if hasattr(self.mesh, "_cache") else None
        if self._scene is None or of_content is None or of_content != self._hash:
            vertices = np.asarray(self.mesh.vertices, np.float64)
            self._origin = _origin(vertices)
            self._scene = RaycastingScene(self._nthreads, origin=self._origin)
            self._scene.add_triangles(vertices - self._origin if self._origin.any() else vertices, self.mesh.faces)
            self._hash = of_content
        return self._scene


class RayMeshIntersector(_Mesh):
    """What rays hit of a mesh.

    Parameters
    ----------
    mesh : trimesh.Trimesh
        Anything with ``vertices`` (N, 3) and ``faces`` (M, 3). A mesh of trimesh may change: it is looked at again where its hash has
        changed.
    nthreads : int, default 0
        Threads; 0 for as many as ``umbrage.set_threads`` says.

    Examples
    --------
    >>> import trimesh
    >>> ray = RayMeshIntersector(trimesh.creation.box())
    >>> ray.intersects_any([[0, 0, -5]], [[0, 0, 1]])
    array([ True])
    """

    def intersects_id(
        self,
        ray_origins,
        ray_directions,
        return_locations: bool = False,
        multiple_hits: bool = True,
        max_hits: int | None = None,
        unique: bool | None = None,
    ):
        """Find the triangles that rays hit.

        Parameters
        ----------
        ray_origins, ray_directions : (m, 3) float
            Of any lengths above zero.
        return_locations : bool
            Whether to return where, too.
        multiple_hits : bool
            All hits of a ray rather than its first one.
        max_hits : int, optional
            The most hits of a ray, nearest first.
        unique : bool, optional
            Whether a ray that passes an edge or a corner hits one of its triangles only, that of the lowest index, so that each
            crossing of a surface counts once; otherwise it hits all of them. As with trimesh, the default is `return_locations`.

        Returns
        -------
        index_tri : (h,) int
            Triangles that are hit: ray by ray, and of each the nearest first.
        index_ray : (h,) int
            The ray of each.
        locations : (h, 3) float
            Where, if asked for.
        """
        rays = _rays(ray_origins, ray_directions)
        if multiple_hits:
            hits = self._current().list_intersections(rays)
            index_ray, index_tri, t = hits["ray_ids"], hits["primitive_ids"].astype(np.int64), hits["t_hit"]
            if (return_locations if unique is None else unique) and len(t) > 1:
                # Where a ray passes an edge all of its triangles have the very same t.
                again = (index_ray[1:] == index_ray[:-1]) & (t[1:] == t[:-1])
                first = np.concatenate(([True], ~again))
                index_ray, index_tri, t = index_ray[first], index_tri[first], t[first]
            if max_hits is not None:
                number = np.arange(len(index_ray)) - np.searchsorted(index_ray, index_ray)
                index_ray, index_tri, t = (of[number < max_hits] for of in (index_ray, index_tri, t))
        else:
            answer = self._current().cast_rays(rays)
            index_ray = np.flatnonzero(np.isfinite(answer["t_hit"]))
            index_tri = answer["primitive_ids"][index_ray].astype(np.int64)
            t = answer["t_hit"][index_ray]
        if not return_locations:
            return index_tri, index_ray
        return index_tri, index_ray, rays[index_ray, :3] + rays[index_ray, 3:] * t[:, None]

    def intersects_location(self, ray_origins, ray_directions, **kwargs):
        """Find where rays hit, each place once; keywords are those of `intersects_id`.

        Returns
        -------
        locations : (h, 3) float
        index_ray : (h,) int
        index_tri : (h,) int
        """
        index_tri, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, return_locations=True, **kwargs
        )
        return locations, index_ray, index_tri

    def intersects_first(self, ray_origins, ray_directions):
        """Find the first triangle that each ray hits.

        Returns
        -------
        (m,) int
            The triangle's index, or -1.
        """
        answer = self._current().cast_rays(_rays(ray_origins, ray_directions))
        return np.where(np.isfinite(answer["t_hit"]), answer["primitive_ids"].astype(np.int64), -1)

    def intersects_any(self, ray_origins, ray_directions):
        """Find whether each ray hits anything.

        Returns
        -------
        (m,) bool
        """
        return self._current().test_occlusions(_rays(ray_origins, ray_directions))

    def contains_points(self, points):
        """Find which points are inside of a watertight mesh; not those on its surface, of which this says either.

        A point is inside where a ray from it passes the surface an odd number of times. Only rays that pass no edge and no corner are
        counted, so the count is right, and the same each time.

        Parameters
        ----------
        points : (n, 3) float

        Returns
        -------
        (n,) bool
        """
        points = _rows("points", "n", points)
        scene = self._current()
        inside = np.zeros(len(points), bool)
        vertices = (np.asarray(self.mesh.vertices, np.float64) - self._origin).astype(np.float32)
        if len(vertices) == 0:
            return inside
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        local = points - self._origin
        undecided = np.flatnonzero(((local >= low) & (local <= high)).all(axis=1))
        for direction in _DIRECTIONS:
            if len(undecided) == 0:
                break
            rays = np.hstack((points[undecided], np.broadcast_to(direction, (len(undecided), 3))))
            hits = scene.list_intersections(rays)
            u, v = hits["primitive_uvs"].T
            at_edge = (u < _EDGE) | (v < _EDGE) | (u + v > 1 - _EDGE)
            odd = np.diff(hits["ray_splits"]) % 2 == 1
            unclear = np.bincount(hits["ray_ids"], at_edge, len(undecided)) > 0
            inside[undecided] = odd
            undecided = undecided[unclear]
        return inside


class ProximityQuery(_Mesh):
    """How far points are from a mesh.

    Parameters
    ----------
    mesh, nthreads
        As of `RayMeshIntersector`.

    Examples
    --------
    >>> import trimesh
    >>> ProximityQuery(trimesh.creation.box()).signed_distance([[0, 0, 0.25], [0, 0, 2]])
    array([ 0.25, -1.5 ])
    """

    def on_surface(self, points):
        """Find the nearest point of the mesh for each point.

        Parameters
        ----------
        points : (n, 3) float

        Returns
        -------
        closest : (n, 3) float
        distance : (n,) float
            From the point to the nearest one; infinite for points that aren't finite, and for a mesh without triangles.
        triangle_id : (n,) int
            Of equally near triangles the first.
        """
        scene, points = self._current(), _rows("points", "n", points)
        found = scene.compute_closest_points(points)
        distance = scene.compute_distance(points)
        return found["points"], distance, found["primitive_ids"].astype(np.int64)

    def signed_distance(self, points):
        """Find how far the surface is from points, above zero inside of a closed mesh and below zero outside.

        Parameters
        ----------
        points : (n, 3) float

        Returns
        -------
        (n,) float
        """
        return -self._current().compute_signed_distance(_rows("points", "n", points))


def _origin(vertices):
    """The origin of a mesh, as scenes of files have it: the middle of its box where that is far from (0, 0, 0)."""
    with np.errstate(over="ignore"):
        vertices = vertices[np.isfinite(vertices.astype(np.float32)).all(axis=-1)]
    if vertices.size == 0:
        return np.zeros(3)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    diagonal = np.linalg.norm(high - low)
    if max(-low.min(), high.max()) <= _MOST_DIAGONALS * diagonal:
        return np.zeros(3)
    # Whole numbers, or halves, quarters and so on of a mesh smaller than 1.
    step = 2.0 ** np.floor(np.log2(diagonal)) if 0 < diagonal < 1 else 1.0
    return np.round((low + high) / (2 * step)) * step


def _rays(origins, directions):
    origins = _rows("ray_origins", "m", origins)
    return np.hstack((origins, _rows("ray_directions", len(origins), directions)))


def _rows(name, count, value):
    """An array of shape (count, 3), of any number of rows where the count is a letter."""
    try:
        found = np.asarray(value)
    except ValueError as why:
        raise TypeError(f"{name}: expected shape ({count}, 3) float64, found {type(value).__name__}: {why}") from None
    says = f"{name}: expected shape ({count}, 3) float64, found shape {found.shape} {found.dtype}"
    if found.dtype.kind not in "fiu" and found.size > 0:
        raise TypeError(says)
    if found.ndim != 2 or found.shape[1] != 3 or count not in (len(found), "m", "n"):
        raise ValueError(says)
    return found.astype(np.float64, copy=False)
