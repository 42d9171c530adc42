//! Makes `hatchback.obj`: `cargo run --release --example hatchback > assets/hatchback.obj`.
//!
//! The car is a function that is negative inside, made of rounded profiles, and the surface is its dual contour on a
//! grid: one vertex per cell that the surface passes, where the tangent planes at the crossed grid edges meet. That
//! makes a closed surface by construction, keeps the edges of tyres and arches sharp, and lets the outlines of the
//! windows be drawn by moving vertices onto them. All lengths are in metres; x points forward, y up.

use crumple::body::Surface;
use crumple::math::{DMat3, DVec3, narrow};
use std::collections::BTreeMap;
use std::io::Write;

/// Axles, wheel radius, arch radius, tyre faces and the depth of the arches.
const AXLES: [f64; 2] = [1.30, -1.26];
const WHEEL: f64 = 0.31;
const ARCH: f64 = 0.42;
const TYRE: [f64; 2] = [0.665, 0.865];
const WELL: f64 = 0.715;

/// Lower body and greenhouse from the side.
const BODY: [[f64; 2]; 15] = [
    [-1.98, 0.19],
    [1.97, 0.19],
    [2.10, 0.30],
    [2.10, 0.50],
    [2.04, 0.55],
    [2.00, 0.69],
    [1.88, 0.78],
    [1.50, 0.88],
    [0.95, 0.95],
    [-1.80, 0.99],
    [-1.98, 0.96],
    [-2.03, 0.80],
    [-2.03, 0.57],
    [-2.10, 0.51],
    [-2.10, 0.32],
];
const CABIN: [[f64; 2]; 7] = [
    [-1.96, 0.80],
    [1.15, 0.80],
    [1.02, 0.92],
    [0.24, 1.42],
    [-0.35, 1.48],
    [-1.58, 1.42],
    [-1.96, 0.97],
];
/// Side windows.
const WINDOWS: [&[[f64; 2]]; 2] = [
    &[[0.78, 1.00], [0.17, 1.375], [-0.34, 1.395], [-0.34, 1.00]],
    &[
        [-0.45, 1.00],
        [-0.45, 1.395],
        [-1.12, 1.365],
        [-1.40, 1.20],
        [-1.40, 1.00],
    ],
];

/// Signed distance to a convex or concave polygon in the plane.
fn polygon(points: &[[f64; 2]], x: f64, y: f64) -> f64 {
    let mut nearest = f64::INFINITY;
    let mut inside = false;
    for (i, &[ax, ay]) in points.iter().enumerate() {
        let [bx, by] = points[(i + points.len() - 1) % points.len()];
        let (ex, ey, px, py) = (bx - ax, by - ay, x - ax, y - ay);
        let t = ((px * ex + py * ey) / (ex * ex + ey * ey)).clamp(0.0, 1.0);
        nearest = nearest.min((px - t * ex).hypot(py - t * ey));
        if (ay > y) != (by > y) && x < ax + (y - ay) * ex / ey {
            inside = !inside;
        }
    }
    if inside { -nearest } else { nearest }
}

/// Intersection of two distances with an edge rounded by `r`.
fn round_and(a: f64, b: f64, r: f64) -> f64 {
    let (u, v) = ((a + r).max(0.0), (b + r).max(0.0));
    a.max(b).min(-r) + u.hypot(v)
}

/// Union with a fillet of about `r`.
fn smooth_or(a: f64, b: f64, r: f64) -> f64 {
    let h = (r - (a - b).abs()).max(0.0) / r;
    a.min(b) - h * h * r / 4.0
}

/// Half the width of the body at x and y: narrower at both ends, the sides bulging most at door-handle height.
fn half_width(x: f64, y: f64) -> f64 {
    let nose = ((x - 0.9).max(0.0) / 1.2).powi(2) * 0.13;
    let tail = ((-x - 1.1).max(0.0) / 1.0).powi(2) * 0.08;
    0.875 - nose - tail - 0.22 * (y - 0.60).powi(2)
}

/// Half the width of the greenhouse.
fn cabin_half_width(x: f64, y: f64) -> f64 {
    let tail = ((-x - 0.9).max(0.0)).powi(2) * 0.06;
    let nose = ((x - 0.2).max(0.0)).powi(2) * 0.10;
    0.83 - 0.36 * (y - 0.92) - tail - nose
}

/// Distance to the axis of the nearest wheel.
fn axle_distance(p: DVec3) -> f64 {
    AXLES
        .iter()
        .map(|x| (p.x - x).hypot(p.y - WHEEL))
        .fold(f64::INFINITY, f64::min)
}

/// Negative inside the car, about a distance near its surface.
fn car(p: DVec3) -> f64 {
    let z = p.z.abs();
    let lower = round_and(polygon(&BODY, p.x, p.y), z - half_width(p.x, p.y), 0.07);
    let cabin = round_and(
        polygon(&CABIN, p.x, p.y),
        z - cabin_half_width(p.x, p.y),
        0.06,
    );
    let body = smooth_or(lower, cabin, 0.03);
    let axle = axle_distance(p);
    let arch = (axle - ARCH).max(WELL - z);
    let tyre = round_and(axle - WHEEL, (z - TYRE[1]).max(TYRE[0] - z), 0.03);
    body.max(-arch).min(tyre)
}

/// Central differences.
fn gradient(f: impl Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
    let e = 1.0e-4;
    let d = |v: DVec3| (f(p + v * e) - f(p - v * e)) / (2.0 * e);
    DVec3::new(d(DVec3::X), d(DVec3::Y), d(DVec3::Z))
}

/// Negative on the side windows, as far as the surface looks sideways.
fn side_glass(p: DVec3, n: DVec3) -> f64 {
    if n.z.abs() > 0.6 {
        WINDOWS
            .iter()
            .map(|w| polygon(w, p.x, p.y))
            .fold(f64::INFINITY, f64::min)
    } else {
        f64::INFINITY
    }
}

/// Negative on the windscreen and the rear window.
fn screen(p: DVec3, n: DVec3) -> f64 {
    if p.y > 0.85 && n.x.abs() > 0.25 && n.z.abs() < 0.6 {
        let low = if p.x > 0.0 { 1.0 } else { 1.05 };
        (p.z.abs() - (cabin_half_width(p.x, p.y) - 0.10))
            .max(low - p.y)
            .max(p.y - 1.37)
    } else {
        f64::INFINITY
    }
}

/// Negative on the lamps.
fn lamp(p: DVec3, n: DVec3) -> f64 {
    let z = p.z.abs();
    if n.x > 0.2 && p.x > 1.6 {
        (0.46 - z).max(0.58 - p.y).max(p.y - 0.71)
    } else if n.x < -0.3 && p.x < -1.7 {
        (0.56 - z).max(0.66 - p.y).max(p.y - 0.90)
    } else {
        f64::INFINITY
    }
}

/// Negative on the rims.
fn rim(p: DVec3, n: DVec3) -> f64 {
    let outer = n.z * p.z.signum() > 0.7 && p.z.abs() > TYRE[1] - 0.05;
    if outer {
        axle_distance(p) - 0.20
    } else {
        f64::INFINITY
    }
}

/// What has its own colour.
const OUTLINES: [fn(DVec3, DVec3) -> f64; 4] = [side_glass, screen, rim, lamp];

/// Grid lines from a first coordinate and (spacing, count) runs.
fn lines(first: f64, runs: &[(f64, usize)]) -> Vec<f64> {
    let mut out = vec![first];
    for &(step, count) in runs {
        for _ in 0..count {
            out.push(out[out.len() - 1] + step);
        }
    }
    out
}

/// Where the planes at the crossed edges of a cell meet, inside the cell.
fn vertex(planes: &[(DVec3, DVec3)], lo: DVec3, hi: DVec3) -> DVec3 {
    let n = planes.len() as f64;
    let mean = planes.iter().map(|(p, _)| *p).sum::<DVec3>() / n;
    let mut a = DMat3::from_diagonal(DVec3::splat(0.04 * n));
    let mut b = DVec3::ZERO;
    for &(p, normal) in planes {
        a += DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        b += normal * normal.dot(p - mean);
    }
    (mean + a.inverse() * b).clamp(lo, hi)
}

fn main() {
    // Finest around the wheels, where the gap of the arch must be seen; one empty cell all around.
    let x = lines(
        -2.28,
        &[
            (0.115, 5),
            (0.069, 13),
            (0.141, 12),
            (0.069, 13),
            (0.105, 6),
        ],
    );
    let y = lines(-0.115, &[(0.07, 13), (0.115, 7)]);
    let z = {
        let half = [0.14, 0.38, 0.54, 0.65, 0.74, 0.83, 0.92, 1.0];
        half.iter()
            .rev()
            .map(|v| -v)
            .chain(half)
            .collect::<Vec<f64>>()
    };
    let point = |i: usize, j: usize, k: usize| DVec3::new(x[i], y[j], z[k]);
    let (nx, ny, nz) = (x.len(), y.len(), z.len());
    let at = |i: usize, j: usize, k: usize| i + nx * (j + ny * k);
    let mut values = vec![0.0; nx * ny * nz];
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                values[at(i, j, k)] = car(point(i, j, k));
            }
        }
    }
    // Crossed grid edges: the plane there, and the four cells around as a quad seen from outside.
    let mut planes: BTreeMap<usize, Vec<(DVec3, DVec3)>> = BTreeMap::new();
    let mut quads: Vec<[usize; 4]> = Vec::new();
    let step = [1, nx, nx * ny];
    for k in 1..nz - 1 {
        for j in 1..ny - 1 {
            for i in 1..nx - 1 {
                let here = at(i, j, k);
                for axis in 0..3 {
                    let (a, b) = (values[here], values[here + step[axis]]);
                    if (a < 0.0) == (b < 0.0) {
                        continue;
                    }
                    let (mut p, mut q) = (point(i, j, k), point(i, j, k));
                    q[axis] = [
                        x[(i + 1).min(nx - 1)],
                        y[(j + 1).min(ny - 1)],
                        z[(k + 1).min(nz - 1)],
                    ][axis];
                    for _ in 0..40 {
                        let m = 0.5 * (p + q);
                        if (car(m) < 0.0) == (a < 0.0) {
                            p = m
                        } else {
                            q = m
                        }
                    }
                    let (u, v) = (step[(axis + 1) % 3], step[(axis + 2) % 3]);
                    let quad = [here - u - v, here - v, here, here - u];
                    for cell in quad {
                        planes
                            .entry(cell)
                            .or_default()
                            .push((p, gradient(car, p).normalize()));
                    }
                    quads.push(if a < 0.0 {
                        quad
                    } else {
                        [quad[3], quad[2], quad[1], quad[0]]
                    });
                }
            }
        }
    }
    let mut index = BTreeMap::new();
    let mut places = Vec::new();
    let mut marks: Vec<[f64; 4]> = Vec::new();
    for (&cell, planes) in &planes {
        let (i, j, k) = (cell % nx, cell / nx % ny, cell / nx / ny);
        let (lo, hi) = (point(i, j, k), point(i + 1, j + 1, k + 1));
        let margin = 0.04 * (hi - lo);
        let (lo, hi) = (lo + margin, hi - margin);
        let mut p = vertex(planes, lo, hi);
        let n = planes.iter().map(|(_, n)| *n).sum::<DVec3>().normalize();
        for (outline, reach) in OUTLINES.into_iter().zip([0.075, 0.07, 0.045, 0.05]) {
            // Onto the outline, along the surface, but inside the cell: no two vertices may meet.
            let mut q = p;
            for _ in 0..8 {
                let g = outline(q, n);
                let along = gradient(|p| outline(p, n), q).reject_from(n);
                if g.abs() < reach && along.length() > 0.2 {
                    q -= along * (g / along.length_squared());
                }
                let normal = gradient(car, q);
                q -= normal * (car(q).clamp(-0.02, 0.02) / normal.length_squared());
                q = q.clamp(lo, hi);
            }
            if outline(p, n).abs() < reach && car(q).abs() < 0.004 && outline(q, n).abs() < 0.02 {
                p = q;
            }
        }
        // The road is at y = 0, and a file has four decimals: what is checked must be what is written.
        p = (p.max(DVec3::new(f64::NEG_INFINITY, 0.0, f64::NEG_INFINITY)) * 1.0e4).round() / 1.0e4
            + DVec3::ZERO;
        index.insert(cell, places.len() as u32);
        places.push(p);
        marks.push(OUTLINES.map(|outline| outline(p, n)));
    }
    let mut groups: [(&str, Vec<[u32; 3]>); 5] =
        ["body", "glass", "tyre", "rim", "lamp"].map(|name| (name, Vec::new()));
    for quad in quads {
        let q = quad.map(|c| index[&c]);
        let place = |v: u32| places[v as usize];
        let off = |a: usize, b: usize| car(0.5 * (place(q[a]) + place(q[b]))).abs();
        // An outline across the quad is its diagonal; otherwise the one nearer to the surface.
        let on = |a: usize, b: usize| {
            (0..4).any(|m| {
                let g = |i: usize| marks[q[i] as usize][m];
                g(a).abs() < 0.015 && g(b).abs() < 0.015 && g((a + 1) % 4) * g((b + 1) % 4) < 0.0
            })
        };
        // Of a quad that is not convex, one diagonal folds the surface over: how far its two triangles face alike.
        let alike = |a: usize, b: usize| {
            let [p, r] = [place(q[a]), place(q[b])];
            let [s, t] = [place(q[(a + 1) % 4]), place(q[(b + 1) % 4])];
            let [n, m] = [(s - p).cross(r - p), (r - p).cross(t - p)];
            n.dot(m) / (n.length() * m.length()).max(1.0e-12)
        };
        let (fold, other) = (alike(0, 2), alike(1, 3));
        let first = if fold.min(other) < -0.2 && (fold - other).abs() > 0.2 {
            fold > other
        } else if on(0, 2) != on(1, 3) {
            on(0, 2)
        } else {
            off(0, 2) <= off(1, 3)
        };
        let pair = if first {
            [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]
        } else {
            [[q[0], q[1], q[3]], [q[1], q[2], q[3]]]
        };
        for t in pair {
            let [a, b, c] = t.map(place);
            let (centre, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize());
            // Where all corners are on an outline, its own value between them decides.
            let inside = |m: usize| {
                let sum: f64 = t
                    .iter()
                    .map(|&v| marks[v as usize][m].clamp(-1.0, 1.0))
                    .sum();
                let value = if sum.abs() < 0.03 {
                    OUTLINES[m](centre, normal)
                } else {
                    sum
                };
                value < -1.0e-3
            };
            let wheel = axle_distance(centre) < WHEEL + 0.02
                && (centre.z.abs() > WELL + 0.02 || centre.y < 0.17);
            let group = if inside(0) || inside(1) {
                1
            } else if wheel {
                if inside(2) { 3 } else { 2 }
            } else if inside(3) {
                4
            } else {
                0
            };
            groups[group].1.push(t);
        }
    }
    let surface = Surface::new(
        places.iter().map(|p| narrow(*p)).collect(),
        groups.iter().flat_map(|(_, t)| t.iter().copied()).collect(),
    );
    let checks = surface
        .check_closed()
        .and_then(|()| surface.check_self_intersection());
    eprintln!(
        "{} vertices, {} triangles, {:.3} m³, {checks:?}",
        surface.vertices.len(),
        surface.triangles.len(),
        surface.volume()
    );
    let mut text =
        String::from("# A hatchback, in metres: x forward, y up. Made by assets/hatchback.rs.\n");
    for p in &places {
        text += &format!("v {:.4} {:.4} {:.4}\n", p.x, p.y, p.z);
    }
    for (name, triangles) in &groups {
        text += &format!("g {name}\n");
        for [a, b, c] in triangles {
            text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        }
    }
    if let Err(error) = std::io::stdout().write_all(text.as_bytes()) {
        eprintln!("can't write: {error}");
    }
}
