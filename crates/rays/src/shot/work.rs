use std::ops::AddAssign;

/// A struct of numbers, each of which has a name.
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

/// What answering took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// How much there was to do.
    pub counts: Counts,
    /// How long its stages took.
    pub seconds: Seconds,
}

impl Work {
    /// What some lights took together: the survey, which serves all of them, once.
    pub(crate) fn of_lights(lights: &[Self]) -> Self {
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
    /// How much work an answer was. A structure counts what it has; the rest is zero.
    Counts of u64 {
        /// Rays that were traced: those in packets of a grid, single ones of a tree. Counted with the feature `statistics`, as
        /// are the next nine.
        rays,
        /// Groups of rays that were traced together.
        packets,
        /// Inner nodes that rays or packets visited, again where one came from above again.
        nodes,
        /// Leaves that they visited.
        leaves,
        /// Times that one came from above again.
        restarts,
        /// Nodes that were visited to find where packets begin.
        searched,
        /// Triangles that a packet remembered to have tested.
        mailbox_hits,
        /// Triangles outside of a packet's frustum.
        frustum_culls,
        /// Triangles behind what all of a packet's rays hit.
        depth_culls,
        /// Triangles that no sample's ray could hit, and that weren't listed.
        dropped,
        /// Samples of tiny triangles, tested while building.
        fragments,
        /// Pairs of a triangle and a tile or cell that it is listed in.
        pairs,
        /// Cells with triangles that were searched.
        cells,
        /// Faces of the light that see points.
        faces,
        /// Points that were tested, once for each face that they are on or beside.
        points,
        /// Points that no face of the light could hold, tested against every triangle.
        outliers,
        /// Parts of tiles: points in up to 16 blocks that are near each other for a light.
        parts,
        /// Triangles that were tested, once for each face, in local coordinates.
        small_triangles,
        /// Triangles that were tested, once for each face, row by row.
        large_triangles,
        /// Blocks of work: some points of a cell, and some triangles.
        blocks,
        /// Tests of a triangle against up to 16 samples or points, or against a packet ray by ray.
        tests,
        /// Pairs about which the filter asked the triangle's mask.
        masked,
        /// Pairs of a triangle and a sample or point that the filter, or a mask asked by it, left undecided.
        undecided,
        /// Pairs that the predicate settled, since f64 or the mask couldn't decide them and nothing nearer was found.
        settled,
        /// Samples whose depth, or points whose coordinates, were found again in f64, since the filter's weren't exact
        /// enough.
        refined,
    }
}

named_numbers! {
    /// How long stages took, in seconds. A structure times what it has; the rest is zero.
    Seconds of f64 {
        /// How far away the image's tiles are; once for all lights.
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
        /// What the filter left undecided, and the bits of all threads.
        settle,
    }
}

impl Counts {
    /// The sum of both.
    pub(crate) fn plus(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

/// Bytes that a structure holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bytes {
    /// For triangles, counting what is only used while building.
    pub triangles: usize,
    /// For the points that pixels show.
    pub points: usize,
}
