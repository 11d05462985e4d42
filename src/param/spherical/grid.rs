//! A surface about a centre or an axis on the integer grid.
//!
//! In: points of the vertex grid. Out: points near them for which every triangle is still seen the right way round: exactly,
//! from the centre by a determinant of three rows of 24 bits. Where rounding turned one over, a vertex of it moves by a few
//! steps.

/// Steps of the vertex grid per unit.
pub(in crate::param) const STEPS: f64 = (1u32 << 23) as f64;
/// The sphere's radius in steps: 31/32 of the grid's reach.
pub(super) const RADIUS: f64 = STEPS * 31.0 / 32.0;
/// How far a vertex may move to set a triangle right, in steps.
const REACH: i32 = 4;
/// Rounds of setting right.
const ROUNDS: usize = 8;

/// Six times the volume between the centre and a triangle: positive where it is seen the right way round.
pub(super) fn determinant([a, b, c]: [[i32; 3]; 3]) -> i128 {
    let minor = |i: usize, j: usize| {
        i128::from(b[i]) * i128::from(c[j]) - i128::from(b[j]) * i128::from(c[i])
    };
    i128::from(a[0]) * minor(1, 2) + i128::from(a[1]) * minor(2, 0) + i128::from(a[2]) * minor(0, 1)
}

/// The points with those moved at which a triangle is `turned`. What is turned over after all rounds stays so.
pub(in crate::param) fn settle(
    mut on_grid: Vec<[i32; 3]>,
    triangles: &[[u32; 3]],
    turned: impl Fn([[i32; 3]; 3]) -> bool,
) -> Vec<[i32; 3]> {
    for _ in 0..ROUNDS {
        let bad = |t: &&[u32; 3]| turned(t.map(|v| on_grid[v as usize]));
        let mut wanted: Vec<u32> = triangles.iter().filter(bad).flatten().copied().collect();
        if wanted.is_empty() {
            break;
        }
        wanted.sort_unstable();
        wanted.dedup();
        let mut around: Vec<(u32, usize)> = vec![];
        for (t, corners) in triangles.iter().enumerate() {
            around.extend(
                corners
                    .iter()
                    .filter(|v| wanted.binary_search(v).is_ok())
                    .map(|&v| (v, t)),
            );
        }
        around.sort_unstable();
        for group in around.chunk_by(|a, b| a.0 == b.0) {
            let about: Vec<[u32; 3]> = group.iter().map(|g| triangles[g.1]).collect();
            nudge(&mut on_grid, group[0].0 as usize, &about, &turned);
        }
    }
    on_grid
}

/// Moves a vertex to the nearest step where most of the triangles about it are right.
fn nudge(
    on_grid: &mut [[i32; 3]],
    v: usize,
    about: &[[u32; 3]],
    turned: impl Fn([[i32; 3]; 3]) -> bool,
) {
    let wrong = |on_grid: &[[i32; 3]]| {
        about
            .iter()
            .filter(|t| turned(t.map(|w| on_grid[w as usize])))
            .count()
    };
    let stood = on_grid[v];
    let mut best = (wrong(on_grid), stood);
    let range = -REACH..=REACH;
    let mut steps: Vec<(i32, [i32; 3])> = vec![];
    for x in range.clone() {
        for y in range.clone() {
            steps.extend(range.clone().map(|z| (x * x + y * y + z * z, [x, y, z])));
        }
    }
    steps.sort_unstable();
    for (_, step) in steps {
        if best.0 == 0 {
            break;
        }
        on_grid[v] = [0, 1, 2].map(|k| stood[k] + step[k]);
        let count = wrong(on_grid);
        if count < best.0 {
            best = (count, on_grid[v]);
        }
    }
    on_grid[v] = best.1;
}
