//! Indices: of triangles that share edges (mode TRIANGLES), and in sequence (mode INDICES).
//!
//! The formats are defined in `EXT_meshopt_compression`, appendix A.2 and A.3.

use super::{Bytes, signed};

/// Vertices of recent triangles, or their edges; the newest is number 0.
struct Recent<T> {
    values: [T; 16],
    next: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { values: [T::default(); 16], next: 0 }
    }

    fn get(&self, age: usize) -> T {
        self.values[self.next.wrapping_sub(1 + age) % 16]
    }

    fn push(&mut self, value: T) {
        self.values[self.next] = value;
        self.next = (self.next + 1) % 16;
    }
}

struct Triangles<'a> {
    data: Bytes<'a>,
    /// Table of common pairs of vertex codes, which a triangle's code refers to by number.
    pairs: &'a [u8],
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
    /// The first vertex not yet used by a triangle.
    next: u32,
    /// The last explicit vertex; explicit numbers are relative to it.
    last: u32,
}

/// Decodes the indices of `count / 3` triangles.
///
/// # Errors
/// A message about the broken bytes.
pub(super) fn triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, String> {
    const PAIRS: usize = 16;
    if !count.is_multiple_of(3) {
        return Err(format!("count is {count}, but triangles have three indices each"));
    }
    let Some((0xe1, bytes)) = bytes.split_first().map(|(first, rest)| (*first, rest)) else {
        return Err("its bytes don't begin as compressed triangles do".to_owned());
    };
    let (codes, rest) = bytes.split_at_checked(count / 3).ok_or("its bytes end too early")?;
    let (data, pairs) = rest.split_last_chunk::<PAIRS>().ok_or("its bytes end too early")?;
    let mut decoder =
        Triangles { data: Bytes::new(data), pairs, edges: Recent::new(), vertices: Recent::new(), next: 0, last: 0 };
    let mut indices = Vec::with_capacity(count);
    for &code in codes {
        indices.extend(decoder.triangle(code)?);
    }
    decoder.data.expect_end()?;
    Ok(indices)
}

impl Triangles<'_> {
    fn triangle(&mut self, code: u8) -> Result<[u32; 3], String> {
        let (edge, vertex) = (code >> 4, code & 15);
        if edge < 15 {
            let [a, b] = self.edges.get(edge.into());
            let c = self.third(vertex)?;
            self.edges.push([c, b]);
            self.edges.push([a, c]);
            return Ok([a, b, c]);
        }
        let [a, b, c] = if vertex < 14 { self.with_common_pair(vertex)? } else { self.alone(vertex)? };
        self.edges.push([b, a]);
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        Ok([a, b, c])
    }

    /// Decodes the third vertex of a triangle on a recent edge.
    fn third(&mut self, code: u8) -> Result<u32, String> {
        let vertex = match code {
            0 => self.new_vertex(),
            1..13 => return Ok(self.vertices.get(code.into())),
            13 => self.relative(u32::MAX),
            14 => self.relative(1),
            _ => self.explicit()?,
        };
        self.vertices.push(vertex);
        Ok(vertex)
    }

    /// Decodes a triangle of a new vertex and two given by a pair of codes from the table.
    fn with_common_pair(&mut self, pair: u8) -> Result<[u32; 3], String> {
        let pair = self.pairs[usize::from(pair)];
        let a = self.new_vertex();
        let mut other = |code: u8| match code {
            0 => (self.new_vertex(), true),
            _ => (self.vertices.get(usize::from(code) - 1), false),
        };
        let ((b, b_is_new), (c, c_is_new)) = (other(pair >> 4), other(pair & 15));
        self.remember([(a, true), (b, b_is_new), (c, c_is_new)]);
        Ok([a, b, c])
    }

    /// Decodes a triangle whose pair of codes is in the data.
    fn alone(&mut self, code: u8) -> Result<[u32; 3], String> {
        let pair = self.data.byte()?;
        if pair == 0 {
            self.next = 0;
        }
        let a = if code == 14 { self.new_vertex() } else { self.explicit()? };
        let mut other = |code: u8| {
            Ok::<_, String>(match code {
                0 => (self.new_vertex(), true),
                15 => (self.explicit()?, true),
                _ => (self.vertices.get(usize::from(code) - 1), false),
            })
        };
        let ((b, b_is_new), (c, c_is_new)) = (other(pair >> 4)?, other(pair & 15)?);
        self.remember([(a, true), (b, b_is_new), (c, c_is_new)]);
        Ok([a, b, c])
    }

    fn remember(&mut self, corners: [(u32, bool); 3]) {
        for (vertex, _) in corners.into_iter().filter(|(_, is_new)| *is_new) {
            self.vertices.push(vertex);
        }
    }

    fn new_vertex(&mut self) -> u32 {
        let vertex = self.next;
        self.next = vertex.wrapping_add(1);
        vertex
    }

    fn explicit(&mut self) -> Result<u32, String> {
        let difference = signed(self.data.number()?);
        Ok(self.relative(difference))
    }

    fn relative(&mut self, difference: u32) -> u32 {
        self.last = self.last.wrapping_add(difference);
        self.last
    }
}

/// Decodes `count` indices of any meaning.
///
/// # Errors
/// A message about the broken bytes.
pub(super) fn sequence(bytes: &[u8], count: usize) -> Result<Vec<u32>, String> {
    const TAIL: usize = 4;
    let Some((0xd1, bytes)) = bytes.split_first().map(|(first, rest)| (*first, rest)) else {
        return Err("its bytes don't begin as compressed indices do".to_owned());
    };
    let (data, _) = bytes.split_last_chunk::<TAIL>().ok_or("its bytes end too early")?;
    // Checked before memory is allocated.
    if count > data.len() {
        return Err(format!("{count} indices don't fit into {} bytes", data.len()));
    }
    let mut data = Bytes::new(data);
    let mut last = [0_u32; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let code = data.number()?;
        let last = &mut last[(code & 1) as usize];
        *last = last.wrapping_add(signed(code >> 1));
        indices.push(*last);
    }
    data.expect_end()?;
    Ok(indices)
}
