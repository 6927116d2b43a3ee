use super::Fans;
use umbrage_rays::Triangles;

impl Fans {
    /// Checks the fans against their triangles.
    ///
    /// # Errors
    /// Names the first triangle that breaks a rule: every triangle that can be hit is in exactly one fan, all others are in
    /// none, and a triangle in a fan has the centre and the two ends of its edges for corners, in its own orientation.
    pub fn validate(&self, triangles: Triangles<'_>) -> Result<(), String> {
        let mut seen = vec![0_u32; triangles.len()];
        for index in 0..self.len() {
            let fan = self.fan(index);
            for (triangle, &id) in fan.ids.iter().enumerate() {
                let corners = match triangles.indices.get(id as usize) {
                    Some(_) => triangles.usable_corners(id),
                    None => return Err(format!("fan {index} has triangle {id}, which isn't there")),
                };
                let mut corners = corners.map_err(|why| format!("fan {index} has triangle {id}: {why:?}"))?;
                corners.rotate_left(usize::from(fan.center_corners[triangle]));
                let [center, first, second] = corners;
                let edges = [first - center, second - center];
                if center != fan.center || edges != fan.edges[triangle..triangle + 2] {
                    return Err(format!("fan {index} has other corners than triangle {id}"));
                }
                seen[id as usize] += 1;
            }
        }
        let wrong = (0..triangles.len() as u32).find(|&id| {
            let expected = u32::from(triangles.usable_corners(id).is_ok());
            seen[id as usize] != expected
        });
        wrong.map_or(Ok(()), |id| Err(format!("triangle {id} is in {} fans", seen[id as usize])))
    }
}
