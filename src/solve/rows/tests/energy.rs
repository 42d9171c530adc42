//! Rows take energy and give none, whatever they start with and whether they settle or not.

use super::*;

/// SplitMix64 (Steele, Lea & Flood 2014), as numbers from `a` to `b`.
struct Dice(u64);

impl Dice {
    fn range(&mut self, a: f64, b: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        a + (b - a) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        let mut along = || self.range(-size, size);
        DVec3::new(along(), along(), along())
    }
}

/// Light nodes between two heavy bodies, which touch each other, and the fixed world; some rows are on faces of three nodes,
/// some of these with levers, some nodes are tied, and much is warm from a substep in which everything pressed otherwise.
fn jam(dice: &mut Dice) -> (Rows, [Shadow; 3]) {
    let mut rows = Rows::default();
    let count = dice.range(1.0, 5.0) as u32;
    for _ in 0..count {
        let v = dice.vector(2.0);
        rows.nodes.push(RowNode {
            inv_mass: dice.range(2.0, 7.0).exp(),
            ..node(v)
        });
    }
    for _ in 0..dice.range(2.0, 9.0) as usize {
        let shadow = dice.range(0.0, 3.0) as u32;
        let first = dice.range(0.0, f64::from(count)) as u32;
        let whole = Term {
            node: first,
            weight: 1.0,
            share: 1.0,
        };
        let term = |k: u32, weight: f64| Term {
            node: (first + k) % count,
            weight,
            share: weight,
        };
        let face = [term(0, 0.5), term(1, 0.3), term(2, 0.2)];
        let on_face = count >= 3 && dice.range(0.0, 1.0) < 0.4;
        let out = if shadow == 0 { DVec3::Y } else { DVec3::NEG_Y };
        let normal = (out + dice.vector(0.6)).normalize();
        let levers = (on_face && shadow == 0).then_some(rows.levers.len() as u32);
        if levers.is_some() {
            let [a, b] = [dice.vector(0.5), dice.vector(0.5)];
            let across = [a, b, -(a + b)].map(|l| l - normal * l.dot(normal));
            rows.levers.extend(across);
        }
        let terms = if on_face {
            rows.add_terms(face)
        } else {
            rows.add_terms([whole])
        };
        let warm = if on_face {
            dice.range(-20.0, 20.0).max(0.0)
        } else {
            0.0
        };
        rows.contacts.push(Row {
            shadow,
            normal,
            levers,
            arm: dice.vector(0.3),
            friction: dice.range(0.0, 0.9),
            normal_impulse: warm,
            ..row(terms)
        });
    }
    for first in 0..count {
        if dice.range(0.0, 1.0) < 0.6 {
            continue;
        }
        let terms = rows.add_terms([Term {
            node: first,
            weight: 1.0,
            share: 1.0,
        }]);
        let tie = Tie {
            terms,
            shadow: dice.range(1.0, 2.3) as u32,
            arm: dice.vector(0.3),
            impulse: dice.vector(10.0),
            ..tie()
        };
        rows.ties.push(tie);
        // Some are tied to the other body too, or by a point of two nodes, and are no part of a composite then.
        if dice.range(0.0, 1.0) < 0.1 {
            rows.ties.push(Tie {
                shadow: 3 - tie.shadow,
                ..tie
            });
        }
        if count > 1 && dice.range(0.0, 1.0) < 0.1 {
            let half = |node: u32| Term {
                node: node % count,
                weight: 0.5,
                share: 0.5,
            };
            let terms = rows.add_terms([half(first), half(first + 1)]);
            rows.ties.push(Tie { terms, ..tie });
        }
    }
    for _ in 0..dice.range(0.0, 3.0) as usize {
        let on = [[0, 1], [0, 2], [1, 2]][dice.range(0.0, 3.0) as usize];
        let normal = (DVec3::Y + dice.vector(0.6)).normalize();
        rows.rigid.push(RigidRow {
            shadows: on,
            arms: [dice.vector(0.3), dice.vector(0.3)],
            normal,
            shares: [1.0, 1.0],
            friction: dice.range(0.0, 0.9),
            normal_impulse: dice.range(-20.0, 20.0).max(0.0),
            ..RigidRow::default()
        });
    }
    let body = |dice: &mut Dice| Shadow {
        inv_mass: DMat3::from_diagonal(DVec3::splat(dice.range(-4.0, 0.0).exp())),
        inv_inertia: DMat3::from_diagonal(DVec3::splat(dice.range(-2.0, 3.0).exp())),
        v: dice.vector(2.0),
        ..Shadow::FIXED
    };
    (rows, [Shadow::FIXED, body(dice), body(dice)])
}

fn kinetic_energy(rows: &Rows, shadows: &[Shadow; 3]) -> f64 {
    let nodes = rows.nodes.iter().map(|n| n.v.length_squared() / n.inv_mass);
    let bodies = shadows[1..].iter().map(|s| {
        s.v.length_squared() / s.inv_mass.x_axis.x + s.w.length_squared() / s.inv_inertia.x_axis.x
    });
    0.5 * (nodes.sum::<f64>() + bodies.sum::<f64>())
}

#[test]
fn rows_give_no_energy() {
    let mut dice = Dice(1);
    for n in 0..5000 {
        let (mut rows, mut shadows) = jam(&mut dice);
        let before = kinetic_energy(&rows, &shadows);
        rows.solve(&mut shadows, 1e-3, 4, n % 2 == 0);
        let after = kinetic_energy(&rows, &shadows);
        assert!(
            after <= before * (1.0 + 1e-9),
            "jam {n}: {before} J become {after} J"
        );
    }
}

/// Friction is bounded by the load that is left in the end. Symptom: rows of a sheet kept a thousand times that, as their load was given to
/// others after they had rubbed.
#[test]
fn rows_keep_no_more_friction_than_their_loads_allow() {
    let mut dice = Dice(2);
    for n in 0..5000 {
        let (mut rows, mut shadows) = jam(&mut dice);
        rows.solve(&mut shadows, 1e-3, 4, n % 2 == 0);
        for row in &rows.contacts {
            let (friction, limit) = (row.friction_impulse.length(), row.friction_limit());
            assert!(
                friction <= limit * (1.0 + 1e-9),
                "jam {n}: {friction} of {limit}"
            );
        }
    }
}
