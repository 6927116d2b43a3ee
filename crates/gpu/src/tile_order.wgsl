// Storage order of an image's pixels: umbrage_rays::TileOrder.

// Side of a tile and of a block, in pixels.
const TILE_SIDE: u32 = 64u;
const BLOCK_SIDE: u32 = 4u;
const TILE_BLOCKS: u32 = TILE_SIDE / BLOCK_SIDE;
const TILE_SLOTS: u32 = TILE_SIDE * TILE_SIDE;
const BLOCK_SLOTS: u32 = BLOCK_SIDE * BLOCK_SIDE;

// Number of tiles in a row of an image `width` pixels wide.
fn tile_columns(width: u32) -> u32 {
    return (width + TILE_SIDE - 1u) / TILE_SIDE;
}

// Slot of a pixel, given by column and row, in an image `width` pixels wide.
fn slot_of_pixel(pixel: vec2<u32>, width: u32) -> u32 {
    let tile = pixel / TILE_SIDE;
    let block = pixel / BLOCK_SIDE % TILE_BLOCKS;
    let sample = pixel % BLOCK_SIDE;
    return (tile.y * tile_columns(width) + tile.x) * TILE_SLOTS
        + (block.y * TILE_BLOCKS + block.x) * BLOCK_SLOTS
        + sample.y * BLOCK_SIDE + sample.x;
}

// Column and row of the pixel at a slot; outside of the image if the slot has no pixel.
fn pixel_of_slot(slot: u32, width: u32) -> vec2<u32> {
    let columns = max(tile_columns(width), 1u);
    let tile = slot / TILE_SLOTS;
    let block = slot % TILE_SLOTS / BLOCK_SLOTS;
    let sample = slot % BLOCK_SLOTS;
    return vec2<u32>(tile % columns, tile / columns) * TILE_SIDE
        + vec2<u32>(block % TILE_BLOCKS, block / TILE_BLOCKS) * BLOCK_SIDE
        + vec2<u32>(sample % BLOCK_SIDE, sample / BLOCK_SIDE);
}
