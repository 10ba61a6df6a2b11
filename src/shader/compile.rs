//! GLSL text to SPIR-V by shaderc: parts of several files in one module, errors as "bsdf/lambert.glsl:12: ...".
//!
//! Target: Vulkan 1.2, SPIR-V 1.5, optimised for speed; a warning is an error. Every define is given, as 0 or a number,
//! because an undefined name in `#if` is silently 0. shaderc strips all names when it optimises, so the module is compiled with
//! debug information, and all of it but the names that reflection needs is taken out again (`strip`).

use std::time::{Duration, Instant};

use super::cache::Cache;
use super::reflect::{ReflectError, Reflection, instructions, op, reflect};
use super::source;

/// A piece of a module: text, and the file that errors name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    pub file: String,
    pub text: String,
}

/// A compute module before compilation. `#version` is added; the parts must not have one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// The kernel's name in errors and in the driver's tools.
    pub name: String,
    pub defines: Vec<(String, u32)>,
    pub parts: Vec<Part>,
}

impl Source {
    pub fn new(name: &str) -> Source {
        Source { name: name.to_owned(), ..Source::default() }
    }

    /// `#define NAME VALUE` before all parts.
    pub fn define(mut self, name: &str, value: impl Into<u32>) -> Source {
        self.defines.push((name.to_owned(), value.into()));
        self
    }

    /// Appends generated text; `file` is what errors name.
    pub fn part(mut self, file: &str, text: impl Into<String>) -> Source {
        self.parts.push(Part { file: file.to_owned(), text: text.into() });
        self
    }

    /// Appends an embedded file of `shaders/`.
    pub fn file(self, path: &str) -> Result<Source, CompileError> {
        let text = source::get(path).ok_or_else(|| CompileError::NoFile(path.to_owned()))?;
        Ok(self.part(path, text))
    }

    /// Replaces text that occurs exactly once in one part.
    pub fn apply(&mut self, edit: &Edit) -> Result<(), CompileError> {
        let part = self.parts.iter_mut().find(|p| p.file == edit.file);
        let part = part.ok_or_else(|| CompileError::NoFile(edit.file.to_owned()))?;
        let count = part.text.matches(edit.from).count();
        if count != 1 {
            return Err(CompileError::Edit { file: edit.file.to_owned(), from: edit.from.to_owned(), count });
        }
        part.text = part.text.replacen(edit.from, edit.to, 1);
        Ok(())
    }

    /// The whole text as the compiler sees it.
    pub fn text(&self) -> String {
        let mut text = "#version 460\n#extension GL_GOOGLE_cpp_style_line_directive : require\n".to_owned();
        for (name, value) in &self.defines {
            text += &format!("#define {name} {value}\n");
        }
        for part in &self.parts {
            text += &format!("#line 1 \"{}\"\n{}\n", part.file, part.text);
        }
        text
    }
}

/// One change of a part's text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The part's name, `bsdf/lambert.glsl`.
    pub file: &'static str,
    /// Must occur exactly once in the part.
    pub from: &'static str,
    pub to: &'static str,
}

#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    #[error("the text \"{from}\" occurs {count} times in {file}, not once")]
    Edit { file: String, from: String, count: usize },
    #[error("there is no embedded shader file \"{0}\"")]
    NoFile(String),
    #[error("kernel \"{kernel}\" does not compile:\n{log}")]
    Glsl { kernel: String, log: String },
    #[error(
        "kernel \"{kernel}\" tests the macro {name} in {place}, which is neither 0 nor 1: give it in Features::defines"
    )]
    NoMacro { kernel: String, name: String, place: String },
    #[error("the GLSL compiler could not be started")]
    NoCompiler,
    #[error("kernel \"{kernel}\": {source}")]
    Reflect { kernel: String, source: ReflectError },
}

/// A compiled module. Only `compile` makes one, so its words are what shaderc wrote.
#[derive(Clone, Debug)]
pub struct Spirv {
    name: String,
    words: Vec<u32>,
    reflection: Reflection,
    key: String,
    compile_time: Duration,
    was_cached: bool,
}

impl Spirv {
    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn words(&self) -> &[u32] {
        &self.words
    }

    pub fn reflection(&self) -> &Reflection {
        &self.reflection
    }

    /// Hash of text, options and compiler: what records call the kernel's hash. 32 hexadecimal digits.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Compilation, or reading from the cache.
    pub fn compile_time(&self) -> Duration {
        self.compile_time
    }

    pub fn was_cached(&self) -> bool {
        self.was_cached
    }
}

/// What the output depends on besides the text.
pub(super) fn compiler_fingerprint() -> String {
    let (version, revision) = shaderc::get_spirv_version();
    // STERADIAN_SHADERC is set by the build script: size and time of the archives that were linked.
    format!("vulkan1.2 performance {version}.{revision} {} 1", env!("STERADIAN_SHADERC"))
}

/// Compiles, or takes the result from `cache`, which may be `Cache::off()`.
pub fn compile(source: &Source, cache: &Cache) -> Result<Spirv, CompileError> {
    let start = Instant::now();
    let text = source.text();
    if let Some((name, place)) = undefined_macro(source) {
        return Err(CompileError::NoMacro { kernel: source.name.clone(), name, place });
    }
    let key = Cache::key(&[&text, &compiler_fingerprint()]);
    let kernel = || source.name.clone();
    let reflected = |words: &[u32]| reflect(words).map_err(|source| CompileError::Reflect { kernel: kernel(), source });
    let stored = cache.load(&key).and_then(|words| reflected(&words).ok().map(|reflection| (words, reflection)));
    let was_cached = stored.is_some();
    let (words, reflection) = match stored {
        Some(found) => found,
        None => {
            let words = translate(&source.name, &text)?;
            let words = strip(&words).map_err(|source| CompileError::Reflect { kernel: kernel(), source })?;
            cache.store(&key, &words);
            let reflection = reflected(&words)?;
            (words, reflection)
        }
    };
    Ok(Spirv { name: kernel(), words, reflection, key, compile_time: start.elapsed(), was_cached })
}

/// A name in `#if` or `#elif` that nothing defines, and where it stands: the preprocessor would take it as 0 without a word.
fn undefined_macro(source: &Source) -> Option<(String, String)> {
    let mut known: std::collections::HashSet<&str> = source.defines.iter().map(|(name, _)| name.as_str()).collect();
    for part in &source.parts {
        for (number, line) in part.text.lines().enumerate() {
            let line = line.trim_start();
            if let Some(rest) = line.strip_prefix("#define ") {
                known.extend(rest.split(|c: char| !c.is_alphanumeric() && c != '_').next());
            }
            let Some(condition) = line.strip_prefix("#if ").or_else(|| line.strip_prefix("#elif ")) else { continue };
            let names = condition.split(|c: char| !c.is_alphanumeric() && c != '_');
            let is_name = |word: &&str| word.starts_with(|c: char| c.is_alphabetic() || c == '_');
            if let Some(name) = names.filter(is_name).find(|name| !known.contains(name)) {
                return Some((name.to_owned(), format!("{}:{}", part.file, number + 1)));
            }
        }
    }
    None
}

fn translate(name: &str, text: &str) -> Result<Vec<u32>, CompileError> {
    let compiler = shaderc::Compiler::new().map_err(|_| CompileError::NoCompiler)?;
    let mut options = shaderc::CompileOptions::new().map_err(|_| CompileError::NoCompiler)?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_5);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    let compiled = compiler.compile_into_spirv(text, shaderc::ShaderKind::Compute, name, "main", Some(&options));
    let artifact = compiled.map_err(|e| {
        let log = match e {
            shaderc::Error::CompilationError(_, log) => log,
            other => other.to_string(),
        };
        CompileError::Glsl { kernel: name.to_owned(), log: log.trim().to_owned() }
    })?;
    Ok(artifact.as_binary().to_vec())
}

/// Takes out source text, lines, and names of all but global variables, struct types and specialisation constants: the
/// driver's cache then does not see line numbers, and the word count is that of the code.
fn strip(words: &[u32]) -> Result<Vec<u32>, ReflectError> {
    let all = instructions(words)?;
    let is_global = |opcode: u32| matches!(opcode, op::TYPE_STRUCT | 48..=52);
    let mut kept_names = std::collections::HashSet::new();
    let mut in_function = false;
    for (opcode, o) in &all {
        in_function |= *opcode == 54;
        match (*opcode, *o) {
            (op::VARIABLE, [_, id, ..]) if !in_function => drop(kept_names.insert(*id)),
            (op::TYPE_STRUCT, [id, ..]) => drop(kept_names.insert(*id)),
            (opcode, [_, id, ..]) if is_global(opcode) => drop(kept_names.insert(*id)),
            _ => {}
        }
    }
    let mut kept = words[..5].to_vec();
    for (opcode, o) in all {
        let is_debug = match opcode {
            op::SOURCE_CONTINUED
            | op::SOURCE
            | op::SOURCE_EXTENSION
            | op::STRING
            | op::LINE
            | op::NO_LINE
            | op::MODULE_PROCESSED => true,
            op::NAME => !o.first().is_some_and(|id| kept_names.contains(id)),
            _ => false,
        };
        if !is_debug {
            kept.push(((o.len() as u32 + 1) << 16) | opcode);
            kept.extend_from_slice(o);
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_macro_that_is_tested_but_not_given_is_an_error_with_its_place() {
        let source =
            Source::new("probe").define("HAS_A", true).part("a.glsl", "#if HAS_A && HAS_B\n#endif\nvoid main() {}");
        let error = compile(&source, &Cache::off()).unwrap_err().to_string();
        assert!(error.contains("HAS_B in a.glsl:1"), "{error}");
    }
}
