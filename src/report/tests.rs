//! Pictures and plots as files and pixels.

use super::*;
use crate::math::{Pose, Vector};
use std::path::PathBuf;

fn file(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("crumple-{}-{name}", std::process::id()))
}

fn background() -> [u8; 3] {
    Picture::BACKGROUND.map(|c| (c * 255.0 + 0.5) as u8)
}

fn at(x: f32, y: f32, z: f32) -> Pose {
    Pose::from_translation(Vector::new(x, y, z))
}

fn front() -> Camera {
    Camera::new(Vector::new(0.0, 0.0, 10.0), Vector::ZERO)
}

/// Whether a colour is rather red than blue.
fn red(c: [u8; 3]) -> bool {
    c[0] > c[2] + 40
}

#[test]
fn an_empty_picture_is_the_background() {
    let mut picture = Picture::new(30, 20);
    picture.draw_mesh(&front(), &Mesh::default());
    picture.draw_text([2.0, 2.0], 12.0, [0.0; 3], "");
    let rgb = picture.rgb();
    assert_eq!(rgb.len(), 30 * 20 * 3);
    assert!(rgb.chunks(3).all(|p| p == background()));
    assert_eq!(picture.pixel(30, 0), None);
    assert_eq!(Picture::new(0, 0).rgb().len(), 3);
}

#[test]
fn the_nearer_triangle_hides_the_farther() {
    let near = Mesh::cuboid(Vector::splat(0.5), &at(0.0, 0.0, 2.0), [0.9, 0.1, 0.1]);
    let far = Mesh::cuboid(Vector::splat(2.0), &at(0.0, 0.0, -2.0), [0.1, 0.1, 0.9]);
    for order in [[&near, &far], [&far, &near]] {
        let mut picture = Picture::new(90, 60);
        for mesh in order {
            picture.draw_mesh(&front(), mesh);
        }
        assert!(red(picture.pixel(45, 30).unwrap()));
        let beside = picture.pixel(53, 30).unwrap();
        assert!(!red(beside) && beside != background(), "{beside:?}");
        let hidden = [Vector::new(-0.2, 0.0, -1.0), Vector::new(0.2, 0.0, -1.0)];
        let before = picture.rgb();
        picture.draw_line(&front(), hidden[0], hidden[1], [0.0; 3], 2.0);
        assert_eq!(picture.rgb(), before);
    }
}

#[test]
fn both_sides_are_lit_alike() {
    let vertices = vec![
        Vector::new(-2.0, -2.0, 0.0),
        Vector::new(2.0, -2.0, 0.0),
        Vector::new(0.0, 3.0, 0.0),
    ];
    let shots = [[0, 1, 2], [0, 2, 1]].map(|triangle| {
        let mut picture = Picture::new(30, 20);
        picture.draw_mesh(
            &front(),
            &Mesh::new(vertices.clone(), vec![triangle], [0.8; 3]),
        );
        picture.pixel(15, 10).unwrap()
    });
    assert_eq!(shots[0], shots[1]);
    assert_ne!(shots[0], background());
}

#[test]
fn what_is_not_finite_is_left_out() {
    let mut mesh = Mesh::cuboid(Vector::ONE, &Pose::IDENTITY, [0.9, 0.1, 0.1]);
    mesh.vertices[0].x = f32::NAN;
    mesh.vertices[3].y = f32::INFINITY;
    mesh.triangles.push([0, 99, 7]);
    mesh.colors.truncate(7);
    let mut picture = Picture::new(60, 40);
    for mesh in [mesh.clone(), mesh.clone().smooth()] {
        picture.draw_mesh(&front(), &mesh);
        picture.draw_outline(&front(), &mesh, [0.0; 3], 1.0);
        picture.draw_ground(
            &front(),
            &Ground {
                origin: Vector::new(0.0, -1.0, 0.0),
                ..Default::default()
            },
            &[&mesh],
        );
    }
    assert!(
        red(picture.pixel(33, 18).unwrap()),
        "the sound triangles are there"
    );
    let nowhere = Camera::new(Vector::splat(f32::NAN), Vector::ZERO);
    for camera in [nowhere, Camera::new(Vector::ONE, Vector::ONE)] {
        picture.draw_mesh(&camera, &mesh);
        picture.draw_ground(&camera, &Ground::default(), &[]);
    }
    // From within the box: everything is cut by the near plane.
    let inside = Camera::new(Vector::new(0.0, 0.0, 0.5), Vector::new(0.1, 0.2, -5.0));
    picture.draw_mesh(
        &inside,
        &Mesh::cuboid(Vector::ONE, &Pose::IDENTITY, [0.5; 3]),
    );
    picture.draw_text([f32::NAN, 0.0], 12.0, [0.0; 3], "x");
    picture.draw_text(
        [-20.0, -5.0],
        40.0,
        [0.0; 3],
        "cut off at every side of the picture",
    );
    let bar = ColorBar {
        max: f64::NAN,
        ..Default::default()
    };
    picture.draw_color_bar(&bar);
}

#[test]
fn text_draws_and_has_the_width_it_says() {
    let mut picture = Picture::new(300, 40);
    let text = "Force 12.5 kN";
    picture.draw_text([10.0, 10.0], 16.0, [0.0; 3], text);
    let width = Picture::text_width(16.0, text);
    let dark: Vec<(u32, u32)> = (0..300)
        .flat_map(|x| (0..40).map(move |y| (x, y)))
        .filter(|(x, y)| picture.pixel(*x, *y).unwrap()[0] < 128)
        .collect();
    assert!(dark.len() > 200, "{}", dark.len());
    let right = dark.iter().map(|p| p.0).max().unwrap() as f32;
    assert!((right - 10.0 - width).abs() < 3.0, "{right} {width}");
    assert!(dark.iter().all(|p| p.0 >= 9 && p.1 >= 9 && p.1 <= 27));
}

#[test]
fn the_scale_darkens_all_the_way() {
    assert_eq!(colormap(-1.0), colormap(0.0));
    assert_eq!(colormap(f32::INFINITY), colormap(1.0));
    assert_eq!(colormap(f32::NAN), [0.5; 3]);
    let light = |t: f32| {
        let [r, g, b] = colormap(t).map(|c| c.powf(2.2));
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    assert!(light(0.0) > 0.55 && light(1.0) < 0.02);
    assert!((0..100).all(|i| light(i as f32 / 100.0) > light((i + 1) as f32 / 100.0)));
}

#[test]
fn a_framed_box_fills_the_picture_and_fits() {
    let (low, high) = (Vector::new(-3.0, 0.0, -1.0), Vector::new(2.0, 1.5, 1.0));
    let mesh = Mesh::cuboid(
        0.5 * (high - low),
        &Pose::from_translation(0.5 * (low + high)),
        [0.2; 3],
    );
    assert_eq!(mesh.bounds(), Some((low, high)));
    for from in [Vector::X, Vector::Y, Vector::new(-1.0, 0.4, 2.0)] {
        let camera = Camera::framing(low, high, from, 1.5);
        let mut picture = Picture::new(90, 60);
        picture.draw_mesh(&camera, &mesh);
        let drawn = |x: u32, y: u32| picture.pixel(x, y) != Some(background());
        assert!(!(0..90).any(|x| drawn(x, 0) || drawn(x, 59)));
        assert!(!(0..60).any(|y| drawn(0, y) || drawn(89, y)));
        let columns = (0..90).filter(|x| (0..60).any(|y| drawn(*x, y))).count();
        let rows = (0..60).filter(|y| (0..90).any(|x| drawn(x, *y))).count();
        assert!(columns > 76 || rows > 50, "{columns} {rows}");
    }
}

#[test]
fn a_sheet_holds_its_pictures() {
    let mut dark = Picture::new(20, 10);
    dark.fill([0.0, 0.0], [20.0, 10.0], 1.0, |_, _| [0.0; 3]);
    let sheet = contact_sheet(&[Picture::new(20, 10), dark, Picture::new(5, 5)], 2);
    assert_eq!((sheet.width(), sheet.height()), (46, 26));
    assert_eq!(sheet.pixel(27, 3), Some([0; 3]));
    assert_eq!(sheet.pixel(0, 0), Some(background()));
    assert_eq!(sheet.pixel(22, 3), Some([255; 3]));
    assert_eq!(contact_sheet(&[], 0).width(), 1);
}

#[test]
fn files_are_written_and_errors_name_them() {
    let good = file("picture.png");
    Picture::new(7, 5).save_png(&good).unwrap();
    let size = image::image_dimensions(&good).unwrap();
    assert_eq!(size, (7, 5));
    let series = Series {
        name: "$a$".to_owned(),
        x: vec![0.0, 1.0],
        y: vec![0.0, f64::NAN],
        style: Stroke::Thin,
    };
    let plot = Plot {
        title: "t".to_owned(),
        series: vec![series],
        ..Default::default()
    };
    plot.save_png(&good).unwrap();
    assert_eq!(image::image_dimensions(&good).unwrap(), (1200, 750));
    Plot::default().save_png(&good).unwrap();
    // Nothing to span an axis, and more than one may.
    for (x, y) in [
        ([1.0, 2.0], [7.0, 7.0]),
        ([3.0, 3.0], [0.0, 0.0]),
        ([0.0, 1.0e-9], [-1.0e300, 1.0e300]),
    ] {
        let mut plot = plot.clone();
        (plot.series[0].x, plot.series[0].y) = (x.to_vec(), y.to_vec());
        plot.save_png(&good).unwrap();
    }
    std::fs::remove_file(&good).unwrap();
    let bad = file("no-such-folder").join("x.png");
    let mut uneven = plot.clone();
    uneven.series[0].x.pop();
    for error in [
        Picture::new(7, 5).save_png(&bad),
        plot.save_png(&bad),
        uneven.save_png(&bad),
    ] {
        let error = error.unwrap_err();
        assert_eq!(error.path(), bad);
        assert!(
            error.to_string().contains(&bad.display().to_string()),
            "{error}"
        );
    }
}
