use bytemuck::{Pod, Zeroable};
use glam::DVec2;

use super::trace::Trace;
use crate::grid::words;
use crate::view::ExactView;
use crate::{Band, Buffer, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The stage `settle`: what the filter has left undecided, by the predicate.
#[derive(Debug)]
pub(super) struct Settle {
    nodes: Kernel,
    pixels: Kernel,
    view: Buffer,
    sizes: Buffer,
}

/// As in `settle.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct SettleView {
    view: ExactView,
    x_offset: [u32; 2],
    y_offset: [u32; 2],
    culls_back_faces: u32,
    first_row: u32,
    unused: [u32; 2],
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

    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        band: &Band,
        offset_pixels: DVec2,
        culls_back_faces: bool,
    ) -> Result<(), GpuError> {
        self.sizes.reserve(gpu, 4 * Trace::NODES_HEADER)?;
        let view = SettleView {
            view: (&band.view).into(),
            x_offset: words(offset_pixels.x),
            y_offset: words(offset_pixels.y),
            culls_back_faces: u32::from(culls_back_faces),
            first_row: band.rows.start,
            unused: [0; 2],
        };
        self.view.write(gpu, &[view])
    }

    pub(super) fn record(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        seen: &Buffer,
        nodes: &Buffer,
    ) {
        recorder.copy_words(nodes, &self.sizes, Trace::NODES_HEADER);
        let buffers = [&self.view, geometry.triangles(), geometry.positions(), seen, nodes, geometry.masks().buffer()];
        recorder.stage("settle", |pass| {
            self.nodes.dispatch(gpu, pass, &buffers, Groups::Indirect(&self.sizes, Trace::NODE_GROUPS));
            self.pixels.dispatch(gpu, pass, &buffers, Groups::Indirect(&self.sizes, Trace::PIXEL_GROUPS));
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{differences, layout, module};
    use crate::link::link;

    #[test]
    fn the_view_is_that_of_the_shader() {
        let shader = module(&link("camera::settle"));
        let layout = layout!(SettleView { view, x_offset, y_offset, culls_back_faces, first_row });
        assert_eq!(differences(&shader, &layout), [""; 0]);
    }
}
