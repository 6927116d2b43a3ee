//! Order and grouping of rays.

use umbrage_rays::Ray;

use super::Order;

/// Rays in the order of their packets, and the end of each packet.
pub(super) fn packets<'a>(
    order: Order,
    ray: impl Fn(usize) -> &'a Ray,
    kinds: &[u32],
    most: usize,
) -> (Vec<u32>, Vec<usize>) {
    let mut keys: Vec<(u32, u32)> = kinds.iter().zip(0..).map(|(&kind, index)| (kind, index)).collect();
    match order {
        Order::Arrival => keys.iter_mut().for_each(|key| key.0 = 0),
        Order::Runs => {}
        Order::Types => keys.sort_unstable(),
        Order::Directions => {
            for (kind, index) in &mut keys {
                *kind = *kind << 5 | direction(ray(*index as usize));
            }
            keys.sort_unstable();
        }
    }
    let mut ends = Vec::new();
    for together in keys.chunk_by(|a, b| a.0 == b.0) {
        let start = ends.last().copied().unwrap_or(0);
        ends.extend(together.chunks(most).scan(start, |end, packet| {
            *end += packet.len();
            Some(*end)
        }));
    }
    (keys.into_iter().map(|(_, index)| index).collect(), ends)
}

/// The axis of a direction's largest component, and the signs of all components.
fn direction(ray: &Ray) -> u32 {
    let size = ray.direction.abs();
    let of_two = if size.y > size.x { 1 } else { 0 };
    let axis = if size.z > size[of_two] { 2 } else { of_two as u32 };
    axis << 3 | ray.direction.is_negative_bitmask()
}
