//! Cuts on devices: the processor's triangles, byte for byte, whatever is looked at, with and without memory.
#![cfg(feature = "gpu")]

mod camera;
mod devices;
mod parted;

use camera::{looking, parallel, perspective};
use devices::on_every_device;
use glam::DVec3;
use invertex::lod::multiresolution::gpu::{MOST_VIEWS, Selector};
use invertex::lod::multiresolution::{
    Criterion, Hierarchy, Limits, Memory, Multiresolution, Seen, StepColours, View,
};
use invertex::lod::progressive::colour::Distance;
use invertex::lod::progressive::{Cost, Progressive};
use invertex::mesh::shapes;
use invertex::param::PrimaryKind;
use parted::Model;

/// A sphere whose colours are off by anything.
fn sphere(subdivisions: u32, coloured: bool) -> Hierarchy {
    let model = Model::new(shapes::icosphere(subdivisions), PrimaryKind::Sphere);
    let history = Progressive::new(&model.input(), Cost::Displacement, 4);
    let code = |k: usize| [(k * 37 % 120) as u8, (k * 91 % 90) as u8];
    let colours = StepColours {
        distance: Distance::Lab,
        footprint: 0.002,
        levels: 5,
        codes: (0..history.collapses.len() * 5).map(code).collect(),
    };
    Hierarchy::new(history, &model.mesh.positions, coloured.then_some(colours))
}

/// The `i`th of views all over the place.
fn view(model: &Multiresolution, i: u64) -> View {
    let b = |k: u64| parted::spread(i * 11 + k)[0];
    let towards = DVec3::new(b(1) - 0.4, b(2) - 0.3, b(3) - 0.4).normalize();
    let seen = Seen {
        object_to_view: looking(
            towards * 10f64.powf(2.0 * b(4) - 0.2),
            DVec3::new(b(5), b(6), 0.1) * 0.5,
            DVec3::new(0.1, 1.0, 0.2),
        ),
        projection: match i % 5 {
            0 => parallel(1.0 + b(7), 1.5),
            _ => perspective(0.1 + 0.6 * b(7), 1.5),
        },
        size: [300, 200],
        double_sided: i.is_multiple_of(3),
    };
    let limits = Limits {
        pixels: [0.5, 0.0, 4.0][(i % 3) as usize],
        criterion: match i / 2 % 6 {
            0 => Criterion::Displacement,
            3 => Criterion::Surface,
            1 | 4 => Criterion::Colour(2.0),
            _ => Criterion::Colour(20.0),
        },
        hysteresis: [1.0, 0.7][(i / 3 % 2) as usize],
        outside: i.is_multiple_of(2),
    };
    model.view(&seen, &limits).unwrap()
}

#[test]
fn devices_cut_as_the_processor_does() {
    for (hierarchy, triangles) in [(sphere(5, true), 20_480), (sphere(3, false), 1280)] {
        let model = &hierarchy.model;
        assert!(model.levels.len() > 1);
        on_every_device(|context| {
            let mut selector = Selector::new(context, model, triangles).unwrap();
            let mut memory = Memory::default();
            let mut sizes = std::collections::BTreeSet::new();
            for i in 0..60 {
                let views: Vec<View> = (0..1 + i % 3).map(|k| view(model, i + k)).collect();
                let here = model.select(&views, &mut memory);
                let (there, _) = selector.select(&views).unwrap();
                assert_eq!(
                    here.faces,
                    there.faces,
                    "picture {i} on {}",
                    context.info().name
                );
                let indices: Vec<u32> = context.download(selector.indices()).unwrap();
                let numbers: Vec<u32> = context.download(selector.numbers()).unwrap();
                let triangles = indices.chunks(3).zip(numbers).take(here.faces.len());
                assert!(
                    triangles
                        .clone()
                        .all(|(t, f)| model.faces[f as usize].corners == t)
                );
                sizes.insert(here.faces.len());
            }
            assert!(sizes.len() > 10);
        });
    }
}

#[test]
fn too_many_instances_are_refused() {
    let hierarchy = sphere(2, false);
    let views = vec![view(&hierarchy.model, 1); MOST_VIEWS + 1];
    on_every_device(|context| {
        let selector = Selector::new(context, &hierarchy.model, 320).unwrap();
        assert_eq!(selector.write_views(&views).unwrap_err().exit_code(), 3);
        selector.write_views(&views[1..]).unwrap();
    });
}

#[test]
fn what_differs_is_seen() {
    // The negative control: another limit on the device than on the processor.
    let hierarchy = sphere(4, false);
    on_every_device(|context| {
        let mut selector = Selector::new(context, &hierarchy.model, 5120).unwrap();
        let differs = (0..10).any(|i| {
            let mut other = view(&hierarchy.model, i);
            let here = hierarchy.model.select(&[other], &mut Memory::default());
            other.pixels = other.pixels.map(|p| p * 0.5 + 0.1);
            selector.select(&[other]).unwrap().0.faces != here.faces
        });
        assert!(differs);
    });
}
