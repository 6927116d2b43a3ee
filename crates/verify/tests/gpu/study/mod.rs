//! Rays through the kd-tree on the GPU against the CPU's, which uses the predicate: equal bit for bit.

mod frames;
mod rays;
mod visits;

use glam::DVec3;
use umbrage_gpu::rays::{RayRecords, RayTracer, RayTracerWork};
use umbrage_gpu::{Geometry, Gpu, Recorder};
use umbrage_papers::gpu_kdtree::KdFrame;
use umbrage_papers::{KdNodes, KdTracerOptions, KdTraversal, KdTree, KdTreeOptions};
use umbrage_rays::predicate::HitPoint;
use umbrage_rays::{Hit, LightSource, Ray, SingleRays as _};

use crate::common::{self, Pool, Pooled};
use crate::support::{self, Mesh};

/// A device and a frame.
struct Device {
    gpu: Gpu,
    frame: KdFrame,
}

/// The shared device with a frame of its own. `None` without an adapter.
fn device() -> Option<Pooled<Device>> {
    static DEVICES: Pool<Device> = Pool::new();
    let gpu = common::gpu()?;
    let mut device = DEVICES.take(|| Device { frame: KdFrame::new(&gpu, KdTracerOptions::DEFAULT), gpu });
    let Device { gpu, frame } = &mut *device;
    frame.set_options(gpu, KdTracerOptions::DEFAULT);
    Some(device)
}

/// Traversals of single rays and of packets.
fn walks() -> Vec<KdTracerOptions> {
    let single = |traversal| KdTracerOptions { traversal, packet: None, counts: true, from_triangles: false };
    let packet = |traversal, lanes| KdTracerOptions { packet: Some(lanes), ..single(traversal) };
    vec![
        single(KdTraversal::Stack),
        single(KdTraversal::Restart),
        single(KdTraversal::PushDown),
        single(KdTraversal::ShortStack(1)),
        single(KdTraversal::ShortStack(4)),
        packet(KdTraversal::Restart, 8),
        packet(KdTraversal::PushDown, 16),
        packet(KdTraversal::ShortStack(3), 64),
        packet(KdTraversal::Stack, 4),
    ]
}

/// A scene with its tree, on CPU and GPU.
struct Scene {
    mesh: Mesh,
    tree: KdTree,
    geometry: Geometry,
    nodes: KdNodes,
}

impl Scene {
    fn new(gpu: &Gpu, mesh: Mesh, options: KdTreeOptions) -> Self {
        let (mut geometry, mut nodes) = (Geometry::new(gpu), KdNodes::new(gpu));
        let mut tree = KdTree::default();
        tree.set_options(options).expect("possible options");
        tree.build(mesh.triangles());
        geometry.write(gpu, mesh.triangles(), |_| 0).expect("room");
        nodes.write(gpu, &tree).expect("room");
        Self { mesh, tree, geometry, nodes }
    }
}

/// A tracer's nearest hits of rays.
fn nearest(gpu: &Gpu, tracer: &mut RayTracer, scene: &Scene, rays: &[(Ray, Option<u32>)]) -> Vec<Option<Hit>> {
    let mut records = RayRecords::new(gpu);
    records.write_rays(gpu, rays.iter().copied(), tracer.options().lanes()).expect("room");
    nearest_of(gpu, tracer, scene, &records, rays.len())
}

/// A tracer's nearest hits of `count` rays on the GPU.
fn nearest_of(
    gpu: &Gpu,
    tracer: &mut RayTracer,
    scene: &Scene,
    records: &RayRecords,
    count: usize,
) -> Vec<Option<Hit>> {
    loop {
        tracer.prepare(gpu, count as u32, 1).expect("room");
        let mut recorder = Recorder::new(gpu);
        tracer.record_nearest(gpu, &mut recorder, &scene.geometry, &scene.nodes, records);
        let done = recorder.submit_and_wait().expect("done");
        if tracer.finish(gpu, &done).expect("done") {
            return tracer.read_hits(gpu, count).expect("read");
        }
    }
}

/// A tracer's answers for points and lights.
fn blocked(gpu: &Gpu, tracer: &mut RayTracer, scene: &Scene, questions: &[(LightSource, HitPoint, u32)]) -> Vec<bool> {
    let mut records = RayRecords::new(gpu);
    records.write_shadows(gpu, questions.iter().copied(), tracer.options().lanes()).expect("room");
    loop {
        tracer.prepare(gpu, questions.len() as u32, 1).expect("room");
        let mut recorder = Recorder::new(gpu);
        tracer.record_blocked(gpu, &mut recorder, &scene.geometry, &scene.nodes, &records);
        let done = recorder.submit_and_wait().expect("done");
        if tracer.finish(gpu, &done).expect("done") {
            return tracer.read_shadows(gpu, questions.len()).expect("read");
        }
    }
}

fn bits(hit: Option<Hit>) -> Option<(u32, u64, [u32; 2])> {
    hit.map(|hit| (hit.triangle, hit.t.to_bits(), hit.barycentric.map(f32::to_bits)))
}

/// Compares with the CPU; returns the number of hits, and the work.
fn check(gpu: &Gpu, tracer: &mut RayTracer, scene: &Scene, rays: &[(Ray, Option<u32>)]) -> (usize, RayTracerWork) {
    let found = nearest(gpu, tracer, scene, rays);
    let mut hits = 0;
    for ((ray, own), found) in rays.iter().zip(found) {
        let expected = scene.tree.nearest(scene.mesh.triangles(), ray, &|hit| Some(hit.triangle) != *own);
        assert_eq!(bits(found), bits(expected), "{ray:?} without {own:?}, {:?}", tracer.options());
        hits += usize::from(expected.is_some());
    }
    (hits, tracer.work()[0])
}

/// Rays without a triangle of their own.
fn free(rays: impl IntoIterator<Item = Ray>) -> Vec<(Ray, Option<u32>)> {
    rays.into_iter().filter(|ray| ray.direction != DVec3::ZERO).map(|ray| (ray, None)).collect()
}
