//! Directions round a normal, as many as their cosine: what sees the sky, and what looks through a body.
//!
//! In: a unit normal, a number of directions. Out: unit vectors round it, as dense as their cosine, the same on every machine:
//! a fixed even sequence turned by the place alone, made of `+ - * /` and square roots.

use super::arithmetic::{V3, add3, cross3, scale3, unit3};

/// A direction of [`directions`], which is round +z, round the normal whose [`tangents`] these are.
pub(crate) fn turned([x, y, z]: V3, [across, along]: [V3; 2], normal: V3) -> V3 {
    add3(add3(scale3(across, x), scale3(along, y)), scale3(normal, z))
}

/// Two unit vectors perpendicular to a unit one and to each other.
pub(crate) fn tangents(n: V3) -> [V3; 2] {
    let aside = if n[0].abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let across = unit3(cross3(aside, n), [0.0, 0.0, 1.0]);
    [across, cross3(n, across)]
}

/// A number for a place.
pub(crate) fn seed(p: V3) -> u32 {
    p.iter().fold(0x9e37_79b9, |h, c| {
        let h = (h ^ (c + 0.0).to_bits()).wrapping_mul(0x85eb_ca6b);
        (h ^ h >> 15).wrapping_mul(0xc2b2_ae35) ^ h >> 13
    })
}

/// `count` unit vectors around +z, as dense as their cosine: an even sequence of the plane (Roberts' R2), shifted by `seed`,
/// as far as it lies in the unit disk, raised onto the sphere.
pub(crate) fn directions(seed: u32, count: u32) -> impl Iterator<Item = V3> {
    let shift = [seed & 0xffff, seed >> 16].map(|s| f64::from(s) / 65536.0);
    let steps = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
    let point = move |k: u32| {
        let [x, y] =
            [0, 1].map(|i| ((shift[i] + f64::from(k) * steps[i]).fract() * 2.0 - 1.0) as f32);
        let squared = x * x + y * y;
        (squared < 1.0).then(|| [x, y, (1.0 - squared).sqrt()])
    };
    (0..).filter_map(point).take(count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_vectors_as_dense_as_their_cosine() {
        for seed in [0, 7, u32::MAX] {
            let all: Vec<V3> = directions(seed, 4096).collect();
            assert_eq!(all.len(), 4096);
            let mean = |of: &dyn Fn(&V3) -> f32| all.iter().map(of).sum::<f32>() / 4096.0;
            // Moments of the cosine-weighted half sphere: z is 2/3 in the mean, x and y 0, z squared 1/2.
            assert!((mean(&|d| d[2]) - 2.0 / 3.0).abs() < 3e-3);
            assert!((mean(&|d| d[2] * d[2]) - 0.5).abs() < 3e-3);
            assert!(mean(&|d| d[0]).abs() < 3e-3 && mean(&|d| d[1]).abs() < 3e-3);
            assert!(
                all.iter()
                    .all(|d| (d.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-6)
            );
        }
    }
}
