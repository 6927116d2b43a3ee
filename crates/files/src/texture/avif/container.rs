//! The container of a file's picture and its properties (HEIF, ISO/IEC 23008-12, and the AV1 Image File Format).

use std::borrow::Cow;
use std::ops::ControlFlow;

use super::color::Coding;

/// A file's primary picture.
#[derive(Debug)]
pub(super) struct Picture<'a> {
    pub(super) color: Item<'a>,
    pub(super) alpha: Option<Item<'a>>,
    /// Whether colours were multiplied by alpha.
    pub(super) is_premultiplied: bool,
}

/// An AV1 frame.
#[derive(Debug)]
pub(super) struct Item<'a> {
    pub(super) data: Cow<'a, [u8]>,
    /// Width and height, at least 1.
    pub(super) size: [u32; 2],
    /// Colour coding, where the container specifies it.
    pub(super) coding: Option<Coding>,
}

/// The boxes with a file's structure.
struct Container<'a> {
    file: &'a [u8],
    /// Content of the box `meta`.
    meta: Bytes<'a>,
    /// The properties that items refer to.
    properties: Vec<([u8; 4], Bytes<'a>)>,
}

const ALPHA: [&[u8]; 2] = [b"urn:mpeg:mpegB:cicp:systems:auxiliary:alpha\0", b"urn:mpeg:hevc:2015:auxid:1\0"];

impl<'a> Picture<'a> {
    /// # Errors
    /// A message about the fault or the unsupported feature.
    pub(super) fn read(file: &'a [u8]) -> Result<Self, String> {
        let mut meta = Bytes(file).find(b"meta")?;
        meta.version()?;
        let mut boxes = meta.find(b"iprp")?.find(b"ipco")?;
        let mut properties = Vec::new();
        while let Some(property) = boxes.next_box()? {
            properties.push(property);
        }
        let container = Container { file, meta, properties };
        let mut primary = meta.find(b"pitm")?;
        let id = match primary.version()?.0 {
            0 => u32::from(primary.u16()?),
            _ => primary.u32()?,
        };
        let color = container.item(id)?;
        let mut alpha = None;
        let auxiliary = container.references(b"auxl")?.into_iter().filter(|[_, to]| *to == id).map(|[from, _]| from);
        // There may be a few others, such as depth maps; more than 16 aren't examined.
        for auxiliary in auxiliary.take(16) {
            if container.is_alpha(auxiliary)? {
                alpha = Some((auxiliary, container.item(auxiliary).map_err(|cause| format!("its alpha: {cause}"))?));
                break;
            }
        }
        let multiplied = container.references(b"prem")?;
        let is_premultiplied = alpha.as_ref().is_some_and(|(alpha, _)| multiplied.contains(&[id, *alpha]));
        Ok(Self { color, alpha: alpha.map(|(_, item)| item), is_premultiplied })
    }
}

impl<'a> Container<'a> {
    /// # Errors
    /// Where the item is missing, or isn't an AV1 frame that can be shown unchanged.
    fn item(&self, id: u32) -> Result<Item<'a>, String> {
        match &self.kind(id)? {
            b"av01" => {}
            b"grid" => return Err("it is a grid of pictures, which is not read".to_owned()),
            other => return Err(format!("it is of the kind `{}`, which is not read", other.escape_ascii())),
        }
        let (mut size, mut coding) = (None, None);
        for (name, mut content, is_essential) in self.properties_of(id)? {
            match &name {
                b"ispe" => {
                    content.version()?;
                    size = Some([content.u32()?, content.u32()?]);
                }
                b"colr" if content.name()? == *b"nclx" => {
                    let [_, _, matrix] = [content.u16()?, content.u16()?, content.u16()?];
                    coding = Some(Coding { matrix, is_full_range: content.u8()? & 0x80 != 0 });
                }
                b"irot" if content.u8()? & 3 != 0 => return Err("it is to be rotated, which is not read".to_owned()),
                b"imir" => return Err("it is to be mirrored, which is not read".to_owned()),
                b"clap" => return Err("it is to be cut out of a larger one, which is not read".to_owned()),
                b"av1C" | b"auxC" | b"pixi" | b"pasp" | b"irot" | b"colr" => {}
                _ if is_essential => {
                    return Err(format!("it has the property `{}`, which is not read", name.escape_ascii()));
                }
                _ => {}
            }
        }
        let size = size.filter(|size| !size.contains(&0)).ok_or("it doesn't say its size")?;
        Ok(Item { data: self.data(id)?, size, coding })
    }

    fn is_alpha(&self, id: u32) -> Result<bool, String> {
        for (name, mut content, _) in self.properties_of(id)? {
            if name == *b"auxC" {
                content.version()?;
                return Ok(ALPHA.iter().any(|urn| content.0.starts_with(urn)));
            }
        }
        Ok(false)
    }

    /// An item's type.
    fn kind(&self, id: u32) -> Result<[u8; 4], String> {
        let mut items = self.meta.find(b"iinf")?;
        let wide = items.version()?.0 > 0;
        items.number(if wide { 4 } else { 2 })?;
        while let Some((name, mut item)) = items.next_box()? {
            let version = item.version()?.0;
            // Earlier versions belong to other file types.
            if name != *b"infe" || version < 2 {
                continue;
            }
            let found = item.number(if version == 2 { 2 } else { 4 })?;
            item.u16()?;
            if found == u64::from(id) {
                return item.name();
            }
        }
        Err(format!("it says nothing of item {id}"))
    }

    /// Names and contents of an item's properties, and whether each is essential to show the item.
    fn properties_of(&self, id: u32) -> Result<Vec<([u8; 4], Bytes<'a>, bool)>, String> {
        let mut boxes = self.meta.find(b"iprp")?;
        let mut found = Vec::new();
        while let Some((name, mut content)) = boxes.next_box()? {
            if name != *b"ipma" {
                continue;
            }
            let (version, flags) = content.version()?;
            for _ in 0..content.u32()? {
                let item = content.number(if version == 0 { 2 } else { 4 })?;
                for _ in 0..content.u8()? {
                    let bytes = if flags & 1 == 0 { 1 } else { 2 };
                    let link = content.number(bytes)?;
                    let essential = 0x80 << (8 * (bytes - 1));
                    let Some(number) = (link & (essential - 1)).checked_sub(1) else { continue };
                    if item != u64::from(id) {
                        continue;
                    }
                    let property = self.properties.get(number as usize);
                    let &(name, content) = property.ok_or_else(|| format!("it has no property {}", number + 1))?;
                    found.push((name, content, link & essential != 0));
                }
            }
        }
        Ok(found)
    }

    /// References of a kind, as pairs of the source and target items.
    fn references(&self, kind: &[u8; 4]) -> Result<Vec<[u32; 2]>, String> {
        let mut found = Vec::new();
        // References are optional.
        let Ok(mut boxes) = self.meta.find(b"iref") else { return Ok(found) };
        let bytes = if boxes.version()?.0 == 0 { 2 } else { 4 };
        while let Some((name, mut content)) = boxes.next_box()? {
            let from = content.number(bytes)? as u32;
            for _ in 0..content.u16()? {
                let to = content.number(bytes)? as u32;
                if name == *kind {
                    found.push([from, to]);
                }
            }
        }
        Ok(found)
    }

    /// An item's bytes, in one piece.
    fn data(&self, id: u32) -> Result<Cow<'a, [u8]>, String> {
        let mut table = self.meta.find(b"iloc")?;
        let (version, _) = table.version()?;
        let sizes = table.u16()?;
        let [offset_bytes, length_bytes, base_bytes, index_bytes] =
            [sizes >> 12, sizes >> 8 & 15, sizes >> 4 & 15, if version == 0 { 0 } else { sizes & 15 }].map(usize::from);
        if [offset_bytes, length_bytes, base_bytes, index_bytes].iter().any(|&bytes| bytes > 8) {
            return Err("offsets are of more than eight bytes".to_owned());
        }
        let id_bytes = if version < 2 { 2 } else { 4 };
        for _ in 0..table.number(id_bytes)? {
            let item = table.number(id_bytes)?;
            let method = if version == 0 { 0 } else { table.u16()? & 15 };
            let other_file = table.u16()?;
            let base = table.number(base_bytes)?;
            let count = usize::from(table.u16()?);
            if item != u64::from(id) {
                // Skipped in one step, since extents may take no bytes.
                table.take(count * (index_bytes + offset_bytes + length_bytes))?;
                continue;
            }
            let whole = match (method, other_file) {
                (0, 0) => self.file,
                (1, _) => self.meta.find(b"idat")?.0,
                (0, _) => return Err("it is in another file, which is not read".to_owned()),
                _ => return Err("it is made of other items, which is not read".to_owned()),
            };
            let mut pieces = Vec::new();
            for _ in 0..count {
                table.number(index_bytes)?;
                let (offset, length) = (table.number(offset_bytes)?, table.number(length_bytes)?);
                pieces.push(piece(whole, base.checked_add(offset), length)?);
            }
            return match pieces[..] {
                [] => Err("its compressed texels are not there".to_owned()),
                [one] => Ok(Cow::Borrowed(one)),
                _ => joined(&pieces, self.file.len()).map(Cow::Owned),
            };
        }
        Err(format!("it doesn't say where item {id} is"))
    }
}

/// The bytes of an extent; length 0 means up to the end. Empty extents are refused, since the decoder aborts on empty input
/// if compiled with debug assertions.
fn piece(whole: &[u8], offset: Option<u64>, length: u64) -> Result<&[u8], String> {
    let from = offset.and_then(|offset| whole.get(usize::try_from(offset).ok()?..));
    let piece = from.and_then(|from| match usize::try_from(length).ok()? {
        0 => Some(from),
        length => from.get(..length),
    });
    piece.filter(|piece| !piece.is_empty()).ok_or_else(|| "its compressed texels are not all there".to_owned())
}

/// Joins extents. Their total length is limited to `most`, the file's, so that a small file can't request much memory.
fn joined(pieces: &[&[u8]], most: usize) -> Result<Vec<u8>, String> {
    let length = pieces.iter().try_fold(0_usize, |sum, piece| match sum.checked_add(piece.len()) {
        Some(sum) if sum <= most => ControlFlow::Continue(sum),
        _ => ControlFlow::Break(()),
    });
    match length {
        ControlFlow::Continue(_) => Ok(pieces.concat()),
        ControlFlow::Break(()) => Err("pieces of its texels are the same".to_owned()),
    }
}

/// The unread bytes of boxes (ISO/IEC 14496-12): length, name of four letters, content.
#[derive(Clone, Copy, Debug)]
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    /// The next `count` bytes.
    ///
    /// # Errors
    /// Where there are fewer.
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or("it is cut off")?;
        self.0 = rest;
        Ok(taken)
    }

    /// Reads a big-endian number of at most eight bytes; 0 for none.
    fn number(&mut self, bytes: usize) -> Result<u64, String> {
        Ok(self.take(bytes)?.iter().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    fn u8(&mut self) -> Result<u8, String> {
        Ok(self.number(1)? as u8)
    }

    fn u16(&mut self) -> Result<u16, String> {
        Ok(self.number(2)? as u16)
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(self.number(4)? as u32)
    }

    fn name(&mut self) -> Result<[u8; 4], String> {
        Ok(self.u32()?.to_be_bytes())
    }

    /// Reads a full box's version and flags.
    fn version(&mut self) -> Result<(u8, u32), String> {
        let word = self.u32()?;
        Ok(((word >> 24) as u8, word & 0x00FF_FFFF))
    }

    /// Reads the next box's name and content; `None` at the end.
    fn next_box(&mut self) -> Result<Option<([u8; 4], Bytes<'a>)>, String> {
        if self.0.is_empty() {
            return Ok(None);
        }
        let (length, name) = (self.u32()?, self.name()?);
        let content = match length {
            0 => self.0.len() as u64,
            1 => self.number(8)?.checked_sub(16).ok_or("a box is shorter than its head")?,
            _ => u64::from(length).checked_sub(8).ok_or("a box is shorter than its head")?,
        };
        let content = usize::try_from(content).ok().and_then(|content| self.take(content).ok());
        let content = content.ok_or_else(|| format!("the box `{}` is cut off", name.escape_ascii()))?;
        Ok(Some((name, Bytes(content))))
    }

    /// Finds the first box called `wanted`.
    ///
    /// # Errors
    /// Where there is none.
    fn find(mut self, wanted: &[u8; 4]) -> Result<Bytes<'a>, String> {
        while let Some((name, content)) = self.next_box()? {
            if name == *wanted {
                return Ok(content);
            }
        }
        Err(format!("it has no box `{}`", wanted.escape_ascii()))
    }
}
