//! `KHR_draco_mesh_compression`: primitives whose triangles and attributes are compressed by Draco.

use std::collections::BTreeMap;
use std::panic::catch_unwind;

use draco_core::{DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute, PointIndex};
use gltf::json::accessor::{Accessor, ComponentType};
use gltf::json::mesh::{Mode, Primitive};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, accessor};
use rayon::prelude::*;
use serde::Deserialize;
use umbrage_scene::Error;

use super::document::Document;
use crate::scalar::Scalar;

const NAME: &str = "KHR_draco_mesh_compression";

/// The extension's object in a primitive.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compressed {
    buffer_view: usize,
    /// Each attribute's number in the stream.
    attributes: BTreeMap<String, u32>,
}

/// A decompressed primitive: accessors as in the JSON, and their bytes.
struct Decoded {
    indices: (Accessor, Vec<u8>),
    attributes: Vec<(String, Accessor, Vec<u8>)>,
    warning: Option<String>,
}

/// Replaces all compressed primitives by plain ones. Where a stream's number of vertices or indices differs from its
/// accessors', the stream's is used.
///
/// # Errors
/// Where a stream is broken, or exceeds the memory budget.
pub(super) fn decompress(document: &mut Document, warnings: &mut Vec<String>) -> Result<(), Error> {
    let of_mesh = |mesh: usize| {
        let primitives = document.json.meshes[mesh].primitives.iter().enumerate();
        primitives.map(move |(number, primitive)| (mesh, number, primitive)).collect::<Vec<_>>()
    };
    let primitives: Vec<_> = (0..document.json.meshes.len()).flat_map(of_mesh).collect();
    let decode = |(mesh, number, primitive): (usize, usize, &Primitive)| {
        let json = primitive.extensions.as_ref()?.others.get(NAME)?;
        let location = format!("meshes[{mesh}].primitives[{number}].extensions.{NAME}");
        let compressed =
            Compressed::deserialize(json).map_err(|error| document.malformed(&location, error.to_string()));
        let decoded = compressed.and_then(|compressed| read(document, primitive, &compressed, &location));
        Some(decoded.map(|decoded| (mesh, number, decoded)))
    };
    let all: Vec<Result<_, Error>> = primitives.into_par_iter().filter_map(decode).collect();
    for result in all {
        let (mesh, number, mut decoded) = result?;
        warnings.extend(decoded.warning.take());
        put(document, mesh, number, decoded);
    }
    Ok(())
}

/// Makes a primitive use its decoded accessors.
fn put(document: &mut Document, mesh: usize, number: usize, decoded: Decoded) {
    let (accessor, bytes) = decoded.indices;
    let indices = document.add_accessor(accessor, bytes);
    let attributes: Vec<_> = decoded
        .attributes
        .into_iter()
        .map(|(name, accessor, bytes)| (name, document.add_accessor(accessor, bytes)))
        .collect();
    let primitive = &mut document.json.meshes[mesh].primitives[number];
    // Also of a primitive that was a strip: the stream has whole triangles.
    primitive.mode = Checked::Valid(Mode::Triangles);
    primitive.indices = Some(indices);
    for (semantic, index) in &mut primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        let name = semantic.to_string();
        if let Some((_, decoded)) = attributes.iter().find(|(decoded, _)| *decoded == name) {
            *index = *decoded;
        }
    }
}

fn read(document: &Document, primitive: &Primitive, compressed: &Compressed, location: &str) -> Result<Decoded, Error> {
    let malformed = |cause: String| document.malformed(location, cause);
    let (stream, _) = document.view(compressed.buffer_view, format_args!("{location}.bufferView"))?;
    let json =
        |index: Index<Accessor>| document.element(&document.json.accessors, "accessors", index.value(), location);
    let indices = primitive.indices.map(json).transpose()?;
    let indices = indices.ok_or_else(|| malformed("the primitive has no indices".to_owned()))?;
    let mut attributes = Vec::new();
    for (semantic, &index) in &primitive.attributes {
        let Checked::Valid(semantic) = semantic else { continue };
        let name = semantic.to_string();
        let Some(&id) = compressed.attributes.get(&name) else { continue };
        attributes.push((name, id, json(index)?));
    }
    let points = attributes.iter().map(|(_, _, accessor)| accessor.count.0).max().unwrap_or(0);
    let mesh = decode(document, stream, points, indices.count.0, compressed.attributes.len(), location)?;
    let faces: Vec<u32> = mesh.faces().iter().flatten().map(|point| point.0).collect();
    let counts = [USize64::from(mesh.num_points()), USize64::from(faces.len())];
    let differs = indices.count != counts[1] || attributes.iter().any(|(_, _, accessor)| accessor.count != counts[0]);
    let warning = differs.then(|| {
        let [vertices, indices] = counts.map(|count| count.0);
        format!("{location}: the stream has {vertices} vertices and {indices} indices, other than its accessors say; it counts")
    });
    let bytes = faces.iter().flat_map(|index| index.to_le_bytes()).collect();
    let component_type = Checked::Valid(accessor::GenericComponentType(ComponentType::U32));
    let indices = (Accessor { component_type, count: counts[1], ..indices.clone() }, bytes);
    let attributes = attributes.into_iter().map(|(name, id, accessor)| {
        let of_name = |cause: String| document.malformed(format_args!("{location}.attributes.{name}"), cause);
        let attribute = mesh.attribute_by_unique_id(id);
        let attribute = attribute.ok_or_else(|| of_name(format!("the stream has no attribute {id}")))?;
        let bytes = values(attribute, accessor, mesh.num_points()).map_err(of_name)?;
        Ok((name.clone(), Accessor { count: counts[0], ..accessor.clone() }, bytes))
    });
    Ok(Decoded { indices, attributes: attributes.collect::<Result<_, Error>>()?, warning })
}

/// Decodes a stream. It may have more points and indices than the JSON says, but at most [`MOST_TIMES`] as many.
fn decode(
    document: &Document,
    stream: &[u8],
    points: u64,
    indices: u64,
    attributes: usize,
    location: &str,
) -> Result<Mesh, Error> {
    // Bytes of a corner with its connectivity; bytes of a value of at most four components, as quantized and as floats.
    const BYTES_OF_CORNER: u64 = 64;
    const BYTES_OF_VALUE: u64 = 32;
    /// A larger stream would take unexpectedly much memory.
    const MOST_TIMES: u64 = 64;
    let malformed = |cause: String| document.malformed(location, cause);
    let mut times = 1;
    loop {
        let [points, indices] = [points, indices].map(|count| count.saturating_mul(times));
        let values = points.saturating_mul(BYTES_OF_VALUE).saturating_mul(attributes as u64 + 1);
        let bytes = indices.saturating_mul(BYTES_OF_CORNER).saturating_add(values);
        document.budget.take(bytes, location).map_err(malformed)?;
        let limits =
            DecodeLimits::default().with_max_points(points).with_max_faces(indices / 3).with_max_decoded_bytes(values);
        let decoded = catch_unwind(|| {
            let mut mesh = Mesh::new();
            let result = MeshDecoder::new().decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh);
            result.map(|()| mesh)
        });
        return match decoded {
            Ok(Ok(mesh)) => Ok(mesh),
            Ok(Err(error)) if error.kind() == ErrorKind::LimitExceeded && times < MOST_TIMES => {
                times *= 4;
                continue;
            }
            Ok(Err(error)) if error.kind() == ErrorKind::LimitExceeded => {
                Err(malformed(format!("the stream has more in it than {points} vertices and {indices} indices")))
            }
            Ok(Err(error)) => Err(malformed(format!("a broken Draco stream: {error}"))),
            Err(_) => Err(malformed("a broken Draco stream".to_owned())),
        };
    }
}

/// An attribute's value at each of `points`, in the accessor's component type.
fn values(attribute: &PointAttribute, accessor: &Accessor, points: usize) -> Result<Vec<u8>, String> {
    let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
        return Err("componentType or type is none of glTF's".to_owned());
    };
    let components = usize::from(attribute.num_components());
    if components != kind.multiplicity() {
        return Err(format!("the stream has {components} components where {} are needed", kind.multiplicity()));
    }
    let scalar = scalar(attribute.data_type()).ok_or("values of a kind that glTF has not")?;
    let (data, stride) = (attribute.buffer().data(), attribute.byte_stride() as usize);
    let mut bytes = Vec::with_capacity(points * components * component.0.size());
    for point in 0..points as u32 {
        let first = attribute.mapped_index(PointIndex(point)).0 as usize;
        let value = first.checked_mul(stride).and_then(|first| data.get(first..)?.get(..components * scalar.bytes()));
        let value = value.ok_or_else(|| format!("there is no value for vertex {point}"))?;
        for number in value.chunks_exact(scalar.bytes()) {
            write(scalar.decode(number, false), component.0, &mut bytes);
        }
    }
    Ok(bytes)
}

/// The type of a component; `None` for types that glTF doesn't have.
fn scalar(kind: DataType) -> Option<Scalar> {
    Some(match kind {
        DataType::Int8 => Scalar::I8,
        DataType::Uint8 | DataType::Bool => Scalar::U8,
        DataType::Int16 => Scalar::I16,
        DataType::Uint16 => Scalar::U16,
        DataType::Int32 => Scalar::I32,
        DataType::Uint32 => Scalar::U32,
        DataType::Float32 => Scalar::F32,
        _ => return None,
    })
}

fn write(number: f64, component: ComponentType, bytes: &mut Vec<u8>) {
    match component {
        ComponentType::I8 => bytes.extend((number as i8).to_le_bytes()),
        ComponentType::U8 => bytes.extend((number as u8).to_le_bytes()),
        ComponentType::I16 => bytes.extend((number as i16).to_le_bytes()),
        ComponentType::U16 => bytes.extend((number as u16).to_le_bytes()),
        ComponentType::U32 => bytes.extend((number as u32).to_le_bytes()),
        ComponentType::F32 => bytes.extend((number as f32).to_le_bytes()),
    }
}
