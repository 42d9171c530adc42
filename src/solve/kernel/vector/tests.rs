use super::*;

/// Roots and their reciprocals of numbers, in place and beside them.
struct Roots<'a>(&'a mut [f32], &'a mut [f32]);

impl Pass for Roots<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vector>(self) {
        let pairs = self.0.chunks_exact_mut(V::LANES);
        for (numbers, inverses) in pairs.zip(self.1.chunks_exact_mut(V::LANES)) {
            let [root, inverse] = V::load_from(numbers).root();
            root.store_to(numbers);
            inverse.store_to(inverses);
        }
    }
}

/// Without a divider every root and every reciprocal is rounded as it is with one: all mantissas, with even and with odd exponents,
/// and the ends of the range.
#[test]
fn roots_without_a_divider_are_rounded_correctly() {
    if Width::widest() < Width::Avx512 {
        eprintln!("left out: the processor has no AVX-512");
        return;
    }
    const COUNT: usize = 1 << 16;
    let [mut roots, mut inverses] = [vec![0.0; COUNT], vec![0.0; COUNT]];
    let least = (crate::law::spring::LEAST_SQUARE as f32).to_bits();
    let ends = [least, f32::MAX.to_bits() - COUNT as u32 + 1];
    let all = (1.0_f32.to_bits()..4.0_f32.to_bits()).step_by(COUNT);
    for first in all.chain(ends) {
        let square = |i: usize| f32::from_bits(first + i as u32);
        for (i, root) in roots.iter_mut().enumerate() {
            *root = square(i);
        }
        // SAFETY: the processor has AVX-512, see above.
        unsafe { x86::run512_without_divider(Roots(&mut roots, &mut inverses)) };
        for (i, (root, inverse)) in roots.iter().zip(&inverses).enumerate() {
            let exact = square(i).sqrt();
            assert_eq!(root.to_bits(), exact.to_bits(), "root of {:e}", square(i));
            let exact = 1.0 / exact;
            assert_eq!(
                inverse.to_bits(),
                exact.to_bits(),
                "inverse of {:e}",
                square(i)
            );
        }
    }
}
