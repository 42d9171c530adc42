//! Who is held, how far the sheets sag, and what is through.

use super::super::{Figures, Run, SceneError};
use super::{HALF, SHEETS};
use crate::math::{DVec3, wide};
use crate::world::Deformable;
use rapier3d::dynamics::RigidBody;

/// Keys and labels of one sheet: boxes held, sag, rest of the sag.
const KEYS: [[(&str, &str); 3]; 2] = [
    [
        ("boxes_held_10kg", "boxes held by the sheet of 10 kg"),
        ("max_sag_10kg_m", "its largest sag"),
        ("rest_sag_10kg_m", "its sag at the end"),
    ],
    [
        ("boxes_held_1kg", "boxes held by the sheet of 1 kg"),
        ("max_sag_1kg_m", "its largest sag"),
        ("rest_sag_1kg_m", "its sag at the end"),
    ],
];

/// All figures of a run.
pub(super) fn figures(run: &Run) -> Result<Figures, SceneError> {
    let mut f = Figures::default();
    let (mut through, mut fewest, mut deepest) = (0, usize::MAX, 0.0_f64);
    let mut fastest = 0.0_f64;
    for (name, [held_key, sag_key, rest_key]) in SHEETS.into_iter().zip(KEYS) {
        let handle = run.cast.deformable(&format!("sheet_{name}"));
        let sheet = handle.and_then(|h| Some((run.deformables.get(h)?, run.recorder.body(h)?)));
        let (sheet, record) = sheet.ok_or(SceneError::Missing("sheet"))?;
        let prefix = format!("box_{name}_");
        let mut held = 0;
        for (who, body, _) in &run.cast.rigid {
            let body = body.and_then(|b| run.world.bodies.get(b));
            let Some(body) = body.filter(|_| who.starts_with(&prefix)) else {
                continue;
            };
            held += usize::from(is_held(sheet, body));
            through += over(sheet, body);
            fastest = fastest.max(f64::from(body.linvel().length()));
        }
        fewest = fewest.min(held);
        let sag = record.bounds.iter().map(|[lo, _]| -lo.y);
        let sag = sag.fold(0.0, f64::max);
        deepest = deepest.max(sag);
        f.add(held_key.0, held_key.1, held as f64, "");
        f.add(sag_key.0, sag_key.1, sag, "m");
        f.add(rest_key.0, rest_key.1, -sheet.bounds().0.y, "m");
    }
    f.add("boxes_held", "boxes held, of ten", fewest as f64, "");
    f.add("max_sag_m", "largest sag", deepest, "m");
    f.add("nodes_through", "nodes over a box", through as f64, "");
    f.add("box_speed_mps", "fastest box at the end", fastest, "m/s");
    f.add(
        "max_penetration_m",
        "deepest node",
        run.recorder.max_depth(),
        "m",
    );
    run.common_figures(&mut f);
    Ok(f)
}

/// Whether the middle of a box is over a face of the sheet and above it.
fn is_held(sheet: &Deformable, body: &RigidBody) -> bool {
    let at = wide(body.translation());
    let faces = &sheet.blueprint().faces;
    let nodes: Vec<DVec3> = sheet.positions().map(wide).collect();
    let corners = |f: &[u32; 3]| f.map(|n| nodes[n as usize]);
    faces
        .iter()
        .any(|f| height(corners(f), at).is_some_and(|y| y < at.y))
}

/// Height of a triangle over or under a point; `None` where it is beside it.
fn height([a, b, c]: [DVec3; 3], p: DVec3) -> Option<f64> {
    let cross = |a: DVec3, b: DVec3| a.x * b.z - a.z * b.x;
    let (u, v, w) = (b - a, c - a, p - a);
    let area = cross(u, v);
    let (s, t) = (cross(w, v) / area, cross(u, w) / area);
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some(a.y + s * u.y + t * v.y)
}

/// How many nodes of the sheet are over the middle of a box, or within it by more than 1 mm.
fn over(sheet: &Deformable, body: &RigidBody) -> usize {
    let (turn, at) = (body.rotation().inverse(), wide(body.translation()));
    let within = HALF - 1.0e-3;
    let nodes = sheet.positions().map(wide).filter(|p| {
        let away = *p - at;
        let inside = wide(turn * away.as_vec3()).abs().max_element() < within;
        inside || (away.y > 0.0 && away.x.hypot(away.z) < HALF)
    });
    nodes.count()
}
