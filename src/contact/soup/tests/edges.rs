//! Ridges, valleys and borders.

use super::*;
use crate::contact::soup::{Edge, EdgeKind, EdgeSearch};

fn all_edges(soup: &Soup) -> Vec<Edge> {
    let (mut search, mut out) = (EdgeSearch::default(), Vec::new());
    soup.convex_edges_in(DVec3::splat(-9.0), DVec3::splat(9.0), &mut search, &mut out);
    out
}

#[test]
fn a_box_has_twelve_ridges_and_eight_corners_however_it_is_cut() {
    let half = DVec3::new(0.5, 0.25, 0.75);
    for flags in [
        TriMeshFlags::empty(),
        TriMeshFlags::ORIENTED,
        TriMeshFlags::FIX_INTERNAL_EDGES,
    ] {
        // The sides share no vertices: edges are found by place.
        let soup = soup(&box_mesh(half, 4, flags));
        let edges = all_edges(&soup);
        assert_eq!(edges.len(), 12 * 4, "{flags:?}");
        assert!(edges.iter().all(|e| e.kind == EdgeKind::Ridge));
        let length: f64 = edges.iter().map(|e| e.ends[0].distance(e.ends[1])).sum();
        assert!((length - 8.0 * (half.x + half.y + half.z)).abs() < 1e-6);
        for edge in &edges {
            // Into the box, along its sides.
            let inwards = -0.5 * (edge.ends[0] + edge.ends[1]);
            let [first, second] = edge.flanks();
            assert!(first.dot(inwards) > 0.0 && second.dot(inwards) > 0.0);
            let across = edge
                .normals
                .map(|n| n.dot(first).abs().min(n.dot(second).abs()));
            assert!(across.into_iter().all(|x| x < 1e-6) && edge.bend() > 0.999);
            assert!((0.1..0.5).contains(&edge.width), "{}", edge.width);
        }
        assert!(
            edges
                .iter()
                .all(|e| e.normals[0].dot(e.normals[1]).abs() < 1e-6)
        );
        let (mut search, mut list) = (EdgeSearch::default(), Vec::new());
        let corner = DVec3::splat(0.01);
        soup.convex_edges_in(half - corner, half + corner, &mut search, &mut list);
        assert_eq!(list.len(), 3);
        assert!(list.iter().all(|e| e.ends.contains(&half)));
    }
}

#[test]
fn turned_inside_out_its_edges_are_valleys() {
    let v = Vector::new;
    let corners = vec![
        v(0.0, 0.0, 0.0),
        v(1.0, 0.0, 0.0),
        v(0.0, 1.0, 0.0),
        v(0.0, 0.0, 1.0),
    ];
    let inward = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    let plain = soup(&SharedShape::trimesh(corners.clone(), inward.clone()).unwrap());
    let edges = all_edges(&plain);
    assert_eq!(edges.len(), 6);
    assert!(edges.iter().all(|e| e.kind == EdgeKind::Valley));
    let oriented =
        SharedShape::trimesh_with_flags(corners, inward, TriMeshFlags::ORIENTED).unwrap();
    assert!(soup(&oriented).oriented());
    assert_eq!(all_edges(&soup(&oriented)), []);
}

#[test]
fn a_field_has_the_edges_of_the_same_mesh() {
    let field = bumpy();
    let (vertices, triangles): (Vec<Vector>, Vec<[u32; 3]>) = {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for t in field.triangles() {
            let k = vertices.len() as u32;
            vertices.extend([t.a, t.b, t.c]);
            triangles.push([k, k + 1, k + 2]);
        }
        (vertices, triangles)
    };
    let mesh = soup(&SharedShape::trimesh(vertices, triangles).unwrap());
    let field = soup(&SharedShape::new(field));
    let (of_mesh, of_field) = (all_edges(&mesh), all_edges(&field));
    let key = |e: &Edge| (e.ends, e.kind, e.normals, e.width);
    assert_eq!(
        of_mesh.iter().map(key).collect::<Vec<_>>(),
        of_field.iter().map(key).collect::<Vec<_>>()
    );
    for kind in [EdgeKind::Ridge, EdgeKind::Valley] {
        assert!(of_field.iter().filter(|e| e.kind == kind).count() > 50);
    }
    assert_eq!(
        of_field.iter().filter(|e| e.kind == EdgeKind::Free).count(),
        2 * (12 + 10)
    );
    // Boxes give the edges in them.
    let mut random = Random(51);
    let (mut search, mut a, mut b) = (EdgeSearch::default(), Vec::new(), Vec::new());
    for _ in 0..1000 {
        let p = random.vector();
        let half = random.vector().abs() * 0.3;
        field.convex_edges_in(p - half, p + half, &mut search, &mut a);
        mesh.convex_edges_in(p - half, p + half, &mut search, &mut b);
        assert_eq!(
            a.iter().map(key).collect::<Vec<_>>(),
            b.iter().map(key).collect::<Vec<_>>()
        );
    }
}

#[test]
fn borders_and_lines_are_free() {
    for (name, count) in [("triangle", 3), ("segment", 1), ("polyline", 3)] {
        let (_, shape) = soups().into_iter().find(|(n, _)| *n == name).unwrap();
        let edges = all_edges(&soup(&shape));
        assert_eq!(edges.len(), count, "{name}");
        assert!(edges.iter().all(|e| e.kind == EdgeKind::Free));
    }
}
