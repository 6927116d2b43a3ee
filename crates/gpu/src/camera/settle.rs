use glam::DVec2;

use super::trace::{NODES_FIRST, NODES_GROUPS, NODES_PIXEL_GROUPS};
use crate::view::PointView;
use crate::{Band, Buffer, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stage `settle`: decides hits that the filter has left undecided, by the predicate.
#[derive(Debug)]
pub(super) struct Settle {
    nodes: Kernel,
    pixels: Kernel,
    view: Buffer,
    sizes: Buffer,
}

impl Settle {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let [nodes, pixels] = Kernel::all(gpu, "camera::settle", ["settle_nodes", "settle"], &[]);
        Self {
            nodes,
            pixels,
            view: Buffer::uniform(gpu, "view to settle"),
            sizes: Buffer::sizes(gpu, "settle dispatch sizes"),
        }
    }

    pub(super) fn prepare(&mut self, gpu: &Gpu, band: &Band, offset_pixels: DVec2) -> Result<(), GpuError> {
        self.sizes.reserve(gpu, 4 * NODES_FIRST)?;
        self.view.write(gpu, &[PointView::new(band, offset_pixels)])
    }

    pub(super) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        seen: &Buffer,
        nodes: &Buffer,
    ) {
        recorder.copy_words(nodes, &self.sizes, NODES_FIRST);
        let buffers = [&self.view, geometry.triangles(), geometry.positions(), seen, nodes, geometry.masks().buffer()];
        recorder.stage("settle", |pass| {
            self.nodes.dispatch(gpu, pass, &buffers, Groups::Indirect(&self.sizes, NODES_GROUPS));
            self.pixels.dispatch(gpu, pass, &buffers, Groups::Indirect(&self.sizes, NODES_PIXEL_GROUPS));
        });
    }
}
