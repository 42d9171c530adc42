//! Sets without common members, joined one by one: union–find.

/// The numbers from 0 on in sets. A set is named by its smallest number, so that names do not depend on the order of the joins.
#[derive(Clone, Debug, Default)]
pub(crate) struct Disjoint {
    /// Per number, a smaller one of its set, or itself.
    parent: Vec<u32>,
}

impl Disjoint {
    /// So many sets of one number each.
    pub fn new(numbers: usize) -> Self {
        let mut sets = Self::default();
        sets.restart(numbers);
        sets
    }

    /// The same, keeping the memory.
    pub fn restart(&mut self, numbers: usize) {
        self.parent.clear();
        self.parent.extend(0..numbers as u32);
    }

    /// Makes one set of those of two numbers.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The set of a number. Halves the way there.
    pub fn of(&mut self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            let above = self.parent[self.parent[number as usize] as usize];
            self.parent[number as usize] = above;
            number = above;
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_named_by_their_smallest_numbers() {
        for joins in [
            [(1, 2), (4, 5), (5, 2), (3, 0)],
            [(0, 3), (2, 5), (2, 1), (4, 5)],
        ] {
            let mut sets = Disjoint::new(7);
            joins.iter().for_each(|&(a, b)| sets.join(a, b));
            let names: Vec<u32> = (0..7).map(|i| sets.of(i)).collect();
            assert_eq!(names, [0, 1, 1, 0, 1, 1, 6]);
        }
    }
}
