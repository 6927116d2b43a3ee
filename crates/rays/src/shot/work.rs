use std::ops::AddAssign;

/// Defines a struct of numbers that lists them by name.
macro_rules! named_numbers {
    ($(#[$attribute:meta])* $name:ident of $number:ty { $($(#[$field_attribute:meta])* $field:ident,)+ }) => {
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $name {
            $($(#[$field_attribute])* pub $field: $number,)+
        }

        impl $name {
            /// Each number with its name.
            pub fn named(&self) -> impl Iterator<Item = (&'static str, $number)> + use<> {
                [$((stringify!($field), self.$field)),+].into_iter()
            }
        }

        impl AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)+
            }
        }
    };
}

/// The work of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Amounts of work.
    pub counts: Counts,
    /// Times of the stages.
    pub seconds: Seconds,
}

impl Work {
    /// The work of some lights together. The survey serves all of them and counts once.
    pub fn of_lights(lights: &[Self]) -> Self {
        let mut all = Self::default();
        for light in lights {
            all += *light;
        }
        let survey = lights.first().map_or(0.0, |first| first.seconds.survey);
        Self { seconds: Seconds { survey, ..all.seconds }, ..all }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        self.seconds += other.seconds;
    }
}

named_numbers! {
    /// Amounts of work for an answer. A structure counts some of them; the rest is zero.
    Counts of u64 {
        /// Traced rays: those in packets of a grid, single rays of a tree. Counted with the feature `statistics` of
        /// `umbrage-papers`, as are the next nine.
        rays,
        /// Groups of rays that were traced together.
        packets,
        /// Inner nodes that rays or packets visited, counted again after a restart.
        nodes,
        /// Leaves that rays or packets visited.
        leaves,
        /// Restarts of a traversal from above.
        restarts,
        /// Nodes visited to find the start of packets.
        searched,
        /// Triangles skipped because a packet had tested them before.
        mailbox_hits,
        /// Triangles outside of a packet's frustum.
        frustum_culls,
        /// Triangles behind the hits of all rays of a packet.
        depth_culls,
        /// Triangles that no sample's ray could hit, which were not listed.
        dropped,
        /// Samples of tiny triangles, tested while building.
        fragments,
        /// Pairs of a triangle and a tile or cell that lists it.
        pairs,
        /// Cells with triangles that were searched.
        cells,
        /// Faces of the light that see points.
        faces,
        /// Points that were tested, once for each face that they are on or beside.
        points,
        /// Points outside of every face of the light, tested against every triangle.
        outliers,
        /// Parts of tiles: points in up to 16 blocks that are near each other for a light.
        parts,
        /// Triangles that were tested, once for each face, in local coordinates.
        small_triangles,
        /// Triangles that were tested, once for each face, row by row.
        large_triangles,
        /// Blocks of work: some points of a cell and some triangles.
        blocks,
        /// Tests of a triangle against up to 16 samples or points, or against a packet ray by ray.
        tests,
        /// Pairs for which the filter asked the triangle's mask.
        masked,
        /// Pairs of a triangle and a sample or point that the filter or a mask left undecided.
        undecided,
        /// Pairs settled by the predicate: f64 or the mask couldn't decide them, and nothing nearer was found.
        settled,
        /// Samples whose depth, or points whose coordinates, were recomputed in f64 because the filter's weren't exact
        /// enough.
        refined,
    }
}

named_numbers! {
    /// Times of stages, in seconds. A structure times some of them; the rest is zero.
    Seconds of f64 {
        /// Distances of the image's tiles measured; once for all lights.
        survey,
        /// The light's faces divided into cells, and points mapped to the faces.
        map,
        /// Points sorted by cell, and gathered there.
        points,
        /// Vertices projected to pixels, or to the light's faces.
        project,
        /// Triangles dropped or listed.
        list,
        /// Pairs, or clusters of points, sorted by cell.
        sort,
        /// Triangles tested against samples or points.
        trace,
        /// Undecided pairs settled, and the bits of all threads joined.
        settle,
    }
}

impl Counts {
    /// The sum of both.
    pub fn plus(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

/// Bytes that a structure holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bytes {
    /// For triangles, memory used only while building included.
    pub triangles: usize,
    /// For the points that pixels show.
    pub points: usize,
}
