//! Lines of the debug picture.

use crate::fixtures::{cube, pair};
use crumple::prelude::*;
use crumple::rapier3d::prelude::*;
use crumple::world::{DebugStyle, rgba};

type Line = (Vector, Vector, [f32; 4]);

fn lines(set: &DeformableWorld, style: &DebugStyle) -> Vec<Line> {
    let mut lines = Vec::new();
    set.debug_lines(style, |a, b, color| lines.push((a, b, color)));
    lines
}

fn nothing() -> DebugStyle {
    let mut style = DebugStyle::default();
    (style.springs, style.faces, style.pinned, style.attachments) = (false, false, false, false);
    style
}

#[test]
fn springs_show_their_load() {
    let style = DebugStyle::default();
    let mut net = pair();
    net.springs[0].yield_tension = 100.0;
    let mut set = DeformableWorld::new();
    let body = set.insert(DeformableBuilder::new(net)).unwrap();
    let color_at = |set: &mut DeformableWorld, x: f32| {
        assert!(set[body].set_position(NodeId(1), Vector::X * x));
        let lines = lines(set, &style);
        assert_eq!(lines.len(), 1);
        assert!((lines[0].1.x - x).abs() < 1e-6 && lines[0].0 == Vector::ZERO);
        lines[0].2
    };
    assert_eq!(color_at(&mut set, 1.0), style.relaxed_color);
    // It flows at 0.1 m, and is never redder than that.
    let near = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
    assert!(near(color_at(&mut set, 1.1), style.tension_color));
    assert!(near(color_at(&mut set, 1.5), style.tension_color));
    let half = color_at(&mut set, 1.05);
    let expected = 0.5 * (style.relaxed_color[1] + style.tension_color[1]);
    assert!((half[1] - expected).abs() < 1e-4 && half[0] == style.tension_color[0]);
    // It never flows in compression: the strain counts.
    assert!(near(color_at(&mut set, 0.95), style.compression_color));
    set[body].set_enabled(false);
    let faint = lines(&set, &style)[0].2;
    assert!((faint[1] - 0.3 * style.compression_color[1]).abs() < 1e-6);
}

#[test]
fn broken_springs_are_not_drawn() {
    let mut net = pair();
    net.springs[0].break_force = 10.0;
    let mut set = DeformableWorld::new();
    let body = set.insert(DeformableBuilder::new(net)).unwrap();
    assert!(set[body].set_linvel_of(NodeId(1), Vector::X * 50.0));
    let mut world = PhysicsWorld::default();
    for _ in 0..3 {
        set.step(&mut world);
    }
    assert_eq!(set[body].is_broken(SpringId(0)), Some(true));
    assert!(lines(&set, &DebugStyle::default()).is_empty());
}

#[test]
fn pinned_and_attached_nodes_have_crosses_and_faces_have_sides() {
    let mut world = PhysicsWorld::default();
    let (rigid, _) = world.insert(RigidBodyBuilder::dynamic(), ColliderBuilder::ball(0.1));
    let mut set = DeformableWorld::new();
    let block = set.insert(cube(0.6)).unwrap();
    assert!(set[block].set_pinned(NodeId(4), true));
    let held = [NodeId(1), NodeId(2)];
    let handle = set.attach(block, &held, rigid, &world.bodies).unwrap();
    let mut style = nothing();
    assert!(lines(&set, &style).is_empty());
    style.pinned = true;
    let crosses = lines(&set, &style);
    assert_eq!(crosses.len(), 3);
    let at = set[block].position(NodeId(4)).unwrap().as_vec3();
    for (a, b, color) in crosses {
        assert!(((a + b) * 0.5).distance(at) < 1e-6);
        assert!((a.distance(b) - 2.0 * style.cross).abs() < 1e-6);
        assert_eq!(color, style.pinned_color);
    }
    style = nothing();
    style.attachments = true;
    assert_eq!(lines(&set, &style).len(), 6);
    assert!(set.detach(handle));
    assert!(lines(&set, &style).is_empty());
    style.faces = true;
    let faces = set[block].blueprint().faces.len();
    assert_eq!(lines(&set, &style).len(), 3 * faces);
    style.springs = true;
    let springs = set[block].spring_count();
    assert_eq!(lines(&set, &style).len(), 3 * faces + springs);
}

#[test]
fn colors_become_red_green_and_blue() {
    for (hsla, expected) in [
        ([0.0, 1.0, 0.5, 1.0], [1.0, 0.0, 0.0, 1.0]),
        ([120.0, 1.0, 0.5, 0.5], [0.0, 1.0, 0.0, 0.5]),
        ([240.0, 1.0, 0.5, 1.0], [0.0, 0.0, 1.0, 1.0]),
        ([60.0, 1.0, 0.25, 1.0], [0.5, 0.5, 0.0, 1.0]),
        ([77.0, 0.0, 0.3, 1.0], [0.3, 0.3, 0.3, 1.0]),
    ] {
        for (found, expected) in rgba(hsla).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{hsla:?}");
        }
    }
}

/// Rapier's backends get the same lines, after their filter has been asked once per body.
#[cfg(feature = "debug-render")]
#[test]
fn a_backend_of_rapier_draws_the_same_lines() {
    use crumple::rapier3d::pipeline::{DebugRenderBackend, DebugRenderObject};

    #[derive(Default)]
    struct Backend {
        lines: Vec<Line>,
        asked: std::cell::Cell<usize>,
        hidden: u128,
    }

    impl DebugRenderBackend for Backend {
        fn filter_object(&self, object: DebugRenderObject) -> bool {
            self.asked.set(self.asked.get() + 1);
            matches!(object, DebugRenderObject::RigidBody(_, b) if b.user_data != self.hidden)
        }

        fn draw_line(&mut self, _: DebugRenderObject, a: Vector, b: Vector, color: [f32; 4]) {
            self.lines.push((a, b, color));
        }
    }

    let mut set = DeformableWorld::new();
    set.insert(cube(0.6).user_data(1)).unwrap();
    set.insert(DeformableBuilder::new(pair()).user_data(2))
        .unwrap();
    let style = DebugStyle::default();
    let mut all = Backend::default();
    set.debug_render(&style, &mut all);
    assert_eq!((all.asked.get(), all.lines), (2, lines(&set, &style)));
    let mut one = Backend {
        hidden: 1,
        ..Backend::default()
    };
    set.debug_render(&style, &mut one);
    assert_eq!(one.lines.len(), 1);
}
