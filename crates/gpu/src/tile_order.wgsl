// The order in which what belongs to pixels is stored: tiles of 64×64 pixels, in them blocks of 4×4 (as `TileOrder`).

fn tile_order_place(x: u32, y: u32, width: u32) -> u32 {
    let tile = (y >> 6u) * ((width + 63u) >> 6u) + (x >> 6u);
    let block = ((y >> 2u) & 15u) * 16u + ((x >> 2u) & 15u);
    return tile * 4096u + block * 16u + (y & 3u) * 4u + (x & 3u);
}

// Column and row of what is stored at a place; beyond the image's border where that is no pixel.
fn tile_order_pixel(place: u32, width: u32) -> vec2<u32> {
    let columns = max((width + 63u) >> 6u, 1u);
    let tile = place >> 12u;
    let block = (place >> 4u) & 255u;
    return vec2<u32>(
        (tile % columns) * 64u + (block & 15u) * 4u + (place & 3u),
        (tile / columns) * 64u + (block >> 4u) * 4u + ((place >> 2u) & 3u));
}
