//! `KHR_animation_pointer`: channels whose target is a path in the JSON.
//!
//! Pointers to properties that plain channels can move are made plain before the JSON is parsed. The parsing library drops
//! the others, so they are kept here until animations are read.

use serde_json::{Value, json};

use super::moved::Target;

const NAME: &str = "KHR_animation_pointer";

/// A channel that moves a property that no plain channel can.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PointerChannel {
    pub(super) animation: usize,
    pub(super) channel: usize,
    pub(super) sampler: usize,
    pub(super) pointer: String,
}

impl PointerChannel {
    /// The channel's path in the JSON.
    pub(super) fn location(&self) -> String {
        format!("animations[{}].channels[{}]", self.animation, self.channel)
    }

    /// The node whose visibility this channel changes, if any.
    pub(super) fn toggled_node(&self) -> Option<usize> {
        match Target::of(&self.pointer)? {
            Target::Visibility(node) => Some(node),
            _ => None,
        }
    }
}

/// Makes an animation's channels plain where possible, and returns the other channels with pointers. Their samplers stay.
pub(super) fn resolve(number: usize, animation: &mut Value) -> Vec<PointerChannel> {
    let mut others = Vec::new();
    let channels = animation.get_mut("channels").and_then(Value::as_array_mut);
    for (at, channel) in channels.into_iter().flatten().enumerate() {
        let Some(pointer) = pointer(channel) else { continue };
        if let Some((node, path)) = plain(pointer) {
            channel["target"] = json!({ "node": node, "path": path });
            continue;
        }
        let sampler = channel.get("sampler").and_then(Value::as_u64).map_or(usize::MAX, |sampler| sampler as usize);
        others.push(PointerChannel { animation: number, channel: at, sampler, pointer: pointer.to_owned() });
    }
    others
}

/// A channel's pointer, if it has one. After [`resolve`], such a channel is among those returned.
pub(super) fn pointer(channel: &Value) -> Option<&str> {
    channel.pointer(&format!("/target/extensions/{NAME}/pointer"))?.as_str()
}

/// Node and path of a plain channel.
fn plain(pointer: &str) -> Option<(u32, &str)> {
    let (node, path) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    let is_plain = ["translation", "rotation", "scale", "weights"].contains(&path);
    Some((node.parse().ok()?, path)).filter(|_| is_plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_become_plain_and_others_wait() {
        let channel = |pointer: &str| {
            let extensions = json!({ NAME: { "pointer": pointer } });
            json!({ "sampler": 3, "target": { "path": "pointer", "extensions": extensions } })
        };
        let visible = "/nodes/4/extensions/KHR_node_visibility/visible";
        let plain = json!({ "sampler": 0, "target": { "node": 1, "path": "scale" } });
        let channels = json!([channel("/nodes/12/rotation"), channel(visible), plain, channel("/nodes/x/rotation")]);
        let mut animation = json!({ "channels": channels });
        let others = resolve(2, &mut animation);
        assert_eq!(animation["channels"][0]["target"], json!({ "node": 12, "path": "rotation" }));
        assert_eq!(animation["channels"][2], plain);
        let pointer = |channel: usize, pointer: &str| PointerChannel {
            animation: 2,
            channel,
            sampler: 3,
            pointer: pointer.to_owned(),
        };
        assert_eq!(others, [pointer(1, visible), pointer(3, "/nodes/x/rotation")]);
        assert_eq!(others[0].toggled_node(), Some(4));
        assert_eq!(others[1].toggled_node(), None);
        assert_eq!(others[1].location(), "animations[2].channels[3]");
    }
}
