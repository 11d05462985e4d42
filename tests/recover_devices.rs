//! Closest points and first hits on every device of this machine: the processor's answers, bit for bit.
#![cfg(feature = "gpu")]

mod devices;

use devices::on_every_device;
use invertex::mesh::shapes;
use invertex::recover::{Answer, Ask, Question, Triangles};

/// A ball, a plane through its middle, slivers, and some triangles twice.
fn triangles() -> Vec<[[f32; 3]; 3]> {
    let (ball, grid) = (shapes::icosphere(4), shapes::grid(21));
    let mut all: Vec<[[f32; 3]; 3]> = Vec::new();
    for mesh in [&ball, &grid] {
        all.extend((0..mesh.triangles.len()).map(|t| mesh.corners(t)));
    }
    all.push([[0.2; 3]; 3]);
    all.push([[-1.0, 0.3, 0.1], [1.0, 0.3, 0.1], [0.0, 0.300_01, 0.1]]);
    all.extend_from_within(..60);
    all
}

/// Numbers in -1..1 without a pattern.
fn noise(k: u32) -> [f32; 3] {
    [0.731_f64, 0.377, 0.913].map(|step| ((f64::from(k) * step).fract() * 2.0 - 1.0) as f32)
}

fn questions() -> Vec<Question> {
    let kinds = [
        Ask::Closest,
        Ask::ClosestFacing,
        Ask::Ray,
        Ask::RayFront,
        Ask::RayBack,
    ];
    let question = |k: u32| {
        let mut way = noise(k + 7919);
        if k.is_multiple_of(7) {
            // Along an axis, from a point of the grid: many triangles are equally near.
            way = [0.0, 0.0, way[2]];
        }
        let within = if k.is_multiple_of(3) {
            0.3
        } else {
            f32::INFINITY
        };
        Question {
            place: noise(k).map(|c| c * 1.5),
            within,
            way,
            ask: kinds[k as usize % 5],
        }
    };
    let mut all: Vec<Question> = (0..6000).map(question).collect();
    let grid = |k: u32| [(k % 22) as f32 / 21.0, (k / 22) as f32 / 21.0, 0.5];
    all.extend((0..484).map(|k| Question::closest(grid(k))));
    all.extend((0..484).map(|k| Question::ray(grid(k), [0.0, 0.0, -1.0], 3.0)));
    all
}

fn bits(answers: &[Option<Answer>]) -> Vec<Option<[u32; 5]>> {
    let words = |a: &Answer| {
        let [x, y, z] = a.barycentric.map(f32::to_bits);
        [a.triangle, x, y, z, a.distance.to_bits()]
    };
    answers.iter().map(|a| a.as_ref().map(words)).collect()
}

#[test]
fn answers_are_the_processors_to_the_bit() {
    let (triangles, questions) = (Triangles::new(&triangles()), questions());
    let answers = triangles.ask(&questions);
    let found = answers.iter().flatten().count();
    assert!(found > 2500 && found < answers.len() - 600, "{found}");
    on_every_device(|context| {
        let theirs = triangles.ask_on(context, &questions).unwrap();
        let (ours, theirs) = (bits(&answers), bits(&theirs));
        let differ = (0..ours.len()).find(|&k| ours[k] != theirs[k]);
        if let Some(k) = differ {
            panic!(
                "{}: question {k} {:?}: {:?} here, {:?} there",
                context.info().name,
                questions[k],
                ours[k],
                theirs[k]
            );
        }
        // The negative control: one question asked otherwise is told apart.
        let mut other = questions.clone();
        other[5].place[1] += 1e-3;
        let other = triangles.ask_on(context, &other).unwrap();
        assert_ne!(bits(&other), ours);
    });
}

#[test]
fn nothing_is_found_where_nothing_is() {
    let (empty, one) = (Triangles::new(&[]), [Question::closest([0.0; 3])]);
    assert_eq!(empty.ask(&one), [None]);
    on_every_device(|context| {
        assert_eq!(empty.ask_on(context, &one).unwrap(), [None]);
        assert!(empty.ask_on(context, &[]).unwrap().is_empty());
    });
}
