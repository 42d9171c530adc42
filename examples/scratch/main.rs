#[path = "../../tests/suite/fixtures.rs"]
mod fixtures;
#[path = "../../tests/suite/support.rs"]
mod support;
#[path = "../../tests/suite/coupling/attached.rs"]
mod attached;
#[path = "../../tests/suite/validation/held.rs"]
mod held;
fn main() {
    let run = |n: &str, f: fn()| println!("== {n}: {}", if std::panic::catch_unwind(f).is_ok() { "ok" } else { "FAILED" });
    run("car", attached::a_lattice_rolls_on_rigid_wheels);
    run("net", attached::a_net_carries_a_rigid_part);
    run("bar", attached::a_bar_between_two_bodies);
    run("weld", attached::welded_nodes_lie_on_their_body);
    run("pair", attached::deformables_are_attached_to_each_other);
    run("break", held::an_attachment_breaks_at_its_strength);
    run("link", held::a_link_has_its_frequency_and_keeps_its_energy);
    run("pend", held::v27_a_rigid_pendulum);
}
