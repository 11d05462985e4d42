//! Lit shading: twin of `glsl/render/light.glsl`.
//!
//! In: a [`Surface`], the unit directions to the eye and to the light. Out: linear RGB. glTF's metallic-roughness model
//! (appendix B of its specification: GGX, Smith visibility, Schlick's Fresnel) under one directional light, plus a
//! constant ambient light that metals reflect in their own colour.

use crate::attribute::arithmetic::{V3, add3, dot3, scale3, unit3};
use crate::attribute::surface::Surface;

/// Light that `surface` sends towards the eye. `light` is the unit direction to the light.
pub(crate) fn lit(surface: &Surface, eye: V3, light: V3, intensity: f32, ambient: f32) -> V3 {
    let n = surface.normal;
    let nl = dot3(n, light).max(0.0);
    let nv = dot3(n, eye).max(0.001);
    let h = unit3(add3(light, eye), n);
    let nh = dot3(n, h).max(0.0);
    let vh = dot3(eye, h).max(0.0);
    let alpha = (surface.roughness * surface.roughness).max(0.002);
    let a2 = alpha * alpha;
    let d = (nh * nh) * (a2 - 1.0) + 1.0;
    let smith_v = nl * ((nv * nv) * (1.0 - a2) + a2).sqrt();
    let smith_l = nv * ((nl * nl) * (1.0 - a2) + a2).sqrt();
    // Distribution times visibility, times pi: a white diffuse surface that faces the light returns `intensity`.
    let specular = (a2 / (d * d)) * (0.5 / (smith_v + smith_l).max(1e-6));
    let p = (1.0 - vh).max(0.0);
    let p5 = (p * p) * (p * p) * p;
    let matte = 1.0 - surface.metallic;
    let radiance = nl * intensity;
    let around = ambient * surface.occlusion;
    std::array::from_fn(|i| {
        let base = surface.base[i];
        let f0 = 0.04 * matte + base * surface.metallic;
        let fresnel = f0 + (1.0 - f0) * p5;
        let direct = (base * matte * (1.0 - fresnel) + specular * fresnel) * radiance;
        let indirect = (base * matte + f0) * around;
        direct + indirect + surface.emissive[i]
    })
}

/// Unit direction and intensity of a light given as one vector.
pub(crate) fn split(light: V3) -> (V3, f32) {
    let intensity = dot3(light, light).sqrt();
    (unit3(light, [0.0, 1.0, 0.0]), intensity)
}

/// Unit direction from a world position to the eye, or the parallel one where `eye` is a direction.
pub(crate) fn towards_eye(eye: [f32; 4], position: V3) -> V3 {
    let [x, y, z, w] = eye;
    if w == 0.0 {
        return [x, y, z];
    }
    unit3(add3([x, y, z], scale3(position, -1.0)), [0.0, 0.0, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matte() -> Surface {
        Surface {
            base: [1.0; 4],
            normal: [0.0, 0.0, 1.0],
            roughness: 1.0,
            occlusion: 1.0,
            ..Surface::default()
        }
    }

    #[test]
    fn no_light_is_dark_and_ambient_is_occluded() {
        let mut s = matte();
        assert_eq!(
            lit(&s, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, 0.0),
            [0.0; 3]
        );
        let open = lit(&s, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, 0.5)[0];
        s.occlusion = 0.5;
        assert_eq!(
            lit(&s, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0], 1.0, 0.5)[0],
            open / 2.0
        );
    }

    #[test]
    fn energy_is_not_created_and_light_is_reciprocal() {
        // A white furnace by directional sums: integral over the hemisphere of the eye, cosine weighted, is at most one.
        for roughness in [0.3f32, 0.6, 1.0] {
            for metallic in [0.0f32, 1.0] {
                let s = Surface {
                    roughness,
                    metallic,
                    ..matte()
                };
                let light = unit3([0.3, 0.1, 0.8], [0.0; 3]);
                let (mut sum, steps) = (0f64, 200);
                for i in 0..steps {
                    for j in 0..steps {
                        let u = (i as f32 + 0.5) / steps as f32;
                        let phi = (j as f32 + 0.5) / steps as f32 * std::f32::consts::TAU;
                        // Cosine-weighted directions: the mean of the returned light is the reflectance.
                        let eye = [u.sqrt() * phi.cos(), u.sqrt() * phi.sin(), (1.0 - u).sqrt()];
                        sum += f64::from(lit(&s, eye, light, 1.0, 0.0)[0] / light[2]);
                    }
                }
                let reflected = sum / f64::from(steps * steps);
                assert!(
                    reflected < 1.02 && reflected > 0.3,
                    "{roughness} {metallic}: {reflected}"
                );
            }
        }
        let (a, b) = (
            unit3([0.3, 0.1, 0.8], [0.0; 3]),
            unit3([-0.5, 0.2, 0.6], [0.0; 3]),
        );
        let s = Surface {
            roughness: 0.5,
            metallic: 1.0,
            ..matte()
        };
        let (forth, back) = (
            lit(&s, a, b, 1.0, 0.0)[0] / b[2],
            lit(&s, b, a, 1.0, 0.0)[0] / a[2],
        );
        assert!((forth - back).abs() < 1e-4);
    }
}
