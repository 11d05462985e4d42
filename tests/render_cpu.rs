//! The deferred path on the CPU: what must hold for any picture.

mod render;

use glam::{DMat4, DVec3};
use invertex::mesh::shapes;
use invertex::render::{Camera, Options, Output, Picture, Projection, Renderer};
use render::{camera, picture, tangents};

#[test]
fn a_closed_surface_has_no_holes_and_agrees_with_its_own_geometry() {
    let ball = tangents(shapes::icosphere(4));
    let picture = picture(&[(&ball, DMat4::IDENTITY)]);
    let view = camera(&picture, 30.0, 20.0, 201, 143);
    let image = Renderer::cpu(picture)
        .draw(&view, &Options::default())
        .unwrap();
    assert_eq!(
        (image.width, image.height, image.triangle.len()),
        (201, 143, 201 * 143)
    );
    // The sphere of radius one seen through 40 degrees: a disc without a hole.
    for y in 0..143 {
        let row = &image.triangle[y * 201..(y + 1) * 201];
        let covered: Vec<usize> = (0..201).filter(|&x| row[x] != u32::MAX).collect();
        if let (Some(first), Some(last)) = (covered.first(), covered.last()) {
            assert_eq!(last - first + 1, covered.len(), "row {y} has a hole");
        }
    }
    let radius = 143.0 / 2.0 / 1.02;
    let disc = std::f64::consts::PI * radius * radius;
    assert!(
        (image.covered_pixels as f64 - disc).abs() < 0.02 * disc,
        "{} {disc}",
        image.covered_pixels
    );
    for at in 0..image.triangle.len() {
        let covered = image.triangle[at] != u32::MAX;
        assert_eq!(image.rgba8[at * 4 + 3], if covered { 255 } else { 0 });
        let [b1, b2] = image.barycentric[at];
        assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 + 1e-6);
        assert!(!covered || (0.0..1.0).contains(&image.depth[at]));
    }
}

#[test]
fn the_same_picture_twice_is_the_same_bytes_on_any_number_of_threads() {
    let ball = tangents(shapes::icosphere(3));
    let draw = || {
        let picture = picture(&[
            (&ball, DMat4::IDENTITY),
            (&ball, DMat4::from_translation(DVec3::new(0.7, 0.3, 0.2))),
        ]);
        let view = camera(&picture, 200.0, -35.0, 65, 64);
        let mut image = Renderer::cpu(picture)
            .draw(&view, &Options::default())
            .unwrap();
        image.passes.clear();
        image
    };
    let all = draw();
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap()
        .install(draw);
    assert!(all == one);
    // Negative control: another view is another image.
    let picture = picture(&[(&ball, DMat4::IDENTITY)]);
    let view = camera(&picture, 200.1, -35.0, 65, 64);
    assert_ne!(
        Renderer::cpu(picture)
            .draw(&view, &Options::default())
            .unwrap()
            .rgba8,
        all.rgba8
    );
}

#[test]
fn from_inside_a_closed_surface_every_pixel_is_covered() {
    for mesh in [
        shapes::icosphere(3),
        shapes::uv_sphere(32, 16),
        shapes::octahedron(),
        shapes::tetrahedron(),
    ] {
        let picture = picture(&[(&mesh, DMat4::IDENTITY)]);
        let renderer = Renderer::cpu(picture);
        for (azimuth, elevation) in [(0.0, 0.0), (47.0, 12.0), (90.0, 90.0), (181.0, -60.0)] {
            // The eye of a tiny framed sphere at the middle: everything is around it, half of it behind.
            let view = Camera::framed(
                [0.01, 0.02, 0.03],
                1e-3,
                azimuth,
                elevation,
                Projection::Perspective,
                63,
                47,
            )
            .unwrap();
            let far = widen(&view);
            let image = renderer.draw(&far, &Options::default()).unwrap();
            assert_eq!(
                image.covered_pixels,
                63 * 47,
                "{} {azimuth} {elevation}",
                mesh.name
            );
        }
    }
}

/// The same eye, with the far plane beyond a unit sphere and a very near one.
fn widen(view: &Camera) -> Camera {
    let mut projection = view.projection;
    let (near, far) = (1e-4, 10.0);
    projection.z_axis.z = -far / (far - near);
    projection.w_axis.z = -far * near / (far - near);
    Camera::new(view.view, projection, view.width, view.height).unwrap()
}

#[test]
fn nothing_to_draw_and_one_pixel_are_images_too() {
    let empty = picture(&[]);
    let view = camera(&empty, 0.0, 0.0, 17, 5);
    let image = Renderer::cpu(empty)
        .draw(&view, &Options::default())
        .unwrap();
    assert_eq!((image.covered_pixels, image.mean_fetches), (0, 0.0));
    assert!(image.rgba8.iter().all(|&b| b == 0));
    let ball = shapes::icosphere(1);
    let one = picture(&[(&ball, DMat4::IDENTITY)]);
    let view = camera(&one, 0.0, 0.0, 1, 1);
    assert_eq!(
        Renderer::cpu(one)
            .draw(&view, &Options::default())
            .unwrap()
            .covered_pixels,
        1
    );
}

#[test]
fn nearer_draws_hide_farther_ones_whatever_their_order() {
    let ball = shapes::icosphere(2);
    let near = DMat4::from_translation(DVec3::new(0.0, 0.0, 3.0));
    let (a, b) = (
        picture(&[(&ball, DMat4::IDENTITY), (&ball, near)]),
        picture(&[(&ball, near), (&ball, DMat4::IDENTITY)]),
    );
    let view = camera(&a, 0.0, 0.0, 64, 64);
    let options = Options {
        output: Output::Unlit,
        ..Options::default()
    };
    let (a, b) = (
        Renderer::cpu(a).draw(&view, &options).unwrap(),
        Renderer::cpu(b).draw(&view, &options).unwrap(),
    );
    assert_eq!(a.rgba8, b.rgba8);
    let middle = 32 * 64 + 32;
    assert_eq!((a.draw[middle], b.draw[middle]), (1, 0));
}

#[test]
fn normals_of_a_sphere_point_at_the_eye_in_the_middle_and_mirroring_keeps_them_outside() {
    let ball = shapes::icosphere(4);
    for world in [
        DMat4::IDENTITY,
        DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
    ] {
        let picture: Picture = picture(&[(&ball, world)]);
        let view = camera(&picture, 0.0, 0.0, 65, 65);
        let options = Options {
            output: Output::Normals,
            ..Options::default()
        };
        let image = Renderer::cpu(picture).draw(&view, &options).unwrap();
        let n = image.linear[32 * 65 + 32];
        assert!(
            (n[0] - 0.5).abs() < 0.05 && (n[1] - 0.5).abs() < 0.05 && n[2] > 0.95,
            "{n:?}"
        );
    }
}
