//! The four measures where their values are known: planes, ramps, balls.

mod pair;

use invertex::measure::{AssessSettings, Assessment, Rating, assess};
use invertex::mesh::{Mesh, shapes};
use invertex::recover::{Mapping, UvLayout};
use invertex::render::Renderer;
use pair::{Quiet, plane, scene};

fn rate(high: &Mesh, low: &Mesh, settings: &AssessSettings) -> Assessment {
    let draw = |picture| Ok(Renderer::cpu(picture));
    assess(
        &scene("high", high),
        &scene("low", low),
        settings,
        &draw,
        &Quiet,
    )
    .unwrap()
}

fn settings(mappings: &[Mapping]) -> AssessSettings {
    let mut settings = AssessSettings {
        mappings: mappings.to_vec(),
        views: 256,
        rays: 48,
        size: 64,
        ..AssessSettings::default()
    };
    settings.recovery.probes.size = 64;
    settings
}

fn of(assessment: &Assessment, mapping: Mapping) -> &Rating {
    let mut all = assessment.ratings.iter();
    all.find(|r| r.mapping == mapping).unwrap()
}

fn near(value: f64, wanted: f64, share: f64) {
    assert!((value - wanted).abs() <= share * wanted, "{value} {wanted}");
}

const FEET: [Mapping; 3] = [Mapping::Proximity, Mapping::Normal, Mapping::Cage];

/// A plane at height h over another: F(p) stands h over p. A ray at the angle a to the normal passes F(p) at h sin a and
/// meets the upper plane h tan a from it; rays over all views are as dense as cos a over the half sphere, so sin a is 2/3 in
/// the mean.
#[test]
fn a_plane_over_a_plane() {
    let h = 0.002;
    let (high, low) = (plane(3, h as f32, 0.0), plane(1, 0.0, 0.0));
    let assessment = rate(&high, &low, &settings(&FEET));
    near(assessment.diagonal, 2f64.sqrt(), 1e-5);
    for mapping in FEET {
        let rating = of(&assessment, mapping);
        near(rating.image_space_normalized, 2.0 / 3.0, 0.01);
        near(
            rating.image_space,
            2.0 / 3.0 * h * 100.0 / 2f64.sqrt(),
            0.01,
        );
        // The mean of tan a is pi / 2; rays that graze miss the upper plane.
        let whole = std::f64::consts::FRAC_PI_2 * h * 100.0 / 2f64.sqrt();
        assert!(rating.object_space < whole && rating.object_space > 0.85 * whole);
        assert!(
            rating.sampling_uniformity < 1e-4,
            "{}",
            rating.sampling_uniformity
        );
        assert_eq!(rating.missed_fraction, 0.0);
    }
}

/// A ramp of slope s over a plane: rays stretch distances along the slope by sqrt(1 + s^2), closest points shrink them by as
/// much; across it nothing changes.
#[test]
fn a_ramp_over_a_plane() {
    let s = 0.75f32;
    let mut high = plane(5, 0.0, 0.0);
    for p in &mut high.positions {
        // Long enough that feet and rays meet it everywhere.
        p[0] = 2.0 * p[0] - 0.5;
        p[1] = 2.0 * p[1] - 0.5;
        p[2] = s * (p[0] - 0.5);
    }
    let normal = [-0.6, 0.0, 0.8];
    high.normals.fill(normal);
    let assessment = rate(&high, &plane(2, 0.0, 0.0), &settings(&FEET));
    let stretched = f64::from(1.0 + s * s).sqrt();
    near(
        of(&assessment, Mapping::Normal).sampling_uniformity,
        (stretched - 1.0) / 2.0,
        1e-3,
    );
    near(
        of(&assessment, Mapping::Cage).sampling_uniformity,
        (stretched - 1.0) / 2.0,
        1e-3,
    );
    near(
        of(&assessment, Mapping::Proximity).sampling_uniformity,
        (1.0 - 1.0 / stretched) / 2.0,
        1e-3,
    );
}

/// Balls within each other: every mapping goes along radii, distances grow by the ratio of radii.
#[test]
fn a_ball_in_a_ball() {
    let mut outer = shapes::icosphere(5);
    outer.positions.iter_mut().flatten().for_each(|c| *c *= 1.1);
    let mut settings = settings(&[Mapping::Proximity, Mapping::Normal, Mapping::HybridVertex]);
    (settings.layout, settings.size) = (UvLayout::Charts, 256);
    let assessment = rate(&outer, &shapes::icosphere(5), &settings);
    for rating in &assessment.ratings {
        near(rating.image_space_normalized, 2.0 / 3.0, 0.02);
        near(rating.sampling_uniformity, 0.1, 0.03);
        let percent = 100.0 / assessment.diagonal;
        near(rating.image_space, 2.0 / 3.0 * 0.1 * percent, 0.02);
    }
}

/// What is asked of the measures is what they tell apart: a surface over itself is perfect, a torn one is not.
#[test]
fn a_surface_over_itself_and_a_shifted_one() {
    let low = plane(4, 0.0, 0.0);
    let same = rate(&low, &low, &settings(&[Mapping::Proximity]));
    let perfect = of(&same, Mapping::Proximity);
    assert!(perfect.image_space < 1e-4 && perfect.object_space < 1e-3);
    assert!(perfect.sampling_uniformity < 1e-4);
    // Steps: neighbours on either side of one are torn apart.
    let mut steps = plane(64, 0.0, 0.0);
    for p in &mut steps.positions {
        p[2] = if ((p[0] * 8.0) as u32).is_multiple_of(2) {
            0.02
        } else {
            0.05
        };
    }
    let torn = rate(
        &steps,
        &low,
        &settings(&[Mapping::Proximity, Mapping::Normal]),
    );
    // Seven steps, each between three texels, and half of one at the rim: 15 of 63 pairs of a row climb 0.015 in 1/64,
    // none of a column.
    let climbed = (1.0 + (0.015f64 * 64.0).powi(2)).sqrt() - 1.0;
    let wanted = climbed * 15.0 / 63.0 / 2.0;
    near(
        of(&torn, Mapping::Normal).sampling_uniformity,
        wanted,
        0.002,
    );
    assert!(of(&torn, Mapping::Normal).image_space > 100.0 * perfect.image_space);
}

#[test]
fn heat_adds_up_to_the_mean_over_rays_and_repeats() {
    let mut bumpy = plane(32, 0.0, 0.0);
    for p in &mut bumpy.positions {
        p[2] = 0.03 * (9.0 * p[0]).sin() * (7.0 * p[1]).cos();
    }
    let mut settings = settings(&[Mapping::Normal]);
    (settings.views, settings.heat) = (64, 16);
    let assessment = rate(&bumpy, &plane(2, 0.0, 0.0), &settings);
    let again = rate(&bumpy, &plane(2, 0.0, 0.0), &settings);
    let heat = &assessment.ratings[0].heat[0];
    assert_eq!(*heat, again.ratings[0].heat[0]);
    assert_eq!(
        assessment.ratings[0].image_space,
        again.ratings[0].image_space
    );
    let known: Vec<f32> = heat.image_space.iter().flatten().copied().collect();
    assert_eq!(known.len(), 256);
    // Rays are spread evenly over a plane, so the mean over texels is that over rays.
    let mean = known.iter().map(|v| f64::from(*v)).sum::<f64>() / 256.0;
    near(mean, assessment.ratings[0].image_space, 0.05);
}
