//! Where Mesa keeps what lavapipe's LLVM compiled: 1.5 s of JIT at the first dispatch become 6 ms in the next process.
//!
//! Mesa's cache is on by default, but its key leaves out what the code was compiled for: the CPU's instruction sets and the
//! width that LP_NATIVE_VECTOR_WIDTH asks for. A home folder shared between machines would then hand AVX-512 code to a CPU
//! without it. So the cache gets a folder of its own per combination, unless the user has set one.

/// Points Mesa at this machine's folder. Call it first in `main`: once threads run it does nothing, as the environment
/// must not change under them. True when the folder was set.
pub fn configure() -> bool {
    let is_alone = std::fs::read_dir("/proc/self/task").is_ok_and(|tasks| tasks.count() == 1);
    let is_set = ["MESA_SHADER_CACHE_DIR", "MESA_GLSL_CACHE_DIR"].iter().any(|v| std::env::var_os(v).is_some());
    let Some(folder) = folder().filter(|_| is_alone && !is_set) else { return false };
    // SAFETY: this is the only thread of the process, so nothing reads the environment meanwhile.
    unsafe { std::env::set_var("MESA_SHADER_CACHE_DIR", folder) };
    true
}

fn folder() -> Option<std::path::PathBuf> {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = |key: &str| cpu.lines().find(|l| l.starts_with(key)).unwrap_or_default().to_owned();
    let mut settings: Vec<String> = std::env::vars_os()
        .map(|(name, value)| format!("{}={}", name.to_string_lossy(), value.to_string_lossy()))
        .filter(|setting| ["LP_", "GALLIVM_", "NIR_"].iter().any(|prefix| setting.starts_with(prefix)))
        .collect();
    settings.sort();
    let parts = [line("model name"), line("flags"), line("Features"), settings.join("\n")];
    let key = crate::shader::cache::Cache::key(&parts.each_ref().map(String::as_str));
    crate::shader::cache::Cache::user().folder().map(|base| base.join(format!("mesa-{}", &key[..16])))
}
