//! Which nodes are joined to which, and an order in which those that are joined lie near each other.

use std::collections::VecDeque;

/// The springs, or edges, at each node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Adjacency {
    firsts: Vec<u32>,
    /// Spring and the node at its other end, in the order of springs.
    ends: Vec<(u32, u32)>,
}

impl Adjacency {
    /// Of springs, each with its number and its two nodes.
    pub fn new(nodes: usize, springs: impl Iterator<Item = (u32, [u32; 2])> + Clone) -> Self {
        let mut firsts = vec![0; nodes + 1];
        for (_, ends) in springs.clone() {
            for node in ends {
                firsts[node as usize + 1] += 1;
            }
        }
        for node in 0..nodes {
            firsts[node + 1] += firsts[node];
        }
        let mut next = firsts.clone();
        let mut ends = vec![(0, 0); firsts[nodes] as usize];
        for (spring, [a, b]) in springs {
            for (node, other) in [(a, b), (b, a)] {
                let at = &mut next[node as usize];
                ends[*at as usize] = (spring, other);
                *at += 1;
            }
        }
        Self { firsts, ends }
    }

    /// The springs at a node, each with the node at its other end.
    pub fn at(&self, node: u32) -> &[(u32, u32)] {
        let node = node as usize;
        &self.ends[self.firsts[node] as usize..self.firsts[node + 1] as usize]
    }

    pub fn nodes(&self) -> usize {
        self.firsts.len() - 1
    }

    /// Mean distance in the order of nodes between the ends of a spring.
    pub fn spread(&self) -> f64 {
        let each = |node: u32| {
            let far = |&(_, other): &(u32, u32)| f64::from(node.abs_diff(other));
            self.at(node).iter().map(far).sum::<f64>()
        };
        let sum: f64 = (0..self.nodes() as u32).map(each).sum();
        sum / self.ends.len().max(1) as f64
    }

    /// Reverse Cuthill–McKee (*Proc. 24th Nat. Conf. ACM*, 1969), each part of the body from a node of few springs.
    pub fn cuthill_mckee(&self) -> Vec<u32> {
        let length = |node: u32| self.at(node).len();
        let mut seeds: Vec<u32> = (0..self.nodes() as u32).collect();
        seeds.sort_by_key(|&node| length(node));
        let mut seen = vec![false; self.nodes()];
        let mut order = Vec::with_capacity(self.nodes());
        let (mut queue, mut next) = (VecDeque::new(), Vec::new());
        for seed in seeds {
            if std::mem::replace(&mut seen[seed as usize], true) {
                continue;
            }
            queue.push_back(seed);
            while let Some(node) = queue.pop_front() {
                order.push(node);
                let others = self.at(node).iter().map(|&(_, other)| other);
                next.clear();
                next.extend(others.filter(|&o| !std::mem::replace(&mut seen[o as usize], true)));
                next.sort_by_key(|&node| length(node));
                queue.extend(&next);
            }
        }
        order.reverse();
        order
    }
}
