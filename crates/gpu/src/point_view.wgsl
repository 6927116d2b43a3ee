// The camera whose pixels, and points on them, are traced. A stage declares it as the uniform `point_view`.

import package::exact::camera::{ExactView, exact_pixel_ray};
import package::exact::predicate::{ExactRay};
import package::tile_order::{pixel_of_slot};
import stage::{point_view};

struct PointView {
    view: ExactView,
    // Position of the sample in each pixel.
    x_offset: vec2<u32>,
    y_offset: vec2<u32>,
    slots: u32,
    // The first row of the band in the whole image, and the number of rows.
    first_row: u32,
    rows: u32,
}

// The ray of the pixel at a slot.
fn ray_of_slot(slot: u32) -> ExactRay {
    let pixel = pixel_of_slot(slot, point_view.view.width);
    let row = pixel.y + point_view.first_row;
    return exact_pixel_ray(point_view.view, pixel.x, row, point_view.x_offset, point_view.y_offset);
}
