//! Instruction sets, and vectors of as many lanes as they have.

pub(crate) mod lanes;
mod level;
pub(crate) mod vectors;

pub use level::SimdLevel;

// Closures that vectors pass through have to be inlined, and functions only so where they say it: what isn't inlined is
// compiled without the instruction set.

/// An expression for each of three values: `each!(x in corners.x => x - middle)`.
macro_rules! each {
    ($value:pat in $three:expr => $result:expr) => {{
        let [first, second, third] = $three;
        [
            {
                let $value = first;
                $result
            },
            {
                let $value = second;
                $result
            },
            {
                let $value = third;
                $result
            },
        ]
    }};
}

/// An expression, compiled with the instruction set of a token: `vectorized!(simd => sum(simd, values))`.
macro_rules! vectorized {
    ($simd:expr => $result:expr) => {
        $simd.vectorize(
            #[inline(always)]
            || $result,
        )
    };
}

pub(crate) use {each, vectorized};
