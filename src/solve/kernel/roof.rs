//! What the processor can do at best, for comparison: a stream of memory, and arithmetic in registers.

use super::Kernel;
use super::vector::{LANES, Pass, Vector, Wide, Width, run};

/// a = b + s·c over three arrays (McCalpin's STREAM).
#[derive(Clone, Debug)]
pub struct Triad {
    kernel: Kernel,
    arrays: [Vec<Wide>; 3],
}

impl Triad {
    /// Over about so many bytes in all, with the vectors of a kernel.
    pub fn new(kernel: Kernel, bytes: usize) -> Self {
        let rows = bytes / 3 / size_of::<Wide>() + 1;
        let array = |x: f32| vec![Wide([x; LANES]); rows];
        Self {
            kernel,
            arrays: [array(0.0), array(1.0), array(2.0)],
        }
    }

    /// Bytes read and written by a run.
    pub fn bytes(&self) -> usize {
        3 * size_of_val(&self.arrays[0][..])
    }

    /// Once over all.
    pub fn run(&mut self) {
        let [a, b, c] = &mut self.arrays;
        run(self.kernel, Stream { a, b, c });
    }
}

struct Stream<'a> {
    a: &'a mut [Wide],
    b: &'a [Wide],
    c: &'a [Wide],
}

impl Pass for Stream<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
        let factor = V::of(0.5);
        for ((a, b), c) in self.a.iter_mut().zip(self.b).zip(self.c) {
            for part in 0..LANES / V::LANES {
                (V::load(b, part) + factor * V::load(c, part)).store(a, part);
            }
        }
    }
}

/// Chains of products and sums, so many that none waits for the one before.
const CHAINS: usize = 12;

/// Operations of [`multiply_and_add`].
pub fn operations(kernel: Kernel, rounds: usize) -> usize {
    let lanes = match Width::of(kernel) {
        Width::Portable => 4,
        Width::Avx2 => 8,
        Width::Avx512 => 16,
    };
    2 * CHAINS * rounds * lanes
}

/// So many products and sums in registers, fused where the processor can; something of the outcome.
pub fn multiply_and_add(kernel: Kernel, rounds: usize) -> f64 {
    run(kernel, Chains(std::hint::black_box(rounds)))
}

struct Chains(usize);

impl Pass for Chains {
    type Output = f64;

    #[inline(always)]
    fn run<V: Vector>(self) -> f64 {
        let (factor, more) = (V::of(0.999), V::of(0.001));
        let mut chains: [V; CHAINS] = std::array::from_fn(|i| V::of(i as f64));
        for _ in 0..self.0 {
            for chain in &mut chains {
                *chain = chain.multiply_and_add(factor, more);
            }
        }
        chains.iter().map(|c| c.lane(0)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_width_streams_and_multiplies() {
        for kernel in [Kernel::Portable, Kernel::Avx2, Kernel::Avx512] {
            let mut triad = Triad::new(kernel, 10_000);
            triad.run();
            assert!(triad.arrays[0].iter().all(|w| w.0 == [2.0; LANES]));
            assert!(triad.bytes() >= 10_000 && triad.bytes() < 11_000);
            let sum = multiply_and_add(kernel, 20_000);
            assert!((sum - CHAINS as f64).abs() < 1e-2, "{sum}");
        }
    }
}
