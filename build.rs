//! Shaders at build time. In: `glsl/<stage>/<pass>.{comp,vert,frag}` and the committed `spirv/`. Out:
//! `OUT_DIR/shaders.rs`, the typed module `gpu::shaders`, written from what the binaries say about themselves.
//!
//! An ordinary build reads `spirv/` and checks it against `spirv/MANIFEST`: nobody who uses the crate needs a shader
//! compiler. With the feature `compile-shaders` every shader is compiled again and must give the committed bytes; with
//! `INVERTEX_BLESS_SPIRV=1` beside it the new bytes are written instead. Without the feature `gpu` nothing happens.

#[cfg(feature = "compile-shaders")]
#[path = "build/compile.rs"]
mod compile;
#[cfg(feature = "gpu")]
#[path = "build/generate.rs"]
mod generate;
#[cfg(feature = "gpu")]
#[path = "build/layout.rs"]
mod layout;
#[cfg(feature = "gpu")]
#[path = "build/manifest.rs"]
mod manifest;
#[cfg(feature = "gpu")]
#[path = "build/reflect.rs"]
mod reflect;
#[cfg(feature = "gpu")]
#[path = "build/source.rs"]
mod source;

fn main() {
    for path in ["build.rs", "build", "glsl", "spirv"] {
        println!("cargo::rerun-if-changed={path}");
    }
    println!("cargo::rerun-if-env-changed=INVERTEX_BLESS_SPIRV");
    #[cfg(feature = "gpu")]
    if let Err(message) = shaders() {
        for line in message.lines() {
            println!("cargo::error={line}");
        }
        std::process::exit(1);
    }
}

#[cfg(feature = "gpu")]
fn shaders() -> Result<(), String> {
    let sources = source::find("glsl")?;
    #[cfg(feature = "compile-shaders")]
    {
        compile::refresh(&sources)?;
        compile::embed()?;
    }
    let binaries = manifest::read(&sources)?;
    let mut interfaces = Vec::new();
    for (source, binary) in sources.iter().zip(&binaries) {
        interfaces.push(
            reflect::stage(source, binary)
                .map_err(|reason| format!("{}: {reason}", source.path))?,
        );
    }
    let module = generate::module(&reflect::pair_stages(interfaces)?)?;
    let out = std::env::var("OUT_DIR").map_err(|error| error.to_string())?;
    std::fs::write(format!("{out}/shaders.rs"), module)
        .map_err(|error| format!("{out}/shaders.rs: {error}"))
}
