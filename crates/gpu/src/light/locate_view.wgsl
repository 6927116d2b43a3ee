// The camera whose points a light is asked about. A stage declares it as the uniform `locate_view`.

import package::exact::camera::{ExactView, exact_pixel_ray};
import package::exact::predicate::{ExactRay};
import package::tile_order::{pixel_of_place};
import stage::{locate_view};

struct LocateView {
    view: ExactView,
    // Where samples are in their pixels.
    x_offset: vec2<u32>,
    y_offset: vec2<u32>,
    places: u32,
    // The rows of the whole image that are asked about: the first, and how many.
    first_row: u32,
    rows: u32,
}

// The ray of what is stored at a place.
fn ray_of_place(place: u32) -> ExactRay {
    let pixel = pixel_of_place(place, locate_view.view.width);
    let row = pixel.y + locate_view.first_row;
    return exact_pixel_ray(locate_view.view, pixel.x, row, locate_view.x_offset, locate_view.y_offset);
}
