// The camera whose points a light is asked about.

import package::exact::camera::{ExactView};

struct LocateView {
    view: ExactView,
    // Where samples are in their pixels.
    x_offset: vec2<u32>,
    y_offset: vec2<u32>,
    places: u32,
}
