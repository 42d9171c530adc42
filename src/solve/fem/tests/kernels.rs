//! Every width of vectors against functions of nodes, bit for bit, on elements stretched, turned inside out and flat.

use super::gather::Gather;
use super::*;
use crate::solve::Solver;
use crate::solve::forces::{Force, Forces};
use crate::solve::kernel::Kernel;
use std::sync::Arc;

/// Nodes thrown about by up to 0.6 cells, and some elements made flat.
fn thrown(mesh: &TetMesh) -> State<f32> {
    let nodes = mesh.nodes.iter().enumerate().map(|(i, x)| {
        let k = i as f64;
        let wild = if i % 3 == 0 { 0.3 } else { 0.02 };
        let mut x = *x + wild * DVec3::new(k.sin(), (2.3 * k).cos(), (3.1 * k).sin());
        if i % 7 == 0 {
            x.y = 0.0;
        }
        let v = DVec3::new((1.7 * k).sin(), (0.4 * k).cos(), (2.9 * k).sin());
        let [x, v] = [x, v].map(|x| x.as_vec3().to_array());
        (x, v, 1.0)
    });
    State::new(nodes, [])
}

fn bits(forces: &[Force<f32>]) -> Vec<u32> {
    let three = |f: [f32; 4]| f.into_iter().take(3);
    let all = forces.iter();
    all.flat_map(|f| three(f.elastic).chain(three(f.damping)))
        .map(|x| (x + 0.0).to_bits())
        .collect()
}

#[test]
fn every_kernel_gives_the_bits_of_the_functions() {
    for mesh in distorted() {
        for law in SolidLaw::ALL {
            for beta in [0.0, 1e-3] {
                let solid = Solid::new(1.0e6, 0.3, 1000.0).law(law).damping(0.0, beta);
                let model = Arc::new(Model::<f32>::new(&mesh, solid).unwrap());
                let state = thrown(&mesh);
                let mut by_functions = vec![Force::<f32>::default(); mesh.nodes.len()];
                let add = |n: usize, elastic: [f32; 3], damping: [f32; 3]| {
                    for k in 0..3 {
                        by_functions[n].elastic[k] += elastic[k];
                        by_functions[n].damping[k] += if beta > 0.0 { damping[k] } else { 0.0 };
                    }
                };
                let particles = &state.particles;
                model.add_damped(|n| particles[n].x, |n| particles[n].v, add);
                let part = Part::new(model.clone(), &vec![1.0; mesh.nodes.len()]);
                let mut solver = Solver::new(&[], &state).with_elements(part);
                for kernel in [Kernel::Portable, Kernel::Avx2, Kernel::Avx512] {
                    solver.kernel = kernel;
                    solver.evaluate(&mut state.clone(), None, None, 0.0);
                    let nodes = 0..mesh.nodes.len();
                    let found: Vec<_> = nodes.map(|node| solver.forces.at(node)).collect();
                    assert!(found.iter().any(|f| f.elastic[0].abs() > 1.0));
                    assert_eq!(
                        bits(&found),
                        bits(&by_functions),
                        "{law:?} {}",
                        kernel.name()
                    );
                }
            }
        }
    }
}

/// Forces that are kept by elements and then gathered are those of the pass over the whole body, also where a body has more
/// nodes than its elements.
#[test]
fn gathered_forces_are_those_of_the_whole() {
    for mesh in distorted() {
        for beta in [0.0, 1e-3] {
            let solid = Solid::new(1.0e6, 0.3, 1000.0).damping(0.0, beta);
            let model = Model::<f32>::new(&mesh, solid).unwrap();
            let mut state = thrown(&mesh);
            state.particles.extend([state.particles[0]; 3]);
            let new = || {
                let mut forces = Forces::new(state.particles.len());
                forces.set_damped(beta > 0.0);
                forces
            };
            let (mut whole, mut gathered) = (new(), new());
            kernel::add_forces(Kernel::Auto, &model, &state.particles, &mut whole);
            let mut gather = Gather::new(model.node_count(), &model.nodes());
            gather.add_forces((Kernel::Auto, 4), &model, &state.particles, &mut gathered);
            let bits_of = |forces: &Forces<f32>| {
                let nodes = 0..state.particles.len();
                bits(&nodes.map(|node| forces.at(node)).collect::<Vec<_>>())
            };
            assert_eq!(bits_of(&gathered), bits_of(&whole));
        }
    }
}
