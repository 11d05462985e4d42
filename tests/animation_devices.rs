//! Animated models on every processor: the same bytes from the CPU and each device, however the pose was come by; and the
//! forward path in motion.

#![cfg(feature = "gpu")]

mod glb;
mod moving;
mod render;

use invertex::render::{Correspond, Options, Output, Renderer, stage_posed};
use moving::{EVERY, SECONDS, built, camera, scene, subjects};
use render::differences;

/// All animated pictures of the made model at a few moments, each drawn by what `renderer` makes of a picture and then
/// reposed.
#[test]
fn every_processor_draws_the_same_frames() {
    let contexts = render::contexts();
    let built = built(scene(), "cylinder:z", &[0.3]);
    let subjects = subjects(&built, 1);
    let poses = [0.3, 1.1, SECONDS].map(|time| built.scene.pose(1, time).unwrap());
    let camera = camera(&built.scene, &poses[1], 30.0, 96);
    let staged = |correspond, pose| {
        stage_posed(&built.scene, &subjects, correspond, true, pose)
            .unwrap()
            .0
    };
    for correspond in EVERY {
        for output in [Output::Lit, Output::Normals] {
            let options = Options {
                output,
                ..Options::default()
            };
            let truth = poses.each_ref().map(|pose| {
                Renderer::cpu(staged(correspond, pose))
                    .draw(&camera, &options)
                    .unwrap()
            });
            // Negative control: another moment is another picture.
            assert!(differences(&truth[0], &truth[1])[0] > 100);
            let mut renderers = vec![Renderer::cpu(staged(correspond, &poses[0]))];
            for context in &contexts {
                renderers.push(Renderer::on(context, staged(correspond, &poses[0])).unwrap());
            }
            for renderer in &mut renderers {
                for k in [0, 1, 2, 0] {
                    renderer
                        .repose(&built.scene, &subjects, correspond, &poses[k])
                        .unwrap();
                    let image = renderer.draw(&camera, &options).unwrap();
                    assert_eq!(differences(&image, &truth[k]), [0; 6], "{correspond:?} {k}");
                }
            }
        }
    }
    for context in &contexts {
        assert_eq!(context.validation_messages(), Vec::<String>::new());
    }
}

/// The forward path in motion, against the deferred one.
#[test]
fn the_forward_path_moves_too() {
    let built = built(scene(), "cylinder:z", &[0.3]);
    let subjects = subjects(&built, 1);
    let poses = [0.3, SECONDS].map(|time| built.scene.pose(1, time).unwrap());
    let camera = camera(&built.scene, &poses[1], 30.0, 96);
    let staged = |pose| {
        stage_posed(&built.scene, &subjects, Correspond::Inverse, true, pose)
            .unwrap()
            .0
    };
    let options = Options::default();
    let [early, late] = poses
        .each_ref()
        .map(|pose| Renderer::cpu(staged(pose)).draw(&camera, &options).unwrap());
    for context in render::contexts() {
        let mut renderer = Renderer::forward(&context, staged(&poses[0])).unwrap();
        let first = renderer.draw(&camera, &options).unwrap();
        renderer
            .repose(&built.scene, &subjects, Correspond::Inverse, &poses[1])
            .unwrap();
        let second = renderer.draw(&camera, &options).unwrap();
        let flips = [(&early, &first), (&late, &second), (&early, &second)]
            .map(|(a, b)| render::flip(a, b));
        println!("{}: {flips:?}", context.info().name);
        assert!(flips[0] < 0.01 && flips[1] < 0.01, "{flips:?}");
        assert!(flips[2] > 0.05, "negative control: {flips:?}");
    }
}
