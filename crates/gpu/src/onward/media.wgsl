// The materials that a ray is inside of: crates/umbrage/src/shade/glass.rs.

// The last entered last. Of more than there is room for, the first is forgotten.
struct Media {
    materials: vec4<u32>,
    count: u32,
}

const MOST_MEDIA: u32 = 4u;
const OPEN_AIR: u32 = 0xffffffffu;

// The material around the ray; `OPEN_AIR` in the open.
fn media_innermost(media: Media) -> u32 {
    if media.count == 0u {
        return OPEN_AIR;
    }
    return media.materials[media.count - 1u];
}

// After a surface of this material is crossed, from its front to its back or the other way.
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
