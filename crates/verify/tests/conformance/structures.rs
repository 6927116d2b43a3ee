//! Tests of each structure in the table, named after the structure and a group of cases, so that a failure names both.

macro_rules! of_each {
    ($($name:ident: $make:expr;)+) => {
        $(mod $name {
            use umbrage_verify::structures::*;

            use crate::check::{check, check_sequence};
            use crate::{cases, frames, single_rays};

            const MAKE: Make = $make;

            #[test] fn few_triangles() { check(MAKE, &cases::FEW_TRIANGLES) }
            #[test] fn triangles_in_bad_places() { check(MAKE, &cases::BAD_PLACES) }
            #[test] fn triangles_of_bad_shapes() { check(MAKE, &cases::BAD_SHAPES) }
            #[test] fn triangles_that_are_none() { check(MAKE, &cases::BROKEN) }
            #[test] fn cameras() { check(MAKE, &cases::CAMERAS) }
            #[test] fn image_sizes() { check(MAKE, &cases::IMAGE_SIZES) }
            #[test] fn worlds() { check(MAKE, &cases::WORLDS) }
            #[test] fn lights() { check(MAKE, &cases::LIGHTS) }
            #[test] fn points_far_from_faces() { check(MAKE, &cases::OUTLIERS) }
            #[test] fn seams() { check(MAKE, &cases::SEAMS) }
            #[test] fn lattices() { check(MAKE, &cases::LATTICES) }
            #[test] fn opacity() { check(MAKE, &cases::OPACITY) }
            #[test] fn sides() { check(MAKE, &cases::SIDES) }
            #[test] fn patches() { check(MAKE, &cases::PATCHES) }
            #[test] fn samples() { check(MAKE, &cases::SAMPLES) }
            #[test] fn aimed() { check(MAKE, &cases::AIMED) }
            #[test] fn crowds() { check(MAKE, &cases::CROWDS) }
            #[test] fn moving() { check_sequence(MAKE, &cases::MOVING) }
            #[test] fn single_rays() { single_rays::check(MAKE) }
            #[test] fn every_number_of_threads_and_level() { frames::are_the_same_everywhere(MAKE) }
            #[test] fn validation() { frames::notice_moved_triangles(MAKE) }
            #[test] fn steady_frames() { frames::allocate_nothing_when_steady(stringify!($name), MAKE) }
        })+
    };
}

macro_rules! tests {
    (short { $($name:ident: $make:expr;)+ } long { $($other:ident: $make_other:expr;)+ }) => {
        of_each! { $($name: $make;)+ }

        mod long {
            of_each! { $($other: $make_other;)+ }
        }
    };
}

umbrage_verify::structures!(tests);
