//! A proven bound on the fastest modes of a body of elements, as it is now.
//!
//! For every way of dividing the masses among elements, λ(M⁻¹K) ≤ max over elements of λ(Mₑ⁻¹Kₑ): the energy of any motion is
//! the sum of the elements', each at most its λ times its own kinetic form (Irons & Treharne 1971). The shares follow the
//! elements' own stiffness at their nodes, so that stiff elements lean on the mass soft neighbours don't need; elements
//! that come out fastest at rest are given more in a few rounds, and the best round counts.
//!
//! What an element's λ is at a deformation follows from its law's [`Majorant`]s, iso·‖D‖² + (along:D)² at each point, and
//! from the second moments of its ∇N over its masses, which are found once. With one point it is the root of a sum of three
//! quotients. With several, the first part has the largest eigenvalue of all moments together, the second the Frobenius
//! norm of the products of the points. So the bound costs about as much as one pass of forces; squeezing, stiffening and
//! geometric stiffness count. Pinned nodes are taken as free, which is on the safe side.

use super::blocks::Blocks;
use super::eigen::{axes, largest_eigenvalue};
use super::elements::{Basis, Element, Elements};
use crate::body::state::Particle;
use crate::law::elastic::Majorant;
use crate::law::elastic::tensor::{Mat, apply, contract, mul, trace};
use crate::math::{Number, Pack, Scalar, WIDTH};

/// How often the masses are divided anew.
const ROUNDS: usize = 4;

/// A bound on the fastest mode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rates {
    /// Bound of λ(M⁻¹K) \[1/s²\], or of λ(M⁻¹C) \[1/s\].
    pub largest: f64,
    /// The element that has it; none when nothing moves.
    pub element: Option<u32>,
}

/// What of the bound depends on masses and the shape at rest only, per block.
#[derive(Clone, Debug, Default)]
pub struct Moments<S> {
    /// The largest eigenvalue of Σ V·∇N·∇Nᵀ over the masses \[m/kg\].
    iso: Vec<Pack<S>>,
    /// Of one point the eigenvectors of V·Σ ∇N⊗∇N/m, row by row, as long as the roots of their eigenvalues \[√(m/kg)\]; of
    /// several √(V·V′)·Σ ∇N⊗∇N′/m of every pair, the first no later than the second \[m/kg\].
    forms: Vec<Mat<Pack<S>>>,
}

/// The same of one element.
struct Own {
    iso: f64,
    forms: Vec<Mat<f64>>,
}

impl<S: Scalar> Moments<S> {
    /// Of elements with 1/m of each node \[1/kg\], which have `rest` at rest.
    pub fn new<B: Basis<N, G>, const N: usize, const G: usize>(
        elements: &Elements<B, N, G>,
        rest: &Majorant<f64>,
        inv_mass: impl Fn(usize) -> f64,
    ) -> Self {
        let shares = divide(elements, rest, &inv_mass);
        let each = elements.list.iter().zip(&shares);
        let own: Vec<Own> = each
            .map(|(element, shares)| own::<B, N, G>(element, shares, &inv_mass))
            .collect();
        let mut moments = Self::default();
        for group in own.chunks(WIDTH) {
            let lane = |l: usize| group.get(l).unwrap_or(&group[0]);
            moments.iso.push(Pack::of_lanes(|l| lane(l).iso));
            for form in 0..G * (G + 1) / 2 {
                moments.forms.push(std::array::from_fn(|i| {
                    std::array::from_fn(|k| Pack::of_lanes(|l| lane(l).forms[form][i][k]))
                }));
            }
        }
        moments
    }

    /// The bound where the particles are: of λ(M⁻¹K) with the majorant of an elastic law, of λ(M⁻¹C) with that of a viscous one.
    pub fn rates<B: Basis<N, G>, const N: usize, const G: usize>(
        &self,
        blocks: &Blocks<S, B, N, G>,
        majorant: impl Fn(&Mat<Pack<S>>) -> Majorant<Pack<S>>,
        particles: &[Particle<S>],
    ) -> Rates {
        let mut rates = Rates::default();
        let forms = self.forms.chunks_exact(G * (G + 1) / 2);
        let parts = blocks.parts::<Pack<S>>();
        for (b, ((at, iso), forms)) in parts.zip(&self.iso).zip(forms).enumerate() {
            let x = B::gradients(&blocks.gather::<Pack<S>>(at, |n| particles[n].x));
            let most: [Majorant<_>; G] = std::array::from_fn(|g| {
                majorant(&mul(&x[g], &blocks.point::<Pack<S>>(at, g).inverse))
            });
            let bound = combine(&most, *iso, forms);
            if Pack::of(rates.largest).all_above(bound) {
                continue;
            }
            for l in 0..blocks.filled::<Pack<S>>(at) {
                let value = bound.lane(l);
                // NaN is the fastest of all.
                if value > rates.largest || value.is_nan() {
                    rates = Rates {
                        largest: if value.is_nan() { f64::INFINITY } else { value },
                        element: Some((b * WIDTH + l) as u32),
                    };
                }
            }
        }
        rates
    }
}

/// The bound of one element.
#[inline(always)]
fn combine<S: Number, const G: usize>(most: &[Majorant<S>; G], iso: S, forms: &[Mat<S>]) -> S {
    // Moments are rounded.
    let sure = S::of(1.0 + 1e-5);
    match (most.as_slice(), forms) {
        ([one], [axes]) => sure * of_one_point(one, axes),
        _ => sure * of_points(most, iso, forms),
    }
}

/// The eigenvalue of iso·T + g·gᵀ, where T has the eigenvectors `axes`, as long as the roots of their eigenvalues, and g is
/// `along` times them: the root of Σ gᵢ²/(λ − iso·tᵢ) = 1, from above. The sum is convex and falls, so Newton's steps from below
/// stay below, and chords to them stay above.
#[inline(always)]
fn of_one_point<S: Number>(most: &Majorant<S>, axes: &Mat<S>) -> S {
    let square = |v: [S; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let poles = axes.map(|a| most.iso * square(a));
    let parts = axes.map(|a| square(apply(&most.along, a)));
    let mut above = poles[0].max(poles[1]).max(poles[2]) + parts[0] + parts[1] + parts[2];
    // A pole alone is below, and the sum there is one at least.
    let alone = |i: usize| poles[i] + parts[i];
    let mut below = alone(0).max(alone(1)).max(alone(2));
    let tiny = S::of(1e-6) * above + S::of(1e-30);
    let sum = |at: S| {
        let inverse = poles.map(|p| S::ONE / (at - p).max(tiny));
        let each = |i: usize| parts[i] * inverse[i];
        let slope = |i: usize| each(i) * inverse[i];
        (
            each(0) + each(1) + each(2) - S::ONE,
            slope(0) + slope(1) + slope(2),
        )
    };
    for _ in 0..2 {
        let (high, slope) = sum(below);
        let next = (below + (high / slope.max(S::of(1e-30))).max(S::ZERO)).min(above);
        let (high, _) = sum(next);
        let (low, _) = sum(above);
        // From `next`, where the sum is above 1 by `high`, to `above`, where it is below by −`low`.
        let width = (high - low).max(S::of(1e-30));
        let chord = above + (above - next) * (low / width).min(S::ZERO);
        (below, above) = (next, chord.max(next));
    }
    above
}

/// iso·λ + ‖tr(Mᵍ·T·Mᵍ′ᵀ)‖ over the points g.
#[inline(always)]
fn of_points<S: Number, const G: usize>(most: &[Majorant<S>; G], iso: S, pairs: &[Mat<S>]) -> S {
    let mut stiffest = S::ZERO;
    let mut square = S::ZERO;
    let mut pair = pairs.iter();
    for (g, a) in most.iter().enumerate() {
        stiffest = stiffest.max(a.iso);
        for (k, b) in most.iter().enumerate().skip(g) {
            let Some(moment) = pair.next() else { break };
            let value = contract(&mul(&a.along, moment), &b.along);
            let twice = if k == g { S::ONE } else { S::of(2.0) };
            square += twice * value * value;
        }
    }
    stiffest * iso + square.sqrt()
}

/// The share of each node's mass that each element has.
fn divide<B: Basis<N, G>, const N: usize, const G: usize>(
    elements: &Elements<B, N, G>,
    rest: &Majorant<f64>,
    inv_mass: &impl Fn(usize) -> f64,
) -> Vec<[f64; N]> {
    let claim = |e: &Element<N, G>| -> [f64; N] {
        let mut claims = [0.0; N];
        for (g, point) in e.points.iter().enumerate() {
            for (c, d) in claims.iter_mut().zip(e.gradients::<B>(g)) {
                *c += point.volume * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            }
        }
        claims
    };
    let mut claims: Vec<[f64; N]> = elements.list.iter().map(claim).collect();
    let mut best = (f64::INFINITY, Vec::new());
    let mut sums = vec![0.0; elements.node_count];
    for _ in 0..=ROUNDS {
        sums.fill(0.0);
        for (element, claims) in elements.list.iter().zip(&claims) {
            for (node, claim) in element.nodes.iter().zip(claims) {
                sums[*node as usize] += claim;
            }
        }
        let share = |(element, claims): (&Element<N, G>, &[f64; N])| -> [f64; N] {
            std::array::from_fn(|a| claims[a] / sums[element.nodes[a] as usize])
        };
        let shares: Vec<[f64; N]> = elements.list.iter().zip(&claims).map(share).collect();
        let mut fastest = 0.0_f64;
        for ((element, shares), claims) in elements.list.iter().zip(&shares).zip(&mut claims) {
            let own = own::<B, N, G>(element, shares, inv_mass);
            let rate = combine(&[*rest; G], own.iso, &own.forms);
            fastest = fastest.max(rate);
            if rate.is_normal() {
                claims.iter_mut().for_each(|c| *c *= rate);
            }
        }
        if fastest < best.0 {
            best = (fastest, shares);
        } else if best.1.is_empty() {
            best.1 = shares;
        }
    }
    best.1
}

fn own<B: Basis<N, G>, const N: usize, const G: usize>(
    element: &Element<N, G>,
    shares: &[f64; N],
    inv_mass: &impl Fn(usize) -> f64,
) -> Own {
    let gradients: [[[f64; 3]; N]; G] = std::array::from_fn(|g| element.gradients::<B>(g));
    let mobility: [f64; N] =
        std::array::from_fn(|a| inv_mass(element.nodes[a] as usize) / shares[a]);
    let moment = |g: usize, k: usize| -> Mat<f64> {
        let volume = (element.points[g].volume * element.points[k].volume).sqrt();
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let each = (0..N).map(|a| mobility[a] * gradients[g][a][i] * gradients[k][a][j]);
                volume * each.sum::<f64>()
            })
        })
    };
    let size = 3 * G;
    let (mut matrix, mut forms) = (vec![0.0; size * size], Vec::new());
    for g in 0..G {
        for k in g..G {
            let pair = moment(g, k);
            for i in 0..3 {
                for j in 0..3 {
                    matrix[(3 * g + i) * size + 3 * k + j] = pair[i][j];
                    matrix[(3 * k + j) * size + 3 * g + i] = pair[i][j];
                }
            }
            forms.push(if G == 1 { axes(&pair) } else { pair });
        }
    }
    let whole: f64 = (0..G).map(|g| trace(&moment(g, g))).sum();
    Own {
        // The matrix is positive: its trace is a bound too, and finite where the powers are not.
        iso: largest_eigenvalue(&mut matrix, size).min(whole),
        forms,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::elastic::tensor::from_fn;

    #[test]
    fn the_root_is_met_from_above() {
        // iso·T + g·gᵀ of T = diag(3, 2, 1), iso = 2, along = diag(1, 2, 0.5): the largest eigenvalue by its own bound.
        let t = [3.0_f64, 2.0, 1.0];
        let axes = from_fn(|i, j| if i == j { t[i].sqrt() } else { 0.0 });
        let along = from_fn(|i, j| if i == j { [1.0, 2.0, 0.5][i] } else { 0.0 });
        let g: Vec<f64> = (0..3).map(|i| along[i][i] * t[i].sqrt()).collect();
        let mut m: Vec<f64> = (0..9)
            .map(|n| g[n / 3] * g[n % 3] + if n % 4 == 0 { 2.0 * t[n / 4] } else { 0.0 })
            .collect();
        let exact = largest_eigenvalue(&mut m, 3);
        let found = of_one_point(&Majorant { iso: 2.0, along }, &axes);
        assert!(
            found >= exact / 1.05 && found < 1.02 * exact,
            "{found} {exact}"
        );
    }
}
