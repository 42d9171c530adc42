//! Shape functions of tetrahedra, over the coordinates (ξ, η, ζ) of the corner tet 0, x, y, z; barycentric L₀ = 1 − ξ − η − ζ,
//! L₁ = ξ, L₂ = η, L₃ = ζ.
//!
//! Linear: Nᵢ = Lᵢ. Quadratic: Nᵢ = Lᵢ(2Lᵢ − 1) at corners, 4LᵢLⱼ in the middle of edges, in the order of [`EDGES`],
//! which is that of VTK and Abaqus.

/// The corners of the six edges, in the order of the middle nodes 4 to 9 of a quadratic tet.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// The corners of the four faces, counter-clockwise seen from outside.
pub const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// The place of the edge between two corners in [`EDGES`].
pub const fn edge(a: usize, b: usize) -> usize {
    let mut i = 0;
    while i < 6 {
        let [p, q] = EDGES[i];
        if (p == a && q == b) || (p == b && q == a) {
            return i;
        }
        i += 1;
    }
    6
}

/// ∂Lᵢ/∂(ξ, η, ζ).
pub const LINEAR: [[f64; 3]; 4] = [
    [-1.0, -1.0, -1.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

/// The four points of degree 2 (Hammer & Stroud 1956), as barycentric coordinates; each has a quarter of the volume.
pub const POINTS: [[f64; 4]; 4] = {
    // (5 + 3√5)/20 and (5 − √5)/20.
    const A: f64 = 0.585_410_196_624_968_5;
    const B: f64 = 0.138_196_601_125_010_5;
    [[A, B, B, B], [B, A, B, B], [B, B, A, B], [B, B, B, A]]
};

/// Derivatives by (ξ, η, ζ) of the ten quadratic shape functions at barycentric coordinates.
pub const fn quadratic_gradients(l: [f64; 4]) -> [[f64; 3]; 10] {
    let mut g = [[0.0; 3]; 10];
    let mut d = 0;
    while d < 3 {
        let mut i = 0;
        while i < 4 {
            g[i][d] = (4.0 * l[i] - 1.0) * LINEAR[i][d];
            i += 1;
        }
        let mut e = 0;
        while e < 6 {
            let [a, b] = EDGES[e];
            g[4 + e][d] = 4.0 * (l[a] * LINEAR[b][d] + l[b] * LINEAR[a][d]);
            e += 1;
        }
        d += 1;
    }
    g
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the ten quadratic shape functions at barycentric coordinates.
    const fn quadratic(l: [f64; 4]) -> [f64; 10] {
        let mut n = [0.0; 10];
        let mut i = 0;
        while i < 4 {
            n[i] = l[i] * (2.0 * l[i] - 1.0);
            i += 1;
        }
        let mut e = 0;
        while e < 6 {
            let [a, b] = EDGES[e];
            n[4 + e] = 4.0 * l[a] * l[b];
            e += 1;
        }
        n
    }

    fn barycentric(x: [f64; 3]) -> [f64; 4] {
        [1.0 - x[0] - x[1] - x[2], x[0], x[1], x[2]]
    }

    #[test]
    fn quadratic_functions_are_one_at_their_node_and_zero_at_the_others() {
        for node in 0..10 {
            let mut l = [0.0; 4];
            if node < 4 {
                l[node] = 1.0;
            } else {
                EDGES[node - 4].iter().for_each(|&c| l[c] = 0.5);
            }
            for (other, value) in quadratic(l).into_iter().enumerate() {
                assert_eq!(value, if other == node { 1.0 } else { 0.0 });
            }
        }
    }

    #[test]
    fn gradients_are_slopes_and_sum_to_zero() {
        let (x, e) = ([0.2, 0.3, 0.1], 1e-6);
        let gradients = quadratic_gradients(barycentric(x));
        for d in 0..3 {
            let at = |by: f64| {
                let mut x = x;
                x[d] += by;
                quadratic(barycentric(x))
            };
            let (plus, minus) = (at(e), at(-e));
            for n in 0..10 {
                assert!(((plus[n] - minus[n]) / (2.0 * e) - gradients[n][d]).abs() < 1e-9);
            }
            assert!(gradients.iter().map(|g| g[d]).sum::<f64>().abs() < 1e-14);
        }
    }

    #[test]
    fn the_points_integrate_quadratics_exactly() {
        // ∫LᵢLⱼ = V/20 (i ≠ j), ∫Lᵢ² = V/10.
        let mean = |f: &dyn Fn([f64; 4]) -> f64| POINTS.iter().map(|&l| f(l)).sum::<f64>() / 4.0;
        assert!((mean(&|l| l[0] * l[2]) - 0.05).abs() < 1e-15);
        assert!((mean(&|l| l[3] * l[3]) - 0.1).abs() < 1e-15);
    }

    #[test]
    fn faces_look_outward_and_edges_are_found() {
        for face in FACES {
            let [a, b, c] = face.map(|i| LINEAR_CORNERS[i]);
            let inside = 6 - face.iter().sum::<usize>();
            let (u, v) = (sub(b, a), sub(c, a));
            let normal = [
                u[1] * v[2] - u[2] * v[1],
                u[2] * v[0] - u[0] * v[2],
                u[0] * v[1] - u[1] * v[0],
            ];
            let to = sub(LINEAR_CORNERS[inside], a);
            assert!((0..3).map(|d| normal[d] * to[d]).sum::<f64>() < 0.0);
        }
        for (i, [a, b]) in EDGES.into_iter().enumerate() {
            assert_eq!((edge(a, b), edge(b, a)), (i, i));
        }
    }

    const LINEAR_CORNERS: [[f64; 3]; 4] = [[0.0; 3], LINEAR[1], LINEAR[2], LINEAR[3]];

    fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| a[i] - b[i])
    }
}
