//! What is written of any run: channels, energies, pictures.

use super::Failure;
use crumple::record::Interface;
use crumple::report::{Stage, charts, contact_sheet};
use crumple::scenario::Run;
use crumple::world::Deformable;
use std::collections::BTreeSet;
use std::path::Path;

pub fn write_channels(run: &Run, out: &Path) -> Result<(), Failure> {
    let name = |interface| match interface {
        Interface::Collider(c) => {
            let mut rigid = run.cast.rigid.iter();
            rigid.find(|r| r.2 == c).map(|r| r.0.clone())
        }
        Interface::Deformable(d) => {
            let mut all = run.cast.deformables.iter();
            all.find(|(_, h)| *h == d).map(|(n, _)| n.clone())
        }
        Interface::Attachment(a) => {
            let mut all = run.cast.attachments.iter();
            all.find(|(_, h)| *h == a).map(|(n, _)| n.clone())
        }
    };
    for (body, handle) in &run.cast.deformables {
        if let Some(record) = run.recorder.body(*handle) {
            record.write_forces(&out.join(format!("{body}_forces.csv")), name)?;
            record.write_energies(&out.join(format!("{body}_energies.csv")))?;
            let history = out.join(format!("{body}_history.csv"));
            run.recorder.write_history(record, &history)?;
        }
    }
    run.recorder.write_events(&out.join("events.csv"))?;
    Ok(())
}

pub fn draw_energies(run: &Run, out: &Path) -> Result<(), Failure> {
    for (i, (name, handle)) in run.cast.deformables.iter().enumerate() {
        if let Some(record) = run.recorder.body(*handle) {
            let file = match i {
                0 => "energies.png".to_owned(),
                _ => format!("{name}_energies.png"),
            };
            charts::energies(&format!("Energies: {}", name.replace('_', " ")), record)
                .save_png(&out.join(file))?;
        }
    }
    Ok(())
}

pub fn draw_pictures(run: &Run, out: &Path) -> Result<(), Failure> {
    let mut stage = Stage::framing(&run.frames, run.view, [1000, 560]);
    stage.ground = run.cast.collider("ground");
    stage.parts = run.cast.parts.clone();
    let plastic = run.frames.iter().flat_map(|f| &f.bodies);
    let largest = plastic
        .flat_map(|b| &b.strain)
        .fold(0.0, |m: f32, s| m.max(*s));
    if largest == 0.0 {
        stage.max_strain = 0.0;
    }
    let solid = |(_, body): (_, &Deformable)| body.tet_count() > 0;
    if run.deformables.iter().any(solid) {
        stage.label = if run.deformables.iter().all(solid) {
            "von Mises stress over E"
        } else {
            "stress / E, plastic strain"
        };
        stage.max_strain = round_up(f64::from(largest));
    }
    let name = run.cast.deformables.first();
    let name = name.map_or("scene", |(n, _)| n.as_str());
    let name = if run.cast.deformables.len() > 1 {
        "scene"
    } else {
        name
    };
    let mut pictures = Vec::new();
    let times: Vec<f64> = run.frames.iter().map(|f| f.time * 1.0e3).collect();
    let digits = digits_apart(&times);
    for (frame, time) in run.frames.iter().zip(&times) {
        let picture = stage.draw(frame);
        let width = if digits == 0 { 3 } else { digits + 4 };
        let file = format!("{name}_{time:0width$.digits$}ms.png");
        picture.save_png(&out.join(file))?;
        pictures.push(picture);
    }
    contact_sheet(&pictures, 2).save_png(&out.join(format!("{name}.png")))?;
    Ok(())
}

/// The next number of which quarters are short.
fn round_up(largest: f64) -> f64 {
    if largest <= 0.0 {
        return 0.0;
    }
    let decade = 10.0_f64.powf(largest.log10().floor());
    let steps = [1.0, 1.2, 1.6, 2.0, 2.4, 3.2, 4.0, 4.8, 6.0, 8.0, 10.0];
    let steps = steps.map(|step| step * decade);
    let fits = |step: &f64| largest <= *step;
    steps.into_iter().find(fits).unwrap_or(largest)
}

/// How many decimals tell all these numbers from each other; none where some are equal.
fn digits_apart(numbers: &[f64]) -> usize {
    let apart = |digits: &usize| {
        let mut seen = BTreeSet::new();
        let mut texts = numbers.iter().map(|x| format!("{x:.0$}", *digits));
        texts.all(|text| seen.insert(text))
    };
    (0..6).find(apart).unwrap_or(0)
}
