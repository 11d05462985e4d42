//! GLSL to SPIR-V with shaderc (feature `compile-shaders`). In: the sources. Out: nothing when every binary equals the
//! committed one, or a fresh `spirv/` under `INVERTEX_BLESS_SPIRV=1`, or an error that names what differs.

use crate::manifest;
use crate::source::{self, Source};
use shaderc::{
    CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind, TargetEnv,
};
use std::fs;

const FLAGS: &str =
    "target vulkan1.2, optimisation performance, names kept, lines dropped, warnings are errors";

/// Compiles everything; compares with `spirv/`, or rewrites it when blessing.
pub(crate) fn refresh(sources: &[Source]) -> Result<(), String> {
    let compiler = Compiler::new().map_err(|error| error.to_string())?;
    let mut binaries = Vec::with_capacity(sources.len());
    for source in sources {
        binaries.push(compile(&compiler, source)?);
    }
    let description = describe(&binaries);
    if std::env::var_os("INVERTEX_BLESS_SPIRV").is_some_and(|value| value == "1") {
        write(sources, &binaries, &description)
    } else {
        compare(sources, &binaries, &description)
    }
}

/// Writes `OUT_DIR/sources.rs`: every file below `glsl/` by its path there, for compiling at run time.
pub(crate) fn embed() -> Result<(), String> {
    let mut list = String::from("&[\n");
    for folder in ["common", "render"] {
        for file in source::entries(&format!("glsl/{folder}"))? {
            let path = format!("{folder}/{file}");
            list += &format!(
                "    ({path:?}, include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/glsl/{path}\"))),\n"
            );
        }
    }
    let out = std::env::var("OUT_DIR").map_err(|error| error.to_string())?;
    fs::write(format!("{out}/sources.rs"), list + "]\n")
        .map_err(|error| format!("{out}/sources.rs: {error}"))
}

fn compile(compiler: &Compiler, source: &Source) -> Result<Vec<u8>, String> {
    let mut options = CompileOptions::new().map_err(|error| error.to_string())?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(|name, _, _, _| {
        let content = source::read(&format!("glsl/{name}"))?;
        Ok(ResolvedInclude {
            resolved_name: format!("glsl/{name}"),
            content,
        })
    });
    let kind = match source.extension.as_str() {
        "vert" => ShaderKind::Vertex,
        "frag" => ShaderKind::Fragment,
        _ => ShaderKind::Compute,
    };
    let artifact = compiler
        .compile_into_spirv(&source.text, kind, &source.path, "main", Some(&options))
        .map_err(|error| error.to_string())?;
    Ok(without_lines(artifact.as_binary())
        .iter()
        .flat_map(|word| word.to_le_bytes())
        .collect())
}

/// Drops the embedded source text and line numbers but keeps the names: optimisation without debug information would
/// strip the names too, and reflection lives on them.
fn without_lines(words: &[u32]) -> Vec<u32> {
    // OpSourceContinued, OpSource, OpSourceExtension, OpString, OpLine, OpNoLine, OpModuleProcessed.
    const DROPPED: [u32; 7] = [2, 3, 4, 7, 8, 317, 330];
    const HEADER_WORDS: usize = 5;
    let mut kept = words[..HEADER_WORDS].to_vec();
    let mut at = HEADER_WORDS;
    while at < words.len() {
        let length = (words[at] >> 16).max(1) as usize;
        if !DROPPED.contains(&(words[at] & 0xffff)) {
            kept.extend_from_slice(&words[at..at + length]);
        }
        at += length;
    }
    kept
}

/// Which compiler made these bytes: the generator word of the modules and shaderc's own SPIR-V version.
fn describe(binaries: &[Vec<u8>]) -> String {
    let (version, revision) = shaderc::get_spirv_version();
    let generator = binaries
        .first()
        .and_then(|binary| binary.get(8..12))
        .map(|word| {
            let word = [word[0], word[1], word[2], word[3]];
            u32::from_le_bytes(word)
        });
    format!(
        "shaderc for SPIR-V {version:#x}.{revision}, generator {:#x}; {FLAGS}",
        generator.unwrap_or(0)
    )
}

fn write(sources: &[Source], binaries: &[Vec<u8>], description: &str) -> Result<(), String> {
    let mut wanted: Vec<String> = sources.iter().map(Source::binary_path).collect();
    for (path, binary) in wanted.iter().zip(binaries) {
        write_changed(path, binary)?;
    }
    wanted.push(manifest::PATH.to_owned());
    write_changed(
        manifest::PATH,
        manifest::text(sources, binaries, description).as_bytes(),
    )?;
    for entry in fs::read_dir("spirv")
        .map_err(|error| format!("spirv: {error}"))?
        .flatten()
    {
        let path = format!("spirv/{}", entry.file_name().to_string_lossy());
        if path.ends_with(".spv") && !wanted.contains(&path) {
            fs::remove_file(&path).map_err(|error| format!("{path}: {error}"))?;
        }
    }
    Ok(())
}

/// Leaves an equal file alone, so that its time stamp does not start another build.
fn write_changed(path: &str, bytes: &[u8]) -> Result<(), String> {
    if fs::read(path).is_ok_and(|present| present == bytes) {
        return Ok(());
    }
    fs::write(path, bytes).map_err(|error| format!("{path}: {error}"))
}

fn compare(sources: &[Source], binaries: &[Vec<u8>], description: &str) -> Result<(), String> {
    let differing: Vec<String> = sources
        .iter()
        .zip(binaries)
        .filter(|(source, binary)| fs::read(source.binary_path()).ok().as_ref() != Some(*binary))
        .map(|(source, _)| source.binary_path())
        .collect();
    if differing.is_empty() {
        return Ok(());
    }
    let written = fs::read_to_string(manifest::PATH).unwrap_or_default();
    Err(format!(
        "compiling glsl/ does not give the committed {}\n\
         committed by: {}\n\
         compiled by:  {description}\n\
         If a shader changed, run `INVERTEX_BLESS_SPIRV=1 cargo build --features compile-shaders` and commit spirv/",
        differing.join(", "),
        manifest::compiler(&written).unwrap_or("no compiler named"),
    ))
}
