//! The energies that change with some of a body's nodes: those of the nodes, and of the springs and tets at them. To add up
//! the whole body for a few nodes that are moved would cost more than to move them.

use super::Deformable;
use super::energies::Energies;
use crate::body::Blueprint;
use crate::body::incidence::Incidence;

/// The springs and tets at each node of a body. Both keep their nodes for as long as there is a body: what breaks has no
/// stiffness and stays where it was.
#[derive(Debug)]
pub(super) struct Incident {
    springs: Incidence,
    tets: Option<Incidence>,
}

impl Incident {
    fn of(blueprint: &Blueprint) -> Self {
        let nodes = blueprint.nodes.len();
        let springs = blueprint.springs.iter().map(|s| &s.nodes[..]);
        let solid = blueprint.solid.as_ref();
        Self {
            springs: Incidence::new(nodes, springs),
            tets: solid.map(|s| Incidence::new(nodes, s.mesh.tets.iter())),
        }
    }
}

/// Some nodes of a body, and the springs and tets at them, each once and in ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Subset {
    pub nodes: Vec<u32>,
    pub springs: Vec<u32>,
    pub tets: Vec<u32>,
}

impl Deformable {
    /// Such of its nodes, with what is at them.
    pub(super) fn subset(&self, nodes: impl IntoIterator<Item = u32>) -> Subset {
        let mut nodes: Vec<u32> = nodes.into_iter().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let new = || Incident::of(&self.blueprint).into();
        let incident = self.incident.get_or_init(new);
        let tets = incident.tets.as_ref();
        Subset {
            springs: incident.springs.at_any(&nodes),
            tets: tets.map_or(Vec::new(), |tets| tets.at_any(&nodes)),
            nodes,
        }
    }

    /// What of its energies is in these nodes, springs and tets. Links of attachments and work so far are counted whole.
    pub(super) fn energies_in(&self, subset: &Subset) -> Energies {
        let [nodes, springs, tets] = [&subset.nodes, &subset.springs, &subset.tets]
            .map(|list| list.iter().map(|i| *i as usize));
        self.energies_of(nodes, springs, tets)
    }

    /// Books a change as [`Self::edit`] does, of such nodes alone.
    pub(super) fn edit_at<T>(
        &mut self,
        nodes: impl IntoIterator<Item = u32>,
        change: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let subset = self.subset(nodes);
        self.edit_by(|body| body.energies_in(&subset), change)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Material, NodeId, Solid};
    use crate::math::{DVec3, Vector};
    use crate::shape::{self, TetSplit};
    use crate::solve::Integrator;
    use crate::world::DeformableBuilder;

    /// Shaken, so that every element of it has energy and power.
    fn shaken(builder: DeformableBuilder, scheme: Integrator) -> Deformable {
        let mut body = builder.integrator(scheme).build().unwrap();
        body.solver.external.gravity = [0.3, -9.8, 1.1];
        body.h = 1e-3;
        for i in 0..body.node_count() {
            let noise = |k: f64| (i as f64 * k).sin();
            let by = DVec3::new(noise(1.3), noise(2.7), noise(4.1));
            let place = body.state.position(i) + 0.02 * by;
            body.state.set_position(i, place);
            body.state.set_velocity(i, 3.0 * by);
        }
        body
    }

    /// A net of which some springs have flowed and some have broken, and solids of both kinds of tets.
    fn bodies(scheme: Integrator) -> [Deformable; 3] {
        let material = Material::mild_steel_foam();
        let net = shape::lattice(Vector::new(0.6, 0.4, 0.4), 0.1);
        let mut net = shaken(DeformableBuilder::new(net).material(material), scheme);
        for spring in (0..net.spring_count()).step_by(3) {
            net.state.flow[spring] = 0.003;
            net.state.broken[spring] = spring % 2 == 0;
        }
        net.rebuild_table();
        assert!(!net.solver.table.limits.is_empty());
        let solid = |quadratic| {
            let mesh = shape::tet_box(Vector::splat(0.3), 0.1, TetSplit::Six).unwrap();
            let mesh = if quadratic { mesh.quadratic() } else { mesh };
            shaken(
                DeformableBuilder::tets(mesh, Solid::new(1e6, 0.3, 1e3)),
                scheme,
            )
        };
        [net, solid(false), solid(true)]
    }

    #[test]
    fn what_moving_nodes_changes_is_all_in_their_subset() {
        for scheme in [Integrator::SymplecticEuler, Integrator::VelocityVerlet] {
            for body in bodies(scheme) {
                let count = body.node_count() as u32;
                for nodes in [vec![0], vec![count / 2], vec![1, count - 1, 7, 1, 8]] {
                    let subset = body.subset(nodes);
                    let mut moved = body.clone();
                    for &node in &subset.nodes {
                        let node = node as usize;
                        let place = body.state.position(node) + DVec3::new(0.01, 0.02, -0.03);
                        moved.state.set_position(node, place);
                        let v = -2.0 * body.state.velocity(node);
                        moved.state.set_velocity(node, v);
                    }
                    let local =
                        moved.energies_in(&subset).balance() - body.energies_in(&subset).balance();
                    let (old, new) = (body.energies(), moved.energies());
                    let miss = local - (new.balance() - old.balance());
                    let scale = new.scale().max(old.scale());
                    assert!(miss.abs() < 1e-13 * scale, "{scheme:?} {miss} of {scale}");
                }
            }
        }
    }

    #[test]
    fn a_subset_is_no_more_than_what_is_at_its_nodes() {
        let [net, linear, quadratic] = bodies(Integrator::VelocityVerlet);
        let at = |body: &Deformable, node: u32| {
            let springs = &body.blueprint.springs;
            let tets = body.blueprint.solid.iter();
            let mut tets = tets.flat_map(|s| s.mesh.tets.iter()).collect::<Vec<_>>();
            tets.retain(|t| t.contains(&node));
            let springs = springs.iter().filter(|s| s.nodes.contains(&node)).count();
            (springs, tets.len())
        };
        for body in [&net, &linear, &quadratic] {
            for node in 0..body.node_count() as u32 {
                let subset = body.subset([node, node]);
                assert_eq!(subset.nodes, [node]);
                assert_eq!((subset.springs.len(), subset.tets.len()), at(body, node));
            }
        }
    }

    /// Symptom: a setter of one node cost as much as the whole body. Its work is that of the whole body still.
    #[test]
    fn setters_of_single_nodes_book_what_the_whole_body_gains() {
        for body in bodies(Integrator::SymplecticEuler) {
            let node = NodeId(5);
            let changes: [fn(&mut Deformable, NodeId) -> bool; 3] = [
                |body, node| body.set_position(node, Vector::new(0.1, 0.3, 0.0)),
                |body, node| body.set_linvel_of(node, Vector::new(5.0, -3.0, 2.0)),
                |body, node| body.set_pinned(node, true),
            ];
            for change in changes {
                let mut changed = body.clone();
                assert!(change(&mut changed, node));
                let (old, new) = (body.energies(), changed.energies());
                assert_ne!(old.work.external, new.work.external);
                let miss = new.balance() - old.balance();
                assert!(miss.abs() < 1e-13 * new.scale(), "{miss}");
            }
        }
    }
}
