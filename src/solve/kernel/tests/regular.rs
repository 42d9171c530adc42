//! Nets whose nodes are numbered as those of a lattice are: slices without indices, until something happens to their springs.

use super::super::ranges::CALM;
use super::*;
use crate::body::Blueprint;
use crate::shape;

/// Ranges are of parts as wide as the kernel that found them. Only where there is AVX-512 do the two kernels differ.
#[test]
fn ranges_found_by_one_width_are_not_believed_by_another() {
    let material = Material::elastic(1e5, 100.0)
        .viscosity(20.0)
        .yielding(2e3, 2e3);
    let struck = |x: [f32; 3]| if x[2] > 0.9 { 2.0 } else { 0.0 };
    let (springs, start) = regular_net([7, 7, 18], false, material, struck);
    let run = |kernels: [Kernel; 2]| {
        let mut state = start.clone();
        let mut solver = Solver::new(&springs, &state);
        let mut known = 0;
        for i in 0..400 {
            solver.kernel = kernels[i / (usize::from(CALM) + 4) % 2];
            solver.substep(&mut state, Integrator::SymplecticEuler, 1e-3);
            if let Rows::Made(sell) = &solver.table.rows {
                let limits = sell.limits.as_ref().unwrap();
                let slices = limits.busy.iter().zip(&limits.untouched);
                known += slices.filter(|(b, u)| b[0] == 0 && !**u).count();
            }
        }
        (outcome(&solver, &state), known)
    };
    let (reference, _) = run([Kernel::Portable; 2]);
    assert!(reference.events.len() > 20, "{}", reference.events.len());
    for kernels in [[Kernel::Avx2; 2], [Kernel::Avx2, Kernel::Avx512]] {
        let (outcome, known) = run(kernels);
        assert!(
            outcome == reference,
            "{:?}",
            outcome.first_difference(&reference)
        );
        assert!(known > 100 || kernels[0].name() == Kernel::Portable.name());
    }
}

/// A lattice or a sheet that yields and breaks, struck where `struck` says.
pub(super) fn regular_net(
    cells: [u32; 3],
    sheet: bool,
    material: Material,
    struck: impl Fn([f32; 3]) -> f32,
) -> (Vec<Spring>, State<f32>) {
    let net = if sheet {
        let [nx, ny, _] = cells.map(|c| c as usize + 1);
        shape::sheet(1.0, 1.0, nx, ny, 0.01).unwrap()
    } else {
        let size = crate::math::Vector::from_array(cells.map(|c| 0.1 * c as f32));
        shape::lattice(size, 0.1).unwrap()
    };
    let blueprint = Blueprint::resolve(net, |_| Some(material), None).unwrap();
    let mut state = blueprint.rest_state();
    for p in &mut state.particles {
        let speed = struck(p.x);
        p.v = [speed, -0.5 * speed, 0.3 * speed];
    }
    (blueprint.springs.clone(), state)
}

fn slices_of(solver: &Solver<f32>) -> (usize, usize, usize) {
    let Rows::Made(sell) = &solver.table.rows else {
        panic!("there are rows");
    };
    let regular = sell.layout.regular.iter().filter(|r| **r).count();
    let untouched = sell.limits.iter().flat_map(|l| &l.untouched);
    let untouched = untouched.filter(|u| **u).count();
    (sell.layout.firsts.len() - 1, regular, untouched)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]
    #[test]
    fn regular_nets_give_the_bits_of_the_scalar_pass_while_they_break(
        cells in [1_u32..9, 1_u32..9, 1_u32..5],
        sheet in any::<bool>(),
        damped in any::<bool>(),
        limited in any::<bool>(),
        tough in any::<bool>(),
        drag in prop::sample::select(vec![0.0_f32, 0.3]),
        seed in any::<u64>(),
        integrator in prop::sample::select(Integrator::ALL.to_vec()),
    ) {
        let mut material = Material::elastic(1e5, 100.0);
        if damped {
            material = material.viscosity(20.0);
        }
        if limited {
            material = material.yielding(2e3, 1e4);
            material.break_strain = if tough { 2.0 } else { 0.1 };
        }
        let mut r = Numbers(seed);
        let corner = [0; 3].map(|_| r.next() as f32 - 0.5);
        let struck = |x: [f32; 3]| {
            let d: f32 = (0..3).map(|k| (x[k] - corner[k]).powi(2)).sum();
            if d < 0.05 { 20.0 } else { 0.0 }
        };
        let net = regular_net(cells, sheet, material, struck);
        // Springs one by one; speeds below any that matter are cut off by the pass over nodes of every kernel.
        let (reference, _) = run_net(&net, Some(Kernel::Portable), integrator, drag);
        for kernel in [Kernel::Avx2, Kernel::Avx512] {
            let (outcome, _) = run_net(&net, Some(kernel), integrator, drag);
            prop_assert!(outcome == reference, "{}: {:?}", kernel.name(), outcome.first_difference(&reference));
        }
    }
}

/// A lattice that is struck and yields, and breaks at such a strain.
fn struck_lattice(break_strain: f32) -> (Vec<Spring>, State<f32>) {
    let mut material = Material::elastic(1e5, 100.0).yielding(2e3, 1e4);
    material.break_strain = break_strain;
    let struck = |x: [f32; 3]| if x[2] > 0.9 { 20.0 } else { 0.0 };
    regular_net([9, 9, 20], false, material, struck)
}

#[test]
fn a_lattice_goes_on_by_steps_but_where_it_broke() {
    for break_strain in [0.1, 2.0] {
        let net = struck_lattice(break_strain);
        let portable = Some(Kernel::Portable);
        let (reference, _) = run_net(&net, portable, Integrator::SymplecticEuler, 0.0);
        let broke = reference.events.iter().filter(|e| e.1).count();
        let yielded = reference.events.len() - broke;
        assert!(
            yielded > 10 && (broke > 10) == (break_strain < 1.0),
            "{broke}"
        );
        for kernel in [Kernel::Avx2, Kernel::Avx512] {
            let (outcome, solver) = run_net(&net, Some(kernel), Integrator::SymplecticEuler, 0.0);
            assert!(
                outcome == reference,
                "{:?}",
                outcome.first_difference(&reference)
            );
            if kernel.name() == Kernel::Portable.name() {
                continue;
            }
            let (slices, regular, untouched) = slices_of(&solver);
            assert!(
                untouched > 0
                    && untouched < slices
                    && untouched <= regular
                    && (regular < slices) == (broke > 0),
                "{untouched} untouched, {regular} regular of {slices}"
            );
        }
    }
}

#[test]
fn a_lattice_numbered_at_random_has_no_steps() {
    let net = struck_lattice(0.1);
    let mut names: Vec<u32> = (0..2100).collect();
    let mut r = Numbers(4);
    for i in (1..2100).rev() {
        names.swap(i, r.below(i + 1) as usize);
    }
    let mut springs = net.0.clone();
    for spring in &mut springs {
        spring.nodes = spring.nodes.map(|n| names[n as usize]);
    }
    let mut state = net.1.clone();
    for (particle, &name) in net.1.particles.iter().zip(&names) {
        state.particles[name as usize] = *particle;
    }
    let mut solver = Solver::new(&springs, &state);
    solver.kernel = Kernel::Auto;
    solver.substep(&mut state, Integrator::SymplecticEuler, 1e-6);
    if Kernel::Auto.name() == Kernel::Portable.name() {
        return;
    }
    let (slices, regular, untouched) = slices_of(&solver);
    assert!(
        regular == 0 && untouched == slices,
        "{untouched} of {slices}"
    );
    for _ in 0..200 {
        solver.substep(&mut state, Integrator::SymplecticEuler, 1e-4);
    }
    let untouched = slices_of(&solver).2;
    assert!(
        untouched > 0 && untouched < slices,
        "{untouched} of {slices}"
    );
}
