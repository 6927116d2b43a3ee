//! The node hierarchy: nodes' transforms and visibility.

use std::ops::Mul;

use glam::{Affine3A, Mat4, Quat, Vec3};
use gltf::json::Node;
use umbrage_scene::Error;

use super::document::Document;
use super::pointers::PointerChannel;

/// A node's transform to its parent, taken apart: applied as scale, rotation, translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trs {
    pub(super) translation: Vec3,
    /// Of unit length.
    pub(super) rotation: Quat,
    pub(super) scale: Vec3,
}

impl Trs {
    pub(super) const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    pub(super) fn parent_from_node(&self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// Makes a unit quaternion from components in glTF's order; the identity for zero.
pub(super) fn rotation(components: [f32; 4]) -> Quat {
    let rotation = Quat::from_array(components);
    let length = rotation.length();
    if length > 0.0 && length.is_finite() { rotation / length } else { Quat::IDENTITY }
}

/// All nodes of a file at rest, in every scene, since joints may be anywhere.
#[derive(Debug)]
pub(super) struct Nodes {
    pub(super) parents: Vec<Option<u32>>,
    /// Every node once, parents before their children.
    pub(super) order: Vec<u32>,
    pub(super) parent_from_node: Vec<Affine3A>,
    /// Whether a node is part of the scene that is shown.
    pub(super) in_scene: Vec<bool>,
    /// Whether a node's content can be visible at some time.
    pub(super) visible: Vec<bool>,
    /// Each node's own visibility at rest (`KHR_node_visibility`), regardless of its ancestors.
    pub(super) shows_itself: Vec<bool>,
}

impl Nodes {
    /// Reads the hierarchy and the scene to show: the default one, else the first, else all nodes.
    ///
    /// # Errors
    /// Where an index is out of range, or a node is its own ancestor or has two parents.
    pub(super) fn read(document: &Document) -> Result<Self, Error> {
        let json = &document.json.nodes;
        let mut parents = vec![None; json.len()];
        for (parent, node) in json.iter().enumerate() {
            for (at, child) in node.children.iter().flatten().enumerate() {
                let location = format_args!("nodes[{parent}].children[{at}]");
                document.element(json, "nodes", child.value(), location)?;
                if let Some(other) = parents[child.value()].replace(parent as u32) {
                    let cause = format!("node {} is a child of node {other} already", child.value());
                    return Err(document.malformed(format_args!("nodes[{parent}].children[{at}]"), cause));
                }
            }
        }
        let order = parents_first(json, &parents);
        if order.len() < json.len() {
            let mut reached = vec![false; json.len()];
            order.iter().for_each(|&node| reached[node as usize] = true);
            let lost = reached.iter().position(|&reached| !reached).unwrap_or(0);
            return Err(document.malformed(format_args!("nodes[{lost}]"), "the node is below itself in the hierarchy"));
        }
        let in_scene = in_scene(document, &order, &parents)?;
        let shows_itself: Vec<_> = json.iter().map(shows_itself).collect();
        let mut visible = shows_itself.clone();
        for toggled in document.pointers.iter().filter_map(PointerChannel::toggled_node) {
            visible.get_mut(toggled).into_iter().for_each(|visible| *visible = true);
        }
        hide_below(&mut visible, &order, &parents);
        visible.iter_mut().zip(&in_scene).for_each(|(visible, in_scene)| *visible &= in_scene);
        let parent_from_node = json.iter().map(parent_from_node).collect();
        Ok(Self { parents, order, parent_from_node, in_scene, visible, shows_itself })
    }

    /// Each node's transform to the world, in f32 or in f64, from its transform to its parent.
    pub(super) fn to_world<T: Copy + Mul<Output = T>>(&self, mut transforms: Vec<T>) -> Vec<T> {
        for &node in &self.order {
            if let Some(parent) = self.parents[node as usize] {
                transforms[node as usize] = transforms[parent as usize] * transforms[node as usize];
            }
        }
        transforms
    }
}

/// The node's transform to its parent, taken apart. Shear, which a matrix may have, is lost.
pub(super) fn trs(node: &Node) -> Trs {
    if let Some(matrix) = &node.matrix {
        let (scale, rotation, translation) = Mat4::from_cols_array(matrix).to_scale_rotation_translation();
        return Trs { translation, rotation: self::rotation(rotation.to_array()), scale };
    }
    Trs {
        translation: node.translation.map_or(Vec3::ZERO, Vec3::from_array),
        rotation: node.rotation.map_or(Quat::IDENTITY, |rotation| self::rotation(rotation.0)),
        scale: node.scale.map_or(Vec3::ONE, Vec3::from_array),
    }
}

fn parent_from_node(node: &Node) -> Affine3A {
    match &node.matrix {
        Some(matrix) => Affine3A::from_mat4(Mat4::from_cols_array(matrix)),
        None => trs(node).parent_from_node(),
    }
}

/// All nodes below roots, parents before their children: all nodes of the file, unless there is a cycle.
fn parents_first(json: &[Node], parents: &[Option<u32>]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..json.len() as u32).filter(|&node| parents[node as usize].is_none()).collect();
    let mut next = 0;
    while let Some(&node) = order.get(next) {
        order.extend(json[node as usize].children.iter().flatten().map(|child| child.value() as u32));
        next += 1;
    }
    order
}

/// A node's own visibility.
fn shows_itself(node: &Node) -> bool {
    let visibility = node.extensions.as_ref().and_then(|extensions| extensions.others.get("KHR_node_visibility"));
    visibility.and_then(|visibility| visibility.get("visible")?.as_bool()).unwrap_or(true)
}

/// Hides all nodes below a hidden node.
pub(super) fn hide_below(visible: &mut [bool], order: &[u32], parents: &[Option<u32>]) {
    for &node in order {
        if let Some(parent) = parents[node as usize] {
            visible[node as usize] &= visible[parent as usize];
        }
    }
}

fn in_scene(document: &Document, order: &[u32], parents: &[Option<u32>]) -> Result<Vec<bool>, Error> {
    let json = &document.json;
    let number = json.scene.map_or(0, |scene| scene.value());
    if json.scenes.is_empty() && json.scene.is_none() {
        return Ok(vec![true; parents.len()]);
    }
    let scene = document.element(&json.scenes, "scenes", number, "scene")?;
    let mut in_scene = vec![false; parents.len()];
    for (at, node) in scene.nodes.iter().enumerate() {
        document.element(parents, "nodes", node.value(), format_args!("scenes[{number}].nodes[{at}]"))?;
        in_scene[node.value()] = true;
    }
    for &node in order {
        if let Some(parent) = parents[node as usize] {
            in_scene[node as usize] |= in_scene[parent as usize];
        }
    }
    Ok(in_scene)
}
