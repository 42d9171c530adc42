//! Searches, distances and normals against all facets, one by one, by another formula.

use super::*;
use crate::contact::soup::Facet;
use crate::contact::soup::facet::Patch;

/// The nearest point by planes through the sides, and of the sides.
fn reference(facet: &Facet, p: DVec3) -> DVec3 {
    let on = |a: DVec3, b: DVec3| {
        let t = (p - a).dot(b - a) / (b - a).length_squared();
        a.lerp(b, t.clamp(0.0, 1.0))
    };
    match *facet {
        Facet::Segment([a, b]) => on(a, b),
        Facet::Triangle([a, b, c]) => {
            let n = (b - a).cross(c - a).normalize();
            let over = |a: DVec3, b: DVec3| n.cross(b - a).dot(p - a) >= 0.0;
            if over(a, b) && over(b, c) && over(c, a) {
                return p - n * n.dot(p - a);
            }
            let mut rim = [on(a, b), on(b, c), on(c, a)];
            rim.sort_by(|x, y| x.distance(p).total_cmp(&y.distance(p)));
            rim[0]
        }
    }
}

fn all(soup: &Soup) -> Vec<(u32, Facet)> {
    (0..2000)
        .filter_map(|id| Some((id, soup.facet(id)?)))
        .collect()
}

#[test]
fn searches_and_touches_agree_with_all_facets() {
    for (name, shape) in soups() {
        let soup = soup(&shape);
        let facets = all(&soup);
        let mut random = Random(3);
        let (mut found, mut list, mut out) =
            (Vec::new(), NodeFacets::default(), Touches::default());
        let (mut near_count, mut inside_count) = (0, 0);
        for _ in 0..10_000 {
            let p = random.vector() * 1.1;
            let half = random.vector().abs() * 0.3;
            soup.facets_in(p - half, p + half, &mut found);
            let expected: Vec<u32> = facets
                .iter()
                .filter(|(_, facet)| {
                    let (lo, hi) = facet.bounds();
                    lo.cmple(p + half).all() && hi.cmpge(p - half).all()
                })
                .map(|(id, _)| *id)
                .collect();
            assert_eq!(found, expected, "{name} at {p}");

            let margin = 0.2;
            list.gather(&soup, std::iter::once((7, p)), margin);
            let nearest = facets
                .iter()
                .map(|(_, facet)| reference(facet, p))
                .min_by(|a, b| a.distance(p).total_cmp(&b.distance(p)))
                .unwrap();
            let distance = nearest.distance(p);
            if distance > margin + soup.radius() {
                assert!(list.nodes().is_empty(), "{name} at {p}");
                continue;
            }
            assert_eq!(list.nodes(), [7]);
            touches(list.near(0), p, DVec3::ZERO, None, 0.0, margin, &mut out);
            let inside = name == "oriented" && p.abs().cmplt(DVec3::new(0.5, 0.3, 0.8)).all();
            let sign = if inside { -1.0 } else { 1.0 };
            let touch = out.as_slice()[0];
            assert!(
                (touch.depth - (soup.radius() - sign * distance)).abs() < 1e-7,
                "{name} at {p}: {touch:?}, {distance}"
            );
            if distance > 1e-4 {
                let n = (p - nearest) / distance * sign;
                assert!(
                    touch.normal.distance(n) < 1e-6,
                    "{name} at {p}: {touch:?}, {n}"
                );
            }
            near_count += 1;
            inside_count += u32::from(inside);
            let exit = soup.inside(p);
            assert_eq!(exit.is_some(), inside, "{name} at {p}");
            if let Some(exit) = exit {
                assert!((exit.depth - distance).abs() < 1e-7);
                assert!((p + exit.normal * exit.depth).distance(exit.point) < 1e-7);
            }
        }
        assert!(near_count > 100, "{name}: {near_count} near");
        assert_eq!(
            inside_count > 100,
            name == "oriented",
            "{name}: {inside_count} inside"
        );
    }
}

#[test]
fn lists_hold_exactly_the_facets_within_the_margin() {
    for (name, shape) in soups() {
        let soup = soup(&shape);
        let facets = all(&soup);
        let mut random = Random(11);
        let points: Vec<DVec3> = (0..300).map(|_| random.vector() * 1.1).collect();
        let mut list = NodeFacets::default();
        let margin = 0.15;
        list.gather(
            &soup,
            points.iter().enumerate().map(|(i, &p)| (i as u32, p)),
            margin,
        );
        let mut index = 0;
        for (i, &p) in points.iter().enumerate() {
            let expected: Vec<u32> = facets
                .iter()
                .filter(|(_, facet)| reference(facet, p).distance(p) <= margin + soup.radius())
                .map(|(id, _)| *id)
                .collect();
            if expected.is_empty() {
                assert!(!list.nodes().contains(&(i as u32)), "{name}");
                continue;
            }
            assert_eq!(list.nodes()[index], i as u32, "{name}");
            let got: Vec<u32> = list
                .near(index)
                .iter()
                .map(|(_, patch): (u32, &Patch)| patch.id)
                .collect();
            assert_eq!(got, expected, "{name} at {p}");
            index += 1;
        }
        assert_eq!(list.nodes().len(), index);
        assert!(list.near(index).slots.is_empty(), "no such node, no facets");
    }
}
