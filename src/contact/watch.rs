//! What must be looked at, and when.
//!
//! A distance that has been measured once cannot shrink by more than things have moved since. So every element of a body
//! is looked at again only when the way moved since then may have used up its distance: at rest that is what touches and
//! nothing else, and a body that flies past looks at far things seldom.

/// How many steps beyond the present reach are listed at once: a list lasts for a dozen substeps, and what is in it costs
/// something in each of them.
const AHEAD: f64 = 16.0;

/// Elements whose first arrival is noted together.
const BLOCK: usize = 64;

/// Elements of a body that may come near something.
#[derive(Clone, Debug, Default)]
#[cfg_attr(
    feature = "serde-serialize",
    derive(serde::Serialize, serde::Deserialize)
)]
pub struct Watch {
    /// Per element the way at which it may arrive \[m\]: any moment where its distance is no number.
    due: Vec<f64>,
    /// Per block of elements the way at which its first may arrive, or less \[m\].
    #[cfg_attr(feature = "serde-serialize", serde(skip))]
    first: Vec<f64>,
    /// Those that may arrive before `until`, and a few more, in ascending order.
    soon: Vec<u32>,
    until: f64,
    /// The way at which the first of those listed may arrive \[m\].
    next: f64,
    /// The way up to which all that may arrive is listed \[m\], and how many of those listed turned out to arrive later.
    horizon: f64,
    late: usize,
}

impl Watch {
    /// Forgets all distances.
    pub fn reset(&mut self) {
        self.due.clear();
        self.first.clear();
        self.soon.clear();
    }

    /// Calls `look` for all of `count` elements that may be within `reach` m, in ascending order. `way` is how far both
    /// sides have moved in all, or more; `look` is told how far off the element is at least and tells how far it is, or less.
    /// `step` is about the way of some substeps \[m\].
    pub fn visit(
        &mut self,
        count: usize,
        way: f64,
        (reach, step): (f64, f64),
        mut look: impl FnMut(u32, f64) -> f64,
    ) {
        if self.due.len() != count {
            self.reset();
            self.due.resize(count, f64::NEG_INFINITY);
            self.until = f64::NEG_INFINITY;
        }
        self.first.resize(count.div_ceil(BLOCK), f64::NEG_INFINITY);
        // What is late stays in the list and is passed over in every visit: at first that is nearly all. A few are not worth
        // a look at all others.
        let stale = 2 * self.late > self.soon.len() && 16 * self.late > count;
        if way + reach >= self.until || stale {
            self.gather(way + reach + AHEAD * step);
        } else if self.next - way > reach {
            return;
        }
        let mut next = f64::INFINITY;
        for &i in &self.soon {
            let due = &mut self.due[i as usize];
            // A way that is no number has all looked at.
            let is_far = *due - way > reach;
            if !is_far {
                let arrives = way + look(i, *due - way);
                *due = if arrives.is_nan() {
                    f64::NEG_INFINITY
                } else {
                    arrives
                };
                self.late += usize::from(*due > self.horizon);
                self.first[i as usize / BLOCK] = f64::NEG_INFINITY;
            }
            if *due < next {
                next = *due;
            }
        }
        self.next = next;
    }

    /// Lists what may arrive before the way `horizon`. Blocks of which nothing does are passed over.
    fn gather(&mut self, horizon: f64) {
        self.soon.clear();
        (self.horizon, self.late) = (horizon, 0);
        let mut until = f64::INFINITY;
        let blocks = self.first.iter_mut().zip(self.due.chunks(BLOCK));
        for (begin, (first, block)) in (0..).step_by(BLOCK).zip(blocks) {
            if *first > horizon {
                until = until.min(*first);
                continue;
            }
            *first = f64::INFINITY;
            for (i, &due) in (begin..).zip(block) {
                if due > horizon {
                    until = until.min(due);
                } else {
                    self.soon.push(i);
                }
                if due < *first {
                    *first = due;
                }
            }
        }
        self.until = until;
    }

    /// The elements that may be within `reach` m.
    pub fn within(&self, way: f64, reach: f64) -> impl Iterator<Item = u32> {
        let due = (0..).zip(&self.due);
        due.filter_map(move |(i, due)| {
            let is_far = due - way > reach;
            (!is_far).then_some(i)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that wander at random over a line, watched from the origin: whatever is near is looked at, and little else.
    #[test]
    fn nothing_near_is_missed_and_little_else_is_looked_at() {
        let (count, reach) = (1000, 1e-2);
        let mut places: Vec<f64> = (0..count).map(|i| f64::from(i) * 1e-2 - 2.0).collect();
        let (mut watch, mut way, mut seed) = (Watch::default(), 0.0, 1_u32);
        let (mut looks, mut near) = (0, 0);
        for _ in 0..2000 {
            let mut seen = Vec::new();
            watch.visit(places.len(), way, (reach, reach), |i, _| {
                seen.push(i);
                places[i as usize].abs()
            });
            assert!(seen.is_sorted());
            for (i, x) in (0..).zip(&places) {
                assert!(x.abs() > reach || seen.contains(&i));
                near += usize::from(x.abs() <= reach);
            }
            looks += seen.len();
            for x in &mut places {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                *x += 2e-4 * (f64::from(seed >> 8) / f64::from(1 << 24) - 0.5);
            }
            way += 1e-4;
        }
        let all = 2000 * places.len();
        assert!(
            near > 2000 && looks < all / 50,
            "{looks} of {all}, {near} near"
        );
        assert!(watch.within(way, reach).count() < 20);
    }

    /// What rests is not passed over again and again because all had to be looked at once.
    #[test]
    fn at_rest_only_what_is_near_stays_listed() {
        let mut watch = Watch::default();
        for _ in 0..3 {
            watch.visit(1000, 0.0, (1e-3, 1e-3), |i, _| f64::from(i) * 1e-2);
        }
        assert_eq!(watch.soon.len(), 2);
        // Nothing is forgotten by that.
        let mut seen = Vec::new();
        watch.visit(1000, 0.5, (1e-3, 1e-3), |i, _| {
            seen.push(i);
            f64::from(i) * 1e-2 - 0.5
        });
        assert_eq!(seen, (0..=50).collect::<Vec<_>>());
    }

    #[test]
    fn nothing_is_looked_at_where_nothing_is_left() {
        let mut watch = Watch::default();
        watch.visit(10, 0.0, (1.0, 1.0), |_, _| 0.0);
        watch.reset();
        watch.visit(0, 0.0, (1.0, 1.0), |_, _| panic!("there is nothing"));
    }

    #[test]
    fn what_is_no_number_is_always_looked_at() {
        let mut watch = Watch::default();
        for _ in 0..3 {
            let mut seen = 0;
            watch.visit(2, 0.0, (1.0, 1.0), |_, _| {
                seen += 1;
                f64::NAN
            });
            assert_eq!(seen, 2);
        }
    }
}
