//! The keys of answers that a caller asks for.

use pyo3::prelude::*;
use umbrage::rays::Wanted;

use crate::errors::expected;

/// The arrays that are found and handed over.
#[derive(Clone, Copy, Debug)]
pub(super) struct Keys {
    asked: [bool; Self::NAMES.len()],
}

impl Keys {
    /// In the order of answers.
    pub(super) const NAMES: [&str; 5] =
        ["t_hit", "geometry_ids", "primitive_ids", "primitive_uvs", "primitive_normals"];

    pub(super) const WITHOUT_T: Self = Self { asked: [false, true, true, true, true] };
    pub(super) const WITHOUT_NORMALS: Self = Self { asked: [true, true, true, true, false] };

    /// All keys, or those that are named.
    pub(super) fn new(keys: Option<Vec<String>>) -> PyResult<Self> {
        let Some(keys) = keys else {
            return Ok(Self { asked: [true; Self::NAMES.len()] });
        };
        if let Some(other) = keys.iter().find(|key| !Self::NAMES.contains(&key.as_str())) {
            return Err(expected("keys", &format!("some of {}", Self::NAMES.join(", ")), other));
        }
        Ok(Self { asked: Self::NAMES.map(|name| keys.iter().any(|key| key == name)) })
    }

    /// The parts of hits that are found for them.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted { t: self.t(), barycentric: self.weights() }
    }

    pub(super) fn t(&self) -> bool {
        self.asked[0]
    }

    pub(super) fn geometry(&self) -> bool {
        self.asked[1]
    }

    pub(super) fn primitive(&self) -> bool {
        self.asked[2]
    }

    pub(super) fn weights(&self) -> bool {
        self.asked[3]
    }

    pub(super) fn normals(&self) -> bool {
        self.asked[4]
    }
}
