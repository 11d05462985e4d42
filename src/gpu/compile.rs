//! GLSL at run time (feature `compile-shaders`): our shaders with a function of the user's behind them.
//!
//! In: the text of a function. Out: SPIR-V of one stage, or the compiler's message with line numbers of the user's file. The
//! text may include nothing, and uses no binding that the shader does not have (the pipeline's maker checks).

use crate::{Error, Result};
use shaderc::{
    CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind, TargetEnv,
};

/// Every file of `glsl/` by its path there.
const SOURCES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// A text of the user's, and what is needed to check it alone.
#[derive(Clone, Copy, Debug)]
pub struct UserText<'a> {
    /// What errors call it.
    pub name: &'a str,
    /// GLSL.
    pub text: &'a str,
    /// Declarations that it may use and must define: what stands before it when it is checked.
    pub before: &'a str,
    /// Uses what it must define: what stands behind it when it is checked.
    pub behind: &'a str,
}

impl UserText<'_> {
    /// Compiles the text alone, so that every message names a line of it.
    ///
    /// # Errors
    /// [`Error::Input`] with the compiler's messages.
    pub fn check(&self) -> Result<()> {
        if let Some(line) = self.text.lines().position(is_include) {
            return Err(self.fault(&format!("line {}: nothing can be included", line + 1)));
        }
        let whole = format!("{}\n#line 1\n{}\n{}\n", self.before, self.text, self.behind);
        let name = self.name;
        spirv(name, &whole, ShaderKind::Compute, None)
            .map(drop)
            .map_err(|m| self.fault(&m))
    }

    /// The shader at `path` below `glsl/`, with `define` defined and the text behind it.
    ///
    /// # Errors
    /// As [`UserText::check`]; panics where there is no such shader.
    pub fn behind(&self, path: &str, define: &str) -> Result<Vec<u8>> {
        self.check()?;
        let kind = if path.ends_with(".frag") {
            ShaderKind::Fragment
        } else {
            ShaderKind::Compute
        };
        let ours = source(path).unwrap_or_else(|| panic!("no shader {path}"));
        let whole = format!("{ours}\n#line 1\n{}\n", self.text);
        spirv(self.name, &whole, kind, Some(define)).map_err(|m| self.fault(&m))
    }

    /// The compiler's messages without its count of them.
    fn fault(&self, messages: &str) -> Error {
        let counts = |line: &str| line.ends_with("generated.");
        let told: Vec<&str> = messages.lines().filter(|l| !counts(l)).collect();
        Error::input(self.name, "GLSL", told.join("; "))
    }
}

fn is_include(line: &str) -> bool {
    let directive = line.trim_start().strip_prefix('#');
    directive.is_some_and(|d| d.trim_start().starts_with("include"))
}

fn source(path: &str) -> Option<&'static str> {
    let found = SOURCES.iter().find(|(name, _)| *name == path);
    found.map(|(_, text)| *text)
}

fn spirv(
    name: &str,
    text: &str,
    kind: ShaderKind,
    define: Option<&str>,
) -> std::result::Result<Vec<u8>, String> {
    let compiler = Compiler::new().map_err(|e| e.to_string())?;
    let mut options = CompileOptions::new().map_err(|e| e.to_string())?;
    // As build/compile.rs has it.
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_include_callback(|name, _, _, _| {
        let content = source(name).ok_or_else(|| format!("there is no {name}"))?;
        Ok(ResolvedInclude {
            resolved_name: format!("glsl/{name}"),
            content: content.to_owned(),
        })
    });
    if let Some(define) = define {
        options.add_macro_definition(define, None);
    }
    match compiler.compile_into_spirv(text, kind, name, "main", Some(&options)) {
        Ok(artifact) => Ok(artifact.as_binary_u8().to_vec()),
        Err(shaderc::Error::CompilationError(_, messages)) => Err(messages),
        Err(other) => Err(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn user(text: &str) -> UserText<'_> {
        UserText {
            name: "mine.glsl",
            text,
            before: "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"common/solid.glsl\"\nfloat mine(float x);",
            behind: "void main() { float y = mine(1.0); }",
        }
    }

    #[test]
    fn a_function_may_use_what_stands_before_it() {
        user("float mine(float x) {\n  return igt_noise(ivec3(int(x)), 3, 1u);\n}")
            .check()
            .unwrap();
    }

    #[test]
    fn messages_name_lines_of_the_users_file() {
        for (text, words) in [
            (
                "float mine(float x) {\n  return y;\n}",
                "mine.glsl:2: error: 'y'",
            ),
            (
                "float mine(float x) {\n\n  return x;\n",
                "mine.glsl:5: error",
            ),
            ("float other(float x) { return x; }", "mine"),
            (
                "// twice\nfloat mine(float x) { return x; }\nfloat mine(float x) { return x; }",
                "mine.glsl:3: error",
            ),
            (
                "int i;\n#include \"common/igt.glsl\"",
                "line 2: nothing can be included",
            ),
        ] {
            let message = user(text).check().unwrap_err().to_string();
            assert!(
                message.starts_with("mine.glsl: GLSL: ") && message.contains(words),
                "{message}"
            );
        }
    }
}
