//! Which elements are at which nodes.

/// The elements at each node, by their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Incidence {
    firsts: Vec<u32>,
    elements: Vec<u32>,
}

impl Incidence {
    /// Of elements, each given by its nodes.
    pub fn new<'a>(nodes: usize, elements: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut firsts = vec![0; nodes + 1];
        for &node in elements.clone().flatten() {
            firsts[node as usize + 1] += 1;
        }
        for node in 0..nodes {
            firsts[node + 1] += firsts[node];
        }
        let mut next = firsts.clone();
        let mut found = vec![0; firsts[nodes] as usize];
        for (element, ends) in (0..).zip(elements) {
            for &node in ends {
                let at = &mut next[node as usize];
                found[*at as usize] = element;
                *at += 1;
            }
        }
        Self {
            firsts,
            elements: found,
        }
    }

    /// Those at a node, in ascending order.
    pub fn at(&self, node: u32) -> &[u32] {
        let node = node as usize;
        &self.elements[self.firsts[node] as usize..self.firsts[node + 1] as usize]
    }

    /// Those at any of some nodes, each once, in ascending order.
    pub fn at_any(&self, nodes: &[u32]) -> Vec<u32> {
        let mut found: Vec<u32> = nodes.iter().flat_map(|n| self.at(*n)).copied().collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_is_at_each_of_its_nodes_and_once_at_several() {
        let elements: [&[u32]; 4] = [&[0, 1, 2, 3], &[3, 1], &[4, 3], &[0, 4]];
        let incidence = Incidence::new(6, elements.into_iter());
        assert_eq!(incidence.at(3), [0, 1, 2]);
        assert_eq!(incidence.at(0), [0, 3]);
        assert!(incidence.at(5).is_empty());
        assert_eq!(incidence.at_any(&[1, 3]), [0, 1, 2]);
        assert_eq!(incidence.at_any(&[4]), [2, 3]);
        assert!(incidence.at_any(&[]).is_empty());
    }
}
