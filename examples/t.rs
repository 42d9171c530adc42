use crumple::import::hatchback;
use crumple::shape::filled;
fn main() {
    let s = hatchback().unwrap();
    for cell in [0.12f32, 0.1, 0.08] {
        let net = filled(&s, cell).unwrap();
        let mut k = vec![0.0f64; net.nodes.len()];
        let mut worst_spring = 0.0f64;
        for sp in &net.springs {
            let [a, b] = sp.nodes.map(|n| n as usize);
            let l = net.nodes[a].position.distance(net.nodes[b].position);
            let kk = (sp.section / l) as f64;
            k[a] += kk;
            k[b] += kk;
            let r = kk * (1.0 / net.nodes[a].volume as f64 + 1.0 / net.nodes[b].volume as f64);
            worst_spring = worst_spring.max(r);
        }
        let c = cell as f64;
        let mut r: Vec<f64> = k
            .iter()
            .zip(&net.nodes)
            .map(|(k, n)| k / n.volume as f64 / (0.9 / 0.125 / c / c))
            .collect();
        r.sort_by(f64::total_cmp);
        let n = r.len();
        println!(
            "{cell}: node k/m vs cube: median {:.2} p99 {:.2} max {:.2} top {:?}; spring worst {:.2}",
            r[n / 2],
            r[n * 99 / 100],
            r[n - 1],
            &r[n - 5..],
            worst_spring * c * c
        );
    }
}
