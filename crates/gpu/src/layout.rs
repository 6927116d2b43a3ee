//! Compares Rust structs, byte by byte, with the WGSL structs that shaders read.

use naga::{Expression, Literal, Module, TypeInner};

/// Layout of a Rust struct that shaders read, made by [`layout!`].
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// The struct's name in Rust and in WGSL.
    pub(crate) name: &'static str,
    pub(crate) size: usize,
    pub(crate) members: Vec<Member>,
}

/// A member of such a struct.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub(crate) name: &'static str,
    pub(crate) offset: usize,
    pub(crate) size: usize,
}

/// The layout of a struct and of the members that its shader declares, in order. Padding is left out.
macro_rules! layout {
    ($type:ident { $($member:ident),* $(,)? }) => {
        $crate::layout::Layout {
            name: stringify!($type),
            size: size_of::<$type>(),
            members: vec![$($crate::layout::Member {
                name: stringify!($member),
                offset: std::mem::offset_of!($type, $member),
                size: $crate::layout::size_of_member(|of: &$type| &of.$member),
            }),*],
        }
    };
}
pub(crate) use layout;

/// Size of the member that a function borrows.
pub(crate) fn size_of_member<T, M>(_: impl Fn(&T) -> &M) -> usize {
    size_of::<M>()
}

/// A linked shader's text, read by naga.
///
/// # Panics
/// If it isn't valid WGSL.
pub(crate) fn module(text: &str) -> Module {
    naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)))
}

/// Differences between a Rust struct and the shader's struct of the same name; empty if there are none.
pub(crate) fn differences(module: &Module, layout: &Layout) -> Vec<String> {
    let name = layout.name;
    let found = module.types.iter().find(|(_, of)| of.name.as_deref() == Some(name));
    let Some(TypeInner::Struct { members, span }) = found.map(|(_, of)| &of.inner) else {
        return vec![format!("the shader has no struct {name}")];
    };
    let mut complaints = Vec::new();
    if *span as usize != layout.size {
        complaints.push(format!("{name}: {} bytes in Rust, {span} in WGSL", layout.size));
    }
    if members.len() != layout.members.len() {
        complaints.push(format!("{name}: {} members in Rust, {} in WGSL", layout.members.len(), members.len()));
    }
    for (rust, wgsl) in layout.members.iter().zip(members) {
        let size = module.types[wgsl.ty].inner.size(module.to_ctx()) as usize;
        let of_wgsl = (wgsl.name.as_deref().unwrap_or_default(), wgsl.offset as usize, size);
        let of_rust = (rust.name, rust.offset, rust.size);
        if of_rust != of_wgsl {
            complaints.push(format!("{name}: name, offset and size are {of_rust:?} in Rust, {of_wgsl:?} in WGSL"));
        }
    }
    complaints
}

/// Names of the Rust constants that the shader lacks or has with another value.
pub(crate) fn other_constants<'a>(module: &Module, constants: &[(&'a str, u32)]) -> Vec<&'a str> {
    let others = constants.iter().filter(|(name, value)| constant(module, name) != Some(*value));
    others.map(|(name, _)| *name).collect()
}

/// Value of a shader's u32 constant; `None` if there is none of that name.
fn constant(module: &Module, name: &str) -> Option<u32> {
    let (_, constant) = module.constants.iter().find(|(_, of)| of.name.as_deref() == Some(name))?;
    match module.global_expressions[constant.init] {
        Expression::Literal(Literal::U32(value)) => Some(value),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_comparison_finds_each_kind_of_difference() {
        #[repr(C)]
        struct Pair {
            first: [f32; 3],
            second: u32,
        }
        let of_rust = layout!(Pair { first, second });
        let complaints = |wgsl: &str| differences(&module(wgsl), &of_rust).len();
        assert_eq!(complaints("struct Pair { first: vec3<f32>, second: u32 }"), 0);
        assert_eq!(complaints("struct Other { first: vec3<f32>, second: u32 }"), 1);
        assert_eq!(complaints("struct Pair { second: vec3<f32>, first: u32 }"), 2);
        // The second member starts behind the padding of the first, and the struct becomes larger.
        assert_eq!(complaints("struct Pair { first: vec4<f32>, second: u32 }"), 3);
        assert_eq!(complaints("struct Pair { first: vec3<f32>, second: vec2<u32> }"), 2);
        assert_eq!(complaints("struct Pair { first: vec3<f32> }"), 1);
    }
}
