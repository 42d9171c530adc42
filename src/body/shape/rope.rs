//! A rope: a chain of equal springs.
//!
//! Nothing but tension and compression along the chain: no bending stiffness, because a spring between every second node
//! would stiffen the chain and a rope is wanted for the exact column and pendulum it makes.

use crate::body::error::positive;
use crate::body::{BuildError, Net, Node, Spring};
use crate::math::{Real, Vector, narrow, wide};

/// A straight chain of `segments` springs of `section` \[m²\] from `from` to `to` \[m\]; its first node is at `from`, its
/// last at `to`, and these two have half the volume of the others.
///
/// # Errors
/// [`BuildError::Value`] if the ends coincide or are not finite, the section is not positive and finite, or there are no
/// segments or more than fifty million.
pub fn rope(from: Vector, to: Vector, segments: usize, section: Real) -> Result<Net, BuildError> {
    if segments == 0 || segments > 50_000_000 {
        return Err(BuildError::Value {
            what: "the number of segments of the rope",
            value: segments as f64,
            must: "from 1 to 50 million",
        });
    }
    let area = positive("the section of the rope", section.into())?;
    let (from, to) = (wide(from), wide(to));
    let length = positive("the length of the rope", from.distance(to))?;
    let volume = area * length / segments as f64;
    let nodes = (0..=segments).map(|i| {
        let end = i == 0 || i == segments;
        let at = from.lerp(to, i as f64 / segments as f64);
        Node::of_volume(
            narrow(at),
            (if end { 0.5 * volume } else { volume }) as Real,
        )
    });
    let springs = (0..segments as u32).map(|i| Spring::of_section(i, i + 1, section));
    Ok(Net::new(nodes.collect(), springs.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rope_is_a_chain_with_its_volume() {
        let net = rope(
            Vector::new(1.0, 2.0, 3.0),
            Vector::new(1.0, -2.0, 3.0),
            8,
            1e-4,
        )
        .unwrap();
        net.check().unwrap();
        assert_eq!((net.nodes.len(), net.springs.len()), (9, 8));
        let volume: Real = net.nodes.iter().map(|n| n.volume).sum();
        assert!((volume / 4e-4 - 1.0).abs() < 1e-5);
        assert_eq!(net.nodes[0].volume * 2.0, net.nodes[1].volume);
        assert!(
            net.springs
                .iter()
                .all(|s| (net.length(s) - 0.5).abs() < 1e-6)
        );
    }

    #[test]
    fn bad_ropes_are_errors() {
        let x = Vector::X;
        for bad in [
            rope(x, x, 3, 1e-4),
            rope(x, -x, 0, 1e-4),
            rope(x, -x, 3, 0.0),
            rope(x, -x, 3, Real::NAN),
            rope(x * Real::NAN, x, 3, 1e-4),
        ] {
            assert!(matches!(bad, Err(BuildError::Value { .. })), "{bad:?}");
        }
    }
}
