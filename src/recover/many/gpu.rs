//! Questions answered on a device, a thread each. Shader: `glsl/recover/find.comp`; twin of [`Triangles::ask`].

use super::{Answer, Ask, Question, Triangles};
use crate::gpu::{Context, shaders::recover_find as pass};
use crate::{Error, Result};

/// Questions of one dispatch: no buffer outgrows a device's storage range.
const BLOCK: usize = 1 << 20;
/// Threads of a workgroup.
const GROUP: u64 = 64;
/// Workgroups along one axis, at most.
const ROW: u64 = 32_768;

/// The tree as a device reads it.
pub(super) struct Words {
    nodes: Vec<[u32; 4]>,
    packs: Vec<[u32; 4]>,
}

impl Triangles {
    /// [`Triangles::ask`] on a device; the answers are the same, bit for bit.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a tree beyond the device's storage buffers; those of the device.
    pub fn ask_on(&self, context: &Context, questions: &[Question]) -> Result<Vec<Option<Answer>>> {
        if questions.is_empty() {
            return Ok(Vec::new());
        }
        let words = self.words.get_or_init(|| {
            let [nodes, packs] = self.tree.words();
            Words { nodes, packs }
        });
        let have = context.info().limits.storage_buffer_bytes;
        let need = 16 * words.nodes.len().max(words.packs.len()) as u64;
        if need > have {
            let what = "bytes of a tree of triangles on the device (--device cpu has room)".into();
            return Err(Error::Capacity { what, need, have });
        }
        let nodes = context.upload("tree nodes", &words.nodes)?;
        let packs = context.upload("tree triangles", &words.packs)?;
        let block = questions.len().min(BLOCK) as u64;
        let answers = context.storage("answers", block * 32)?;
        let pipeline = context.compute::<pass::Shader>()?;
        let mut all = Vec::with_capacity(questions.len());
        for block in questions.chunks(BLOCK) {
            let asked: Vec<[u32; 8]> = block.iter().map(question).collect();
            let bound = pipeline.bind(&pass::Bindings {
                nodes: &nodes,
                packs: &packs,
                questions: &context.upload("questions", &asked)?,
                answers: &answers,
            })?;
            let push = pass::Push {
                count: block.len() as u32,
                any_node: u32::from(!self.tree.is_empty()),
                largest: self.tree.largest(),
            };
            let groups = (block.len() as u64).div_ceil(GROUP);
            let mut recorder = context.recorder("recover find")?;
            let counts = [groups.min(ROW) as u32, groups.div_ceil(ROW) as u32, 1];
            recorder.dispatch(&bound, &push, counts);
            context.run(recorder)?;
            let words: Vec<[u32; 8]> = context.download(&answers)?;
            all.extend(
                words[..block.len()]
                    .iter()
                    .zip(block)
                    .map(|(w, q)| self.answer(w, q)),
            );
        }
        Ok(all)
    }

    /// An answer of the shader; a question whose stack was too short is asked again here.
    fn answer(&self, words: &[u32; 8], question: &Question) -> Option<Answer> {
        if words[5] != 0 {
            return self.run(&[*question])[0];
        }
        (words[0] != u32::MAX).then(|| Answer {
            triangle: words[0],
            barycentric: [words[1], words[2], words[3]].map(f32::from_bits),
            distance: f32::from_bits(words[4]),
        })
    }
}

fn question(q: &Question) -> [u32; 8] {
    let ask = match q.ask {
        Ask::Closest => 0,
        Ask::ClosestFacing => 1,
        Ask::Ray => 2,
        Ask::RayFront => 3,
        Ask::RayBack => 4,
    };
    let [x, y, z] = q.place.map(f32::to_bits);
    let [i, j, k] = q.way.map(f32::to_bits);
    [x, y, z, q.within.to_bits(), i, j, k, ask]
}
