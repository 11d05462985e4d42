//! A scene at one moment of an animation.
//!
//! In: a scene, one of its animations, a time in seconds. Out: a [`Pose`]: where every node stands and how far its mesh
//! is morphed. Geometry is not touched; `render` moves it.

use super::animation::{Animation, Channel, Property};
use super::node::{Transform, world_matrices};
use super::{Instance, Scene};
use crate::{Error, Result};
use glam::{DMat4, DVec3};

/// Where the nodes of a scene stand at one moment, and how far their meshes are morphed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    pub(crate) world: Vec<DMat4>,
    pub(crate) weights: Vec<Vec<f64>>,
}

impl Pose {
    /// Object-to-world matrix of every node.
    pub fn world_matrices(&self) -> &[DMat4] {
        &self.world
    }

    /// For every node the weight of each morph target of its mesh.
    pub fn weights(&self) -> &[Vec<f64>] {
        &self.weights
    }
}

impl Animation {
    /// Time of the last keyframe that moves something, in seconds. It begins at 0, whenever its first keyframe is.
    pub fn duration(&self) -> f64 {
        let moving = self.channels.iter().filter(|c| c.moves());
        moving
            .map(|c| self.tracks[c.track].end())
            .fold(0.0, f64::max)
    }

    /// `time` as it is up to the end; beyond it the animation begins again from 0.
    pub fn looped(&self, time: f64) -> f64 {
        let duration = self.duration();
        if time <= duration || duration <= 0.0 {
            time
        } else {
            time % duration
        }
    }
}

impl Channel {
    /// Whether it moves something that we know.
    fn moves(&self) -> bool {
        self.node.is_some() && self.property != Property::Other
    }
}

impl Scene {
    /// The scene as it stands when nothing moves it.
    pub fn rest(&self) -> Pose {
        let weights = self.nodes.iter().map(|node| {
            let targets = node.mesh.map_or(0, |m| self.meshes[m].targets.len());
            let own = &node.weights;
            let shared = node.mesh.map(|m| &self.meshes[m].target_weights);
            let given = shared.filter(|_| own.is_empty()).unwrap_or(own);
            let weight = |k: usize| given.get(k).map_or(0.0, |&w| f64::from(w));
            (0..targets).map(weight).collect()
        });
        Pose {
            world: self.world.clone(),
            weights: weights.collect(),
        }
    }

    /// The scene `time` seconds into animation `animation` (an index). Before a track's first keyframe the first one
    /// holds, after its last one the last; see [`Animation::looped`] for the other way.
    ///
    /// # Errors
    /// [`Error::Option`] for a time that is negative or no number; [`Error::Input`] for an animation that does not exist,
    /// a rotation without length, weights that do not fit the mesh, transforms that leave the range of floats.
    pub fn pose(&self, animation: usize, time: f64) -> Result<Pose> {
        if !time.is_finite() || time < 0.0 {
            return Err(Error::Option {
                option: "--time",
                reason: format!("{time} is not a time in seconds, 0 or later"),
            });
        }
        let Some(moving) = self.animations.get(animation) else {
            return Err(self.no_animation(&animation.to_string()));
        };
        let mut pose = self.rest();
        let mut local: Vec<Transform> = self.nodes.iter().map(|node| node.transform).collect();
        for (k, channel) in moving.channels.iter().enumerate() {
            let element = || format!("animations[{animation}].channels[{k}]");
            let Some(node) = channel.node.filter(|_| channel.moves()) else {
                continue;
            };
            let track = &moving.tracks[channel.track];
            if channel.property == Property::Weights {
                self.morph(&mut pose.weights[node], node, track.sample(time), element)?;
                continue;
            }
            let moved = moved(local[node], channel.property, track, time);
            local[node] = moved.map_err(|reason| Error::input(&self.name, element(), reason))?;
        }
        pose.world = world_matrices(&self.name, &self.nodes, |i| local[i].matrix())?;
        Ok(pose)
    }

    /// The scene with every joint of its skins turned by `angle` (radians) about `axis` of its own space.
    ///
    /// # Errors
    /// [`Error::Input`] where transforms leave the range of floats.
    pub fn flexed(&self, axis: DVec3, angle: f64) -> Result<Pose> {
        let turn = DMat4::from_axis_angle(axis.normalize_or(DVec3::X), angle);
        let mut local: Vec<DMat4> = self.nodes.iter().map(|n| n.transform.matrix()).collect();
        let mut joints: Vec<usize> = self.skins.iter().flat_map(|s| s.joints.clone()).collect();
        joints.sort_unstable();
        joints.dedup();
        joints.iter().for_each(|&joint| local[joint] *= turn);
        Ok(Pose {
            world: world_matrices(&self.name, &self.nodes, |i| local[i])?,
            ..self.rest()
        })
    }

    /// Weights of `node` as an animation gives them; of a node whose mesh has no targets they mean nothing.
    fn morph(
        &self,
        weights: &mut Vec<f64>,
        node: usize,
        sampled: Vec<f64>,
        element: impl Fn() -> String,
    ) -> Result<()> {
        if weights.is_empty() {
            return Ok(());
        }
        if sampled.len() != weights.len() {
            let reason = format!(
                "{} weights for the {} morph targets of nodes[{node}]",
                sampled.len(),
                weights.len()
            );
            return Err(Error::input(&self.name, element(), reason));
        }
        *weights = sampled;
        Ok(())
    }

    /// The index of the animation called `wanted`, or whose index it is.
    ///
    /// # Errors
    /// [`Error::Input`] listing the animations there are.
    pub fn animation_named(&self, wanted: &str) -> Result<usize> {
        let named = self.animations.iter().position(|a| a.name == wanted);
        let index = || {
            let index = wanted.parse().ok();
            index.filter(|&i: &usize| i < self.animations.len())
        };
        named
            .or_else(index)
            .ok_or_else(|| self.no_animation(wanted))
    }

    fn no_animation(&self, wanted: &str) -> Error {
        let names: Vec<&str> = self.animations.iter().map(|a| a.name.as_str()).collect();
        let reason = match names.as_slice() {
            [] => "the model has no animations".to_owned(),
            _ => format!(
                "there is no such animation; there are: {}",
                names.join(", ")
            ),
        };
        Error::input(&self.name, format!("animation \"{wanted}\""), reason)
    }

    /// [`Scene::instances`] as they stand in `pose`, which is one of this scene.
    pub fn instances_in(&self, pose: &Pose) -> Vec<Instance> {
        let mut instances = self.instances();
        for instance in &mut instances {
            instance.world = pose.world[instance.node];
        }
        instances
    }
}

/// A node's transform with one property from a track.
fn moved(
    transform: Transform,
    property: Property,
    track: &super::Track,
    time: f64,
) -> Result<Transform, &'static str> {
    let (mut translation, mut rotation, mut scale) = match transform {
        Transform::Parts {
            translation,
            rotation,
            scale,
        } => (translation, rotation, scale),
        // glTF has no matrix on an animated node; one that has parts is taken apart.
        Transform::Matrix(matrix) if matrix.determinant() != 0.0 => {
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            (translation, rotation, scale)
        }
        Transform::Matrix(_) => return Err("moves a node whose matrix has no inverse"),
    };
    let vector = || DVec3::from_slice(&track.sample(time));
    match property {
        Property::Translation => translation = vector(),
        Property::Scale => scale = vector(),
        Property::Rotation => {
            rotation = track
                .rotation(time)
                .ok_or("a rotation at this time has no length")?;
        }
        Property::Weights | Property::Other => {}
    }
    Ok(Transform::Parts {
        translation,
        rotation,
        scale,
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Interpolation, Node, Track};
    use super::*;
    use crate::mesh::{Mesh, MorphTarget};
    use glam::DQuat;

    fn node(parent: Option<usize>, children: Vec<usize>, mesh: Option<usize>) -> Node {
        Node {
            name: String::new(),
            parent,
            children,
            transform: Transform::Parts {
                translation: DVec3::X,
                rotation: DQuat::IDENTITY,
                scale: DVec3::ONE,
            },
            mesh,
            skin: None,
            weights: vec![],
        }
    }

    fn track(values: &[f32]) -> Track {
        Track {
            times: vec![0.0, 2.0],
            values: values.into(),
            interpolation: Interpolation::Linear,
        }
    }

    fn channel(node: usize, property: Property, track: usize) -> Channel {
        Channel {
            node: Some(node),
            property,
            track,
        }
    }

    /// A parent that turns a quarter about z in two seconds, a child that slides and morphs.
    fn scene() -> Scene {
        let quarter = std::f32::consts::FRAC_1_SQRT_2;
        let mesh = Mesh {
            targets: vec![MorphTarget::default(); 2],
            target_weights: vec![0.25, 0.75],
            ..Mesh::default()
        };
        let nodes = vec![node(None, vec![1], None), node(Some(0), vec![], Some(0))];
        Scene {
            name: "s".into(),
            meshes: vec![mesh],
            world: world_matrices("s", &nodes, |i| nodes[i].transform.matrix()).unwrap(),
            nodes,
            roots: vec![0],
            animations: vec![Animation {
                name: "turn".into(),
                channels: vec![
                    channel(0, Property::Rotation, 0),
                    channel(1, Property::Translation, 1),
                    channel(1, Property::Weights, 2),
                    channel(0, Property::Weights, 3),
                ],
                tracks: vec![
                    track(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, quarter, quarter]),
                    track(&[1.0, 0.0, 0.0, 3.0, 0.0, 0.0]),
                    track(&[0.0, 1.0, 1.0, 0.0]),
                    track(&[1.0, 2.0]),
                ],
            }],
            ..Scene::default()
        }
    }

    #[test]
    fn parents_carry_their_children_and_weights_follow() {
        let scene = scene();
        let rest = scene.rest();
        assert_eq!(rest.weights, [vec![], vec![0.25, 0.75]]);
        assert_eq!(rest.world_matrices(), scene.world_matrices());
        let end = scene.pose(0, 2.0).unwrap();
        let at = end.world[1].transform_point3(DVec3::ZERO);
        assert!((at - DVec3::new(1.0, 3.0, 0.0)).length() < 1e-6, "{at}");
        assert_eq!(end.weights[1], [1.0, 0.0]);
        let middle = scene.pose(0, 1.0).unwrap();
        let root = 2.0 * std::f64::consts::FRAC_1_SQRT_2;
        let at = middle.world[1].transform_point3(DVec3::ZERO);
        assert!((at - DVec3::new(1.0 + root, root, 0.0)).length() < 1e-6);
        assert_eq!(middle.weights[1], [0.5, 0.5]);
        assert_eq!(scene.pose(0, 99.0).unwrap(), end, "held");
        let moving = &scene.animations[0];
        assert_eq!((moving.duration(), moving.looped(2.0)), (2.0, 2.0));
        assert_eq!(moving.looped(5.5), 1.5);
    }

    #[test]
    fn bad_moments_and_animations_are_errors() {
        let mut scene = scene();
        for time in [f64::NAN, f64::INFINITY, -0.001] {
            assert_eq!(scene.pose(0, time).unwrap_err().exit_code(), 2);
        }
        assert_eq!(scene.animation_named("turn").unwrap(), 0);
        assert_eq!(scene.animation_named("0").unwrap(), 0);
        let message = |e: Error| (e.exit_code(), e.to_string());
        let (code, text) = message(scene.animation_named("walk").unwrap_err());
        assert!(code == 3 && text.contains("walk") && text.contains("there are: turn"));
        assert_eq!(scene.pose(1, 0.0).unwrap_err().exit_code(), 3);
        let fails = |scene: &Scene, words: &str| {
            let (code, text) = message(scene.pose(0, 1.0).unwrap_err());
            assert!(code == 3 && text.contains(words), "{text}");
        };
        scene.animations[0].tracks[2].values = vec![1.0; 6];
        fails(&scene, "channels[2]: 3 weights for the 2 morph targets");
        scene.animations[0].tracks[2].values = vec![1.0; 4];
        scene.animations[0].tracks[1].values = vec![1e30; 6];
        fails(&scene, "beyond 1e15");
        scene.animations[0].tracks[0].values = vec![0.0; 8];
        fails(&scene, "channels[0]: a rotation at this time has no length");
        scene.animations.clear();
        let (_, text) = message(scene.animation_named("turn").unwrap_err());
        assert!(text.contains("has no animations"), "{text}");
    }
}
