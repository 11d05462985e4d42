//! Triangles at equal looks: what each criterion needs for pictures that are as near to the reference.
//!
//! In: [`CutRun`]s of several criteria. Out: [`EqualFlip`]s: for each distance and each limit of the criterion `pixels` the FLIP
//! that it gives, and the triangles that the others give the same for, between two of their limits by logarithms.

use super::cuts::CutRun;
use serde::Serialize;

/// Triangles at the FLIP that one limit in pixels gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EqualFlip {
    /// The built file.
    pub file: String,
    /// The mesh, or [`WHOLE`](super::WHOLE).
    pub mesh: String,
    /// Distance, in units of the one at which the model fills the view.
    pub distance: f64,
    /// The limit in pixels that gives this FLIP where displacement decides.
    pub pixels: f64,
    /// Mean FLIP against the reference.
    pub flip: f64,
    /// Triangles where displacement decides.
    pub triangles: f64,
    /// Where the surface alone counts; none where no limit that was tried gives this FLIP.
    pub surface: Option<f64>,
    /// Where colours count too.
    pub colours: Vec<WithColour>,
}

/// Triangles where colours count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WithColour {
    /// The limit of colours.
    pub colour: f64,
    /// Triangles; none where no limit in pixels that was tried gives this FLIP.
    pub triangles: Option<f64>,
}

/// The rows for `runs`, in their order.
pub fn at_equal_flip(runs: &[CutRun]) -> Vec<EqualFlip> {
    let by_pixels = runs.iter().filter(|run| run.criterion == "pixels");
    let row = |run: &CutRun| {
        let from_there: Vec<&CutRun> = runs
            .iter()
            .filter(|r| r.file == run.file && r.mesh == run.mesh && r.distance == run.distance)
            .collect();
        let needed = |criterion: &str, colour: Option<f64>| {
            let curve = from_there
                .iter()
                .filter(|r| r.criterion == criterion && r.colour == colour);
            let curve = curve.map(|r| [f64::from(r.triangles), r.flip_mean]);
            triangles_at(&curve.collect::<Vec<_>>(), run.flip_mean)
        };
        let mut colours: Vec<f64> = from_there.iter().filter_map(|r| r.colour).collect();
        colours.sort_by(f64::total_cmp);
        colours.dedup();
        let with = |colour: f64| WithColour {
            colour,
            triangles: needed("pixels+colour", Some(colour)),
        };
        EqualFlip {
            file: run.file.clone(),
            mesh: run.mesh.clone(),
            distance: run.distance,
            pixels: run.pixels,
            flip: run.flip_mean,
            triangles: f64::from(run.triangles),
            surface: needed("surface", None),
            colours: colours.into_iter().map(with).collect(),
        }
    };
    by_pixels.map(row).collect()
}

/// The fewest triangles that a curve of triangles and FLIP has this FLIP at; none where it lies above or below all of it.
fn triangles_at(curve: &[[f64; 2]], flip: f64) -> Option<f64> {
    // What cannot be told from the reference is as good as anything finer.
    let log = |flip: f64| flip.max(1e-6).ln();
    let mut curve = curve.to_vec();
    curve.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let same = curve.iter().filter(|p| p[1] == flip).map(|p| p[0]);
    let between = curve.windows(2).filter_map(|pair| {
        let [[fewer, worse], [more, better]] = [pair[0], pair[1]];
        let (low, high) = (better.min(worse), better.max(worse));
        if !(low < flip && flip < high) || fewer <= 0.0 {
            return None;
        }
        let share = (log(flip) - log(worse)) / (log(better) - log(worse));
        Some(fewer * (more / fewer).powf(share))
    });
    same.chain(between).min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_points_a_power_law_is_met() {
        let law = |triangles: f64| [triangles, 30.0 / triangles];
        let curve: Vec<_> = [4000.0, 10.0, 400.0, 60.0].map(law).into();
        for triangles in [10.0, 25.0, 60.0, 399.0, 4000.0] {
            let found = triangles_at(&curve, law(triangles)[1]).unwrap();
            assert!(
                (found / triangles - 1.0).abs() < 1e-9,
                "{triangles} {found}"
            );
        }
        assert_eq!(triangles_at(&curve, 3.1), None, "worse than all");
        assert_eq!(triangles_at(&curve, 0.007), None, "better than all");
        assert_eq!(triangles_at(&[], 0.1), None);
    }

    #[test]
    fn where_a_curve_comes_back_the_fewest_count() {
        let curve = [[10.0, 0.4], [20.0, 0.1], [40.0, 0.3], [80.0, 0.05]];
        let found = triangles_at(&curve, 0.2).unwrap();
        assert!(found > 10.0 && found < 20.0, "{found}");
        assert_eq!(triangles_at(&curve, 0.1), Some(20.0));
        // Nothing at all to be seen of a difference.
        assert_eq!(triangles_at(&[[10.0, 0.1], [20.0, 0.0]], 0.0), Some(20.0));
    }
}
