//! Writes the module `gpu::shaders`. In: the interfaces of all pipelines. Out: Rust text, one module per pipeline with
//! `Shader`, `Bindings` and `Push`, and `types` with the structs that blocks are made of.

use crate::layout::{Structs, definition};
use crate::reflect::{Interface, Slot, most_storage_buffers};
use std::fmt::Write;

/// The bytes of push constants that every device has.
const PUSH_MOST: usize = 128;

/// The text of `shaders.rs`.
pub(crate) fn module(pipelines: &[Interface]) -> Result<String, String> {
    let mut structs = Structs::default();
    let mut text = String::from("// Written by build.rs from the reflection of spirv/.\n");
    for pipeline in pipelines {
        text += &pipeline_module(pipeline, &mut structs)
            .map_err(|reason| format!("{}: {reason}", pipeline.name))?;
    }
    let most = most_storage_buffers(pipelines);
    let _ = writeln!(
        text,
        "/// The most storage buffers that one stage of one of these pipelines uses.\n\
         pub const MOST_STORAGE_BUFFERS: u64 = {most};"
    );
    let _ = write!(
        text,
        "/// Structs that shader blocks are made of.\npub mod types {{\n{}}}\n",
        structs.definitions()
    );
    Ok(text)
}

fn pipeline_module(pipeline: &Interface, structs: &mut Structs) -> Result<String, String> {
    for slot in &pipeline.slots {
        match (&slot.block, slot.kind) {
            (Some(block), "StorageBuffer") => structs.elements(block)?,
            (Some(block), "UniformBuffer") => drop(structs.insert(block)?),
            _ => {}
        }
    }
    let name = &pipeline.name;
    let sources: Vec<String> = pipeline
        .stages
        .iter()
        .map(|stage| format!("`{}`", stage.1))
        .collect();
    // Shaders that only tests dispatch stay out of the documentation.
    let hidden = if name.starts_with("test_") {
        "#[doc(hidden)]\n"
    } else {
        ""
    };
    let mut text = format!(
        "/// {}.\n{hidden}pub mod {name} {{\nuse crate::gpu::*;\n/// The pipeline of {}.\n#[derive(Clone, Copy, Debug)]\npub struct Shader;\n",
        sources.join(" and "),
        sources.join(" and ")
    );
    text += &bindings(&pipeline.slots);
    let push = match &pipeline.push {
        Some((block, _)) => {
            let members = structs.members(block)?;
            let bytes = members.last().map_or(0, |last| last.offset + last.bytes);
            if bytes > PUSH_MOST {
                return Err(format!(
                    "{bytes} bytes of push constants; every device has {PUSH_MOST}"
                ));
            }
            text += &definition(
                "Push",
                &format!("The push constants of {}.", sources.join(" and ")),
                &members,
            );
            "Push"
        }
        None => "()",
    };
    for (constant, id) in &pipeline.constants {
        let upper = constant.to_uppercase();
        let _ = writeln!(
            text,
            "/// Id of the specialization constant `{constant}`.\npub const {upper}: u32 = {id};"
        );
    }
    text += &interface(pipeline, push);
    text += match pipeline.stages.len() {
        1 => "impl ComputeShader for Shader {}\n",
        _ => "impl GraphicsShader for Shader {}\n",
    };
    Ok(text + "}\n")
}

/// `pub struct Bindings`: a field per slot, named as in the shader.
fn bindings(slots: &[Slot]) -> String {
    if slots.is_empty() {
        return "/// This pipeline reads no resources.\n#[derive(Clone, Copy)]\npub struct Bindings;\n".to_owned();
    }
    let mut fields = String::new();
    for slot in slots {
        let _ = writeln!(
            fields,
            "    /// {}.\n    pub r#{}: {},",
            describe(slot),
            slot.name,
            rust_type(slot.kind)
        );
    }
    format!(
        "/// The resources of this pipeline, by their GLSL names.\n#[derive(Clone, Copy)]\npub struct Bindings<'a> {{\n{fields}}}\n"
    )
}

fn describe(slot: &Slot) -> String {
    let block = slot.block.as_ref().and_then(|block| block.name.as_ref());
    match block {
        Some(block) => format!("{}, block `{block}`", slot.kind),
        None => slot.kind.to_owned(),
    }
}

fn rust_type(kind: &str) -> &'static str {
    match kind {
        "StorageBuffer" | "UniformBuffer" => "&'a Buffer",
        "StorageImage" | "SampledImage" => "&'a Image",
        "Sampler" => "&'a Sampler",
        _ => "(&'a Image, &'a Sampler)",
    }
}

fn resource(slot: &Slot) -> String {
    let field = format!("bindings.r#{}", slot.name);
    match slot.kind {
        "StorageBuffer" | "UniformBuffer" => format!("Resource::Buffer({field})"),
        "StorageImage" | "SampledImage" => format!("Resource::Image({field})"),
        "Sampler" => format!("Resource::Sampler({field})"),
        _ => format!("Resource::Sampled({field}.0, {field}.1)"),
    }
}

fn interface(pipeline: &Interface, push: &str) -> String {
    let mut stages = String::new();
    for (extension, _, binary) in &pipeline.stages {
        let _ = write!(
            stages,
            "\n        Stage {{ flags: {}, spirv: include_bytes!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{binary}\")) }},",
            flag(extension)
        );
    }
    let mut slots = String::new();
    for slot in &pipeline.slots {
        let _ = write!(
            slots,
            "\n        Slot {{ name: {:?}, binding: {}, kind: SlotKind::{}, stages: {} }},",
            slot.name,
            slot.binding,
            slot.kind,
            flags(&slot.stages)
        );
    }
    let push_stages = pipeline
        .push
        .as_ref()
        .map_or(&[][..], |(_, stages)| stages.as_slice());
    let lifetime = if pipeline.slots.is_empty() {
        ""
    } else {
        "<'a>"
    };
    let argument = if pipeline.slots.is_empty() {
        "_"
    } else {
        "bindings"
    };
    let resources: Vec<String> = pipeline.slots.iter().map(resource).collect();
    format!(
        "impl ShaderInterface for Shader {{\n    const NAME: &'static str = {:?};\n    \
         const STAGES: &'static [Stage] = &[{stages}\n    ];\n    const SLOTS: &'static [Slot] = &[{slots}\n    ];\n    \
         const PUSH_STAGES: vk::ShaderStageFlags = {};\n    const WORKGROUP: [u32; 3] = {:?};\n    \
         type Bindings<'a> = Bindings{lifetime};\n    type Push = {push};\n    \
         fn resources<'a>({argument}: &Self::Bindings<'a>) -> Vec<Resource<'a>> {{\n        vec![{}]\n    }}\n}}\n",
        pipeline.name,
        flags(push_stages),
        pipeline.workgroup,
        resources.join(", ")
    )
}

fn flag(extension: &str) -> &'static str {
    match extension {
        "vert" => "vk::ShaderStageFlags::VERTEX",
        "frag" => "vk::ShaderStageFlags::FRAGMENT",
        _ => "vk::ShaderStageFlags::COMPUTE",
    }
}

fn flags(extensions: &[String]) -> String {
    let raw: Vec<String> = extensions
        .iter()
        .map(|extension| format!("{}.as_raw()", flag(extension)))
        .collect();
    match raw.is_empty() {
        true => "vk::ShaderStageFlags::empty()".to_owned(),
        false => format!("vk::ShaderStageFlags::from_raw({})", raw.join(" | ")),
    }
}
