//! Mutations of a file: bits, numbers and words change; pieces vanish, move, are duplicated or come from another file.

use std::ops::Range;

use serde_json::Value;
use umbrage_verify::Random;

/// Integers at limits of types and lengths.
const WHOLE: [i64; 12] = [0, 1, -1, 2, 127, 255, 256, 65_535, 0x7FFF_FFFF, 0x8000_0000, 0xFFFF_FFFF, i64::MAX];

/// Numbers far from the usual ones, and NaN.
pub(crate) const REAL: [f64; 12] =
    [0.0, -0.0, 0.5, -1.0, 1e-45, 1e9, -1e19, 1e38, -3.4e38, 1.7e308, f64::INFINITY, f64::NAN];

/// Some element of a list that isn't empty.
pub(crate) fn any<'a, T>(random: &mut Random, list: &'a [T]) -> &'a T {
    &list[random.below(list.len())]
}

/// Changes `bytes` in up to four ways, or leaves them unchanged; `other` is a file of the same kind, to take pieces from.
pub(crate) fn mutate(random: &mut Random, name: &str, bytes: &[u8], other: &[u8]) -> Vec<u8> {
    let mut mutant = bytes.to_vec();
    for _ in 0..*any(random, &[0, 1, 1, 1, 1, 1, 1, 2, 2, 4]) {
        let changed = match name.rsplit('.').next() {
            _ if random.below(4) == 0 => None,
            Some("gltf") => changed_json(random, &mutant),
            Some("glb") => changed_glb(random, &mutant),
            _ => std::str::from_utf8(&mutant).is_ok().then(|| changed_words(random, &mutant, other)),
        };
        mutant = changed.unwrap_or_else(|| changed_bytes(random, mutant, other));
    }
    mutant
}

/// A range within `length` bytes, often a small one.
fn piece(random: &mut Random, length: usize) -> Range<usize> {
    let first = random.below(length + 1);
    let most = if random.below(2) == 0 { 16 } else { length };
    first..first + random.below(most.min(length - first) + 1)
}

fn changed_bytes(random: &mut Random, mut bytes: Vec<u8>, other: &[u8]) -> Vec<u8> {
    if bytes.is_empty() {
        return other.to_vec();
    }
    let at = random.below(bytes.len());
    match random.below(7) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 | 2 => {
            let number = binary_number(random);
            let end = (at + number.len()).min(bytes.len());
            bytes[at..end].copy_from_slice(&number[..end - at]);
        }
        3 => bytes.truncate(at),
        4 => drop(bytes.drain(piece(random, bytes.len()))),
        5 => drop(bytes.splice(at..at, bytes[piece(random, bytes.len())].to_vec())),
        _ => drop(bytes.splice(piece(random, bytes.len()), other[piece(random, other.len())].to_vec())),
    }
    bytes
}

fn binary_number(random: &mut Random) -> Vec<u8> {
    let (whole, real) = (*any(random, &WHOLE), *any(random, &REAL));
    let mut bytes = match random.below(3) {
        0 => whole.to_le_bytes()[..1 << random.below(3)].to_vec(),
        1 => (real as f32).to_le_bytes().to_vec(),
        _ => real.to_le_bytes().to_vec(),
    };
    if random.below(3) == 0 {
        bytes.reverse();
    }
    bytes
}

/// A number as a text format writes it.
pub(crate) fn written_number(random: &mut Random) -> String {
    match random.below(4) {
        0 => any(random, &WHOLE).to_string(),
        1 => any(random, &REAL).to_string(),
        2 => format!("{:e}", any(random, &REAL)),
        _ => random.below(6).to_string(),
    }
}

/// Ranges of a text's words, of its line ends, and of the characters that join words.
fn words(text: &[u8]) -> Vec<Range<usize>> {
    let kind = |byte: u8| match byte {
        b' ' | b'\t' => 0,
        b'\n' | b'\r' => 1,
        b'/' | b',' | b':' | b'=' => 2,
        _ => 3,
    };
    let mut end = 0;
    let words = text.chunk_by(|&a, &b| kind(a) == kind(b)).map(|word| {
        end += word.len();
        end - word.len()..end
    });
    words.filter(|word| kind(text[word.start]) > 0).collect()
}

/// Replaces a word of a text by a number, by another word or by nothing.
pub(crate) fn changed_words(random: &mut Random, text: &[u8], other: &[u8]) -> Vec<u8> {
    let (own, others) = (words(text), words(other));
    if own.is_empty() || others.is_empty() {
        return other.to_vec();
    }
    let new = match random.below(5) {
        0 | 1 => written_number(random).into_bytes(),
        2 => text[any(random, &own).clone()].to_vec(),
        3 => other[any(random, &others).clone()].to_vec(),
        _ => Vec::new(),
    };
    let mut mutant = text.to_vec();
    mutant.splice(any(random, &own).clone(), new);
    mutant
}

fn changed_json(random: &mut Random, text: &[u8]) -> Option<Vec<u8>> {
    let mut document: Value = serde_json::from_slice(text).ok()?;
    let donor = value_in(random, &mut document)?.clone();
    let value = value_in(random, &mut document)?;
    let new = match random.below(6) {
        0 => (*any(random, &WHOLE)).into(),
        1 => (*any(random, &REAL)).into(),
        2 => random.below(6).into(),
        3 if value.is_number() => random.unit().into(),
        _ => donor,
    };
    let at = random.below(64);
    match value {
        Value::Array(list) if at < list.len() => match random.below(3) {
            0 => drop(list.remove(at)),
            1 => list.push(new),
            _ => list.resize(list.len() + random.below(300), new),
        },
        Value::Object(members) if at < members.len() => {
            let key = members.keys().nth(at).cloned()?;
            drop(members.remove(&key));
        }
        value => *value = new,
    }
    serde_json::to_vec(&document).ok()
}

/// Some value within another, most often one without children.
fn value_in<'a>(random: &mut Random, value: &'a mut Value) -> Option<&'a mut Value> {
    let count = match value {
        Value::Array(list) => list.len(),
        Value::Object(members) => members.len(),
        _ => 0,
    };
    if count == 0 || random.below(8) == 0 {
        return Some(value);
    }
    let inner = match value {
        Value::Array(list) => list.get_mut(random.below(count)),
        Value::Object(members) => members.values_mut().nth(random.below(count)),
        _ => None,
    };
    value_in(random, inner?)
}

/// Changes the text or the numbers of a GLB, and updates its lengths.
fn changed_glb(random: &mut Random, bytes: &[u8]) -> Option<Vec<u8>> {
    /// Its signature, version and length, and the length and kind of each of two chunks.
    const HEADERS: [usize; 2] = [12, 8];
    let text_start = HEADERS[0] + HEADERS[1];
    let text_length = bytes.get(HEADERS[0]..)?.first_chunk().map(|&length| u32::from_le_bytes(length) as usize)?;
    let mut text = bytes.get(text_start..text_start.checked_add(text_length)?)?.to_vec();
    let mut numbers = bytes.get(text_start + text_length + HEADERS[1]..).unwrap_or_default().to_vec();
    if random.below(3) == 0 {
        numbers = changed_bytes(random, numbers, bytes);
    } else {
        text = changed_json(random, &text)?;
    }
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = bytes[..8].to_vec();
    glb.extend(((text_start + text.len() + HEADERS[1] + numbers.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", numbers)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    Some(glb)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mutants_follow_from_their_seed_and_differ() {
        let mut glb = b"glTF\x02\0\0\0\0\0\0\0\x08\0\0\0JSON{\"a\":1} ".to_vec();
        glb.extend(b"\x04\0\0\0BIN\0abcd");
        let files: [(&str, &[u8]); 4] = [
            ("a.obj", b"v 0 0 0\nv 1 0 0\nf 1/1 2 3\n"),
            ("a.gltf", br#"{"nodes":[{"children":[1,2]},{}],"asset":{"version":"2.0"}}"#),
            ("a.glb", &glb),
            ("a.stl", &[200; 90]),
        ];
        for (name, bytes) in files {
            let of = |seed| mutate(&mut Random::new(seed), name, bytes, b"another file");
            assert!((0..99).all(|seed| of(seed) == of(seed)));
            assert!((0..99).filter(|&seed| of(seed) != bytes).count() > 70, "{name}");
        }
        let is_whole = |mutant: &Vec<u8>| mutant[8..12] == (mutant.len() as u32).to_le_bytes();
        let mutants = (0..99).filter_map(|seed| changed_glb(&mut Random::new(seed), &glb));
        assert!(mutants.inspect(|mutant| assert!(is_whole(mutant))).count() > 50);
    }
}
