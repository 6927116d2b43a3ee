//! Typed reading of accessors. Sizes in the JSON are checked against the bytes before they are used.

use std::fmt::Display;

use gltf::json::Index;
use gltf::json::accessor::{self, ComponentType, Type};
use gltf::json::validation::Checked;
use umbrage_scene::Error;

use super::document::Document;

/// Maximum length of an accessor without bytes, whose elements glTF defines as zeros.
const MAX_ELEMENTS_WITHOUT_BYTES: u64 = 1 << 20;

/// An accessor whose bytes are all there.
#[derive(Clone, Debug)]
pub(super) struct Accessor<'a> {
    document: &'a Document,
    index: usize,
    count: usize,
    kind: Type,
    component: ComponentType,
    normalized: bool,
    /// The elements; `None` for zeros.
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

/// Elements at a constant stride in bytes, all inside `bytes`.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Replacements of some of an accessor's elements.
#[derive(Clone, Debug)]
struct Sparse<'a> {
    /// Strictly ascending and in range.
    indices: Vec<u32>,
    values: Strided<'a>,
}

impl Document {
    /// Returns accessor `index`, which `location` in the JSON refers to.
    ///
    /// # Errors
    /// Where it doesn't exist, or its description or bytes are broken.
    pub(super) fn accessor(
        &self,
        index: Index<accessor::Accessor>,
        location: impl Display,
    ) -> Result<Accessor<'_>, Error> {
        let index = index.value();
        let json = self.element(&self.json.accessors, "accessors", index, location)?;
        let own_location = format!("accessors[{index}]");
        let (Checked::Valid(component), Checked::Valid(kind)) = (json.component_type, json.type_) else {
            return Err(self.malformed(own_location, "componentType or type is none of glTF's"));
        };
        let component = component.0;
        let size = component.size() * kind.multiplicity();
        let offset = json.byte_offset.map_or(0, |offset| offset.0);
        let base = match json.buffer_view {
            Some(view) => Some(self.strided(view.value(), offset, json.count.0, size, &own_location)?),
            None if json.count.0 > MAX_ELEMENTS_WITHOUT_BYTES => {
                let cause = format!("there are no bytes for its {} elements", json.count.0);
                return Err(self.malformed(own_location, cause));
            }
            None => None,
        };
        let sparse = json.sparse.as_ref().map(|sparse| self.sparse(sparse, index, json.count.0, size));
        Ok(Accessor {
            document: self,
            index,
            count: self.size(json.count.0, &own_location)?,
            kind,
            component,
            normalized: json.normalized,
            base,
            sparse: sparse.transpose()?,
        })
    }

    /// Reads the sparse replacements of accessor `index`, which has `count` elements of `size` bytes.
    fn sparse(
        &self,
        json: &accessor::sparse::Sparse,
        index: usize,
        count: u64,
        size: usize,
    ) -> Result<Sparse<'_>, Error> {
        let location = format!("accessors[{index}].sparse");
        let indices_location = format!("{location}.indices");
        let Checked::Valid(component) = json.indices.component_type else {
            return Err(self.malformed(indices_location, "componentType is none of glTF's"));
        };
        let component = component.0;
        let indices = self.strided(
            json.indices.buffer_view.value(),
            json.indices.byte_offset.0,
            json.count.0,
            component.size(),
            &indices_location,
        )?;
        let values = self.strided(
            json.values.buffer_view.value(),
            json.values.byte_offset.0,
            json.count.0,
            size,
            &format!("{location}.values"),
        )?;
        let indices = Accessor {
            document: self,
            index,
            count: self.size(json.count.0, &location)?,
            kind: Type::Scalar,
            component,
            normalized: false,
            base: Some(indices),
            sparse: None,
        };
        let indices = indices.whole_numbers(None, |[index]| index)?;
        if !indices.is_sorted_by(|a, b| a < b) || indices.last().is_some_and(|&last| u64::from(last) >= count) {
            return Err(self.malformed(indices_location, format!("indices don't rise, or go beyond {count} elements")));
        }
        Ok(Sparse { indices, values })
    }

    /// Returns `count` elements of `size` bytes in a buffer view, starting at byte `offset`.
    fn strided(&self, view: usize, offset: u64, count: u64, size: usize, location: &str) -> Result<Strided<'_>, Error> {
        let (bytes, json) = self.view(view, format_args!("{location}.bufferView"))?;
        let stride = json.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            let cause = format!("byteStride is {stride}, but an element of {location} takes {size} bytes");
            return Err(self.malformed(format_args!("bufferViews[{view}]"), cause));
        }
        let length = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride as u64).and_then(|length| length.checked_add(size as u64)),
        };
        let end = length.and_then(|length| offset.checked_add(length));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let cause = format!(
                "{count} elements of {stride} bytes from byte {offset} on reach beyond the {} bytes of bufferViews[{view}]",
                bytes.len()
            );
            return Err(self.malformed(location, cause));
        }
        // With no elements the offset may lie anywhere.
        Ok(Strided { bytes: bytes.get(offset as usize..).unwrap_or_default(), stride })
    }

    fn size(&self, count: u64, location: &str) -> Result<usize, Error> {
        usize::try_from(count).map_err(|_| self.malformed(location, format!("{count} elements are too many")))
    }
}

impl Accessor<'_> {
    /// Number of elements.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Checks that there are `count` elements, one per vertex of the primitive at `location`.
    ///
    /// # Errors
    /// Where the number differs.
    pub(super) fn expect_count(&self, count: usize, location: impl Display) -> Result<(), Error> {
        if self.count == count {
            return Ok(());
        }
        let cause = format!("accessors[{}] has {} elements where {count} are needed", self.index, self.count);
        Err(self.document.malformed(location, cause))
    }

    /// Reads the elements as floats and maps them by `make`: all, or those at the ascending indices `kept`. Integers that
    /// are marked as normalized become 0 … 1 or −1 … 1.
    ///
    /// # Errors
    /// Where its elements don't have N components.
    pub(super) fn floats<const N: usize, T: Clone>(
        &self,
        kept: Option<&[u32]>,
        make: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        self.expect_components(N)?;
        self.take_for::<T>(kept)?;
        // The divisors of the glTF specification, §3.11; −128 and −32768 become −1 like their neighbours.
        let part = |value: f32, greatest: f32| if self.normalized { (value / greatest).max(-1.0) } else { value };
        Ok(match self.component {
            ComponentType::I8 => self.gather(kept, |bytes| part(i8::from_le_bytes(bytes).into(), 127.0), make),
            ComponentType::U8 => self.gather(kept, |bytes| part(u8::from_le_bytes(bytes).into(), 255.0), make),
            ComponentType::I16 => self.gather(kept, |bytes| part(i16::from_le_bytes(bytes).into(), 32_767.0), make),
            ComponentType::U16 => self.gather(kept, |bytes| part(u16::from_le_bytes(bytes).into(), 65_535.0), make),
            ComponentType::U32 => self.gather(kept, |bytes| u32::from_le_bytes(bytes) as f32, make),
            ComponentType::F32 => self.gather(kept, f32::from_le_bytes, make),
        })
    }

    /// As [`Accessor::floats`], but normalizes all integers: for attributes that allow no other kind.
    ///
    /// # Errors
    /// Where its elements don't have N components.
    pub(super) fn fractions<const N: usize, T: Clone>(
        &self,
        kept: Option<&[u32]>,
        make: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        Self { normalized: true, ..self.clone() }.floats(kept, make)
    }

    /// Reads the elements as unsigned integers and maps them by `make`: all, or those at the ascending indices `kept`.
    ///
    /// # Errors
    /// Where its elements don't have N components, or are floats or signed.
    pub(super) fn whole_numbers<const N: usize, T: Clone>(
        &self,
        kept: Option<&[u32]>,
        make: impl Fn([u32; N]) -> T,
    ) -> Result<Vec<T>, Error> {
        self.expect_components(N)?;
        self.take_for::<T>(kept)?;
        match self.component {
            ComponentType::U8 => Ok(self.gather(kept, |[byte]| u32::from(byte), make)),
            ComponentType::U16 => Ok(self.gather(kept, |bytes| u32::from(u16::from_le_bytes(bytes)), make)),
            ComponentType::U32 => Ok(self.gather(kept, u32::from_le_bytes, make)),
            ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => {
                Err(self.malformed("its components are not unsigned integers"))
            }
        }
    }

    /// Whether all elements are zero, except the replacements of [`Accessor::sparse_floats`].
    pub(super) fn is_mostly_zero(&self) -> bool {
        self.base.is_none()
    }

    /// The ascending indices of replaced elements, and their replacements.
    ///
    /// # Errors
    /// Where its elements don't have N components.
    pub(super) fn sparse_floats<const N: usize, T: Clone>(
        &self,
        make: impl Fn([f32; N]) -> T,
    ) -> Result<(Vec<u32>, Vec<T>), Error> {
        let Some(sparse) = &self.sparse else { return Ok((Vec::new(), Vec::new())) };
        let only_values = Self { count: sparse.indices.len(), base: Some(sparse.values), sparse: None, ..self.clone() };
        Ok((sparse.indices.clone(), only_values.floats(None, make)?))
    }

    /// The number of components of an element: 1 … 16.
    pub(super) fn components(&self) -> usize {
        self.kind.multiplicity()
    }

    /// The error that this accessor is wrong for `cause`.
    pub(super) fn malformed(&self, cause: impl Into<String>) -> Error {
        self.document.malformed(format_args!("accessors[{}]", self.index), cause)
    }

    /// Takes the memory of the elements to be read from the budget.
    fn take_for<T>(&self, kept: Option<&[u32]>) -> Result<(), Error> {
        let count = kept.map_or(self.count, <[u32]>::len);
        self.document.take_for::<T>(count, format_args!("accessors[{}]", self.index))
    }

    fn expect_components(&self, components: usize) -> Result<(), Error> {
        // Small integer matrices have gaps between their columns, which nothing here needs.
        let padded = matches!(self.kind, Type::Mat2 | Type::Mat3 | Type::Mat4) && self.component.size() < 4;
        if self.components() == components && !padded {
            return Ok(());
        }
        Err(self.malformed(format!("its elements don't have {components} components as they must where it is used")))
    }

    /// Reads elements of N components of B bytes each.
    fn gather<const N: usize, const B: usize, C: Copy + Default, T: Clone>(
        &self,
        kept: Option<&[u32]>,
        component: impl Fn([u8; B]) -> C,
        make: impl Fn([C; N]) -> T,
    ) -> Vec<T> {
        let read = |strided: &Strided<'_>, index: usize| {
            let first = index * strided.stride;
            let (components, _) = strided.bytes[first..first + N * B].as_chunks::<B>();
            make(std::array::from_fn(|at| component(components[at])))
        };
        let mut elements: Vec<T> = match (&self.base, kept) {
            (None, _) => vec![make([C::default(); N]); kept.map_or(self.count, <[u32]>::len)],
            (Some(base), None) => (0..self.count).map(|index| read(base, index)).collect(),
            (Some(base), Some(kept)) => kept.iter().map(|&index| read(base, index as usize)).collect(),
        };
        for (at, &index) in self.sparse.iter().flat_map(|sparse| sparse.indices.iter().enumerate()) {
            let element = kept.map_or(Some(index as usize), |kept| kept.binary_search(&index).ok());
            if let (Some(element), Some(sparse)) = (element, &self.sparse) {
                elements[element] = read(&sparse.values, at);
            }
        }
        elements
    }
}
