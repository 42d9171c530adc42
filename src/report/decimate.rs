//! Fewer points for the same curve: a plot is about a thousand pixels wide, a channel has a hundred thousand samples.
//!
//! Taking every n-th sample loses the peaks that a crash is judged by. Instead each run of successive points that falls
//! into one pixel column becomes its first, lowest, highest and last point, in their order: what is drawn is the same
//! to the pixel. Runs follow the order of the points and not of x, so loops (force over displacement) keep their shape.

/// A polyline without gaps.
pub type Line = Vec<(f64, f64)>;

/// The curve in pieces without gaps (points that are not finite are gaps), thinned to `columns` over its own range of x.
pub fn decimate(x: &[f64], y: &[f64], columns: usize) -> Vec<Line> {
    let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let points: Line = x.iter().copied().zip(y.iter().copied()).collect();
    let (low, high) = points
        .iter()
        .filter(|p| finite(p))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |r, p| {
            (r.0.min(p.0), r.1.max(p.0))
        });
    let scale = columns as f64 / (high - low).max(f64::MIN_POSITIVE);
    let mut pieces = Vec::new();
    for piece in points.split(|p| !finite(p)).filter(|p| !p.is_empty()) {
        let mut line = Line::new();
        for run in
            piece.chunk_by(|a, b| ((a.0 - low) * scale).floor() == ((b.0 - low) * scale).floor())
        {
            thin(run, &mut line);
        }
        pieces.push(line);
    }
    pieces
}

/// First, lowest, highest and last point of a run, each once, in their order.
fn thin(run: &[(f64, f64)], line: &mut Line) {
    let (mut low, mut high) = (0, 0);
    for (i, p) in run.iter().enumerate() {
        if p.1 < run[low].1 {
            low = i;
        }
        if p.1 > run[high].1 {
            high = i;
        }
    }
    let mut keep = [0, low.min(high), low.max(high), run.len() - 1].to_vec();
    keep.dedup();
    line.extend(keep.into_iter().map(|i| run[i]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_and_ends_stay() {
        let x: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut y: Vec<f64> = x.iter().map(|x| (x * 0.1).sin()).collect();
        (y[31_415], y[77_777]) = (50.0, -70.0);
        let pieces = decimate(&x, &y, 1000);
        assert_eq!(pieces.len(), 1);
        let line = &pieces[0];
        assert!(line.len() <= 4 * 1001, "{}", line.len());
        for p in [
            (31_415.0, 50.0),
            (77_777.0, -70.0),
            (0.0, 0.0),
            (99_999.0, y[99_999]),
        ] {
            assert!(line.contains(&p), "{p:?}");
        }
        assert!(line.windows(2).all(|w| w[0].0 < w[1].0));
    }

    #[test]
    fn gaps_split_and_short_curves_stay() {
        let nan = f64::NAN;
        let pieces = decimate(&[0.0, 1.0, 2.0, 3.0], &[5.0, nan, 6.0, 7.0], 10);
        assert_eq!(pieces, [vec![(0.0, 5.0)], vec![(2.0, 6.0), (3.0, 7.0)]]);
        assert_eq!(decimate(&[nan], &[nan], 10), Vec::<Line>::new());
        assert_eq!(
            decimate(&[2.0, 2.0], &[1.0, 3.0], 10),
            [vec![(2.0, 1.0), (2.0, 3.0)]]
        );
    }
}
