//! Noise in space, from integer hashes: the same on every machine.
//!
//! In: a point of object space (already scaled). Out: value noise in [0, 1], or the cells of a Voronoi pattern for
//! the crackle. Everything is a function of the position on the vase, so nothing shows where charts meet.

use glam::{IVec3, Vec3};

fn hash(cell: IVec3, salt: u32) -> u32 {
    let mut h = salt.wrapping_mul(0x9e37_79b9);
    for c in [cell.x, cell.y, cell.z] {
        h = (h ^ c as u32).wrapping_mul(0x85eb_ca6b);
        h ^= h >> 13;
        h = h.wrapping_mul(0xc2b2_ae35);
        h ^= h >> 16;
    }
    h
}

fn unit(h: u32) -> f32 {
    (h >> 8) as f32 / 16_777_216.0
}

/// Smooth value noise.
pub(crate) fn value(p: Vec3, salt: u32) -> f32 {
    let floor = p.floor();
    let (cell, f) = (floor.as_ivec3(), p - floor);
    let w = f * f * (Vec3::splat(3.0) - 2.0 * f);
    let corner = |x, y, z| unit(hash(cell + IVec3::new(x, y, z), salt));
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let edge = |y, z| lerp(corner(0, y, z), corner(1, y, z), w.x);
    lerp(
        lerp(edge(0, 0), edge(1, 0), w.y),
        lerp(edge(0, 1), edge(1, 1), w.y),
        w.z,
    )
}

/// Four octaves of `value`.
pub(crate) fn fractal(p: Vec3, salt: u32) -> f32 {
    let mut sum = 0.0;
    let (mut weight, mut q) = (0.5, p);
    for octave in 0..4 {
        sum += weight * value(q, salt + octave);
        weight *= 0.5;
        q = q * 2.03 + Vec3::splat(7.1);
    }
    sum / 0.9375
}

/// Distance along the surface (unit normal given) to the border between the two nearest cells of a Voronoi pattern,
/// and that border's own number.
pub(crate) fn crack(p: Vec3, normal: Vec3, salt: u32) -> (f32, f32) {
    let cell = p.floor().as_ivec3();
    let (mut first, mut second) = ((f32::MAX, Vec3::ZERO, 0), (f32::MAX, Vec3::ZERO, 0));
    for z in -1..=1 {
        for y in -1..=1 {
            for x in -1..=1 {
                let at = cell + IVec3::new(x, y, z);
                let h = hash(at, salt);
                let jitter = Vec3::new(
                    (h & 1023) as f32,
                    ((h >> 10) & 1023) as f32,
                    ((h >> 20) & 1023) as f32,
                );
                let seed = at.as_vec3() + 0.1 + jitter * (0.8 / 1023.0);
                let entry = (seed.distance_squared(p), seed, h);
                if entry.0 < first.0 {
                    second = first;
                    first = entry;
                } else if entry.0 < second.0 {
                    second = entry;
                }
            }
        }
    }
    // Measured within the surface: a border that grazes it would else be drawn as a slab.
    let across = second.1 - first.1;
    let within = (across - normal * across.dot(normal)).length().max(1e-6);
    (
        (second.0 - first.0) / (2.0 * within),
        unit(first.2 ^ second.2),
    )
}
