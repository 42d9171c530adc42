//! A ball as a surface of rings of quads.

use crate::body::{Group, Surface};
use crate::math::{Real, Vector};
use std::f32::consts::PI;

/// A ball whose quarters are by turns in a group of their own: one sees how it rolls.
pub(super) fn ball(radius: Real, around: u32, rings: u32) -> Surface {
    let mut vertices = vec![
        Vector::new(0.0, radius, 0.0),
        Vector::new(0.0, -radius, 0.0),
    ];
    for ring in 1..rings {
        let (sin, cos) = (PI * ring as Real / rings as Real).sin_cos();
        for i in 0..around {
            let (s, c) = (2.0 * PI * i as Real / around as Real).sin_cos();
            vertices.push(radius * Vector::new(sin * s, cos, sin * c));
        }
    }
    let at = |ring: u32, i: u32| match ring {
        0 => 0,
        ring if ring == rings => 1,
        _ => 2 + (ring - 1) * around + i % around,
    };
    let (mut triangles, mut groups) = (Vec::new(), Vec::new());
    for quarter in 0..4 {
        for half in 0..2 {
            let first = triangles.len();
            for i in quarter * around / 4..(quarter + 1) * around / 4 {
                for ring in half * rings / 2..(half + 1) * rings / 2 {
                    let [a, b, c, d] = [
                        at(ring, i),
                        at(ring + 1, i),
                        at(ring + 1, i + 1),
                        at(ring, i + 1),
                    ];
                    let quad = [[a, b, c], [a, c, d]].into_iter();
                    triangles.extend(quad.filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]));
                }
            }
            groups.push(Group {
                name: ["lamp", "tyre"][((quarter + half) % 2) as usize].into(),
                triangles: first..triangles.len(),
            });
        }
    }
    Surface {
        vertices,
        triangles,
        groups,
    }
}
