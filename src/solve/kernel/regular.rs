//! Nodes whose neighbours are found by counting: in a lattice, a sheet or a box of tets numbered along its axes, the springs of
//! nodes that follow each other go to nodes that follow each other.

use super::vector::LANES;
use crate::body::adjacency::Adjacency;
use std::ops::Range;

/// By how much the number of a node at the other end of a spring is higher, slot by slot.
pub type Steps = Vec<i32>;

/// How many times more slots than the longest row has springs a regular slice may have.
const MOST: usize = 2;

/// The steps of every slice of nodes in their order, `None` where a slice is not regular; `None` for a body of which less than
/// three quarters are.
pub fn steps(adjacency: &Adjacency) -> Option<Vec<Option<Steps>>> {
    let nodes = adjacency.nodes() as u32;
    let mut last = Steps::new();
    let slices = (0..nodes).step_by(LANES).map(|first| {
        let found = of_slice(adjacency, first..nodes.min(first + LANES as u32), &last);
        if let Some(steps) = &found {
            last.clone_from(steps);
        }
        found
    });
    let slices: Vec<_> = slices.collect();
    let regular = slices.iter().filter(|s| s.is_some()).count();
    (4 * regular >= 3 * slices.len() && regular > 0).then_some(slices)
}

/// One sequence of steps that holds those of every row in their order, so that sums keep it. Mostly it is that of the slice
/// before.
fn of_slice(adjacency: &Adjacency, nodes: Range<u32>, last: &[i32]) -> Option<Steps> {
    let row = |node: u32| -> Steps {
        let ends = adjacency.at(node).iter();
        ends.map(|&(_, other)| other as i32 - node as i32).collect()
    };
    let rows: Vec<Steps> = nodes.map(row).collect();
    let longest = rows.iter().map(Vec::len).max().unwrap_or(0);
    if rows.iter().all(|row| is_within(row, last)) {
        let mut steps = last.to_vec();
        steps.retain(|step| rows.iter().any(|row| row.contains(step)));
        return (steps.len() <= MOST * longest).then_some(steps);
    }
    let mut left: Vec<&[i32]> = rows.iter().map(|row| &row[..]).collect();
    let mut steps = Steps::new();
    while let Some(step) = next(&left) {
        if steps.len() == MOST * longest {
            return None;
        }
        steps.push(step);
        for row in &mut left {
            if row.first() == Some(&step) {
                *row = &row[1..];
            }
        }
    }
    left.iter().all(|row| row.is_empty()).then_some(steps)
}

/// A step that is the first of some rows and not a later one of any.
fn next(left: &[&[i32]]) -> Option<i32> {
    let mut heads = left.iter().filter_map(|row| row.first());
    let later = |step: &i32| left.iter().any(|row| row.iter().skip(1).any(|s| s == step));
    heads.find(|step| !later(step)).copied()
}

/// Whether a row is a part of a sequence, in its order.
fn is_within(row: &[i32], sequence: &[i32]) -> bool {
    let mut rest = sequence.iter();
    row.iter().all(|step| rest.any(|s| s == step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adjacency(nodes: usize, springs: &[[u32; 2]]) -> Adjacency {
        Adjacency::new(nodes, (0..).zip(springs.iter().copied()))
    }

    #[test]
    fn a_chain_is_regular_and_knows_its_order() {
        let forth: Vec<[u32; 2]> = (0..40).map(|i| [i, i + 1]).collect();
        let slices = steps(&adjacency(41, &forth)).unwrap();
        assert_eq!(slices.len(), 3);
        assert!(slices.iter().all(|s| s.as_deref() == Some(&[-1, 1])));
        let back: Vec<[u32; 2]> = forth.iter().rev().copied().collect();
        let slices = steps(&adjacency(41, &back)).unwrap();
        assert!(slices.iter().all(|s| s.as_deref() == Some(&[1, -1])));
    }

    #[test]
    fn rows_that_disagree_on_the_order_are_not_regular() {
        // Node 1 has its spring back first, node 5 its spring forth.
        let springs = [[0, 1], [1, 2], [5, 6], [4, 5]];
        assert!(steps(&adjacency(7, &springs)).is_none());
        // Two springs between two nodes have one step.
        assert!(steps(&adjacency(2, &[[0, 1], [0, 1]])).is_none());
        // Neighbours at random have too many.
        let springs: Vec<[u32; 2]> = (0..15).map(|i| [i, (7 * i * i + 3) % 97 + 16]).collect();
        assert!(of_slice(&adjacency(113, &springs), 0..16, &[]).is_none());
    }
}
