//! Instruction sets, and vectors of their widths.

pub mod lanes;
mod level;
pub mod vectors;

pub use crate::each;
pub use level::SimdLevel;

// Closures that vectors pass through must be inlined; functions only where they are marked so. Code that isn't inlined is
// compiled without the instruction set.

/// Runs an expression with the instructions of a [`SimdLevel`], given to it as a token:
/// `dispatch!(level, simd => sum(simd, values))`.
///
/// The expression is compiled once for each of three levels of x86: SSE2, AVX2 and AVX-512. SSE4.2 is left out: it would add
/// a fifth to this library's code, for machines from before 2013 and some small ones since.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $simd:ident => $result:expr) => {{
        let level = $crate::fearless_simd::Level::from($level);
        match level {
            $crate::fearless_simd::Level::Avx512($simd) => $crate::vectorized!($simd => $result),
            $crate::fearless_simd::Level::Avx2($simd) => $crate::vectorized!($simd => $result),
            _ => match level.as_sse2() {
                Some($simd) => $crate::vectorized!($simd => $result),
                None => unreachable!("all x86 processors that Rust compiles for have SSE2"),
            },
        }
    }};
}

/// Runs an expression with the instructions of a [`SimdLevel`], given to it as a token:
/// `dispatch!(level, simd => sum(simd, values))`.
#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
#[doc(hidden)]
#[macro_export]
macro_rules! dispatch {
    ($level:expr, $simd:ident => $result:expr) => {
        $crate::fearless_simd::dispatch!($crate::fearless_simd::Level::from($level), $simd => $result)
    };
}

/// An expression for each of three values: `each!(x in corners.x => x - middle)`.
#[doc(hidden)]
#[macro_export]
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
#[doc(hidden)]
#[macro_export]
macro_rules! vectorized {
    ($simd:expr => $result:expr) => {
        $crate::fearless_simd::Simd::vectorize(
            $simd,
            #[inline(always)]
            || $result,
        )
    };
}
