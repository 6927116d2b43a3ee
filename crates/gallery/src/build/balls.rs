//! Spheres subdivided as finely as a number of triangles allows.

use glam::Vec3;

use super::MeshBuilder;

/// Triangles of a [`MeshBuilder::ball`] of a fineness: 8, 20, 80, 180, 320, …
pub(crate) fn ball_triangles(fineness: u32) -> usize {
    if fineness == 0 { 8 } else { 20 * fineness as usize * fineness as usize }
}

/// The fineness of balls of `radii` for `budget` triangles in all, with triangles of about one size; the coarsest if
/// the budget is too small.
pub(crate) fn fineness_of_balls(radii: &[f32], budget: usize) -> Vec<u32> {
    let mut fineness = vec![0_u32; radii.len()];
    let mut left = budget.saturating_sub(radii.len() * ball_triangles(0));
    let price = |fineness: u32| ball_triangles(fineness + 1) - ball_triangles(fineness);
    loop {
        // The refinable ball with the largest triangles.
        let affordable = (0..radii.len()).filter(|&ball| price(fineness[ball]) <= left);
        let coarseness = |ball: usize| radii[ball] / (fineness[ball] as f32 + 0.5);
        let Some(next) = affordable.max_by(|&a, &b| coarseness(a).total_cmp(&coarseness(b)).then(b.cmp(&a))) else {
            return fineness;
        };
        left -= price(fineness[next]);
        fineness[next] += 1;
    }
}

impl MeshBuilder {
    /// Adds a smooth ball: an octahedron at fineness 0, and from 1 on a geodesic sphere of that frequency.
    pub(crate) fn ball(&mut self, center: Vec3, radius: f32, fineness: u32) -> &mut Self {
        match fineness {
            0 => self.sphere(center, radius, 4, 2),
            frequency => self.icosphere(center, radius, frequency),
        }
    }

    /// Adds a ball that is hollow: its surface faces inwards.
    pub(crate) fn hollow(&mut self, center: Vec3, radius: f32, fineness: u32) -> &mut Self {
        let (first_vertex, first_triangle) = (self.positions.len(), self.triangles.len());
        self.ball(center, radius, fineness);
        for normal in &mut self.normals[first_vertex..] {
            *normal = -*normal;
        }
        for [_, b, c] in &mut self.triangles[first_triangle..] {
            std::mem::swap(b, c);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_used_up_and_goes_to_the_larger_balls() {
        let radii = [1.0, 0.5, 0.25];
        for budget in [30, 500, 5_000, 60_000] {
            let fineness = fineness_of_balls(&radii, budget);
            let used: usize = fineness.iter().map(|&fineness| ball_triangles(fineness)).sum();
            let next = fineness.iter().map(|&one| ball_triangles(one + 1) - ball_triangles(one)).min();
            assert!(used <= budget && budget - used < next.unwrap_or(0), "{used} of {budget}");
            assert!(fineness[0] >= fineness[1] && fineness[1] >= fineness[2], "{fineness:?}");
        }
        assert_eq!(fineness_of_balls(&radii, 0), [0; 3]);
    }

    #[test]
    fn balls_have_the_triangles_that_were_counted_and_hollow_ones_face_inwards() {
        for fineness in 0..5 {
            let mut builder = MeshBuilder::new();
            builder.hollow(Vec3::ZERO, 2.0, fineness);
            assert_eq!(builder.triangles.len(), ball_triangles(fineness));
            assert!(
                builder.positions.iter().zip(&builder.normals).all(|(position, normal)| position.dot(*normal) < 0.0)
            );
            let inwards = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|vertex| builder.positions[vertex as usize]);
                (b - a).cross(c - a).dot(a) < 0.0
            };
            assert!(builder.triangles.iter().all(inwards));
        }
    }
}
