use std::path::Path;

use glam::{Vec2, Vec3};

use crate::text;
use crate::text::{Lines, number, quoted, words};

/// One material of a library; `None` for statements that it lacks.
#[derive(Clone, Debug, Default)]
pub(super) struct Definition {
    pub(super) name: String,
    /// `Kd`.
    pub(super) diffuse: Option<Vec3>,
    /// `Ks`.
    pub(super) specular: Option<Vec3>,
    /// `Ns`, the Blinn–Phong exponent.
    pub(super) exponent: Option<f32>,
    /// `d`.
    pub(super) opacity: Option<f32>,
    /// `Tr`.
    pub(super) transparency: Option<f32>,
    /// `Ke`.
    pub(super) emissive: Option<Vec3>,
    /// `Ni`.
    pub(super) ior: Option<f32>,
    /// `Pr`.
    pub(super) roughness: Option<f32>,
    /// `Pm`.
    pub(super) metallic: Option<f32>,
    pub(super) diffuse_map: Option<TextureStatement>,
    pub(super) opacity_map: Option<TextureStatement>,
    pub(super) emissive_map: Option<TextureStatement>,
    /// `norm`: tangent-space normals.
    pub(super) normal_map: Option<TextureStatement>,
    pub(super) roughness_map: Option<TextureStatement>,
    pub(super) metallic_map: Option<TextureStatement>,
    /// Statements with a visible effect that materials have no field for, or that can't be read.
    pub(super) left_out: Vec<String>,
}

/// A texture statement: options and a file name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TextureStatement {
    pub(super) file: String,
    /// `-s`: scale of the texture coordinates.
    pub(super) scale: Vec2,
    /// `-o`: offset added to them after scaling.
    pub(super) offset: Vec2,
    /// `-clamp on`.
    pub(super) clamp: bool,
    /// `-bm`: strength of a normal map.
    pub(super) strength: f32,
}

/// Reads the text of a library. Statements that can't be read are left out.
pub(super) fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Vec<Definition> {
    let mut definitions: Vec<Definition> = Vec::new();
    let mut stray = (0, String::new());
    for (line_number, line) in Lines::new(bytes) {
        let (keyword, rest) = text::keyword(line);
        if keyword == b"newmtl" {
            definitions.push(Definition { name: String::from_utf8_lossy(rest).into_owned(), ..Definition::default() });
        } else if let Some(definition) = definitions.last_mut() {
            if let Err(cause) = definition.statement(keyword, rest) {
                definition.left_out.push(format!("{} on line {line_number}: {cause}", quoted(keyword)));
            }
        } else if !keyword.is_empty() && !keyword.starts_with(b"#") {
            stray.0 += 1;
            if stray.0 == 1 {
                stray.1 = format!("{} on line {line_number}", quoted(keyword));
            }
        }
    }
    if let (count @ 1.., first) = stray {
        let path = path.display();
        warnings
            .push(format!("{path}: left out {count} statements before the first `newmtl`, the first being {first}"));
    }
    definitions
}

impl Definition {
    fn statement(&mut self, keyword: &[u8], rest: &[u8]) -> Result<(), String> {
        match keyword.to_ascii_lowercase().as_slice() {
            b"kd" | b"ks" | b"ke" if rest.starts_with(b"spectral") || rest.starts_with(b"xyz") => {
                self.left_out.push(format!("{} in other than RGB", quoted(keyword)));
            }
            b"kd" => self.diffuse = Some(color(rest)?),
            b"ks" => self.specular = Some(color(rest)?),
            b"ke" => self.emissive = Some(color(rest)?),
            b"ns" => self.exponent = Some(scalar(rest)?.max(0.0)),
            b"ni" => self.ior = Some(scalar(rest)?),
            b"pr" => self.roughness = Some(scalar(rest)?.clamp(0.0, 1.0)),
            b"pm" => self.metallic = Some(scalar(rest)?.clamp(0.0, 1.0)),
            // `d -halo 0.5` fades towards the silhouette; only the value is used.
            b"d" => self.opacity = Some(scalar(rest.strip_prefix(b"-halo").unwrap_or(rest))?.clamp(0.0, 1.0)),
            b"tr" => self.transparency = Some(scalar(rest)?.clamp(0.0, 1.0)),
            b"map_kd" => self.diffuse_map = Some(TextureStatement::parse(rest)?),
            b"map_d" => self.opacity_map = Some(TextureStatement::parse(rest)?),
            b"map_ke" => self.emissive_map = Some(TextureStatement::parse(rest)?),
            b"norm" => self.normal_map = Some(TextureStatement::parse(rest)?),
            b"map_pr" => self.roughness_map = Some(TextureStatement::parse(rest)?),
            b"map_pm" => self.metallic_map = Some(TextureStatement::parse(rest)?),
            b"map_bump" | b"bump" => {
                self.left_out.push(format!("{} is a height field, not a map of normals (`norm`)", quoted(keyword)));
            }
            b"map_ks" | b"map_ns" | b"disp" | b"decal" | b"refl" | b"map_tr" => self.left_out.push(quoted(keyword)),
            // Ambient light, illumination models, filters and unknown statements have no effect here.
            _ => {}
        }
        Ok(())
    }
}

impl TextureStatement {
    /// Reads options with their values, and the rest of the line as a file name, which may contain spaces.
    fn parse(rest: &[u8]) -> Result<Self, String> {
        let mut map = Self { file: String::new(), scale: Vec2::ONE, offset: Vec2::ZERO, clamp: false, strength: 1.0 };
        let mut rest = rest;
        loop {
            let (option, values) = text::keyword(rest);
            rest = match option {
                b"-s" => {
                    let (scale, rest) = up_to_three(values, 1.0);
                    map.scale = scale;
                    rest
                }
                b"-o" => {
                    let (offset, rest) = up_to_three(values, 0.0);
                    map.offset = offset;
                    rest
                }
                b"-t" => up_to_three(values, 0.0).1,
                b"-bm" => {
                    let (value, rest) = text::keyword(values);
                    map.strength = finite(value)?;
                    rest
                }
                b"-clamp" => {
                    let (value, rest) = text::keyword(values);
                    map.clamp = value.eq_ignore_ascii_case(b"on");
                    rest
                }
                b"-mm" => text::keyword(text::keyword(values).1).1,
                b"-blendu" | b"-blendv" | b"-cc" | b"-boost" | b"-texres" | b"-imfchan" | b"-type" => {
                    text::keyword(values).1
                }
                _ => break,
            };
        }
        let file = rest.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")).unwrap_or(rest);
        if file.is_empty() {
            return Err("no file name".to_owned());
        }
        map.file = String::from_utf8_lossy(file).into_owned();
        Ok(map)
    }
}

/// Reads one to three numbers, and returns the first two, with `missing` for absent ones, and the text after them. The last
/// word of a line is its file name, even where it looks like a number.
fn up_to_three(text: &[u8], missing: f32) -> (Vec2, &[u8]) {
    let mut rest = text;
    let mut values = [missing; 3];
    for value in &mut values {
        let (word, after) = text::keyword(rest);
        match finite(word) {
            Ok(read) if !after.is_empty() => *value = read,
            _ => break,
        }
        rest = after;
    }
    (Vec2::new(values[0], values[1]), rest)
}

fn finite(word: &[u8]) -> Result<f32, String> {
    let value: f32 = number(word)?;
    if value.is_finite() { Ok(value) } else { Err(format!("{} is not finite", quoted(word))) }
}

fn scalar(rest: &[u8]) -> Result<f32, String> {
    match text::keyword(rest).0 {
        b"" => Err("no number".to_owned()),
        word => finite(word),
    }
}

/// Reads a colour: one number for a grey, or three.
fn color(rest: &[u8]) -> Result<Vec3, String> {
    let mut values = words(rest).take_while(|word| !word.starts_with(b"#")).take(3).map(finite);
    let first = values.next().ok_or("no number")??;
    let color = match (values.next().transpose()?, values.next().transpose()?) {
        (None, _) => Vec3::splat(first),
        (Some(second), Some(third)) => Vec3::new(first, second, third),
        (Some(_), None) => return Err("2 numbers where 3 are needed".to_owned()),
    };
    Ok(color.max(Vec3::ZERO))
}
