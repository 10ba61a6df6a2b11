//! Where rays go, and what is refused.

use super::*;
use crate::scene::SurfaceMeter;
use glam::{DAffine3, DMat3};

const FILM: Film = Film::sized(400, 200);

fn camera(matrix3: DMat3, projection: Projection) -> Camera {
    Camera { to_world: DAffine3 { matrix3, translation: DVec3::new(5.0, 6.0, 7.0) }, projection, is_placed: true }
}

fn perspective(fov_y_deg: f64) -> Projection {
    Projection::Perspective { fov_y_rad: fov_y_deg.to_radians() }
}

fn lens(lens_radius: f64, focus_distance: f64) -> Projection {
    Projection::ThinLens { fov_y_rad: 1.0, lens_radius, focus_distance: Some(focus_distance) }
}

fn recorded(camera: &Camera) -> Result<CameraRecord, String> {
    record(&Scene { camera: camera.clone(), film: FILM, ..Scene::default() })
}

/// The start through `film` with all random words equal.
fn through(camera: &Camera, film: [f64; 2], word: u32) -> Start {
    let record = recorded(camera).unwrap();
    start(&View { camera: &record, elements: &[], alias: &[] }, film.into(), &|_| word)
}

#[track_caller]
fn close(a: DVec3, b: DVec3) {
    assert!((a - b).length() < 1e-6, "{a} {b}");
}

#[test]
fn every_projection_has_one_camera_and_no_radius_is_a_pinhole() {
    let surface = || SurfaceMeter { shapes: vec![], is_back: false };
    for (projection, keyword) in [
        (perspective(40.0), "perspective"),
        (lens(0.0, 1.0), "perspective"),
        (lens(0.1, 1.0), "thin_lens"),
        (lens(f64::NAN, 1.0), "thin_lens"),
        (Projection::Orthographic { half_width: 0.0, half_height: 1.0 }, "orthographic"),
        (Projection::Panorama, "panorama"),
        (Projection::MeterRay, "meter_ray"),
        (Projection::MeterPoint, "meter_point"),
        (Projection::MeterSurface(surface()), "meter_surface"),
        (Projection::MeterLeaving(surface()), "meter_leaving"),
    ] {
        assert_eq!(MODELS[kind(&projection)].keyword, keyword);
        assert_eq!(MODELS.iter().filter(|m| (m.claims)(&projection)).count(), 1, "{keyword}");
    }
    let pinhole = recorded(&camera(DMat3::IDENTITY, Projection::Perspective { fov_y_rad: 1.0 })).unwrap();
    assert_eq!(recorded(&camera(DMat3::IDENTITY, lens(0.0, 3.0))).unwrap(), pinhole);
}

#[test]
fn the_middle_looks_forward_and_the_edges_span_the_field_of_view() {
    // Scaled axes: only their directions count.
    let camera = camera(DMat3::from_diagonal(DVec3::new(3.0, 0.5, 2.0)), perspective(60.0));
    let tan = 30f64.to_radians().tan();
    for (film, d) in [
        ([200.0, 100.0], DVec3::NEG_Z),
        ([200.0, 0.0], DVec3::new(0.0, tan, -1.0)),
        ([200.0, 200.0], DVec3::new(0.0, -tan, -1.0)),
        ([400.0, 0.0], DVec3::new(2.0 * tan, tan, -1.0)),
    ] {
        close(through(&camera, film, 0).direction, d.normalize());
    }
}

#[test]
fn rays_through_a_lens_meet_in_the_plane_of_focus() {
    let camera = camera(DMat3::IDENTITY, lens(0.25, 4.0));
    let focus = 4.0 * DVec3::new(0.5f64.tan() * 1.0, 0.25 * 0.5f64.tan() * 2.0, -1.0);
    for word in [0, 1 << 30, 1 << 31, 3 << 30, u32::MAX] {
        let start = through(&camera, [300.0, 50.0], word);
        assert!(start.origin.length() <= 0.25 + 1e-7 && start.origin.z == 0.0, "{start:?}");
        close(start.origin + start.direction * (focus.z / start.direction.z), focus);
    }
    // The words reach the rim.
    close(through(&camera, [0.0, 0.0], 0).origin, DVec3::new(-0.25, -0.25, 0.0) / 2f64.sqrt());
}

#[test]
fn parallel_rays_keep_pixels_square() {
    let seen = |half_width, half_height| {
        let camera = camera(DMat3::IDENTITY, Projection::Orthographic { half_width, half_height });
        let start = through(&camera, [400.0, 0.0], 0);
        close(start.direction, DVec3::NEG_Z);
        start.origin
    };
    // The film is twice as wide as high.
    close(seen(0.0, 1.5), DVec3::new(3.0, 1.5, 0.0));
    close(seen(3.0, 1.5), DVec3::new(3.0, 1.5, 0.0));
    close(seen(4.0, 1.0), DVec3::new(4.0, 2.0, 0.0));
}

#[test]
fn a_panorama_is_laid_out_as_a_sky() {
    let camera = camera(DMat3::IDENTITY, Projection::Panorama);
    let view = |x: f64, y: f64| through(&camera, [x, y], 0).direction;
    close(view(200.0, 100.0), DVec3::NEG_Z);
    close(view(300.0, 100.0), DVec3::X);
    close(view(0.0, 100.0), DVec3::Z);
    close(view(123.0, 0.0), DVec3::Y);
    for (x, y) in [(17.0, 33.0), (350.0, 180.0), (210.0, 99.0)] {
        let d = view(x, y);
        let (u, v) = (0.5 + d.x.atan2(-d.z) / std::f64::consts::TAU, d.y.acos() / std::f64::consts::PI);
        assert!((u * 400.0 - x).abs() < 1e-4 && (v * 200.0 - y).abs() < 1e-4, "{u} {v}");
    }
}

#[test]
fn cameras_that_show_nothing_are_refused() {
    let ortho = |half_height| Projection::Orthographic { half_width: 0.0, half_height };
    let nan = DMat3::from_diagonal(DVec3::new(1.0, f64::NAN, 1.0));
    let flat = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Z);
    for (axes, projection, word) in [
        (nan, perspective(60.0), "finite"),
        (flat, perspective(60.0), "degenerate"),
        (flat, Projection::MeterPoint, "degenerate"),
        (nan, Projection::Panorama, "finite"),
        (DMat3::IDENTITY, perspective(0.0), "field of view"),
        (DMat3::IDENTITY, perspective(180.0), "field of view"),
        (DMat3::IDENTITY, perspective(f64::NAN), "field of view"),
        (DMat3::IDENTITY, perspective(180.0 - 1e-12), "too near 180"),
        (DMat3::IDENTITY, lens(-1.0, 1.0), "lens radius"),
        (DMat3::IDENTITY, lens(f64::NAN, 1.0), "lens radius"),
        (DMat3::IDENTITY, lens(0.1, 0.0), "focus distance"),
        (DMat3::IDENTITY, lens(0.1, f64::INFINITY), "focus distance"),
        (DMat3::IDENTITY, ortho(0.0), "extent"),
        (DMat3::IDENTITY, ortho(f64::NAN), "extent"),
    ] {
        let error = recorded(&camera(axes, projection.clone())).unwrap_err();
        assert!(error.contains(word), "{projection:?}: {error}");
    }
    // Nearly 180 degrees, and a film of extreme shape.
    let wide = Camera { projection: perspective(179.99), ..Camera::default() };
    let strip = Scene { camera: wide, film: Film { width: 65_536, height: 1, ..FILM }, ..Scene::default() };
    assert!(record(&strip).is_ok());
}
