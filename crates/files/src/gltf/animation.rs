//! A file's animations, their channels, and the choice of playing animations.

use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;

use gltf::json;
use gltf::json::animation::Property;
use gltf::json::validation::Checked;
use umbrage_scene::{Animation, Error};

use super::accessor::Accessor;
use super::curve::{Curve, Interpolation};
use super::document::Document;
use super::moved::{Moved, Target};
use super::nodes::rotation;
use crate::Clip;
use crate::open::unknown_name;

/// One property of one node, over time.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) node: u32,
    pub(super) property: Property,
    pub(super) curve: Curve,
}

/// The channels of one animation.
struct Channels {
    plain: Vec<Channel>,
    moved: Vec<Moved>,
}

/// The file's animations, and the channels of the playing ones.
#[derive(Debug, Default)]
pub(super) struct Animations {
    pub(super) animations: Vec<Animation>,
    /// In order of application.
    pub(super) channels: Vec<Channel>,
    /// Other properties moved by pointers, of the animations that play.
    pub(super) moved: Vec<Moved>,
    /// Time at which the last of all animations ends.
    pub(super) duration_seconds: f64,
}

impl Animations {
    /// Reads all animations and keeps those selected by `clip`. `weights` gives each node's number of morph targets.
    ///
    /// # Errors
    /// Where an animation is broken, or `clip` names a missing one.
    pub(super) fn read(
        document: &Document,
        path: &Path,
        weights: impl Fn(usize) -> usize,
        clip: &Clip,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let mut read = Self::default();
        let mut all = Vec::new();
        check_size(document)?;
        for (number, json) in document.json.animations.iter().enumerate() {
            let channels = read_channels(document, json, number, &weights, warnings)?;
            let moved = read_pointers(document, json, number, warnings)?;
            let curves = channels.iter().map(|channel| &channel.curve).chain(moved.iter().map(|moved| &moved.curve));
            let seconds = curves.map(Curve::end_seconds).fold(0.0, f32::max);
            let name = json.name.clone().unwrap_or_default();
            read.animations.push(Animation { name, seconds: f64::from(seconds), plays: false });
            all.push(Channels { plain: channels, moved });
        }
        let plays = chosen(path, clip, &read.animations, &all)?;
        for ((number, animation), channels) in read.animations.iter_mut().enumerate().zip(all) {
            if plays.contains(&number) {
                animation.plays = true;
                read.duration_seconds = read.duration_seconds.max(animation.seconds);
                read.channels.extend(channels.plain);
                read.moved.extend(channels.moved);
            }
        }
        Ok(read)
    }
}

/// Refuses files whose channels share a few large accessors so often that they would not fit into memory.
fn check_size(document: &Document) -> Result<(), Error> {
    const MAX_KEYFRAMES: u64 = 1 << 26;
    let mut keyframes = 0_u64;
    for (number, animation) in document.json.animations.iter().enumerate() {
        let samplers = animation.channels.iter().filter_map(|channel| animation.samplers.get(channel.sampler.value()));
        let outputs = samplers.filter_map(|sampler| document.json.accessors.get(sampler.output.value()));
        keyframes = outputs.fold(keyframes, |sum, output| sum.saturating_add(output.count.0));
        if keyframes > MAX_KEYFRAMES {
            let cause = format!("the animations so far have {keyframes} keyframes; {MAX_KEYFRAMES} are the most");
            return Err(document.malformed(format_args!("animations[{number}]"), cause));
        }
    }
    Ok(())
}

/// The indices of the animations selected by `clip`.
fn chosen(path: &Path, clip: &Clip, animations: &[Animation], channels: &[Channels]) -> Result<Range<usize>, Error> {
    Ok(match clip {
        Clip::All => 0..animations.len(),
        Clip::Rest => 0..0,
        Clip::Auto if independent(channels) => 0..animations.len(),
        Clip::Auto => 0..1,
        Clip::Named(name) => {
            let by_name = animations.iter().position(|animation| animation.name == *name);
            let by_number = || name.parse().ok().filter(|&number| number < animations.len());
            let number = by_name.or_else(by_number).ok_or_else(|| unknown_clip(path, name, animations))?;
            number..number + 1
        }
    })
}

/// Whether no two animations move the same property of the same node.
fn independent(channels: &[Channels]) -> bool {
    let mut moved = HashSet::new();
    channels.iter().all(|channels| {
        let plain = channels.plain.iter().map(|channel| Thing::Property(channel.node, channel.property as u8));
        let others = channels.moved.iter().map(|moved| Thing::Other(moved.target));
        let own: HashSet<_> = plain.chain(others).collect();
        own.into_iter().all(|thing| moved.insert(thing))
    })
}

/// The property that a channel moves.
#[derive(PartialEq, Eq, Hash)]
enum Thing {
    Property(u32, u8),
    Other(Target),
}

fn unknown_clip(path: &Path, wanted: &str, animations: &[Animation]) -> Error {
    let name = |(number, animation): (usize, &Animation)| match animation.name.as_str() {
        "" => number.to_string(),
        name => format!("`{name}`"),
    };
    unknown_name(path, "animation", wanted, &animations.iter().enumerate().map(name).collect::<Vec<_>>())
}

fn read_channels(
    document: &Document,
    json: &json::Animation,
    number: usize,
    weights: impl Fn(usize) -> usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<Channel>, Error> {
    let mut channels = Vec::new();
    for (at, channel) in json.channels.iter().enumerate() {
        let location = format!("animations[{number}].channels[{at}]");
        let node = channel.target.node.value();
        document.element(&document.json.nodes, "nodes", node, format_args!("{location}.target.node"))?;
        let Checked::Valid(property) = channel.target.path else {
            warnings.push(format!("{location} was left out, as it moves nothing that glTF 2.0 knows"));
            continue;
        };
        let sampler_location = format!("animations[{number}].samplers[{}]", channel.sampler.value());
        let sampler = document.element(
            &json.samplers,
            "samplers",
            channel.sampler.value(),
            format_args!("{location}.sampler"),
        )?;
        let width = match property {
            Property::Translation | Property::Scale => 3,
            Property::Rotation => 4,
            Property::MorphTargetWeights => weights(node),
        };
        if width == 0 {
            warnings.push(format!("{location} was left out, as node {node} has no morph targets"));
            continue;
        }
        let curve = read_curve(document, sampler, Values::of(property), width, &sampler_location)?;
        channels.push(Channel { node: node as u32, property, curve });
    }
    Ok(channels)
}

/// Reads the channels with pointers that hide and show nodes, or change materials, lights and cameras. Others are left out
/// with a warning.
fn read_pointers(
    document: &Document,
    json: &json::Animation,
    number: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<Moved>, Error> {
    let mut all = Vec::new();
    for channel in document.pointers.iter().filter(|channel| channel.animation == number) {
        let location = channel.location();
        let Some(target) = Target::of(&channel.pointer) else {
            warnings.push(format!("{location} was left out: what it moves, `{}`, is not animated", channel.pointer));
            continue;
        };
        target.check(document, &format!("{location}.target"))?;
        let sampler_location = format_args!("{location}.sampler");
        let sampler = document.element(&json.samplers, "samplers", channel.sampler, sampler_location)?;
        let (location, width) = (format!("animations[{number}].samplers[{}]", channel.sampler), target.components());
        let mut curve = read_curve(document, sampler, Values::Numbers(width), width, &location)?;
        if let Target::Visibility(_) = target {
            // There is nothing between visible and hidden.
            let values = (0..curve.times.len()).map(|keyframe| curve.value(keyframe)[0]).collect();
            curve = Curve { values, interpolation: Interpolation::Step, ..curve };
        }
        all.push(Moved { target, curve });
    }
    Ok(all)
}

/// The kind of element of an animation's output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Values {
    Rotations,
    /// Number of components, 1 … 4.
    Numbers(usize),
}

impl Values {
    fn of(property: Property) -> Self {
        match property {
            Property::Translation | Property::Scale => Self::Numbers(3),
            Property::Rotation => Self::Rotations,
            Property::MorphTargetWeights => Self::Numbers(1),
        }
    }

    /// All components, one element after the other.
    fn read(self, output: &Accessor<'_>) -> Result<Vec<f32>, Error> {
        Ok(match self {
            Self::Numbers(1) => output.floats(None, |[value]| value)?,
            Self::Numbers(2) => output.floats(None, |value: [f32; 2]| value)?.into_flattened(),
            Self::Numbers(3) => output.floats(None, |value: [f32; 3]| value)?.into_flattened(),
            Self::Numbers(_) | Self::Rotations => output.floats(None, |value: [f32; 4]| value)?.into_flattened(),
        })
    }
}

fn read_curve(
    document: &Document,
    json: &json::animation::Sampler,
    kind: Values,
    width: usize,
    location: &str,
) -> Result<Curve, Error> {
    let interpolation = match json.interpolation {
        Checked::Valid(json::animation::Interpolation::Step) => Interpolation::Step,
        Checked::Valid(json::animation::Interpolation::CubicSpline) => Interpolation::CubicSpline,
        Checked::Valid(json::animation::Interpolation::Linear) if kind == Values::Rotations => Interpolation::Spherical,
        Checked::Valid(json::animation::Interpolation::Linear) => Interpolation::Linear,
        Checked::Invalid => {
            let location = format_args!("{location}.interpolation");
            return Err(document.malformed(location, "it is none of LINEAR, STEP and CUBICSPLINE"));
        }
    };
    let input = document.accessor(json.input, format_args!("{location}.input"))?;
    let times: Vec<f32> = input.floats(None, |[time]| time)?;
    if times.is_empty() || !times.iter().all(|time| time.is_finite()) || !times.is_sorted() {
        return Err(input.malformed("keyframe times must be finite and never fall, and there must be at least one"));
    }
    let output = document.accessor(json.output, format_args!("{location}.output"))?;
    let mut values = kind.read(&output)?;
    let sets = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let needed = times.len().checked_mul(sets).and_then(|sets| sets.checked_mul(width));
    if Some(values.len()) != needed {
        let cause = format!(
            "{} numbers where {} keyframes with {sets} values of {width} numbers each are needed",
            values.len(),
            times.len()
        );
        return Err(output.malformed(cause));
    }
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        return Err(output.malformed(format!("number {at} is not finite")));
    }
    if matches!(interpolation, Interpolation::Step | Interpolation::Spherical) && kind == Values::Rotations {
        let (rotations, _) = values.as_chunks_mut::<4>();
        rotations.iter_mut().for_each(|components| *components = rotation(*components).to_array());
    }
    Ok(Curve { times, values, width, interpolation })
}
