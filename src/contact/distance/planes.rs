//! Planes side by side, so that a compiler makes vectors of them.

use crate::math::DVec3;

/// Planes to a block.
pub const LANES: usize = 8;

/// Normals and offsets of planes, one lane each.
#[derive(Debug, PartialEq)]
pub struct Block {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    offset: [f64; LANES],
}

impl Block {
    /// Heights of a point over the planes \[m\].
    #[inline]
    pub fn heights(&self, p: DVec3) -> [f64; LANES] {
        let mut heights = [0.0; LANES];
        for (i, height) in heights.iter_mut().enumerate() {
            *height = self.x[i] * p.x + self.y[i] * p.y + self.z[i] * p.z - self.offset[i];
        }
        heights
    }
}

/// The greatest, in a tree, which does not wait for one comparison after the other.
#[inline]
pub fn greatest(h: &[f64; LANES]) -> f64 {
    let of = |a: f64, b: f64| if a > b { a } else { b };
    let four = [
        of(h[0], h[4]),
        of(h[1], h[5]),
        of(h[2], h[6]),
        of(h[3], h[7]),
    ];
    of(of(four[0], four[2]), of(four[1], four[3]))
}

/// Planes in blocks, the last filled up with planes that nothing is above.
pub fn blocks(planes: impl Iterator<Item = (DVec3, f64)>) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for (i, (normal, offset)) in planes.enumerate() {
        if i % LANES == 0 {
            blocks.push(Block {
                x: [0.0; LANES],
                y: [0.0; LANES],
                z: [0.0; LANES],
                offset: [f64::MAX; LANES],
            });
        }
        if let Some(block) = blocks.last_mut() {
            block.x[i % LANES] = normal.x;
            block.y[i % LANES] = normal.y;
            block.z[i % LANES] = normal.z;
            block.offset[i % LANES] = offset;
        }
    }
    blocks
}
