// The stack of materials around a ray: crates/umbrage/src/shade/glass.rs.

// In order of entry. When the stack is full, the oldest entry is dropped.
struct Media {
    materials: vec4<u32>,
    count: u32,
}

const MOST_MEDIA: u32 = 4u;
const OPEN_AIR: u32 = 0xffffffffu;

// The innermost material; `OPEN_AIR` outside of all.
fn media_innermost(media: Media) -> u32 {
    if media.count == 0u {
        return OPEN_AIR;
    }
    return media.materials[media.count - 1u];
}

// The stack after the ray crosses a surface of this material: entering from its front, or leaving from its back.
fn media_across(media: Media, material: u32, from_front: bool) -> Media {
    let held = media.materials;
    if from_front {
        if media.count == MOST_MEDIA {
            return Media(vec4<u32>(held.yzw, material), MOST_MEDIA);
        }
        var entered = media;
        entered.materials[media.count] = material;
        entered.count += 1u;
        return entered;
    }
    var left = Media();
    var found = MOST_MEDIA;
    for (var index = 0u; index < media.count; index++) {
        if held[index] == material {
            found = index;
        }
    }
    for (var index = 0u; index < media.count; index++) {
        if index != found {
            left.materials[left.count] = held[index];
            left.count += 1u;
        }
    }
    return left;
}
