use rayon::prelude::*;
use umbrage_rays::{self as rays, choices};
use umbrage_scene::{Frame, Material};

/// The sides of triangles that stop rays, for a camera's, a light's and a mirror's alike.
///
/// A triangle is invisible, and lets light through, from a side that it doesn't have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// The front, and the back where the material is [double-sided](umbrage_scene::Material::double_sided) or
    /// [bounds a volume](umbrage_scene::Material::bounds_volume).
    #[default]
    File,
    /// Both, for all materials.
    Both,
    /// Only the front, from which corners are seen counterclockwise.
    Front,
}

choices! { Sides, "choice of sides":
    "file" => File, "those that the material has: both, or in glTF, unless it is double-sided, only the front";
    "both" => Both, "both of all";
    "front" => Front, "only the front of all, from which corners are seen counterclockwise";
}

impl Sides {
    /// Whether the triangles of a material have a back.
    pub(crate) fn have_back(self, material: &Material) -> bool {
        match self {
            Self::File => material.double_sided || material.bounds_volume(),
            Self::Both => true,
            Self::Front => false,
        }
    }
}

/// The sides of a frame's triangles, in the form that structures take.
#[derive(Debug, Default)]
pub(crate) struct TriangleSides {
    /// A bit for each triangle that has a back, where some have one and some don't.
    backs: Vec<u64>,
    are_alike: Option<rays::Sides<'static>>,
}

impl TriangleSides {
    /// Finds the sides of another frame's triangles.
    pub(crate) fn find(&mut self, frame: &Frame, chosen: Sides) {
        let materials = &frame.materials.materials;
        let has_back = |material: u32| chosen.have_back(&materials[material as usize]);
        self.are_alike = if materials.iter().all(|material| chosen.have_back(material)) {
            Some(rays::Sides::Both)
        } else if !materials.iter().any(|material| chosen.have_back(material)) {
            Some(rays::Sides::Front)
        } else {
            None
        };
        self.backs.clear();
        if self.are_alike.is_none() {
            let words = frame.mesh.material_of_triangle.par_chunks(u64::BITS as usize).with_min_len(1 << 10);
            let bits = words
                .map(|word| word.iter().rev().fold(0, |bits, &material| bits << 1 | u64::from(has_back(material))));
            self.backs.par_extend(bits);
        }
    }

    pub(crate) fn get(&self) -> rays::Sides<'_> {
        self.are_alike.unwrap_or(rays::Sides::Each(&self.backs))
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.backs.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use umbrage_scene::{Materials, Mesh};

    use super::*;

    #[test]
    fn sides_are_those_of_materials_unless_others_are_chosen() {
        let mut frame = Frame::from_triangles(Vec::new(), vec![[0; 3]; 200]);
        let mut sides = TriangleSides::default();
        sides.find(&frame, Sides::File);
        assert_eq!(sides.get(), rays::Sides::Both, "clay");
        let is_one_sided = |triangle: u32| triangle.is_multiple_of(3) || triangle > 190;
        let materials = vec![Material::clay(), Material::default()];
        frame.materials = Arc::new(Materials { materials, ..Materials::default() });
        let material_of_triangle = (0..200).map(|triangle| is_one_sided(triangle).into()).collect();
        frame.mesh = Arc::new(Mesh { material_of_triangle, ..(*frame.mesh).clone() });
        for (chosen, back) in [(Sides::Both, Some(true)), (Sides::Front, Some(false)), (Sides::File, None)] {
            sides.find(&frame, chosen);
            let expected = |triangle| back.unwrap_or(!is_one_sided(triangle));
            assert!((0..200).all(|triangle| sides.get().has_back(triangle) == expected(triangle)), "{chosen}");
        }
    }
}
