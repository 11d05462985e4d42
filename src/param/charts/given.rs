//! What an artist's uv set does to lengths and where it cuts, measured as a computed map is.
//!
//! In: a mesh and the uv of its vertices. Out: [`Quality`]. A seam is an edge of the welded surface at which the two triangles
//! have different uv. Charts may be mirrored: a triangle counts by its shape, whichever way round it lies; one without area in
//! uv is left out, as its share is the fit's to tell.

use super::lscm::laid_flat;
use super::stretch::Sums;
use super::surface::Surface;
use crate::mesh::Mesh;
use crate::param::computed::Quality;
use glam::DVec2;

/// The quality of `uv` (one for each vertex) over `mesh`, which it divides into `charts`.
pub(crate) fn given(mesh: &Mesh, uv: &[[f32; 2]], charts: usize) -> Quality {
    let surface = Surface::new(mesh);
    let mut sums = Sums::default();
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for t in (0..mesh.triangles.len()).filter(|&t| surface.usable(t)) {
        let image = mesh.triangles[t].map(|v| DVec2::from(uv[v as usize].map(f64::from)));
        let area = (image[1] - image[0]).perp_dot(image[2] - image[0]);
        if area == 0.0 || !area.is_finite() {
            continue;
        }
        image
            .iter()
            .for_each(|&p| (low, high) = (low.min(p), high.max(p)));
        let upright = image.map(|p| DVec2::new(p.x * area.signum(), p.y));
        sums.add(laid_flat(surface.corners(t)), upright);
    }
    let seam_length: f64 = seams(mesh, uv, &surface).map(|h| surface.length(h)).sum();
    let area: f64 = surface.areas.iter().sum();
    let side = (high - low).max_element();
    Quality {
        charts,
        stretch: sums.stretch(),
        seam_length: if area > 0.0 {
            seam_length / area.sqrt()
        } else {
            0.0
        },
        filled_fraction: if side > 0.0 {
            sums.flat_share(side).min(1.0)
        } else {
            0.0
        },
        turned_triangles: vec![],
    }
}

/// Half-edges at which the uv changes, one for each edge.
fn seams<'a>(
    mesh: &'a Mesh,
    uv: &'a [[f32; 2]],
    surface: &'a Surface,
) -> impl Iterator<Item = usize> + 'a {
    let at = |t: usize, k: usize| uv[mesh.triangles[t][k % 3] as usize];
    (0..surface.across.len()).filter(move |&h| {
        let Some(other) = surface.neighbour(h).filter(|&other| h / 3 < other) else {
            return false;
        };
        let (k, l) = (h % 3, surface.across[h] as usize % 3);
        at(h / 3, k) != at(other, l + 1) || at(h / 3, k + 1) != at(other, l)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_square_that_is_its_own_map_has_neither_stretch_nor_seams() {
        let mesh = shapes::grid(8);
        let quality = given(&mesh, &mesh.uv_sets[0], 1);
        assert!((quality.stretch.l2 - 1.0).abs() < 1e-6, "{quality:?}");
        assert!((quality.stretch.linf - 1.0).abs() < 1e-5 && quality.seam_length == 0.0);
        assert!((quality.filled_fraction - 1.0).abs() < 1e-6);
        // Mirrored it is the same map.
        let mirrored: Vec<[f32; 2]> = mesh.uv_sets[0].iter().map(|&[u, v]| [1.0 - u, v]).collect();
        assert!((given(&mesh, &mirrored, 1).stretch.l2 - 1.0).abs() < 1e-6);
        // Twice as long one way: L2 of singular values sqrt 2 and 1 / sqrt 2 (area kept).
        let long: Vec<[f32; 2]> = mesh.uv_sets[0].iter().map(|&[u, v]| [2.0 * u, v]).collect();
        let stretched = given(&mesh, &long, 1).stretch;
        assert!(
            (stretched.l2 - 1.25f64.sqrt()).abs() < 1e-6,
            "{stretched:?}"
        );
        assert!(
            (stretched.linf - 2.0f64.sqrt()).abs() < 1e-5,
            "{stretched:?}"
        );
    }

    /// A tube rolled from a strip: the two ends of the strip meet in one seam as long as the tube.
    #[test]
    fn the_seam_of_a_tube_is_as_long_as_the_tube() {
        let mesh = shapes::tube(64, 6);
        let (low, high) = mesh.bounds().unwrap();
        let height = f64::from(high[2] - low[2]);
        let area: f64 = (0..mesh.triangles.len())
            .map(|t| {
                let [a, b, c] = mesh.corners(t).map(|p| glam::DVec3::from(p.map(f64::from)));
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        let quality = given(&mesh, &mesh.uv_sets[0], 1);
        let expected = height / area.sqrt();
        assert!(
            (quality.seam_length - expected).abs() < 1e-3 * expected,
            "{} for {expected}",
            quality.seam_length
        );
    }
}
